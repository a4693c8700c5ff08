/* SPDX-License-Identifier: MIT
 *
 * The texts of tests/vectors/materials.txt: what becomes of each; and no beginning of one is read past its end, whichever allocation fails.
 */
#include "brdf/brdf.h"
#include "material/maps.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/map_text.h"
#include "support/rows.h"

typedef struct material_text {
    size_t n_materials, n_lines;
    char path[40];                                /* materials.txt:LINE.FORMAT */
    char *format, *verdict, *byte, *words, *text; /* as in the file */
    char *lines;                                  /* n_lines strings "- ...", each after the NUL of the one before */
} material_text;

/* End the string at the next `c`; what is after it. */
static char *cut(char *text, char c) {
    char *end = strchr(text, c);
    assert_non_null(end);
    *end = '\0';
    return end + 1;
}

#define FAIL(T, ...)                                                                                                   \
    do {                                                                                                               \
        print_error("%s: ", (T)->path);                                                                                \
        fail_msg(__VA_ARGS__);                                                                                         \
    } while (0)

static void expect(const material_text *t, const char *where, const char *what) {
    if (!where || !strstr(where, what))
        FAIL(t, "'%s' is not in '%s'", what, where ? where : "nothing");
}

static void check_position(const material_text *t, const nqm_textured *maps, const char *line) {
    double u, v, x, y;
    size_t i = 0;
    assert_int_equal(sscanf(line, "at %lf %lf: %lf %lf", &u, &v, &x, &y), 4);
    while (i < maps->n_nodes && maps->nodes[i].op != NQM_MAP_IMAGE)
        ++i;
    assert_true(i < maps->n_nodes);
    const double(*uv)[3] = maps->nodes[i].uv;
    const double found[2] = {uv[0][0] * u + uv[0][1] * v + uv[0][2], uv[1][0] * u + uv[1][1] * v + uv[1][2]};
    if (!(fabs(found[0] - x) < 1e-12 && fabs(found[1] - y) < 1e-12))
        FAIL(t, "'%s': %g %g", line, found[0], found[1]);
}

/* What a line "KEY VALUE" is about. */
static void describe(const nqm_textured *maps, const char *key, char found[MAP_TEXT]) {
    *found = '\0';
    if (strcmp(key, "nodes") == 0)
        snprintf(found, MAP_TEXT, "%zu", maps->n_nodes);
    else if (strcmp(key, "constants") == 0) {
        char *spec = nqm_values_spec(&maps->values);
        snprintf(found, MAP_TEXT, "%s", spec);
        nqm_free(spec);
    } else if (strcmp(key, "keys") == 0)
        for (size_t i = 0; i < maps->n_outputs; ++i)
            snprintf(found + strlen(found), MAP_TEXT - strlen(found), "%s%s", i ? " " : "", maps->outputs[i].key);
    else
        describe_map(maps, key, found);
}

static void check_maps(const material_text *t, const nqm_textured *maps, const char *remark, char *line) {
    char found[MAP_TEXT];
    if (strncmp(line, "at ", 3) == 0) {
        check_position(t, maps, line);
        return;
    }
    const char *value = cut(line, ' ');
    if (strcmp(line, "remark") == 0) {
        expect(t, remark ? remark : "no remark", value);
        return;
    }
    describe(maps, line, found);
    if (strcmp(found, value) != 0)
        FAIL(t, "%s: '%s' instead of '%s'", line, found, value);
}

/* What of the material reflects: it is refused unless exactly the words are ignored. */
static const char *reflection(const material_text *t, const nqm_materials *materials, nqm_material_info info) {
    unsigned set;
    assert_true(nqm_ignore_parse(t->words, strlen(t->words), &set));
    if (!info.ignorable || strcmp(info.ignorable, t->words) != 0)
        FAIL(t, "ignorable: %s", info.ignorable ? info.ignorable : info.refusal);
    if (!nqm_materials_reflecting(materials, 0, set & (set - 1)).refusal)
        FAIL(t, "accepted when one word is missing");
    const nqm_material_info taken = nqm_materials_reflecting(materials, 0, ~0U);
    if (taken.refusal || strcmp(taken.spec, info.reflection) != 0)
        FAIL(t, "%s instead of %s", taken.refusal ? taken.refusal : taken.spec, info.reflection);
    return taken.spec;
}

/* Line i: the beginning of "NAME | SURFACE | SPEC", or "NAME | SURFACE | refused". */
static void check_list(const material_text *t, const nqm_materials *materials) {
    const char *line = t->lines;
    if (nqm_materials_count(materials) != t->n_lines)
        FAIL(t, "%zu materials", nqm_materials_count(materials));
    for (size_t i = 0; i < t->n_lines; ++i, line += strlen(line) + 1) {
        char found[500];
        const nqm_material_info info = nqm_materials_get(materials, i);
        snprintf(found, sizeof found, "- %s | %s | %s", info.name, info.surface, info.spec ? info.spec : "refused");
        if (strncmp(found, line, strlen(line)) != 0)
            FAIL(t, "'%s' instead of '%s'", found, line);
    }
}

static void check_material(const material_text *t, const nqm_materials *materials) {
    const bool is_accepted = strcmp(t->verdict, "accepted") == 0, is_textured = strcmp(t->verdict, "textured") == 0;
    const size_t n = nqm_materials_count(materials);
    const nqm_material_info info = nqm_materials_get(materials, n - 1);
    const char *spec = info.spec;
    if (n != t->n_materials || !is_accepted == (spec != NULL))
        FAIL(t, "%zu materials, the last is %s", n, spec ? spec : info.refusal);
    if (!is_accepted && info.byte_offset != atoll(t->byte))
        FAIL(t, "byte %lld: %s", (long long)info.byte_offset, info.refusal);
    if (is_accepted && t->n_lines == 0 && strcmp(spec, t->words) != 0)
        FAIL(t, "'%s' instead of '%s'", spec, t->words);
    else if (strcmp(t->verdict, "reflects") == 0)
        spec = reflection(t, materials, info);
    else
        expect(t, is_accepted ? spec : info.refusal, t->words);
    if (spec)
        nqm_brdf_free(must_open(spec));
    const nqm_textured *maps = nqm_materials_maps(materials, n - 1, 0);
    if (is_textured && !maps)
        FAIL(t, "no maps: %s", info.refusal);
    char *next = t->lines;
    for (size_t i = 0; i < t->n_lines; ++i) {
        char *line = next + 2;
        next += strlen(next) + 1;
        if (is_textured)
            check_maps(t, maps, info.remark, line);
        else if (strncmp(line, "remark ", 7) == 0)
            expect(t, info.remark ? info.remark : "no remark", line + 7);
        else if (strncmp(line, "unused ", 7) == 0)
            expect(t, info.unused ? info.unused : "nothing unused", line + 7);
        else
            expect(t, spec, line);
    }
}

static bool is_same(const char *a, const char *b) {
    return a && b ? strcmp(a, b) == 0 : a == b;
}

/* Reading fails cleanly whichever allocation fails; a material may be refused for that. One that is not is the whole material. */
static void fail_allocations(const material_text *t, const nqm_map *map, const nqm_materials *whole) {
    const nqm_material_info expected = nqm_materials_get(whole, 0);
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_materials *materials = NULL;
        status = nqm_materials_read(map, &materials, NULL);
        assert_true((status == NQM_OK) == (materials != NULL));
        const nqm_material_info info = materials ? nqm_materials_get(materials, 0) : expected;
        if (info.refusal && strstr(info.refusal, "memory"))
            status = NQM_ERR_NOMEM;
        else if (info.n_maps != expected.n_maps || !is_same(info.spec, expected.spec) ||
                 !is_same(info.refusal, expected.refusal))
            FAIL(t, "allocation %ld: another material: %s", n, info.refusal ? info.refusal : info.spec);
        nqm_materials_free(materials);
    }
}

static void check(const material_text *t) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    blob b = {malloc(strlen(t->text)), strlen(t->text)}; /* exactly as long, for sanitizers */
    assert_non_null(b.data);
    memcpy(b.data, t->text, b.n_bytes);
    const nqm_map map = {.data = b.data, .n_bytes = b.n_bytes, .path = t->path};
    const nqm_status status = nqm_materials_read(&map, &materials, &err);
    if (strcmp(t->verdict, "error") == 0) {
        if (status != NQM_ERR_FORMAT || materials)
            FAIL(t, "%s", nqm_status_text(status));
        expect(t, err.message, t->words);
        if (err.byte_offset != atoll(t->byte))
            FAIL(t, "byte %lld: %s", (long long)err.byte_offset, err.message);
    } else {
        if (status != NQM_OK)
            FAIL(t, "%s", err.message);
        if (strcmp(t->verdict, "listed") == 0)
            check_list(t, materials);
        else
            check_material(t, materials);
        fail_allocations(t, &map, materials);
    }
    nqm_materials_free(materials);
    while (b.n_bytes && strchr(" \n", b.data[b.n_bytes - 1]))
        --b.n_bytes;
    if (strcmp(t->format, "pbrt") == 0 || strcmp(t->format, "usda") == 0)
        survive_cuts(t->path, b, 1, read_materials);
    else
        refuse_cuts(t->path, b, 1, read_materials);
    blob_free(&b);
}

static material_text parse(char *head, size_t line) {
    material_text t = {.format = head, .n_materials = 1};
    t.verdict = cut(t.format, ' ');
    t.byte = cut(t.verdict, ' ');
    t.words = cut(t.byte, ' ');
    t.text = t.lines = cut(t.words, '\n');
    for (; strncmp(t.text, "- ", 2) == 0; ++t.n_lines)
        t.text = cut(t.text, '\n');
    if (strchr(t.format, '/'))
        t.n_materials = (size_t)atoi(cut(t.format, '/'));
    snprintf(t.path, sizeof t.path, "materials.txt:%zu.%s", line, t.format);
    return t;
}

TEST(every_text) {
    blob file = blob_load(test_vector("materials.txt"));
    char *all = (char *)file.data, *next;
    size_t n = 0, line = 2;       /* of the next head */
    all[file.n_bytes - 1] = '\0'; /* the end of the last line */
    for (const char *c = all; strncmp(c, "\n= ", 3) != 0; ++c)
        line += *c == '\n';
    for (char *at = strstr(all, "\n= "); at; at = next, ++n) {
        next = strstr(at + 1, "\n= ");
        if (next)
            *next = '\0';
        size_t n_lines = 1;
        for (const char *c = at + 1; *c; ++c)
            n_lines += *c == '\n';
        const material_text t = parse(at + 3, line);
        check(&t);
        line += n_lines;
    }
    assert_true(n > 400);
    blob_free(&file);
}

/* A BRDF that is written to a file and read back has the same canonical spec. */
TEST(round_trips) {
    EVERY_ROW(row, "round trips of materials") {
        const char *path = scratch_path(row[0]);
        char argument[320];
        nqm_brdf *brdf = must_open(row[1]);
        nqm_error err = {0};
        if (nqm_material_write(nqm_brdf_get_info(brdf).spec, "Gold leaf", path, &err) != NQM_OK)
            fail_msg("%s: %s", row[1], err.message);
        snprintf(argument, sizeof argument, "%s:Gold_leaf", path);
        nqm_brdf *back = must_open(argument);
        assert_string_equal(nqm_brdf_get_info(back).spec, nqm_brdf_get_info(brdf).spec);
        nqm_brdf_free(back);
        nqm_brdf_free(brdf);
    }
}
