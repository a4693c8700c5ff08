/* SPDX-License-Identifier: MIT
 *
 * Material files of any format: finding the format by content or by extension, the list of materials, and the writing of files.
 */
#define _GNU_SOURCE /* memmem */
#include "material/maps.h"

#include <ctype.h>
#include <stdlib.h>

struct nqm_materials {
    const char *path;                          /* while the file is read, for messages */
    size_t n, max_n, n_reserved, max_reserved; /* bytes, see nqm_materials_reserve() */
    struct entry {
        nqm_material_info info;       /* each name owns a block with the other texts */
        const nqm_textured *textured; /* NULL: none */
        bool is_owner;
        const struct entry *other;      /* the next one of the same name, of the first one; NULL: none */
    } * list;                           /* (n) */
    nqm_index by_name;                  /* the first of each name, when the file is read */
    char unread[NQM_REMARK_SIZE - 100]; /* included files that are not read, for the remarks of all materials */
    size_t n_more;                      /* that are not named there */
};

#define POINTER_TO(NAME) &(NAME),
static const nqm_material_format *const formats[] = {NQM_MATERIAL_FORMATS(POINTER_TO) NULL};

/* ---- the list ---------------------------------------------------------------------------------------------------- */

size_t nqm_materials_count(const nqm_materials *materials) {
    assert(materials);
    return materials->n;
}

static nqm_index_key name_of(const void *value) {
    return (nqm_index_key){.name = ((const struct entry *)value)->info.name};
}

static nqm_status index_names(nqm_materials *m, nqm_error *err) {
    nqm_status status = nqm_index_create(m->n, name_of, &m->by_name, err);
    for (size_t i = 0; i < m->n && status == NQM_OK; ++i) {
        struct entry *first = (struct entry *)(uintptr_t)nqm_index_find(&m->by_name, name_of(&m->list[i]));
        if (!first)
            nqm_index_add(&m->by_name, &m->list[i]);
        else if (!first->other)
            first->other = &m->list[i];
    }
    return status;
}

size_t nqm_materials_find(const nqm_materials *m, const char *name, size_t *other_ret) {
    const struct entry *first = nqm_index_find(&m->by_name, (nqm_index_key){.name = name});
    *other_ret = first && first->other ? (size_t)(first->other - m->list) : SIZE_MAX;
    return first ? (size_t)(first - m->list) : SIZE_MAX;
}

nqm_material_info nqm_materials_get(const nqm_materials *materials, size_t i) {
    assert(materials);
    if (i >= materials->n)
        return (nqm_material_info){.name = NULL};
    nqm_material_info info = materials->list[i].info;
    info.n_maps = info.ignorable ? 0 : info.n_maps;
    return info;
}

/* Whether properties other than the ignored ones refuse the material. */
static bool is_refused(const nqm_material_info *info, unsigned ignored) {
    unsigned needed = 0;
    return info->ignorable && nqm_ignore_parse(info->ignorable, strlen(info->ignorable), &needed) &&
           (needed & ~ignored);
}

nqm_material_info nqm_materials_reflecting(const nqm_materials *materials, size_t i, unsigned ignored) {
    nqm_material_info info = materials->list[i].info;
    if (!info.ignorable || is_refused(&info, ignored))
        return nqm_materials_get(materials, i);
    info.spec = info.reflection;
    info.refusal = info.spec ? NULL : "image maps change it over the surface, and a BRDF is that of one point";
    return info;
}

void nqm_materials_free(nqm_materials *materials) {
    if (!materials)
        return;
    for (size_t i = 0; i < materials->n; ++i) {
        nqm_free((char *)materials->list[i].info.name);
        if (materials->list[i].is_owner)
            nqm_textured_free((nqm_textured *)(uintptr_t)materials->list[i].textured);
    }
    nqm_index_free(&materials->by_name);
    nqm_free(materials->list);
    nqm_free(materials);
}

nqm_status nqm_texts_copy(size_t n, char **const *texts, nqm_error *err) {
    enum { MAX_TEXTS = 8 };
    nqm_array arrays[MAX_TEXTS] = {{.pointer = NULL}};
    char *blocks[MAX_TEXTS];
    assert(n <= MAX_TEXTS);
    for (size_t i = 0; i < n; ++i)
        arrays[i] = (nqm_array){&blocks[i], *texts[i] ? strlen(*texts[i]) + 1 : 0, 1};
    nqm_status status = nqm_alloc_arrays(n, arrays, err);
    for (size_t i = 0; i < n && status == NQM_OK; ++i)
        if (*texts[i])
            *texts[i] = memcpy(blocks[i], *texts[i], arrays[i].n);
    return status;
}

nqm_materials *nqm_materials_create(const char *path) {
    nqm_materials *materials = nqm_alloc(1, sizeof *materials);
    if (materials) {
        materials->path = path;
        materials->max_reserved = (size_t)64 << 20;
    }
    return materials;
}

/* Replace the texts by copies in one block, which the name owns. */
static nqm_status copy_texts(nqm_material_info *info, nqm_error *err) {
    const char **texts[] = {&info->name,   &info->surface, &info->spec,      &info->refusal,
                            &info->remark, &info->unused,  &info->ignorable, &info->reflection};
    return nqm_texts_copy(sizeof texts / sizeof *texts, (char **const *)texts, err);
}

nqm_status nqm_materials_add(nqm_materials *materials, const nqm_material_info *info, nqm_error *err) {
    nqm_material_info copy = *info;
    char number[32];
    if (materials->n == NQM_MAX_MATERIALS)
        return nqm_fail(err, NQM_ERR_LIMIT, info->byte_offset, "%s: more than %d materials (byte %lld)",
                        materials->path, (int)NQM_MAX_MATERIALS, (long long)info->byte_offset);
    if (!copy.name || !*copy.name) {
        snprintf(number, sizeof number, "material%zu", materials->n + 1);
        copy.name = number;
    }
    struct entry *list = nqm_grow(materials->list, &materials->max_n, materials->n + 1, sizeof *list);
    if (!list)
        return nqm_fail_nomem(err, (materials->n + 1) * sizeof *list);
    materials->list = list;
    nqm_status status = copy_texts(&copy, err);
    if (status == NQM_OK)
        list[materials->n++] = (struct entry){.info = copy};
    return status;
}

const nqm_textured *nqm_materials_maps(const nqm_materials *materials, size_t i, unsigned ignored) {
    return is_refused(&materials->list[i].info, ignored) ? NULL : materials->list[i].textured;
}

bool nqm_materials_reserve(nqm_materials *materials, size_t n_bytes) {
    if (n_bytes > materials->max_reserved - materials->n_reserved)
        materials->max_reserved = materials->n_reserved = 0;
    materials->n_reserved += nqm_smaller(n_bytes, materials->max_reserved);
    return materials->max_reserved > 0;
}

void nqm_materials_attach(nqm_materials *materials, const nqm_textured *textured, bool is_owner) {
    struct entry *last = &materials->list[materials->n - 1];
    last->textured = textured;
    last->is_owner = is_owner;
    last->info.n_maps = textured ? textured->n_images : 0;
}

/* ---- included files ---------------------------------------------------------------------------------------------- */

void nqm_materials_unread(nqm_materials *materials, const char *text) {
    const size_t n = strlen(materials->unread), room = sizeof materials->unread - n;
    if (strlen(text) + 20 < room)
        snprintf(materials->unread + n, room, "%s%s", n ? "; not read: " : "not read: ", text);
    else
        ++materials->n_more;
}

/* Add what is not read to the remarks of all materials. */
static nqm_status add_unread(nqm_materials *materials, nqm_error *err) {
    char text[NQM_REMARK_SIZE], more[60] = "";
    if (materials->n_more)
        snprintf(more, sizeof more, "; and %zu more included files", materials->n_more);
    snprintf(text, sizeof text, "%s%s", materials->unread, more);
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < materials->n && *text; ++i) {
        struct entry *entry = &materials->list[i];
        nqm_material_info info = entry->info;
        char *block = (char *)info.name;
        char *remark = info.remark ? nqm_strdupf("%s; %s", info.remark, text) : nqm_strdup(text);
        info.remark = remark;
        status = remark ? copy_texts(&info, err) : nqm_fail_nomem(err, sizeof text);
        if (status == NQM_OK) {
            entry->info = info;
            nqm_free(block);
        }
        nqm_free(remark);
        if (entry->is_owner)
            nqm_textured_remark((nqm_textured *)(uintptr_t)entry->textured, text);
    }
    return status;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static const nqm_material_format *find_format(const nqm_map *map) {
    const nqm_material_format *const *f = formats;
    while (*f && !(*f)->probe(map))
        ++f;
    return *f;
}

bool nqm_materials_probe(const nqm_map *map) {
    return find_format(map) != NULL;
}

void nqm_material_format_names(char *text, size_t n_text) {
    size_t used = 0;
    *text = 0;
    for (const nqm_material_format *const *f = formats; *f && used < n_text; ++f)
        used += (size_t)snprintf(text + used, n_text - used, "%s%s", f == formats ? "" : ", ", (*f)->name);
}

nqm_status nqm_materials_read(const nqm_map *map, nqm_materials **materials_ret, nqm_error *err) {
    const nqm_material_format *format = find_format(map);
    char names[256];
    *materials_ret = NULL;
    if (!format) {
        nqm_material_format_names(names, sizeof names);
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: not a material file (byte 0); these are read: %s", map->path,
                        names);
    }
    nqm_materials *materials = nqm_materials_create(map->path);
    if (!materials)
        return nqm_fail_nomem(err, sizeof *materials);
    materials->max_reserved += 16 * map->n_bytes;
    nqm_status status = format->read(map, materials, err);
    materials->path = NULL;
    if (status == NQM_OK)
        status = add_unread(materials, err);
    if (status == NQM_OK && materials->n == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: this %s file (byte 0) contains no material%s%.300s", map->path,
                          format->name, *materials->unread ? "; " : "", materials->unread);
    if (status == NQM_OK)
        status = index_names(materials, err);
    if (status == NQM_OK)
        *materials_ret = materials;
    else
        nqm_materials_free(materials);
    return status;
}

nqm_status nqm_materials_open(const char *path, nqm_materials **materials_ret, nqm_error *err) {
    NQM_MAKE(err, materials_ret, path);
    nqm_map map = {0};
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK && map.n_bytes == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the file is empty (byte 0)", path);
    if (status == NQM_OK)
        status = nqm_materials_read(&map, materials_ret, err);
    nqm_map_close(&map);
    return status;
}

bool nqm_material_probe_text(const nqm_map *map, size_t n_bytes, const char *word) {
    const size_t n = strlen(word);
    const unsigned char *at = map->data, *end = at + n_bytes;
    for (; at && (size_t)(end - at) >= n; at = memchr(at + 1, *word, (size_t)(end - at) - 1))
        if (memcmp(at, word, n) == 0)
            return true;
    return false;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

size_t nqm_find_word(const char *words, const char *word, bool any_case) {
    const size_t n = strlen(word);
    size_t number = 0;
    for (const char *at = words; *at; at += strspn(at, " "), ++number) {
        const size_t n_at = strcspn(at, " ");
        if (n_at == n && (any_case ? nqm_equal_any_case(at, word, n) : strncmp(at, word, n) == 0))
            return number;
        at += n_at;
    }
    return SIZE_MAX;
}

bool nqm_contains_word(const char *words, const char *word, bool any_case) {
    return nqm_find_word(words, word, any_case) != SIZE_MAX;
}

const char *nqm_material_extensions(const char *model) {
    for (const nqm_material_format *const *f = formats; *f; ++f)
        if (nqm_contains_word((*f)->models, model, false))
            return (*f)->extensions;
    return "";
}

/* A format that writes the model to this path. */
static nqm_status select_format(const char *model, const char *path, const nqm_material_format **format_ret,
                                nqm_error *err) {
    const char *name = strrchr(path, '/'), *dot = strrchr(name ? name : path, '.');
    char all[512] = "";
    size_t used = 0;
    for (const nqm_material_format *const *f = formats; *f; ++f) {
        if (dot && nqm_contains_word((*f)->extensions, dot, true) && nqm_contains_word((*f)->models, model, false)) {
            *format_ret = *f;
            return NQM_OK;
        }
        if (used < sizeof all && *(*f)->models)
            used += (size_t)snprintf(all + used, sizeof all - used, "%s%s (%s)", f == formats ? "" : "; ",
                                     (*f)->extensions, (*f)->models);
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: no file of this name holds a material '%s'; there are %s", path, model,
                    all);
}

/* In place. */
static void clean_name(char *name) {
    for (char *c = name; *c; ++c)
        *c = isalnum((unsigned char)*c) ? *c : '_';
    if (isdigit((unsigned char)*name))
        *name = '_';
    if (!*name)
        strcpy(name, "material");
}

static bool is_taken(size_t n, const nqm_written_material *materials, const char *name) {
    for (size_t i = 0; i < n; ++i)
        if (strcmp(materials[i].name, name) == 0)
            return true;
    return false;
}

/* The name of material i, which differs from those before: a number is appended. */
static void make_name_unique(size_t i, nqm_written_material *materials) {
    char *name = materials[i].name, stem[sizeof materials->name];
    clean_name(name);
    memcpy(stem, name, sizeof stem);
    for (size_t number = 2; is_taken(i, materials, name); ++number)
        snprintf(name, sizeof stem, "%.50s_%zu", stem, number);
}

size_t nqm_parse_numbers(const char *text, size_t max_n, double *v) {
    static const char separators[] = " ,\t\r\n";
    size_t n = 0;
    for (text += strspn(text, separators); *text; text += strspn(text, separators)) {
        if (n == max_n || !nqm_parse_double(text, &text, &v[n]) || (*text && !strchr(separators, *text)))
            return 0;
        ++n;
    }
    return n;
}

nqm_status nqm_material_check(const char *model, const char *path, nqm_error *err) {
    const nqm_material_format *format;
    return select_format(model, path, &format, err);
}

nqm_status nqm_materials_write(size_t n, nqm_written_material *materials, const char *path, nqm_outset *set,
                               nqm_error *err) {
    const nqm_material_format *format = NULL;
    nqm_outfile out = {0};
    for (size_t i = 0; i < n; ++i)
        make_name_unique(i, materials);
    nqm_status status = select_format(materials->values.schema->model, path, &format, err);
    if (status == NQM_OK)
        status = nqm_outfile_open(path, &out, err);
    if (status == NQM_OK)
        status = format->write(n, materials, path, out.stream, err);
    if (status == NQM_OK)
        return nqm_outfile_keep(&out, set, err);
    nqm_outfile_abort(&out);
    return status;
}
