/* SPDX-License-Identifier: MIT
 *
 * Translation of textured materials to glTF with maps. Keys that both models share are copied texel by texel. What that
 * leaves is found by fits to a few texels, spread over all: each texel gets the mean of their corrections, weighted by
 * how near its properties are (Shepard 1968). Keys without a map have one value: copied, or that of a fit of all keys
 * to the middle texel, whichever lets the fits end better.
 */
#include "figures/picture.h"
#include "io/raster.h"
#include "material/gltf.h"
#include "nqm/fit/translate.h"
#include "nqm/textured.h"

#include <math.h>
#include <stdlib.h>
#include <strings.h>

enum { N_FITS = 16, MAX_VARYING = 24, USES = NQM_GLTF_N_USES };

/* A texel that is fitted. */
typedef struct fitted_texel {
    double weight, at[MAX_VARYING], loss;
    char *spec, *copy;      /* of the reference; its copied keys */
    double change[USES][3]; /* fit minus copy, by use */
} fitted_texel;

typedef struct texture_run {
    texture_translation *t;
    const nqm_texture *ref;
    const nqm_spec_schema *schema; /* of glTF */
    size_t n_varying;              /* components of properties of the reference: */
    struct {
        size_t property, component;
    } varying[MAX_VARYING];
    const nqm_spec_key *key[USES]; /* of nqm_gltf_uses; NULL: the property has no map */
    size_t source[USES];           /* the property of the reference */
    nqm_shading constants;
    size_t n;
    fitted_texel fitted[N_FITS];
} texture_run;

nqm_status check_texture_target(const char *model, const char *path, nqm_error *err) {
    if (strcmp(model, "gltf") == 0 && nqm_name_ends_in(path, ".gltf"))
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_ARG, -1,
                    "a material with image maps is written as glTF with PNG files beside it only: "
                    "--to gltf, with -o FILE.gltf or -d FOLDER");
}

/* ---- what varies ------------------------------------------------------------------------------------------------- */

static void drop(texture_translation *t, const char *key) {
    const size_t used = strlen(t->dropped);
    if (!nqm_contains_word(t->dropped, key, false) && !strstr(t->dropped, key))
        snprintf(t->dropped + used, sizeof t->dropped - used, "%s%s", used ? ", " : "", key);
}

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
        for (size_t u = 0; u < USES; ++u)
            for (size_t i = 0; i < run->schema->n_keys; ++i) {
                const nqm_spec_key *key = &run->schema->keys[i];
                if (strcmp(key->name, nqm_gltf_uses[u].key) != 0 || find_same_key(key, 1, &ref->keys[k]) == 1)
                    continue;
                run->key[u] = key;
                run->source[u] = k;
                is_mapped = true;
            }
        if (!is_mapped)
            drop(run->t, ref->keys[k].name);
    }
}

static void find_place(const texture_run *run, const float *rows, size_t i, double *at) {
    for (size_t k = 0; k < run->n_varying; ++k)
        at[k] = nqm_texture_value(run->ref, run->varying[k].property, run->varying[k].component, rows, i);
}

static void copy_value(const texture_run *run, size_t use, const float *rows, size_t i, double v[3]) {
    const size_t k = run->source[use];
    nqm_property p = {.n = run->ref->keys[k].n};
    for (size_t c = 0; c < 3; ++c)
        p.v[c] = nqm_texture_value(run->ref, k, c, rows, i);
    convert_values(&p, run->key[use], v);
}

/* The canonical spec of a texel, with all keys; NULL: an error. */
static char *make_spec(const texture_run *run, const float *rows, size_t i, nqm_error *err) {
    char *spec = nqm_texture_spec(run->ref, rows, i, NULL), *canonical = NULL;
    nqm_brdf *brdf = NULL;
    if (spec && nqm_brdf_open(spec, &brdf, err) == NQM_OK)
        canonical = nqm_strdup(nqm_brdf_get_info(brdf).spec);
    else if (!spec)
        (void)nqm_fail_nomem(err, sizeof(nqm_shading));
    nqm_brdf_free(brdf);
    nqm_free(spec);
    return canonical;
}

static nqm_status add_texels(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                             nqm_error *err) {
    texture_run *run = user;
    for (size_t i = 0; i < n; ++i) {
        fitted_texel *f = &run->fitted[run->n++];
        f->weight = samples[i].weight;
        f->spec = make_spec(run, rows[0], i, err);
        if (!f->spec)
            return err->status;
        f->copy = copy_keys(f->spec, run->schema->model);
        find_place(run, rows[0], i, f->at);
        for (size_t u = 0; u < USES; ++u)
            if (run->key[u])
                copy_value(run, u, rows[0], i, f->change[u]);
        if (!f->copy)
            return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s shares no property with %s", run->ref->name,
                            run->schema->model);
        char dropped[300], *end = dropped;
        list_dropped(f->spec, run->schema->model, dropped, sizeof dropped);
        for (char *key = strtok_r(dropped, ", ", &end); key; key = strtok_r(NULL, ", ", &end))
            drop(run->t, key);
    }
    return NQM_OK;
}

/* ---- fits -------------------------------------------------------------------------------------------------------- */

static nqm_status fit_one(const texture_run *run, const char *spec, const nqm_fit_options *options, nqm_shading *fit,
                          double *loss, nqm_error *err) {
    nqm_match_loss chosen = *run->t->loss;
    nqm_match_report report;
    nqm_brdf *ref = NULL;
    if (strcmp(chosen.text, "auto") == 0)
        chosen.text = "100*ma_crwe+transport"; /* the polish of auto */
    nqm_status status = nqm_brdf_open(spec, &ref, err);
    if (status == NQM_OK)
        status = nqm_match(ref, run->schema->model, &chosen, options, &report, NULL, err);
    nqm_brdf_free(ref);
    if (status == NQM_OK)
        status = nqm_shading_parse(report.fit.spec, fit, err);
    *loss = report.fit.loss;
    return status;
}

static bool has_map(const texture_run *run, const char *key) {
    for (size_t u = 0; u < USES; ++u)
        if (run->key[u] && strcmp(run->key[u]->name, key) == 0)
            return true;
    return false;
}

static double constant_of(const texture_run *run, const nqm_spec_key *key, size_t c) {
    const nqm_property *p = nqm_shading_find(&run->constants, key->name);
    return p ? p->v[c] : key->fallback;
}

/* Fit the keys that have maps at every texel, with the constants of the others. changes: (n, USES, 3) */
static nqm_status fit_texels(texture_run *run, double (*changes)[USES][3], double *loss_ret, nqm_error *err) {
    nqm_fit_bound bounds[NQM_SPEC_MAX_KEYS];
    nqm_fit_options options = *run->t->fit;
    nqm_status status = NQM_OK;
    options.simplify = 0; /* neighbours would get different values */
    options.bounds = bounds;
    for (size_t k = 0; k < run->schema->n_keys; ++k) {
        const nqm_spec_key *key = &run->schema->keys[k];
        const double v = constant_of(run, key, 0);
        const bool is_grey = key->n == 1 || (constant_of(run, key, 1) == v && constant_of(run, key, 2) == v);
        if (!has_map(run, key->name) && is_grey && !key->whole) /* a colour stays near its start */
            bounds[options.n_bounds++] = (nqm_fit_bound){key->name, v, v};
    }
    *loss_ret = 0;
    for (size_t i = 0; status == NQM_OK && i < run->n; ++i) {
        nqm_shading start = run->constants, fit;
        double loss;
        for (size_t u = 0; u < USES; ++u)
            if (run->key[u])
                nqm_shading_set(&start, run->key[u]->name, run->key[u]->n, run->fitted[i].change[u]);
        char *spec = nqm_shading_spec(&start);
        options.start = spec;
        note_progress("texel %zu of %zu", i + 1, run->n);
        status = spec ? fit_one(run, run->fitted[i].spec, &options, &fit, &loss, err) : nqm_fail_nomem(err, sizeof fit);
        nqm_free(spec);
        for (size_t u = 0; status == NQM_OK && u < USES; ++u)
            for (size_t c = 0; run->key[u] && c < 3; ++c) {
                const nqm_property *p = nqm_shading_find(&fit, run->key[u]->name);
                changes[i][u][c] = (p ? p->v[c] : run->key[u]->fallback) - run->fitted[i].change[u][c];
            }
        *loss_ret += run->fitted[i].weight * loss;
    }
    return status;
}

/* With the copied constants, and with those of a free fit. */
static nqm_status fit_all(texture_run *run, nqm_error *err) {
    static double changes[2][N_FITS][USES][3];
    double loss[2], ignored;
    nqm_shading copied;
    const fitted_texel *middle = &run->fitted[run->n / 2];
    nqm_fit_options options = *run->t->fit;
    nqm_status status = nqm_shading_parse(middle->copy, &run->constants, err);
    options.start = middle->copy;
    copied = run->constants;
    if (status == NQM_OK)
        status = fit_texels(run, changes[0], &loss[0], err);
    if (status == NQM_OK)
        status = fit_one(run, middle->spec, &options, &run->constants, &ignored, err);
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
            out[use->channel == SIZE_MAX ? c : use->channel] = *use->space ? nqm_srgb_byte(x) : unit_byte(x);
        }
    }
    if (!job->texture)
        nqm_texture_normal(run->ref, rows, i, v);
    for (size_t c = 0; !job->texture && c < 3; ++c)
        out[c] = unit_byte((v[c] + 1) / 2);
}

/* The map of a texture, beside the file. */
static nqm_status add_map(const texture_run *run, const char *texture, size_t channels, nqm_named_shading *m,
                          nqm_outset *set, nqm_error *err) {
    const char *path = run->t->path, *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
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
    nqm_status status = write_texels(run->ref, m->tiles, fill_texel, &job, &r, err);
    if (status == NQM_OK)
        status = nqm_raster_write_png(whole, &r, strstr(texture, "Color") != NULL, set, err);
    nqm_raster_clear(&r);
    return status;
}

static nqm_status write_all(const texture_run *run, nqm_error *err) {
    nqm_named_shading m = {.shading = run->constants};
    nqm_outset set = {0};
    nqm_status status = NQM_OK;
    snprintf(m.name, sizeof m.name, "%s", run->t->name);
    for (size_t u = 0; status == NQM_OK && u < USES; ++u) {
        const nqm_gltf_use *use = &nqm_gltf_uses[u];
        if (!run->key[u])
            continue;
        nqm_shading_set(&m.shading, use->key, run->key[u]->n, (double[]){1, 1, 1});
        if (m.n_maps == 0 || strcmp(m.maps[m.n_maps - 1].texture, use->texture) != 0)
            status = add_map(run, use->texture, use->n, &m, &set, err);
    }
    if (status == NQM_OK && run->ref->normal != NQM_NO_NODE)
        status = add_map(run, "normalTexture", 3, &m, &set, err);
    char *spec = nqm_shading_spec(&m.shading);
    snprintf(run->t->spec, sizeof run->t->spec, "%s", spec ? spec : "");
    nqm_free(spec);
    if (status == NQM_OK)
        status = nqm_shadings_write(1, &m, run->t->path, &set, err);
    if (status == NQM_OK)
        return nqm_outset_commit(&set, err);
    nqm_outset_abort(&set);
    return status;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static nqm_status score_written(texture_translation *t, const nqm_texture *ref, nqm_error *err) {
    nqm_texture_options options = nqm_texture_options_default();
    nqm_texture *test = NULL;
    options.blame = 0;
    options.progress = show_progress;
    nqm_status status = open_texture_named(t->path, &test, err);
    if (status == NQM_OK)
        status = nqm_texture_score(t->loss->metric, ref, test, &options, &t->score, NULL, err);
    nqm_texture_free(test);
    return status;
}

nqm_status translate_texture(texture_translation *t, nqm_error *err) {
    static const char model[] = "gltf";
    nqm_texture *ref = NULL;
    texture_run *run = allocate(1, sizeof *run);
    nqm_status status = open_texture(t->source, &ref, err);
    run->t = t;
    run->ref = ref;
    run->schema = &nqm_analytic_model_find(model, strlen(model))->schema;
    if (status == NQM_OK) {
        pair_maps(run);
        status = visit_texels(ref, N_FITS, add_texels, run, err);
    }
    if (status == NQM_OK)
        status = fit_all(run, err);
    if (status == NQM_OK)
        status = write_all(run, err);
    if (status == NQM_OK)
        status = score_written(t, ref, err);
    for (size_t i = 0; i < run->n; ++i) {
        nqm_free(run->fitted[i].spec);
        nqm_free(run->fitted[i].copy);
    }
    free(run);
    nqm_texture_free(ref);
    return status;
}
