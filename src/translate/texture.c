/* SPDX-License-Identifier: MIT
 *
 * Translation of textured materials to glTF with maps. Keys that both models share are copied texel by texel. What that
 * leaves is found by fits to a few texels, spread over all: each texel gets the mean of their corrections, weighted by
 * how near its properties are (Shepard 1968). Keys without a map have one value: copied, or that of a fit of all keys
 * to the middle texel, whichever lets the fits end better.
 */
#include "translate/translate.h"

#include "fit/fit.h"
#include "material/gltf.h"
#include "schema/models.h"
#include "texture/score.h"

#include <math.h>
#include <string.h>

enum { N_FITS = 16, MAX_VARYING = 24, USES = NQM_GLTF_N_USES };

/* A texel that is fitted. */
typedef struct fitted_texel {
    double weight, at[MAX_VARYING], loss;
    nqm_values values, copy; /* of the reference; copied from it */
    double change[USES][3];  /* fit minus copy, by use */
} fitted_texel;

typedef struct texture_run {
    const nqm_texture *ref;
    const char *path, *name;
    const nqm_match_loss *loss;
    const nqm_fit_options *options;
    nqm_ticker ticker;
    nqm_translation *result;
    const nqm_schema *schema; /* of glTF */
    size_t n_varying;         /* components of properties of the reference: */
    struct {
        size_t property, component;
    } varying[MAX_VARYING];
    const nqm_schema_key *key[USES]; /* of nqm_gltf_uses; NULL: the property has no map */
    size_t source[USES];             /* the property of the reference */
    nqm_values constants;
    size_t n;
    fitted_texel fitted[N_FITS];
} texture_run;

/* ---- what varies ------------------------------------------------------------------------------------------------- */

static void pair_maps(texture_run *run) {
    const nqm_texture *ref = run->ref;
    for (size_t k = 0; k < ref->n_properties; ++k) {
        bool is_mapped = false;
        if (ref->properties[k].node == NQM_NO_NODE)
            continue;
        for (size_t c = 0; c < ref->keys[k].n && run->n_varying < MAX_VARYING; ++c, ++run->n_varying) {
            run->varying[run->n_varying].property = k;
            run->varying[run->n_varying].component = c;
        }
        const size_t at = nqm_translate_key(ref->values.schema, k, run->schema);
        for (size_t u = 0; u < USES && at < run->schema->n_keys; ++u)
            if (strcmp(run->schema->keys[at].name, nqm_gltf_uses[u].key) == 0) {
                run->key[u] = &run->schema->keys[at];
                run->source[u] = k;
                is_mapped = true;
            }
        if (!is_mapped)
            nqm_translate_drop(ref->keys[k].name, run->result->dropped, sizeof run->result->dropped);
    }
}

static void find_place(const texture_run *run, const float *rows, size_t i, double *at) {
    for (size_t k = 0; k < run->n_varying; ++k)
        at[k] = nqm_texture_value(run->ref, run->varying[k].property, run->varying[k].component, rows, i);
}

static void copy_value(const texture_run *run, size_t use, const float *rows, size_t i, double v[3]) {
    const size_t k = run->source[use];
    const double source[3] = {nqm_texture_value(run->ref, k, 0, rows, i), nqm_texture_value(run->ref, k, 1, rows, i),
                              nqm_texture_value(run->ref, k, 2, rows, i)};
    nqm_translate_value(&run->ref->keys[k], source, run->key[use], v);
}

static nqm_status add_texels(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                             nqm_error *err) {
    texture_run *run = user;
    for (size_t i = 0; i < n; ++i) {
        fitted_texel *f = &run->fitted[run->n++];
        f->weight = samples[i].weight;
        f->values = nqm_texture_values(run->ref, rows[0], i);
        f->copy = nqm_values_of(run->schema);
        nqm_translate_values(&f->values, &f->copy);
        find_place(run, rows[0], i, f->at);
        for (size_t u = 0; u < USES; ++u)
            if (run->key[u])
                copy_value(run, u, rows[0], i, f->change[u]);
        if (!f->copy.given)
            return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s shares no property with %s", run->ref->name,
                            run->schema->model);
        nqm_translate_list_dropped(&f->values, run->schema, run->result->dropped, sizeof run->result->dropped);
    }
    return NQM_OK;
}

/* ---- fits -------------------------------------------------------------------------------------------------------- */

static nqm_status fit_one(const texture_run *run, const nqm_values *values, const nqm_values *start,
                          nqm_fit_options options, nqm_values *fit, double *loss, nqm_error *err) {
    nqm_match_loss chosen = *run->loss;
    nqm_match_report report;
    nqm_brdf *ref = NULL;
    char *spec = nqm_values_spec(start);
    options.start = spec;
    if (strcmp(chosen.text, "auto") == 0)
        chosen.text = "100*ma_crwe+transport"; /* the polish of auto */
    nqm_status status = spec ? nqm_brdf_of_values(values, &ref, err) : nqm_fail_nomem(err, sizeof *start);
    if (status == NQM_OK)
        status = nqm_match(ref, run->schema->model, &chosen, &options, &report, NULL, err);
    nqm_brdf_free(ref);
    nqm_free(spec);
    if (status == NQM_OK)
        status = nqm_values_parse_spec(report.fit.spec, fit, err);
    *loss = status == NQM_OK ? report.fit.loss : NAN;
    return status;
}

static bool has_map(const texture_run *run, const char *key) {
    for (size_t u = 0; u < USES; ++u)
        if (run->key[u] && strcmp(run->key[u]->name, key) == 0)
            return true;
    return false;
}

/* Fit the keys that have maps at every texel, with the constants of the others. changes: (n, USES, 3) */
static nqm_status fit_texels(texture_run *run, double (*changes)[USES][3], double *loss_ret, nqm_error *err) {
    nqm_fit_bound bounds[NQM_SCHEMA_MAX_KEYS];
    nqm_fit_options options = *run->options;
    nqm_status status = NQM_OK;
    options.simplify = 0; /* neighbours would get different values */
    options.bounds = bounds;
    for (size_t k = 0; k < run->schema->n_keys; ++k) {
        const nqm_schema_key *key = &run->schema->keys[k];
        const double *v = run->constants.v[k];
        const bool is_grey = key->n == 1 || (v[1] == v[0] && v[2] == v[0]);
        if (!has_map(run, key->name) && is_grey && !key->whole) /* a colour stays near its start */
            bounds[options.n_bounds++] = (nqm_fit_bound){key->name, v[0], v[0]};
    }
    *loss_ret = 0;
    for (size_t i = 0; status == NQM_OK && i < run->n; ++i) {
        nqm_values start = run->constants, fit;
        double loss;
        for (size_t u = 0; u < USES; ++u)
            if (run->key[u])
                nqm_values_set(&start, run->key[u]->name, run->key[u]->n, run->fitted[i].change[u]);
        status = nqm_tick(&run->ticker, "texels", (double)i, (double)run->n)
                     ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled")
                     : fit_one(run, &run->fitted[i].values, &start, options, &fit, &loss, err);
        for (size_t u = 0; status == NQM_OK && u < USES; ++u)
            for (size_t c = 0; run->key[u] && c < 3; ++c)
                changes[i][u][c] = fit.v[run->key[u] - run->schema->keys][c] - run->fitted[i].change[u][c];
        *loss_ret += run->fitted[i].weight * loss;
    }
    return status;
}

/* With the copied constants, and with those of a free fit. */
static nqm_status fit_all(texture_run *run, nqm_error *err) {
    double changes[2][N_FITS][USES][3], loss[2], ignored;
    const fitted_texel *middle = &run->fitted[run->n / 2];
    const nqm_values copied = run->constants = middle->copy;
    nqm_status status = fit_texels(run, changes[0], &loss[0], err);
    if (status == NQM_OK)
        status = fit_one(run, &middle->values, &copied, *run->options, &run->constants, &ignored, err);
    if (status == NQM_OK)
        status = fit_texels(run, changes[1], &loss[1], err);
    if (status != NQM_OK)
        return status;
    const size_t best = loss[1] < loss[0];
    run->constants = best ? run->constants : copied;
    for (size_t i = 0; i < run->n; ++i)
        memcpy(run->fitted[i].change, changes[best][i], sizeof run->fitted[i].change);
    return NQM_OK;
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

/* A texture that is written, or the normal map (texture NULL). */
typedef struct map_job {
    const texture_run *run;
    const char *texture;
} map_job;

/* The weight of the correction of each fit, where the properties are `at`. */
static void find_weights(const texture_run *run, const double *at, double *weights) {
    double all = 0;
    for (size_t k = 0; k < run->n; ++k) {
        double d = 1e-5;
        for (size_t i = 0; i < run->n_varying; ++i)
            d += (at[i] - run->fitted[k].at[i]) * (at[i] - run->fitted[k].at[i]);
        all += weights[k] = 1 / (d * d);
    }
    for (size_t k = 0; k < run->n; ++k)
        weights[k] /= all;
}

static void fill_texel(void *user, const float *rows, size_t i, unsigned char *out) {
    const map_job *job = user;
    const texture_run *run = job->run;
    double at[MAX_VARYING], weights[N_FITS], v[3];
    find_place(run, rows, i, at);
    find_weights(run, at, weights);
    for (size_t u = 0; job->texture && u < USES; ++u) {
        const nqm_gltf_use *use = &nqm_gltf_uses[u];
        if (!run->key[u] || strcmp(use->texture, job->texture) != 0)
            continue;
        copy_value(run, u, rows, i, v);
        for (size_t c = 0; c < run->key[u]->n; ++c) {
            double x = v[c];
            for (size_t k = 0; k < run->n; ++k)
                x += weights[k] * run->fitted[k].change[u][c];
            x = fmin(fmax(x, run->key[u]->low), run->key[u]->high);
            out[use->channel == SIZE_MAX ? c : use->channel] =
                *use->space ? nqm_unit_byte(nqm_linear_to_srgb(x)) : nqm_unit_byte(x);
        }
    }
    if (!job->texture)
        nqm_texture_normal(run->ref, rows, i, v);
    for (size_t c = 0; !job->texture && c < 3; ++c)
        out[c] = nqm_unit_byte((v[c] + 1) / 2);
}

/* The map of a texture, beside the file. */
static nqm_status add_map(texture_run *run, const char *texture, size_t channels, nqm_written_material *m,
                          nqm_outset *set, nqm_error *err) {
    const char *path = run->path, *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const size_t n_folder = (size_t)(name - path), n_stem = (size_t)(strrchr(name, '.') - name);
    const bool is_normal = strcmp(texture, "normalTexture") == 0;
    map_job job = {run, is_normal ? NULL : texture};
    nqm_raster r = {.channels = channels};
    nqm_written_map *map = &m->maps[m->n_maps++];
    char whole[4096];
    map->texture = texture;
    snprintf(map->file, sizeof map->file, "%.*s_%.*s.png", (int)nqm_smaller(n_stem, 200), name,
             (int)(strlen(texture) - strlen("Texture")), texture);
    snprintf(whole, sizeof whole, "%.*s%s", (int)n_folder, path, map->file);
    for (size_t axis = 0; axis < 2; ++axis)
        m->tiles[axis] = nqm_texture_tiles(run->ref, run->ref, axis, axis ? &r.height : &r.width);
    nqm_status status = nqm_texture_write(run->ref, m->tiles, fill_texel, &job, &run->ticker, &r, err);
    if (status == NQM_OK)
        status = nqm_raster_write_png(whole, &r, strstr(texture, "Color") != NULL, set, err);
    nqm_raster_clear(&r);
    return status;
}

static nqm_status write_all(texture_run *run, nqm_error *err) {
    nqm_written_material m = {.values = run->constants};
    nqm_outset set = {0};
    nqm_status status = NQM_OK;
    snprintf(m.name, sizeof m.name, "%s", run->name);
    for (size_t u = 0; status == NQM_OK && u < USES; ++u) {
        const nqm_gltf_use *use = &nqm_gltf_uses[u];
        if (!run->key[u])
            continue;
        nqm_values_set(&m.values, use->key, run->key[u]->n, (double[]){1, 1, 1});
        if (m.n_maps == 0 || strcmp(m.maps[m.n_maps - 1].texture, use->texture) != 0)
            status = add_map(run, use->texture, use->n, &m, &set, err);
    }
    if (status == NQM_OK && run->ref->normal != NQM_NO_NODE)
        status = add_map(run, "normalTexture", 3, &m, &set, err);
    char *spec = nqm_values_spec(&m.values);
    snprintf(run->result->match.fit.spec, sizeof run->result->match.fit.spec, "%s", spec ? spec : "");
    nqm_free(spec);
    if (status == NQM_OK && !spec)
        status = nqm_fail_nomem(err, sizeof m);
    if (status == NQM_OK)
        status = nqm_materials_write(1, &m, run->path, &set, err);
    if (status == NQM_OK)
        return nqm_outset_commit(&set, err);
    nqm_outset_abort(&set);
    return status;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static nqm_status score_written(texture_run *run, nqm_error *err) {
    nqm_texture_options options = nqm_texture_options_default();
    nqm_texture *test = NULL;
    options.blame = 0;
    options.progress = run->options->progress;
    options.progress_user = run->options->progress_user;
    nqm_status status = nqm_texture_open(run->path, options.progress, options.progress_user, &test, err);
    if (status == NQM_OK)
        status = nqm_texture_score(run->loss->metric, run->ref, test, &options, &run->result->texture, NULL, err);
    nqm_texture_free(test);
    return status;
}

static nqm_status translate(texture_run *run, nqm_error *err) {
    pair_maps(run);
    nqm_status status = nqm_texture_visit(run->ref, N_FITS, add_texels, run, err);
    if (status == NQM_OK)
        status = fit_all(run, err);
    if (status == NQM_OK)
        status = write_all(run, err);
    return status == NQM_OK ? score_written(run, err) : status;
}

nqm_status nqm_translate_texture(const nqm_texture *ref, const char *path, const char *name, const nqm_match_loss *loss,
                                 const nqm_fit_options *options, nqm_translation *result, nqm_error *err) {
    NQM_REQUIRE(err, ref, path, name, loss, result);
    NQM_REQUIRE(err, loss->text, loss->metric);
    const nqm_fit_options defaults = nqm_fit_options_default();
    *result = (nqm_translation){.dropped = ""};
    if (!nqm_name_ends_in(path, ".gltf"))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "%s: a material with image maps is written as glTF with PNG files beside it: FILE.gltf", path);
    if (ref->argument)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s shares no property with gltf", ref->name);
    texture_run *run = nqm_alloc(1, sizeof *run);
    if (!run)
        return nqm_fail_nomem(err, sizeof *run);
    run->ref = ref;
    run->path = path;
    run->name = name;
    run->loss = loss;
    run->options = options ? options : &defaults;
    run->ticker = (nqm_ticker){.fn = run->options->progress, .user = run->options->progress_user};
    run->result = result;
    run->schema = &nqm_gltf_schema;
    nqm_status status = translate(run, err);
    nqm_free(run);
    return status;
}
