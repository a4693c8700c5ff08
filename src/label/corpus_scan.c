/* SPDX-License-Identifier: MIT
 *
 * From a data folder to a material list: which forms of which material there are, which materials are held out, and
 * which serve for validation.
 */
#include "label/corpus.h"

#include <ctype.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>

static const double validation_share = 0.15;

/* A list of owned strings. */
typedef struct names {
    char **text;
    size_t n, n_room;
    bool failed; /* out of memory */
} names;

static void names_add(names *list, const char *text, size_t n_text) {
    if (list->n == list->n_room) {
        size_t n_room = 2 * list->n_room + 64;
        char **grown = nqm_alloc(n_room, sizeof *grown);
        if (!grown) {
            list->failed = true;
            return;
        }
        if (list->n)
            memcpy(grown, list->text, list->n * sizeof *grown);
        nqm_free(list->text);
        list->text = grown;
        list->n_room = n_room;
    }
    char *copy = nqm_alloc(n_text + 1, 1);
    if (!copy) {
        list->failed = true;
        return;
    }
    memcpy(copy, text, n_text);
    list->text[list->n++] = copy;
}

static void names_free(names *list) {
    for (size_t i = 0; i < list->n; ++i)
        nqm_free(list->text[i]);
    nqm_free(list->text);
    *list = (names){0};
}

static bool names_has(const names *list, const char *text) {
    for (size_t i = 0; i < list->n; ++i)
        if (strcmp(list->text[i], text) == 0)
            return true;
    return false;
}

static int compare_text(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* The state of a scan. */
typedef struct scan {
    const char *dir;
    uint64_t seed;
    names held_out;
    FILE *out;
    size_t n_rows;
} scan;

/* FNV-1a; only to give each group's name a counter of its own. */
static uint64_t text_hash(const char *text) {
    uint64_t h = 0xcbf29ce484222325u;
    for (; *text; ++text)
        h = (h ^ (unsigned char)*text) * 0x100000001b3u;
    return h;
}

static nqm_split split_of(const scan *s, const char *group) {
    if (names_has(&s->held_out, group))
        return NQM_SPLIT_TEST;
    double u = (double)(nqm_hash_u64(s->seed, text_hash(group)) >> 11) * 0x1p-53;
    return u < validation_share ? NQM_SPLIT_VALIDATION : NQM_SPLIT_TRAIN;
}

static void put_quoted_part(FILE *out, const char *text) {
    for (; *text; ++text) {
        if (*text == '"')
            fputc('"', out);
        fputc(*text, out);
    }
}

/* A field made of up to three parts, quoted where it has to be. */
static void put_field(FILE *out, const char *a, const char *b, const char *c) {
    static const char special[] = ",\"\r\n";
    if (!strpbrk(a, special) && !strpbrk(b, special) && !strpbrk(c, special)) {
        fprintf(out, "%s%s%s", a, b, c);
        return;
    }
    fputc('"', out);
    put_quoted_part(out, a);
    put_quoted_part(out, b);
    put_quoted_part(out, c);
    fputc('"', out);
}

/* `member`: the material is one of several in the file. */
static void put_row(scan *s, const char *source, const char *material, const char *file, bool member) {
    put_field(s->out, source, "-", material);
    fputc(',', s->out);
    put_field(s->out, material, "", "");
    fputc(',', s->out);
    put_field(s->out, file, member ? ":" : "", member ? material : "");
    fprintf(s->out, ",%s,%s\n", source, nqm_corpus_split_name(split_of(s, material)));
    ++s->n_rows;
}

/* ---- the held-out materials -------------------------------------------------------------------------------------- */

/* "aluminium_7" is the 7th encoding of aluminium. */
static size_t length_without_number(const char *text) {
    size_t n = strlen(text), end = n;
    while (end > 0 && isdigit((unsigned char)text[end - 1]))
        --end;
    return end > 1 && end < n && text[end - 1] == '_' ? end - 1 : n;
}

static nqm_status read_held_out(scan *s, nqm_error *err) {
    char path[4096];
    snprintf(path, sizeof path, "%s/labels/labels_real.csv", s->dir);
    nqm_csv *csv;
    nqm_status status = nqm_csv_load(path, &csv, err);
    if (status != NQM_OK)
        return status;
    int column = nqm_csv_column(csv, "material");
    if (column < 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no column 'material'", path);
    for (size_t i = 0; status == NQM_OK && i < nqm_csv_rows(csv); ++i) {
        const char *text = nqm_csv_text(csv, i, column);
        names_add(&s->held_out, text, length_without_number(text));
    }
    nqm_csv_free(csv);
    return status == NQM_OK && s->held_out.failed ? nqm_fail_nomem(err, 64) : status;
}

/* ---- the folders ------------------------------------------------------------------------------------------------- */

/* Files that match DIR/pattern, sorted; none is fine. */
static nqm_status find_files(const scan *s, const char *pattern, glob_t *found, nqm_error *err) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", s->dir, pattern);
    int result = glob(path, 0, NULL, found);
    if (result == 0 || result == GLOB_NOMATCH)
        return NQM_OK;
    return nqm_fail(err, result == GLOB_NOSPACE ? NQM_ERR_NOMEM : NQM_ERR_IO, -1, "%s: cannot be listed", path);
}

static nqm_status scan_rgl(scan *s, nqm_error *err) {
    glob_t found = {0};
    nqm_status status = find_files(s, "rgl/*.bsdf", &found, err);
    for (size_t i = 0; status == NQM_OK && i < found.gl_pathc; ++i) {
        const char *file = found.gl_pathv[i] + strlen(s->dir) + 1;
        char material[256];
        snprintf(material, sizeof material, "%s", strrchr(file, '/') + 1);
        material[strlen(material) - strlen(".bsdf")] = 0;
        put_row(s, "rgl", material, file, false);
    }
    globfree(&found);
    return status;
}

static void add_member(void *user, const char *name) {
    names_add(user, name, strlen(name) - strlen(".h5"));
}

static nqm_status scan_nbrdf(scan *s, nqm_error *err) {
    glob_t found = {0};
    nqm_status status = find_files(s, "nbrdf/*.zip", &found, err);
    for (size_t i = 0; status == NQM_OK && i < found.gl_pathc; ++i) {
        names members = {0};
        status = nqm_zip_each(found.gl_pathv[i], ".h5", add_member, &members, err);
        if (status == NQM_OK && members.failed)
            status = nqm_fail_nomem(err, 64);
        if (status == NQM_OK && members.n > 1)
            qsort(members.text, members.n, sizeof *members.text, compare_text);
        for (size_t k = 0; status == NQM_OK && k < members.n; ++k)
            put_row(s, "nbrdf", members.text[k], found.gl_pathv[i] + strlen(s->dir) + 1, true);
        names_free(&members);
    }
    globfree(&found);
    return status;
}

static nqm_status scan_nps(scan *s, nqm_error *err) {
    glob_t found = {0};
    nqm_status status = find_files(s, "nps/nps_latents.csv", &found, err);
    if (status == NQM_OK && found.gl_pathc == 1) {
        nqm_csv *csv = NULL;
        status = nqm_csv_load(found.gl_pathv[0], &csv, err);
        int column = status == NQM_OK ? nqm_csv_column(csv, "material") : -1;
        if (status == NQM_OK && column < 0)
            status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no column 'material'", found.gl_pathv[0]);
        for (size_t i = 0; status == NQM_OK && i < nqm_csv_rows(csv); ++i)
            put_row(s, "nps", nqm_csv_text(csv, i, column), "nps/nps_decoder_f32le.bin", true);
        nqm_csv_free(csv);
    }
    globfree(&found);
    return status;
}

static void scan_presets(scan *s) {
    for (size_t i = 0; i < nqm_brdf_preset_count(); ++i) {
        const char *name = nqm_brdf_preset_name(i);
        if (strncmp(name, "sgd:", 4) == 0)
            put_row(s, "sgd", name + 4, name, false);
    }
}

nqm_status nqm_corpus_scan(const char *data_dir, uint64_t seed, const char *path, nqm_error *err) {
    size_t n_dir = strlen(data_dir);
    while (n_dir > 1 && data_dir[n_dir - 1] == '/')
        --n_dir;
    char *dir = nqm_alloc(n_dir + 1, 1);
    if (!dir)
        return nqm_fail_nomem(err, n_dir + 1);
    /* NOLINTNEXTLINE(bugprone-not-null-terminated-result): nqm_alloc() gives zeros */
    memcpy(dir, data_dir, n_dir);
    scan s = {.dir = dir, .seed = seed};
    nqm_outfile out = {0};
    nqm_status status = nqm_outfile_open(path, &out, err);
    s.out = out.stream;
    if (status == NQM_OK)
        status = read_held_out(&s, err);
    if (status != NQM_OK)
        goto done;
    fputs("name,group,brdf,source,split\n", s.out);
    status = scan_rgl(&s, err);
    if (status == NQM_OK)
        status = scan_nbrdf(&s, err);
    if (status == NQM_OK)
        status = scan_nps(&s, err);
    if (status == NQM_OK && s.n_rows == 0)
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: holds none of rgl/*.bsdf, nbrdf/*.zip, nps/nps_latents.csv", dir);
    if (status != NQM_OK)
        goto done;
    scan_presets(&s);
    status = nqm_outfile_commit(&out, err);
done:
    nqm_outfile_abort(&out);
    names_free(&s.held_out);
    nqm_free(dir);
    return status;
}
