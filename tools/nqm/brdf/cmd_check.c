/* SPDX-License-Identifier: MIT
 *
 * nqm check - checks whether a BRDF is physically plausible: reciprocity, energy conservation and positivity.
 */

#include "nqm/textured.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The largest albedo that passes. The tolerance covers the errors of measured data and of the quadrature. */
static const double max_albedo = 1.02;
/* Measured data deviate by 1 to 5 %; more is reported as poor. */
static const double noted_reciprocity = 0.05;

/* A smaller albedo is rather a wrong scale than a material: the blackest coatings reflect 0.1 %. */
static const double least_albedo = 0.001;

typedef struct verdict {
    nqm_brdf_check_report report;
    double largest_albedo;
    bool is_list; /* it lists measured directions: its albedo is unknown */
    bool energy_fails, too_dark, no_data, all_negative, is_merl;
} verdict;

static verdict judge(const nqm_brdf *brdf, const nqm_brdf_check_report *r) {
    verdict v = {.report = *r, .is_merl = strcmp(nqm_brdf_get_info(brdf).format, "merl") == 0};
    v.is_list = isnan(r->albedo_max[0]);
    for (int c = 0; c < 3; ++c)
        if (r->albedo_max[c] > v.largest_albedo)
            v.largest_albedo = r->albedo_max[c];
    v.energy_fails = v.largest_albedo > max_albedo;
    v.too_dark = !v.is_list && v.largest_albedo < least_albedo;
    v.no_data = 2 * r->n_invalid > r->n_pairs;
    v.all_negative =
        v.is_list ? r->n_clamped == r->n_pairs : v.largest_albedo <= 0 && r->n_clamped > 0; /* no value is positive */
    return v;
}

/* The BRDF is freed. */
static nqm_status examine(nqm_brdf *brdf, uint64_t seed, verdict *v, nqm_error *err) {
    nqm_brdf_check_report r;
    const nqm_status status = nqm_brdf_check(brdf, seed, &r, err);
    if (status == NQM_OK) {
        report_remark(brdf);
        *v = judge(brdf, &r);
    }
    nqm_brdf_free(brdf);
    return status;
}

static bool passes(const verdict *v) {
    return !v->energy_fails && !v->no_data && !v->all_negative;
}

static double degrees(double rad) {
    return rad * 57.29577951308232;
}

static double percent(size_t part, size_t whole) {
    return 100.0 * (double)part / (double)whole;
}

/* Why so little light is reflected. */
static const char *dark_words(const verdict *v) {
    if (v->all_negative)
        return "every value is negative or 0";
    if (v->largest_albedo <= 0)
        return "every value is 0";
    return v->is_merl ? "blacker than any coating: is a scale missing? The values of\n"
                        "               a MERL file are those of the BRDF times 1500 (red), 1304 and 904"
                      : "blacker than any coating: is a scale missing?";
}

static void print_energy(const verdict *v) {
    const nqm_brdf_check_report *r = &v->report;
    if (v->is_list) {
        puts("  energy       unknown: this is a list of directions; a complete grid would tell");
        return;
    }
    printf("  energy       %s: at most %.1f %% of the light is reflected\n"
           "               (light at %.0f degrees; red %.3f, green %.3f, blue %.3f)\n",
           v->energy_fails ? "FAILS"
           : v->too_dark   ? "suspicious"
                           : "ok",
           100 * v->largest_albedo, degrees(r->albedo_max_theta_rad), r->albedo_max[0], r->albedo_max[1],
           r->albedo_max[2]);
    if (v->too_dark)
        printf("               %s\n", dark_words(v));
}

static void print_measured(const verdict *v) {
    const nqm_brdf_check_report *r = &v->report;
    print_energy(v);
    if (isnan(r->reciprocity_median))
        puts("  reciprocity  unknown: no two values with light and viewer exchanged");
    else
        printf("  reciprocity  %s: exchanging light and viewer changes the value by\n"
               "               %.2g %% (median), %.2g %% (95th percentile)\n",
               r->reciprocity_median > noted_reciprocity ? "poor" : "ok", 100 * r->reciprocity_median,
               100 * r->reciprocity_p95);
    if (r->anisotropy > 0)
        printf("  isotropy     anisotropic: turning light and viewer about the normal changes\n"
               "               the value by %.2g %% (mean)\n",
               100 * r->anisotropy);
    printf("  positivity   %s: %zu of %zu values (%.1f %%) have a negative channel,\n"
           "               which is read as 0\n",
           v->all_negative ? "FAILS"
           : r->n_clamped  ? "clamped"
                           : "ok",
           r->n_clamped, r->n_pairs, percent(r->n_clamped, r->n_pairs));
}

/* words: what follows the verdict on the same line. */
static void print_text(const char *name, const verdict *v, const char *words) {
    const nqm_brdf_check_report *r = &v->report;
    printf("%s: %s%s\n", shown(name), !passes(v) ? "NOT PLAUSIBLE" : v->too_dark ? "suspicious" : "plausible", words);
    if (r->n_invalid == r->n_pairs)
        puts("  energy, reciprocity, positivity: unknown, there are no values");
    else
        print_measured(v);
    if (r->n_invalid)
        printf("  coverage     %s: %zu of %zu directions (%.1f %%) have no value\n", v->no_data ? "FAILS" : "partial",
               r->n_invalid, r->n_pairs, percent(r->n_invalid, r->n_pairs));
    if (r->n_invalid && v->is_merl)
        puts("               (in a MERL file, negative numbers mean that)");
}

static json_t *to_json(const char *name, const verdict *v) {
    const nqm_brdf_check_report *r = &v->report;
    json_t *failed = json_array();
    if (v->energy_fails)
        json_array_append_new(failed, json_string("energy"));
    if (v->no_data)
        json_array_append_new(failed, json_string("coverage"));
    if (v->all_negative)
        json_array_append_new(failed, json_string("positivity"));
    return json_row("brdf:s ok:b n_pairs:z n_clamped:z n_invalid:z reciprocity_median:f reciprocity_p95:f anisotropy:f "
                    "albedo_max:[fff] albedo_max_theta_deg:f failed:o too_dark:b",
                    name, (int)passes(v), r->n_pairs, r->n_clamped, r->n_invalid, r->reciprocity_median,
                    r->reciprocity_p95, r->anisotropy, r->albedo_max[0], r->albedo_max[1], r->albedo_max[2],
                    degrees(r->albedo_max_theta_rad), failed, v->too_dark);
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

enum { MAX_CHECKED_TEXELS = 32 };

/* Texels that represent all. */
typedef struct checked_texels {
    const nqm_texture *texture;
    size_t n, width;                 /* width: of the texture */
    size_t at[MAX_CHECKED_TEXELS];   /* row by row */
    char *specs[MAX_CHECKED_TEXELS]; /* nqm_free() */
} checked_texels;

static nqm_status add_texels(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                             nqm_error *err) {
    checked_texels *texels = user;
    for (size_t i = 0; i < n; ++i) {
        texels->at[texels->n] = samples[i].texel;
        const nqm_values values = nqm_texture_values(texels->texture, rows[0], i);
        texels->specs[texels->n] = nqm_values_spec(&values);
        if (!texels->specs[texels->n++])
            return nqm_fail_nomem(err, sizeof(nqm_values));
    }
    return NQM_OK;
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

enum { MAX_SIDE = 1024, N_VALUES = NQM_SCHEMA_MAX_KEYS * 3 };

/* A part of the texture at its own size, so that neighbours are neighbours there. */
typedef struct part {
    const nqm_texture *texture;
    size_t width, height;
    double *slope;                       /* (height, width, 2) of the surface, to the right and upwards */
    float low[N_VALUES], high[N_VALUES]; /* of each component of each property */
} part;

/* is_spread: of the whole texture, in place of neighbours. */
static nqm_status read_part(part *p, bool is_spread, nqm_error *err) {
    enum { BLOCK = NQM_TEXEL_BLOCK };
    size_t n_all[2];
    double u[BLOCK], v[BLOCK], normal[3];
    const size_t tiles[2] = {nqm_texture_tiles(p->texture, p->texture, 0, &n_all[0]),
                             nqm_texture_tiles(p->texture, p->texture, 1, &n_all[1])};
    p->width = nqm_smaller(n_all[0], MAX_SIDE);
    p->height = nqm_smaller(n_all[1], MAX_SIDE);
    const double du = 1 / (double)(tiles[0] * (is_spread ? p->width : n_all[0]));
    const double dv = 1 / (double)(tiles[1] * (is_spread ? p->height : n_all[1]));
    p->slope = p->slope ? p->slope : allocate(2 * p->width * p->height, sizeof *p->slope);
    float *rows = allocate((size_t)p->texture->n_rows * BLOCK, sizeof *rows);
    for (size_t first = 0, n; first < p->width * p->height; first += n) {
        n = nqm_smaller(p->width * p->height - first, BLOCK);
        if (show_progress(NULL, "maps", (double)first, (double)(p->width * p->height))) {
            free(rows);
            return nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
        }
        for (size_t i = 0; i < n; ++i) {
            u[i] = ((double)((first + i) % p->width) + 0.5) * du;
            v[i] = ((double)((first + i) / p->width) + 0.5) * dv;
        }
        nqm_texture_evaluate(p->texture, n, u, v, rows);
        for (size_t i = 0; i < n; ++i) {
            nqm_texture_normal(p->texture, rows, i, normal);
            p->slope[2 * (first + i)] = -normal[0] / normal[2];
            p->slope[2 * (first + i) + 1] = -normal[1] / normal[2];
            for (size_t k = 0; k < 3 * p->texture->n_properties; ++k) {
                const float x = (float)nqm_texture_value(p->texture, k / 3, k % 3, rows, i);
                p->low[k] = fminf(p->low[k], x);
                p->high[k] = fmaxf(p->high[k], x);
            }
        }
    }
    free(rows);
    return NQM_OK;
}

/* The normals of a surface of heights have slopes without curl; with the green channel flipped, these have. */
static void suspect_normals(const part *p, json_t *remarks) {
    double curl = 0, flipped = 0, mean[2] = {0, 0};
    for (size_t y = 0; y + 1 < p->height; ++y)
        for (size_t x = 0; x + 1 < p->width; ++x) {
            const double *s = &p->slope[2 * (y * p->width + x)], *right = s + 2, *below = s + 2 * p->width;
            const double along_y = s[0] - below[0], along_x = right[1] - s[1];
            curl += (along_y - along_x) * (along_y - along_x);
            flipped += (along_y + along_x) * (along_y + along_x);
        }
    for (size_t i = 0; i < 2 * p->width * p->height; ++i)
        mean[i % 2] += p->slope[i] / (double)(p->width * p->height);
    const double tilt_deg = atan(hypot(mean[0], mean[1])) * 57.29577951308232;
    if (tilt_deg > 10)
        json_array_append_new(
            remarks,
            json_sprintf("the normals are tilted by %.0f degrees on average: is the map read as sRGB?", tilt_deg));
    if (2 * flipped < curl)
        json_array_append_new(remarks, json_string("the normals fit no surface, and do with green flipped: is it a "
                                                   "map for DirectX?"));
}

/* Remarks on maps: those that are constant, and normals that are tilted or whose green is flipped. A new array of strings. */
static nqm_status suspect_maps(const nqm_texture *texture, json_t **remarks_ret, nqm_error *err) {
    part p = {.texture = texture};
    for (size_t k = 0; k < N_VALUES; ++k) {
        p.low[k] = INFINITY;
        p.high[k] = -INFINITY;
    }
    nqm_status status = read_part(&p, true, err);
    if (status == NQM_OK)
        status = read_part(&p, false, err);
    json_t *remarks = json_array();
    for (size_t k = 0; status == NQM_OK && k < texture->n_properties; ++k) {
        bool varies = false;
        for (size_t c = 0; c < texture->keys[k].n; ++c)
            varies = varies || p.low[3 * k + c] < p.high[3 * k + c];
        if (texture->properties[k].node != NQM_NO_NODE && !varies)
            json_array_append_new(remarks, json_sprintf("the map of %s is constant", texture->keys[k].name));
    }
    if (status == NQM_OK && texture->normal != NQM_NO_NODE)
        suspect_normals(&p, remarks);
    free(p.slope);
    *remarks_ret = remarks;
    return status;
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

/* Whether a is the worse: one that fails, then the one that reflects most. */
static bool is_worse(const verdict *a, const verdict *b) {
    return passes(a) != passes(b) ? passes(b) : a->largest_albedo > b->largest_albedo;
}

/* The verdict on the worst of some texels; *n_failed of these fail. */
static nqm_status judge_texels(const checked_texels *texels, uint64_t seed, verdict *worst, size_t *worst_ret,
                               size_t *n_failed, nqm_error *err) {
    nqm_status status = NQM_OK;
    *worst_ret = *n_failed = 0;
    for (size_t i = 0; status == NQM_OK && i < texels->n; ++i) {
        verdict v = {.is_merl = false};
        nqm_brdf *brdf;
        status = nqm_brdf_open(texels->specs[i], &brdf, err);
        status = status == NQM_OK ? examine(brdf, seed, &v, err) : status;
        if (status == NQM_OK && show_progress(NULL, "texels", (double)i, (double)texels->n))
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
        *n_failed += status == NQM_OK && !passes(&v);
        if (i == 0 || is_worse(&v, worst)) {
            *worst = v;
            *worst_ret = i;
        }
    }
    return status;
}

static void print_texture(const char *argument, const checked_texels *texels, const verdict *v, size_t worst,
                          size_t n_failed, const json_t *remarks) {
    char words[160];
    snprintf(words, sizeof words, "; %zu of %zu texels fail, the worst is (%zu, %zu):", n_failed, texels->n,
             texels->at[worst] % texels->width, texels->at[worst] / texels->width);
    print_text(argument, v, words);
    for (size_t i = 0; i < json_array_size(remarks); ++i)
        printf("  maps         suspicious: %s\n", json_string_value(json_array_get(remarks, i)));
}

/* As check_one(), of a material with image maps. */
static int check_texture(nqm_argument *argument, uint64_t seed, json_t *results) {
    checked_texels texels = {0};
    verdict worst = {.is_merl = false};
    size_t i = 0, n_failed = 0;
    nqm_texture *texture;
    json_t *remarks = NULL;
    nqm_error err = {0};
    nqm_status status = open_texture(argument, &texture, &err);
    if (status == NQM_OK) {
        texels = (checked_texels){.texture = texture, .width = nqm_texture_get_info(texture, NULL).width};
        status = nqm_texture_visit(texture, MAX_CHECKED_TEXELS, add_texels, &texels, &err);
    }
    if (status == NQM_OK)
        status = judge_texels(&texels, seed, &worst, &i, &n_failed, &err);
    if (status == NQM_OK)
        status = suspect_maps(texture, &remarks, &err);
    end_progress();
    nqm_texture_free(texture);
    for (size_t k = 0; k < texels.n; ++k)
        nqm_free(texels.specs[k]);
    if (status == NQM_OK && results) {
        json_t *item = to_json(argument->text, &worst);
        json_set(item, "texels:{checked:z failed:z worst:[zz] remarks:O}", texels.n, n_failed,
                 texels.at[i] % texels.width, texels.at[i] / texels.width, remarks);
        json_array_append_new(results, item);
    } else if (status == NQM_OK)
        print_texture(argument->text, &texels, &worst, i, n_failed, remarks);
    json_decref(remarks);
    return status != NQM_OK ? report_error(&err) : passes(&worst) ? EXIT_OK : EXIT_GATE;
}

/* ---- the verb's arguments ---------------------------------------------------------------------------------------- */

/* Check and print one BRDF; results NULL: as text. Returns its exit code. */
static int check_one(nqm_argument *argument, uint64_t seed, json_t *results) {
    nqm_error err = {0};
    verdict v;
    if (nqm_argument_is_textured(argument))
        return check_texture(argument, seed, results);
    nqm_brdf *brdf;
    nqm_status status = nqm_argument_open(argument, &brdf, &err);
    status = status == NQM_OK ? examine(brdf, seed, &v, &err) : status;
    if (status != NQM_OK && results)
        json_array_append_new(results, json_row("brdf:s ok:b error:s", argument->text, 0, err.message));
    if (status != NQM_OK)
        return report_error(&err);
    if (results)
        json_array_append_new(results, to_json(argument->text, &v));
    else
        print_text(argument->text, &v, "");
    return passes(&v) ? EXIT_OK : EXIT_GATE;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json;
static uint64_t seed = 1;

static const option options[] = {OPTION_ROW_IGNORE,
                                 {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
                                 {"seed", 0, OPTION_COUNT, &seed, "N", "seed of the random directions", 0, 0},
                                 {0}};

static const command cmd = {
    .usage = "BRDF... [options]",
    .about = "Is a BRDF physically plausible? Measures energy conservation (the share of light that is reflected, for"
             " light at 0 to 75 degrees), reciprocity and positivity. Exit code 1 when a BRDF reflects more than 102 "
             "% of the light, has no value for more than half of the directions, or no positive value but negative "
             "ones. A list of measured directions is tested at these directions; its energy is unknown. Of a material"
             " with image maps, 32 texels that represent all are tested, and suspicious maps are named.",
    .example = "nqm check sgd:nickel material.binary\nnqm check 'lambert:kd=1.1' --json",
    .options = options,
    .min_arguments = 1,
    .max_arguments = -1,
};

int cmd_check(int argc, char **argv) {
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    int exit_code = EXIT_OK;
    json_t *results = json ? json_array() : NULL;
    for (int i = 0; i < n_arguments; ++i) {
        if (interrupted())
            return EXIT_INTERRUPTED;
        refuse_model_name(argv[i]);
        nqm_argument *argument = parse_argument(argv[i]);
        const int code = check_one(argument, seed, results);
        nqm_argument_free(argument);
        if (exit_code == EXIT_OK || (exit_code == EXIT_GATE && code != EXIT_OK))
            exit_code = code; /* exit code of the first error; an error counts more than a failed check */
    }
    if (json)
        print_document(json_row("results:o", results));
    return exit_code;
}
