/* SPDX-License-Identifier: MIT
 *
 * Textured materials that are no file of a renderer: a list of maps
 * ("maps:base_color=a.png;roughness=b.png;model=gltf"), and a folder whose maps are found by the names that libraries and
 * exporters give them.
 */
#include "base/os.h"
#include "material/materialx.h"

#include "schema/models.h"
#include <ctype.h>
#include <stdlib.h>

static const char LIST_PREFIX[] = NQM_MAPS_PREFIX;

/* ---- keys -------------------------------------------------------------------------------------------------------- */

/* The inputs of the model of the material; those with a key are its keys. */
static const nqm_rule *inputs_of(const nqm_textured *t) {
    return nqm_mtlx_find_surface(NULL, t->values.schema->model)->inputs;
}

/* NULL: there is no such key. */
static const nqm_rule *find_key(const nqm_textured *t, const char *name) {
    const nqm_rule *key = nqm_rule_find(inputs_of(t), name);
    return key && key->key ? key : NULL;
}

static nqm_status fail_key(const nqm_textured *t, const char *entry, nqm_error *err) {
    char names[700] = "";
    size_t used = 0;
    for (const nqm_rule *input = inputs_of(t); input->name && used < sizeof names; ++input)
        if (input->key)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s, ", input->key);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s%.60s: no such key; there are: %snormal, model", LIST_PREFIX, entry,
                    names);
}

/* ---- one map ----------------------------------------------------------------------------------------------------- */

/* Of what a map has to do with its key. */
typedef enum reading { AS_IS, INVERTED } reading;

/* Let a key, or NULL: the normal, have the values of a file. channel: of those keys that have one value; of the normal
 * 1: its y points downwards. */
static nqm_status add_map(nqm_textured *t, const nqm_rule *key, const char *from, const char *file, size_t channel,
                          reading how, nqm_error *err) {
    const char *dot = strrchr(file, '.');
    const bool is_coded = key && key->n == 3 && !(dot && nqm_equal_any_case(dot, ".exr", SIZE_MAX));
    size_t image;
    if (!nqm_graph_add_file(t, from, file, is_coded ? "srgb_texture" : "", &image))
        return nqm_fail(err, NQM_ERR_NOMEM, -1, "%s: out of memory, or more than %d maps", file, NQM_MAX_MAP_IMAGES);
    t->images[image].needs_alpha |= key && channel == 3 && !*from;
    t->images[image].expects_alpha |= key && channel == 3;
    t->images[image].needs_color |= key && key->n == 1 && (channel == 1 || channel == 2);
    uint16_t node = nqm_graph_image_at(t, image, channel == 3 ? 4 : 3, NULL, NULL);
    if (key) {
        node = key->n == 1 ? nqm_graph_channel(t, node, channel) : node;
        if (how == INVERTED)
            node = nqm_graph_compute(t, NQM_MAP_SUBTRACT, 1, nqm_graph_number(t, 1), node, 0);
        nqm_graph_output_set(t, key->key, node);
    } else {
        const double scale[2] = {1, channel ? -1 : 1};
        t->normal = node = nqm_graph_compute(t, NQM_MAP_NORMAL, 3, node, nqm_graph_value(t, 2, scale), 0);
    }
    return node == NQM_NO_NODE ? nqm_fail_nomem(err, sizeof *t->nodes) : NQM_OK;
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

/* The channel that ends the text, "orm.png:g", which is removed. Of a normal 1 for "n.png:dx": its green channel points down, as in
 * Direct3D. */
static size_t read_channel(char *text, bool is_normal) {
    char *colon = strrchr(text, ':');
    const size_t channel = colon ? nqm_find_word(is_normal ? "dx" : "r g b a", colon + 1, false) : SIZE_MAX;
    if (channel == SIZE_MAX)
        return 0;
    *colon = 0;
    return is_normal ? 1 : channel;
}

/* key NULL: the normal */
static bool is_given(nqm_textured *t, const nqm_rule *key) {
    return key ? nqm_values_given(&t->values, key->key) || nqm_graph_output(t, key->key) : t->normal != NQM_NO_NODE;
}

static nqm_status add_entry(nqm_textured *t, char *entry, nqm_error *err) {
    char *value = strchr(entry, '=');
    if (!value || !value[1])
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s%.100s: needs KEY=FILE or KEY=NUMBER", LIST_PREFIX, entry);
    *value++ = 0;
    const bool is_normal = strcmp(entry, "normal") == 0;
    const nqm_rule *key = is_normal ? NULL : find_key(t, entry);
    double v[3];
    if (strcmp(entry, "model") == 0 && strcmp(value, t->values.schema->model) == 0)
        return NQM_OK; /* read before the others */
    if (strcmp(entry, "model") == 0)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%smodel is given twice", LIST_PREFIX);
    if (!is_normal && !key)
        return fail_key(t, entry, err);
    if (is_given(t, key))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s%s is given twice", LIST_PREFIX, entry);
    const size_t n = nqm_parse_numbers(value, 3, v);
    if (n && (is_normal || (n != 1 && n != key->n)))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s%s=%.60s: needs a file%s", LIST_PREFIX, entry, value,
                        is_normal     ? ""
                        : key->n == 1 ? " or a number"
                                      : ", a number or three of them");
    if (n)
        nqm_values_set(&t->values, entry, n, v);
    const size_t channel = read_channel(value, is_normal);
    return n ? NQM_OK : add_map(t, key, "", value, channel, AS_IS, err);
}

static nqm_status find_list_model(nqm_textured *t, const char *list, nqm_error *err) {
    const char *at = strncmp(list, "model=", 6) == 0 ? list - 1 : strstr(list, ";model="), *name = at ? at + 7 : "gltf";
    const size_t n = strcspn(name, ";");
    const nqm_schema *schema = nqm_schema_find(name, n);
    if (!schema || !nqm_mtlx_find_surface(NULL, schema->model))
        return nqm_fail(
            err, NQM_ERR_ARG, -1,
            "%smodel=%.*s: no such model; maps are read for gltf, open-pbr, standard-surface, usd-preview and disney",
            LIST_PREFIX, (int)n, name);
    t->values = nqm_values_of(schema);
    return NQM_OK;
}

static nqm_status read_list(nqm_textured *t, const char *list, nqm_error *err) {
    char *text = nqm_strdup(list), *entry = text;
    if (!text)
        return nqm_fail_nomem(err, strlen(list));
    nqm_status status = find_list_model(t, list, err);
    while (status == NQM_OK && *(entry += strspn(entry, ";"))) {
        char *end = entry + strcspn(entry, ";");
        const bool is_last = !*end;
        *end = 0;
        status = add_entry(t, entry, err);
        entry = end + !is_last;
    }
    nqm_free(text);
    if (status == NQM_OK && !t->n_images)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s%.100s: names no map (KEY=FILE)", LIST_PREFIX, list);
    return status;
}

/* glTF's default is metal, which no list of maps means: it is 0 in lists and folders that do not give it. */
static void set_default_metallic(nqm_textured *t) {
    if (t->values.schema != &nqm_gltf_schema || is_given(t, find_key(t, "metallic")))
        return;
    nqm_values_set(&t->values, "metallic", 1, &(double){0});
    nqm_textured_remark(t, "metallic is 0, as nothing gives it");
}

/* ---- folders ----------------------------------------------------------------------------------------------------- */

/* What the names of the maps of a key end with: those of ambientCG, Poly Haven, Poliigon, Quixel, MatSynth, Substance, Unity (which
 * has smoothness, in the alpha of the metalness or mask) and Unreal (_BC, _N, _ORM; its normals have y downwards). Rows of one key:
 * the first one that is there is meant. */
static const struct map_name {
    const char *endings, *key;
    size_t channel;
    reading how;
} map_names[] = {{"color basecolor base_color albedo col albedotransparency basemap bc", "base_color", 0, AS_IS},
                 {"diff diffuse", "base_color", 0, AS_IS},
                 {"roughness rough", "roughness", 0, AS_IS},
                 {"arm orm occlusionroughnessmetallic", "roughness", 1, AS_IS},
                 {"metallicroughness", "roughness", 1, AS_IS},
                 {"gloss glossiness smoothness", "roughness", 0, INVERTED},
                 {"metallicsmoothness maskmap", "roughness", 3, INVERTED},
                 {"metallic metalness metal", "metallic", 0, AS_IS},
                 {"arm orm occlusionroughnessmetallic", "metallic", 2, AS_IS},
                 {"metallicroughness", "metallic", 2, AS_IS},
                 {"metallicsmoothness maskmap", "metallic", 0, AS_IS},
                 {"specular", "specular_color", 0, AS_IS},
                 {"normal normals normalgl normal_gl nor_gl nor nrm normalmap normal_ogl", "normal", 0, AS_IS},
                 {"normaldx normal_dx nor_dx normal_directx n", "normal", 1, AS_IS}};
enum { N_NAMES = sizeof map_names / sizeof *map_names };

/* Whether the end of a name says only of which size or variant the file is: "2k", "2048", "var1", and "png" of "1K-PNG". */
static bool is_size(const char *word) {
    const size_t n = strspn(word, "0123456789");
    return (n && (strcmp(word + n, "k") == 0 || (n > 2 && !word[n]))) ||
           nqm_contains_word("png jpg webp", word, false) ||
           (strncmp(word, "var", 3) == 0 && word[3] && !word[3 + strspn(word + 3, "0123456789")]);
}

/* "_" and the name of a file in lower case, with '_' for '-' and blanks, without its extension and resolution. false:
 * no picture. */
static bool simplify(const char *file, char *name, size_t n_name) {
    const char *dot = strrchr(file, '.');
    if (!dot || !nqm_contains_word("png jpg jpeg webp exr", dot + 1, true))
        return false;
    snprintf(name, n_name, "_%.*s", (int)(dot - file), file);
    for (char *c = name; *c; ++c)
        *c = strchr("- .", *c) ? '_' : (char)tolower((unsigned char)*c);
    for (char *last = strrchr(name, '_'); last > name && is_size(last + 1); last = strrchr(name, '_'))
        *last = 0;
    return true;
}

static bool is_map_of(const char *file, const struct map_name *map) {
    char name[300];
    const char *end = simplify(file, name, sizeof name) ? strchr(name, '_') : NULL;
    while (end && !nqm_contains_word(map->endings, end + 1, false))
        end = strchr(end + 1, '_');
    return end != NULL;
}

/* is_used: (n) receives whether a file is a map. */
static nqm_status add_found(nqm_textured *t, const char *from, const nqm_names *files, bool *is_used, nqm_error *err) {
    nqm_status status = NQM_OK;
    const char *done = ""; /* the key of the last map */
    bool has_metallic = false;
    for (const struct map_name *map = map_names; map < map_names + N_NAMES && status == NQM_OK; ++map) {
        const bool is_specular = strcmp(map->key, "specular_color") == 0;
        size_t found = files->n; /* none */
        for (size_t f = 0; f < files->n && strcmp(done, map->key) != 0 && !(is_specular && has_metallic); ++f) {
            if (!is_map_of(nqm_name(files, f), map))
                continue;
            if (found < files->n)
                return nqm_fail(err, NQM_ERR_ARG, -1, "%s: two maps of %s: %.80s and %.80s; say which: %s%s=%.80s;...",
                                from, map->key, nqm_name(files, found), nqm_name(files, f), LIST_PREFIX, map->key,
                                nqm_name(files, f));
            found = f;
        }
        if (found == files->n)
            continue;
        done = map->key;
        is_used[found] = true;
        has_metallic |= strcmp(map->key, "metallic") == 0;
        if (is_specular) /* the colour of the reflection at normal incidence: of an infinite index of refraction */
            nqm_values_set(&t->values, "ior", 1, &(double){1e7});
        status = add_map(t, find_key(t, map->key), from, nqm_name(files, found), map->channel, map->how, err);
    }
    return status;
}

/* Name the pictures that are no map; those for which there is no room are counted. */
static void add_unused(nqm_textured *t, const nqm_names *files, const bool *is_used) {
    enum { ROOM = NQM_REMARK_SIZE - 100 };
    char text[NQM_REMARK_SIZE] = "", name[300];
    size_t used = 0, n_more = 0;
    for (size_t f = 0; f < files->n; ++f) {
        if (is_used[f] || !simplify(nqm_name(files, f), name, sizeof name))
            continue;
        if (used + strlen(nqm_name(files, f)) + 12 > ROOM)
            ++n_more;
        else
            used += (size_t)snprintf(text + used, ROOM - used, "%s%s", used ? ", " : "not used: ", nqm_name(files, f));
    }
    if (n_more)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%zu more", used ? " and " : "not used: ", n_more);
    if (used)
        nqm_textured_remark(t, text);
}

static nqm_status read_files(nqm_textured *t, const char *path, const char *from, const nqm_names *files,
                             nqm_error *err) {
    bool *is_used = nqm_alloc(files->n, sizeof *is_used);
    if (!is_used)
        return nqm_fail_nomem(err, files->n * sizeof *is_used);
    nqm_status status = add_found(t, from, files, is_used, err);
    add_unused(t, files, is_used);
    nqm_free(is_used);
    if (status == NQM_OK && !t->n_images)
        status = nqm_fail(err, NQM_ERR_IO, -1,
                          "%s: no file of this folder is named like a map (..._color.png, ..._diff_2k.jpg, "
                          "..._roughness.png, ..._normalgl.png); list them: %sbase_color=FILE;roughness=FILE",
                          path, LIST_PREFIX);
    return status;
}

static nqm_status read_folder(nqm_textured *t, const char *path, nqm_error *err) {
    nqm_names files = {.n = 0};
    char from[4096];
    t->values = nqm_values_of(&nqm_gltf_schema);
    if (snprintf(from, sizeof from, "%s/", path) >= (int)sizeof from)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: the folder cannot be read", path);
    nqm_status status = nqm_os_list_folder(path, &files, err);
    if (status == NQM_OK)
        status = read_files(t, path, from, &files, err);
    nqm_names_free(&files);
    return status;
}

static bool is_network(const char *file) {
    static const char name[] = "fc1.npy";
    const size_t n = strlen(file), n_name = strlen(name);
    return n >= n_name && strcmp(file + n - n_name, name) == 0;
}

size_t nqm_networks_in_folder(const char *path, char **first_ret) {
    nqm_names files = {.n = 0};
    size_t n = 0;
    *first_ret = NULL;
    const nqm_status status = nqm_os_list_folder(path, &files, NULL);
    for (size_t i = 0; status == NQM_OK && i < files.n; ++i)
        if (is_network(nqm_name(&files, i)) && n++ == 0)
            *first_ret = nqm_strdupf("%s/%s", path, nqm_name(&files, i));
    nqm_names_free(&files);
    return status == NQM_ERR_NOMEM ? 1 : n;
}

nqm_status nqm_maps_open(const char *argument, nqm_textured **textured_ret, nqm_error *err) {
    const bool is_list = strncmp(argument, LIST_PREFIX, strlen(LIST_PREFIX)) == 0;
    nqm_textured *t = nqm_textured_create();
    *textured_ret = NULL;
    if (!t)
        return nqm_fail_nomem(err, sizeof *t);
    nqm_status status = is_list ? read_list(t, argument + strlen(LIST_PREFIX), err) : read_folder(t, argument, err);
    set_default_metallic(t);
    if (status == NQM_OK)
        *textured_ret = t;
    else
        nqm_textured_free(t);
    return status;
}
