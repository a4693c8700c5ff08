/* SPDX-License-Identifier: MIT
 *
 * The functions that JavaScript calls (web/nqm.js): BRDFs by number, results as JSON, pictures as pixels. Everything is computed by the
 * library and by the parts of the tool that have no command line.
 */
#include "brdf/brdf.h"
#include "brdf/core/spec.h"
#include "figures/picture.h"
#include "math/math.h"
#include "nqm/show/charts.h"
#include "pairs/pairs.h"
#include "render/render.h"
#include <nqm/translate.h>

#include <jansson.h>
#include <math.h>
#include <nqm/nqm.h>
#include <nqm/texture.h>
#include <stdlib.h>
#include <unistd.h>

#define EXPORT(NAME) __attribute__((export_name(#NAME))) NAME

/* ---- results ----------------------------------------------------------------------------------------------------- */

static char *result; /* of the last call; freed by the next */

static const char *reply(json_t *json) {
    free(result);
    result = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(json);
    return result ? result : "{\"error\":\"out of memory\",\"status\":-6}";
}

static json_t *error_json(const nqm_error *err) {
    return json_pack("{s:s,s:i,s:I}", "error", err->message, "status", err->status, "byte",
                     (json_int_t)err->byte_offset);
}

static json_t *number(double x) {
    return isfinite(x) ? json_real(x) : json_null();
}

static json_t *text(const char *s) {
    json_t *json = s ? json_string(s) : json_null();
    return json ? json : json_string("(no UTF-8)");
}

void *EXPORT(web_alloc)(size_t n) {
    return nqm_alloc(n, 1);
}

void EXPORT(web_free)(void *block) {
    nqm_free(block);
}

/* ---- models ------------------------------------------------------------------------------------------------------ */

enum { N_MODELS = 2 };
static struct {
    const char *const name;
    nqm_model *model;
    nqm_scorer *scorer;
} models[N_MODELS] = {{.name = "default"}, {.name = "transport"}};

static nqm_status use_model(int i, nqm_error *err) {
    nqm_score_options options = nqm_score_options_default();
    if (i < 0 || i >= N_MODELS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "there is no such model");
    nqm_status status = models[i].model ? NQM_OK : nqm_model_load(models[i].name, &models[i].model, err);
    if (status == NQM_OK && !models[i].scorer)
        status = nqm_scorer_create(models[i].model, &options, &models[i].scorer, err);
    return status;
}

/* The place of an embedded file, which JavaScript fills before the first call; NULL: there is none of this name. */
unsigned char *EXPORT(web_model_bytes)(const char *name) {
    for (const nqm_embedded_file *m = nqm_embedded_models; m->name; ++m)
        if (strcmp(m->name, name) == 0)
            return (unsigned char *)(uintptr_t)m->begin;
    return NULL;
}

/* ---- BRDFs by number --------------------------------------------------------------------------------------------- */

enum { MAX_BRDFS = 4096 };
static nqm_brdf *brdfs[MAX_BRDFS];

static json_t *info_json(int id) {
    const nqm_brdf_info i = nqm_brdf_get_info(brdfs[id]);
    return json_pack("{s:i,s:o,s:o,s:o,s:o,s:o,s:I,s:I,s:b,s:b}", "id", id, "format", text(i.format), "name",
                     text(i.name), "spec", text(i.spec), "doi", text(i.source_doi), "layout", text(i.layout),
                     "n_values", (json_int_t)i.n_values, "n_bytes", (json_int_t)i.n_bytes, "reciprocal", i.reciprocal,
                     "isotropic", i.isotropic);
}

static nqm_status find_place(int *id_ret, nqm_error *err) {
    int id = 0;
    while (id < MAX_BRDFS && brdfs[id])
        ++id;
    *id_ret = id;
    return id < MAX_BRDFS ? NQM_OK : nqm_fail(err, NQM_ERR_LIMIT, -1, "more than %d BRDFs are open", (int)MAX_BRDFS);
}

const char *EXPORT(web_open)(const char *name) {
    nqm_error err = {0};
    int id;
    nqm_status status = find_place(&id, &err);
    if (status == NQM_OK)
        status = nqm_brdf_open(name, &brdfs[id], &err);
    return reply(status == NQM_OK ? info_json(id) : error_json(&err));
}

void EXPORT(web_close)(int id) {
    nqm_brdf_free(brdfs[id]);
    brdfs[id] = NULL;
}

/* JavaScript's function `key` at n pairs of directions, (n, 3) each. */
__attribute__((import_module("env"), import_name("web_call"))) void web_call(int key, int n, const double *wi,
                                                                             const double *wo, double *rgb);
/* Returns nonzero to stop. */
__attribute__((import_module("env"), import_name("web_progress"))) int web_progress(double done);

static void call_function(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    web_call((int)(intptr_t)user, (int)n, wi, wo, rgb);
}

static int pass_progress(void *user, const char *stage, double done, double total) {
    (void)user, (void)stage;
    return web_progress(total > 0 ? done / total : 0);
}

const char *EXPORT(web_function)(int key, const char *name) {
    nqm_error err = {0};
    int id;
    nqm_status status = find_place(&id, &err);
    const nqm_brdf_callbacks callbacks = {.eval = call_function, .user = (void *)(intptr_t)key, .name = name};
    if (status == NQM_OK)
        status = nqm_brdf_create(&callbacks, &brdfs[id], &err);
    return reply(status == NQM_OK ? info_json(id) : error_json(&err));
}

/* wi, wo, rgb: (n, 3); flag: (n). */
void EXPORT(web_eval)(int id, size_t n, const double *wi, const double *wo, double *rgb, uint8_t *flag) {
    nqm_brdf_eval(brdfs[id], n, wi, wo, rgb, flag);
}

/* theta_h, theta_d, phi_d in degrees of the directions of "default": (n, 3). */
const double *EXPORT(web_directions)(void) {
    return use_model(0, NULL) == NQM_OK
               ? nqm_directions_get_info(nqm_model_get_info(models[0].model).directions).degrees
               : NULL;
}

size_t EXPORT(web_direction_count)(void) {
    return use_model(0, NULL) == NQM_OK ? nqm_directions_get_info(nqm_model_get_info(models[0].model).directions).n : 0;
}

/* ---- what there is to choose from -------------------------------------------------------------------------------- */

static json_t *model_keys(const nqm_schema *schema) {
    json_t *keys = json_array();
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const nqm_schema_key *key = &schema->keys[k];
        json_array_append_new(keys, json_pack("{s:s,s:I,s:o,s:o,s:o,s:b}", "name", key->name, "n", (json_int_t)key->n,
                                              "low", number(key->low), "high", number(key->high), "fallback",
                                              number(key->fallback), "required", key->required));
    }
    return keys;
}

/* Presets, models with their keys, and models to which materials are translated. */
const char *EXPORT(web_names)(void) {
    static const nqm_analytic_model *const analytic[] = {
#define ROW(MODEL)         &MODEL,
#define SHADING(NAME, ...) &nqm_##NAME##_model,
        NQM_ANALYTIC_MODELS(ROW) NQM_SHADING_SCHEMAS(SHADING)};
    json_t *presets = json_array(), *schemas = json_array(), *targets = json_array();
    for (size_t i = 0; nqm_brdf_preset_name(i); ++i)
        json_array_append_new(presets, json_string(nqm_brdf_preset_name(i)));
    for (size_t i = 0; i < sizeof analytic / sizeof *analytic; ++i)
        json_array_append_new(schemas, json_pack("{s:s,s:o}", "name", analytic[i]->schema->model, "keys",
                                                 model_keys(analytic[i]->schema)));
    for (size_t i = 0; nqm_translate_target(i).name; ++i)
        json_array_append_new(targets, json_string(nqm_translate_target(i).name));
    return reply(json_pack("{s:o,s:o,s:o,s:s}", "presets", presets, "models", schemas, "targets", targets, "version",
                           nqm_version()));
}

const char *EXPORT(web_materials)(const char *path) {
    nqm_error err = {0};
    nqm_materials *materials;
    if (nqm_materials_open(path, &materials, &err) != NQM_OK)
        return reply(error_json(&err));
    json_t *list = json_array();
    for (size_t i = 0; i < nqm_materials_count(materials); ++i) {
        const nqm_material_info m = nqm_materials_get(materials, i);
        json_array_append_new(list, json_pack("{s:o,s:o,s:o,s:o,s:o,s:I,s:I}", "name", text(m.name), "surface",
                                              text(m.surface), "spec", text(m.spec), "refusal", text(m.refusal),
                                              "remark", text(m.remark), "n_maps", (json_int_t)m.n_maps, "byte",
                                              (json_int_t)m.byte_offset));
    }
    nqm_materials_free(materials);
    return reply(list);
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

static json_t *score_json(const char *ref, const char *test, const nqm_score_result *r, const nqm_error *err) {
    if (r->status != NQM_OK)
        return error_json(err);
    const nqm_label_info info = nqm_label_get_info(&r->parts);
    const char *words = isnan(r->parts.structure) ? "" : info.words;
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        json_object_set_new(metrics, nqm_metric_get_info((nqm_metric)m).name, number(r->metrics[m]));
    char verdict[NQM_VERDICT_TEXT], remarks[NQM_REMARKS_TEXT];
    json_t *sentences = json_array();
    nqm_pairs_remarks(models[0].model, NQM_INVALID_DROP, &(nqm_named_pair){ref, test}, ref, test, r, remarks);
    for (const char *at = remarks; *at; at += strlen(at) + 1)
        json_array_append_new(sentences, text(at));
    return json_pack(
        "{s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:s,s:[ooo],s:o,s:o,s:[ooo],s:o,s:b,s:o,s:I}", "verdict",
        nqm_verdict(r, verdict), "prefer_reference", number(nqm_verdict_preference(r)), "remarks", sentences, "jod",
        number(r->jod), "low", number(r->jod_low), "high", number(r->jod_high), "delta_e", number(r->delta_e),
        "novelty", number(r->novelty), "words", words, "shift", number(r->parts.shift[0]), number(r->parts.shift[1]),
        number(r->parts.shift[2]), "contrast", number(r->parts.contrast), "structure", number(r->parts.structure),
        "apart", number(r->similarity[0]), number(r->similarity[1]), number(r->similarity[2]), "anisotropy",
        number(r->anisotropy), "identical", r->identical, "metrics", metrics, "n_valid", (json_int_t)r->n_valid);
}

/* pairs: an array of [reference, test], each a path or spec. The result is an array of scores and errors. */
const char *EXPORT(web_score_names)(int model, const char *pairs) {
    nqm_error err = {0};
    json_t *list = json_loads(pairs, 0, NULL), *scores = json_array();
    const size_t n = json_array_size(list);
    nqm_named_pair *named = nqm_alloc(n, sizeof *named);
    nqm_score_result *results = nqm_alloc(n, sizeof *results);
    nqm_error *errors = nqm_alloc(n, sizeof *errors);
    nqm_status status = use_model(model, &err);
    if (status == NQM_OK && !(named && results && errors))
        status = nqm_fail_nomem(&err, n * sizeof *results);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        json_t *pair = json_array_get(list, i);
        named[i] =
            (nqm_named_pair){json_string_value(json_array_get(pair, 0)), json_string_value(json_array_get(pair, 1))};
    }
    if (status == NQM_OK)
        status = nqm_scorer_run_named(models[model].scorer, n, named, results, errors, &err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        json_array_append_new(scores, score_json(named[i].ref, named[i].test, &results[i], &errors[i]));
    nqm_free(named);
    nqm_free(results);
    nqm_free(errors);
    json_decref(list);
    if (status != NQM_OK) {
        json_decref(scores);
        return reply(error_json(&err));
    }
    return reply(scores);
}

/* Test `test` of the reference `ref`, BRDFs by number. */
const char *EXPORT(web_score)(int model, int ref, int test) {
    nqm_error err = {0};
    nqm_score_result r = {0};
    const nqm_brdf *tests = brdfs[test];
    nqm_status status = use_model(model, &err);
    if (status == NQM_OK)
        status = nqm_scorer_run(models[model].scorer, brdfs[ref], 1, &tests, &r, &err);
    if (status == NQM_OK && r.status != NQM_OK)
        status = nqm_fail(&err, r.status, -1, "%s: both BRDFs have a value at too few directions",
                          nqm_brdf_get_info(brdfs[test]).name);
    return reply(status == NQM_OK
                     ? score_json(nqm_brdf_get_info(brdfs[ref]).name, nqm_brdf_get_info(brdfs[test]).name, &r, &err)
                     : error_json(&err));
}

/* ---- materials with image maps ------------------------------------------------------------------------------------ */

enum { HEAT = 256 }; /* pixels of a side of the map, at most */

static unsigned char heat[HEAT * HEAT * 4];
static size_t heat_width, heat_height;

/* Draw the Delta-E of the texels from 0 to `end`, the largest texel of each pixel. */
static void draw_heat(const float *delta_e, size_t width, size_t height, double end) {
    const size_t step = nqm_ceil_div(nqm_larger(width, height), HEAT);
    heat_width = nqm_ceil_div(width, step), heat_height = nqm_ceil_div(height, step);
    for (size_t i = 0; i < heat_width * heat_height; ++i) {
        double most = 0, rgb[3];
        for (size_t k = 0; k < step * step; ++k) {
            const size_t y = i / heat_width * step + k / step, x = i % heat_width * step + k % step;
            if (y < height && x < width)
                most = fmax(most, (double)delta_e[y * width + x]);
        }
        nqm_viridis(most / end, rgb);
        for (size_t c = 0; c < 3; ++c)
            heat[4 * i + c] = nqm_srgb_byte(rgb[c]);
        heat[4 * i + 3] = 255;
    }
}

const unsigned char *EXPORT(web_heat)(void) {
    return heat;
}

static json_t *texture_json(const nqm_texture_result *r, double end) {
    json_t *blame = json_array();
    for (size_t i = 0; i < r->n_blame; ++i)
        json_array_append_new(blame, json_pack("{s:s,s:o,s:s}", "key", r->blame[i].key, "jod", number(r->blame[i].jod),
                                               "mistake", r->blame[i].mistake));
    return json_pack("{s:o,s:o,s:o,s:o,s:I,s:I,s:I,s:I,s:I,s:f,s:o}", "far", number(r->far_jod[0]), "median",
                     number(r->median), "worst", number(r->worst), "below9", number(r->below[0]), "width",
                     (json_int_t)r->width, "height", (json_int_t)r->height, "n_scored", (json_int_t)r->n_scored,
                     "heat_width", (json_int_t)heat_width, "heat_height", (json_int_t)heat_height, "end", end, "blame",
                     blame);
}

static nqm_status compare_textures(const nqm_texture *ref, const nqm_texture *test, nqm_texture_result *found,
                                   double *end, nqm_error *err) {
    const nqm_texture_info info = nqm_texture_get_info(ref, test);
    float *delta_e = nqm_alloc(info.width * info.height, sizeof *delta_e);
    if (!delta_e)
        return nqm_fail_nomem(err, info.width * info.height * sizeof *delta_e);
    const nqm_status status = nqm_texture_score(models[0].model, ref, test, NULL, found, delta_e, err);
    for (size_t i = 0; status == NQM_OK && i < info.width * info.height; ++i)
        *end = fmax(*end, (double)delta_e[i]);
    if (status == NQM_OK)
        draw_heat(delta_e, info.width, info.height, *end);
    nqm_free(delta_e);
    return status;
}

static json_t *textures_json(const char *const names[2], const nqm_texture *const each[2], const nqm_texture_result *t,
                             double end) {
    nqm_score_result r = {.jod = t->jod,
                          .jod_low = t->jod_low,
                          .jod_high = t->jod_high,
                          .delta_e = t->delta_e,
                          .novelty = NAN,
                          .parts = t->parts,
                          .similarity = {NAN, NAN, NAN},
                          .identical = t->delta_e == 0};
    json_t *json = score_json(names[0], names[1], &r, NULL), *remarks = json_object_get(json, "remarks");
    for (size_t s = 0; s < 2; ++s) {
        const char *remark = nqm_texture_get_info(each[s], NULL).remark;
        if (*remark)
            json_array_append_new(remarks, json_sprintf("%s: %s", names[s], remark));
    }
    json_object_set_new(json, "texture", texture_json(t, end));
    return json;
}

/* The near score of two materials of which one at least has image maps, with `texture`: far score, worst texels, blame. */
const char *EXPORT(web_score_textures)(const char *ref_name, const char *test_name) {
    nqm_error err = {0};
    const char *const names[2] = {ref_name, test_name};
    nqm_texture *each[2] = {NULL, NULL};
    static nqm_texture_result found;
    double end = 1;
    nqm_status status = use_model(0, &err);
    for (size_t s = 0; status == NQM_OK && s < 2; ++s)
        status = nqm_texture_open(names[s], NULL, NULL, &each[s], &err);
    if (status == NQM_OK)
        status = compare_textures(each[0], each[1], &found, &end, &err);
    json_t *json =
        status == NQM_OK ? textures_json(names, (const nqm_texture *const *)each, &found, end) : error_json(&err);
    nqm_texture_free(each[0]);
    nqm_texture_free(each[1]);
    return reply(json);
}

/* ---- where two BRDFs differ -------------------------------------------------------------------------------------- */

/* The charts of charts.h; phi: azimuth of the plane. */
const double *EXPORT(web_slices)(int id, double phi_deg) {
    static double rgb[CHART_SLICES * CHART_POINTS * 3];
    chart_slices(brdfs[id], phi_deg * NQM_PI / 180, rgb);
    return rgb;
}

const double *EXPORT(web_difference_map)(int ref, int test) {
    static double map[CHART_ROWS * CHART_COLUMNS];
    chart_map(brdfs[ref], brdfs[test], map);
    return map;
}

/* The share of each of the model's directions in the JOD that is lost, by the gradient of the score: [[theta_h, theta_d, phi_d in degrees,
 * share, luminance of the reference, of the test]], the largest first, at most 12. */
const char *EXPORT(web_costs)(int ref, int test) {
    enum { SHOWN = 12 };
    nqm_error err = {0};
    nqm_status status = use_model(0, &err);
    const nqm_directions *directions = status == NQM_OK ? nqm_model_get_info(models[0].model).directions : NULL;
    const size_t n = directions ? nqm_directions_get_info(directions).n : 0;
    float *a = NULL, *b, *gradient;
    double *cost, sum = 0, value;
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&a, 3 * n, sizeof *a}, {&b, 3 * n, sizeof *b},
                                             {&gradient, 3 * n, sizeof *gradient}, {&cost, n, sizeof *cost}),
                                  &err);
    nqm_sample_report report;
    if (status == NQM_OK)
        status = nqm_sample(brdfs[ref], directions, NQM_INVALID_NEAREST, a, NULL, &report, &err);
    if (status == NQM_OK)
        status = nqm_sample(brdfs[test], directions, NQM_INVALID_NEAREST, b, NULL, &report, &err);
    if (status == NQM_OK)
        status = nqm_score_grad(models[0].scorer, NQM_SCORE_DELTA_E, 1, &(nqm_sample_pair){a, b, NULL}, &value,
                                gradient, &err);
    json_t *rows = json_array();
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        for (size_t k = 3 * i; k < 3 * i + 3; ++k)
            cost[i] += (double)gradient[k] * (double)(b[k] - a[k]);
        sum += cost[i] = fmax(cost[i], 0);
    }
    for (size_t shown = 0; status == NQM_OK && shown < SHOWN && sum > 0; ++shown) {
        size_t best = 0;
        for (size_t i = 1; i < n; ++i)
            best = cost[i] > cost[best] ? i : best;
        const double *hd = nqm_directions_get_info(directions).degrees + 3 * best;
        const double f[2] = {nqm_luminance((double[3]){a[3 * best], a[3 * best + 1], a[3 * best + 2]}),
                             nqm_luminance((double[3]){b[3 * best], b[3 * best + 1], b[3 * best + 2]})};
        json_array_append_new(rows, json_pack("[ffffff]", hd[0], hd[1], hd[2], cost[best] / sum, f[0], f[1]));
        cost[best] = 0;
    }
    nqm_free(a);
    if (status == NQM_OK)
        return reply(rows);
    json_decref(rows);
    return reply(error_json(&err));
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

enum { N_STAGES = 4 }; /* one for each light, and one for a light that turns */

static struct stage {
    nqm_scene *scene;
    char light[32];
    size_t size, supersample; /* pixels of the picture; the scene has `supersample` times as many */
    double turn_deg;
    double *rgb_cdm2[2];   /* (n_points, 3) of reference and test */
    double *delta_e;       /* (n_points) */
    unsigned char *pixels; /* (size, size, 4) */
} stages[N_STAGES], *current;
static nqm_error failure;
/* The end of the colours of the difference, and the fractions of the light at directions where reference and test have a value. */
static double facts[3] = {1, 1, 1};

/* A built-in light that is turned about the vertical, as a file. */
static nqm_status write_turned_light(const char *name, double turn_deg, const char *path, nqm_error *err) {
    nqm_image image, turned;
    nqm_status status = nqm_light_draw(name, &image, err);
    if (status != NQM_OK)
        return status;
    turned = image;
    turned.rgb = nqm_alloc(image.width * image.height, 3 * sizeof *image.rgb);
    const size_t shift = (size_t)lround(turn_deg / 360 * (double)image.width) % image.width;
    for (size_t i = 0; turned.rgb && i < image.width * image.height; ++i)
        memcpy(turned.rgb + 3 * i, image.rgb + 3 * (i / image.width * image.width + (i + shift) % image.width),
               3 * sizeof *image.rgb);
    unlink(path); /* files in memory have no permissions, and so look write-protected */
    status = turned.rgb ? nqm_image_write_hdr(path, &turned, err)
                        : nqm_fail_nomem(err, image.width * image.height * 3 * sizeof *image.rgb);
    nqm_free(image.rgb);
    nqm_free(turned.rgb);
    return status;
}

/* Fewer cells of light and directions than in labels: the browser draws while people wait. */
static nqm_status fill_stage(struct stage *s, nqm_error *err) {
    static const char path[] = "turned-light.hdr";
    nqm_scene_options options = nqm_scene_options_default();
    nqm_status status = s->turn_deg != 0 ? write_turned_light(s->light, s->turn_deg, path, err) : NQM_OK;
    options.light = s->turn_deg != 0 ? path : s->light;
    options.shape = "sphere";
    options.width = options.height = s->supersample * s->size;
    options.n_lights = 48;
    options.light_width = 96;
    options.shadows = 0;
    options.min_valid = 0; /* the page says what is missing */
    if (status == NQM_OK)
        status = nqm_scene_create(&options, &s->scene, err);
    const size_t n = status == NQM_OK ? nqm_scene_get_info(s->scene).n_points : 0;
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&s->rgb_cdm2[0], 3 * n, sizeof(double)},
                                             {&s->rgb_cdm2[1], 3 * n, sizeof(double)}, {&s->delta_e, n, sizeof(double)},
                                             {&s->pixels, 4 * s->size * s->size, 1}),
                                  err);
    return status;
}

/* Set `current` to the stage of these arguments. */
static nqm_status set_stage(const char *light, size_t size, size_t supersample, double turn_deg, nqm_error *err) {
    static const char *const lights[] = {"studio", "overcast", "sun"};
    size_t place = N_STAGES - 1;
    for (size_t i = 0; turn_deg == 0 && i < sizeof lights / sizeof *lights; ++i)
        place = strcmp(lights[i], light) == 0 ? i : place;
    current = &stages[place];
    if (current->scene && strcmp(current->light, light) == 0 && current->size == size &&
        current->supersample == supersample && current->turn_deg == turn_deg)
        return NQM_OK;
    nqm_scene_free(current->scene);
    nqm_free(current->rgb_cdm2[0]);
    *current = (struct stage){.size = size, .supersample = supersample, .turn_deg = turn_deg};
    snprintf(current->light, sizeof current->light, "%s", light);
    return fill_stage(current, err);
}

/* Average the points of each pixel: colours of a picture, or of a map up to `end`; alpha: how much of the pixel the sphere covers. */
static const unsigned char *pixels_of(const struct stage *s, const double *rgb_cdm2, const double *delta_e,
                                      double end) {
    const size_t n = nqm_scene_get_info(s->scene).n_points, *pixel = nqm_scene_get_info(s->scene).pixels,
                 size = s->size, width = s->supersample * size;
    const nqm_tone tone = nqm_tone_default();
    double *sum = nqm_alloc(size * size, 4 * sizeof *sum);
    for (size_t i = 0; sum && i < n; ++i) {
        double *to = sum + 4 * (pixel[i] / width / s->supersample * size + pixel[i] % width / s->supersample), rgb[3];
        if (delta_e)
            nqm_viridis(delta_e[i] / end, rgb);
        for (size_t k = 0; k < 3; ++k)
            to[k] += delta_e ? rgb[k] : nqm_tone_apply(&tone, rgb_cdm2[3 * i + k]);
        to[3] += 1;
    }
    for (size_t i = 0; sum && i < size * size; ++i) {
        for (size_t k = 0; k < 3; ++k)
            s->pixels[4 * i + k] = nqm_srgb_byte(sum[4 * i + k] / fmax(sum[4 * i + 3], 1));
        s->pixels[4 * i + 3] = (unsigned char)lround(255 * sum[4 * i + 3] / (double)(s->supersample * s->supersample));
    }
    nqm_free(sum);
    return s->pixels;
}

/* Render BRDF `id` as reference (member 0) or test (1): RGBA (size, size, 4). NULL and web_failure() if that fails. */
const unsigned char *EXPORT(web_render)(int id, int member, const char *light, size_t size, size_t supersample,
                                        double turn_deg) {
    nqm_status status = set_stage(light, size, supersample, turn_deg, &failure);
    if (status == NQM_OK)
        status =
            nqm_scene_render(current->scene, brdfs[id], 0, current->rgb_cdm2[member], &facts[1 + member], &failure);
    return status == NQM_OK ? pixels_of(current, current->rgb_cdm2[member], NULL, 1) : NULL;
}

const char *EXPORT(web_failure)(void) {
    return reply(error_json(&failure));
}

/* The Delta-E ITP between the pictures that were rendered last, from 0 to the first of the facts in viridis. */
const unsigned char *EXPORT(web_difference)(void) {
    nqm_scene_compare(current->scene, current->rgb_cdm2[0], current->rgb_cdm2[1], current->delta_e);
    const double *maps[1] = {current->delta_e};
    const nqm_status status = nqm_map_scale(1, maps, nqm_scene_get_info(current->scene).n_points, facts, &failure);
    return status == NQM_OK ? pixels_of(current, NULL, current->delta_e, facts[0]) : NULL;
}

const double *EXPORT(web_facts)(void) {
    return facts;
}

/* ---- translations ------------------------------------------------------------------------------------------------ */

/* Translate as `nqm translate` does, write the result to `path` under `name`, and score what was written. */
const char *EXPORT(web_translate)(int ref, const char *target, const char *name, const char *path) {
    nqm_error err = {0};
    static nqm_translation t;
    nqm_brdf *written = NULL;
    const nqm_brdf *test;
    nqm_score_result r = {0};
    nqm_status status = use_model(0, &err);
    if (status == NQM_OK)
        status = use_model(1, &err);
    if (status != NQM_OK)
        return reply(error_json(&err));
    nqm_fit_options fit = nqm_fit_options_default();
    fit.n_directions = 2000;
    fit.progress = pass_progress;
    const nqm_match_loss loss = {"auto", models[0].model, models[1].model, NULL};
    unlink(path); /* as of tables */
    status = nqm_translate(brdfs[ref], target, path, name, &loss, &fit, &t, &err);
    if (status == NQM_OK)
        status = nqm_brdf_open(path, &written, &err);
    test = written;
    if (status == NQM_OK)
        status = nqm_scorer_run(models[0].scorer, brdfs[ref], 1, &test, &r, &err);
    json_t *json = status != NQM_OK
                       ? error_json(&err)
                       : json_pack("{s:s,s:s,s:s,s:o}", "spec", t.match.fit.spec, "selected", t.match.selected,
                                   "dropped", t.dropped, "score", score_json("reference", path, &r, &err));
    nqm_brdf_free(written);
    return reply(json);
}
