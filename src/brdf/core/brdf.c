/* SPDX-License-Identifier: MIT
 *
 * Common to all BRDFs: finding the format of an argument, skipping pairs below the horizon, clamping and flagging
 * values, and conversion between direction pairs and half-vector coordinates (Rusinkiewicz 1998, DOI
 * 10.1007/978-3-7091-6453-2_2). Independent of the formats.
 */
#include "brdf/brdf.h"

#include "brdf/core/spec.h"
#include "brdf/formats/listed.h"

#include "io/io.h"
#include "material/material.h"
#include "math/math.h"
#include <math.h>
#include <string.h>
#include <sys/stat.h>

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* Has one of the two functions. */
typedef struct file_format {
    bool (*probe)(const nqm_map *map);
    nqm_status (*open)(nqm_map *map, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
    /** `setting` is what follows the colon of "FILE:SETTING", or NULL. */
    nqm_status (*open_with)(nqm_map *map, const char *setting, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
} file_format;

static const file_format formats[] = {
    {nqm_merl_probe, nqm_merl_open, NULL},     {nqm_tensor_brdf_probe, NULL, nqm_tensor_brdf_open},
    {nqm_nbrdf_probe, nqm_nbrdf_open, NULL},   {nqm_npy_probe, nqm_npy_open, NULL},
    {nqm_listed_probe, NULL, nqm_listed_open}, {nqm_saved_probe, nqm_saved_open, NULL}};

static const file_format *find_format(const nqm_map *map) {
    for (size_t i = 0; i < sizeof formats / sizeof *formats; ++i)
        if (formats[i].probe(map))
            return formats + i;
    return NULL;
}

nqm_status nqm_brdf_wrap(const nqm_brdf_class *class_, void *self, const nqm_brdf_info *info, nqm_brdf **brdf_ret,
                         nqm_error *err) {
    nqm_brdf_info copy = *info;
    const char **texts[] = {&copy.name, &copy.spec, &copy.layout};
    nqm_array arrays[4] = {{brdf_ret, 1, sizeof(nqm_brdf)}};
    char *texts_of_copy[3];
    for (size_t i = 0; i < 3; ++i)
        arrays[1 + i] = (nqm_array){&texts_of_copy[i], *texts[i] ? strlen(*texts[i]) + 1 : 0, 1};
    nqm_status status = nqm_alloc_arrays(4, arrays, err);
    if (status != NQM_OK) {
        class_->free(self);
        return status;
    }
    for (size_t i = 0; i < 3; ++i)
        if (*texts[i])
            *texts[i] = memcpy(texts_of_copy[i], *texts[i], arrays[1 + i].n);
    copy.format = class_->format;
    copy.reciprocal = class_->reciprocal;
    **brdf_ret = (nqm_brdf){class_, self, copy};
    return NQM_OK;
}

static bool is_zip(const nqm_map *map) {
    static const unsigned char member[4] = {'P', 'K', 3, 4}, end[4] = {'P', 'K', 5, 6};
    return map->n_bytes >= 4 && (memcmp(map->data, member, 4) == 0 || memcmp(map->data, end, 4) == 0);
}

/* Fail for an archive without the name of a material; the message lists some of its materials. */
static nqm_status request_material(const char *path, nqm_error *err) {
    char examples[256];
    nqm_status status = nqm_zip_examples(path, ".h5", examples, sizeof examples, err);
    if (status != NQM_OK)
        return status;
    if (!*examples)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: this zip (byte 0) contains no NBRDF .h5 file", path);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this archive, '%s:MATERIAL': %s", path, path,
                    examples);
}

/* ---- materials of renderers -------------------------------------------------------------------------------------- */

/* The material of that name; NULL: the only one. */
static nqm_status select_material(const char *path, const nqm_materials *materials, const char *material,
                                  nqm_material_info *info, nqm_error *err) {
    const size_t n = nqm_materials_count(materials);
    char names[256] = "";
    size_t used = 0, n_found = 0;
    nqm_nearest nearest = nqm_nearest_begin(material ? material : "");
    for (size_t i = 0; i < n; ++i) {
        const nqm_material_info one = nqm_materials_get(materials, i);
        const bool is_it = material ? strcmp(one.name, material) == 0 : n == 1;
        if (is_it && n_found++)
            return nqm_fail(err, NQM_ERR_FORMAT, one.byte_offset,
                            "%s: two materials have the name '%s' (bytes %lld and %lld); rename one", path, material,
                            (long long)info->byte_offset, (long long)one.byte_offset);
        if (is_it)
            *info = one;
        if (n_found)
            continue;
        nqm_nearest_add(&nearest, one.name);
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", one.name);
    }
    if (n_found)
        return NQM_OK;
    return material ? nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no material '%s' in this file%s; it has %s", path,
                               material, nearest.advice, names)
                    : nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this file, '%s:MATERIAL': %s", path,
                               path, names);
}

/* The path of a file that a material names; `path` is that of the material file. NULL: out of memory. */
static char *measured_path(const char *path, const char *measured) {
    const char *slash = strrchr(path, '/');
    return nqm_brdf_path_below(measured, path, slash ? (size_t)(slash - path) : 0);
}

char *nqm_brdf_measured(const char *path, const char *material) {
    nqm_map map = {0};
    nqm_materials *materials = NULL;
    nqm_material_info info;
    char *measured = NULL;
    if (nqm_map_open_sparse(path, &map, NULL) == NQM_OK && map.n_bytes && nqm_materials_probe(&map) &&
        nqm_materials_read(&map, &materials, NULL) == NQM_OK &&
        select_material(path, materials, material, &info, NULL) == NQM_OK && info.spec && !nqm_spec_probe(info.spec))
        measured = measured_path(path, info.spec);
    nqm_materials_free(materials);
    nqm_map_close(&map);
    return measured;
}

static nqm_status open_measured(const char *path, const char *measured, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_map map = {0};
    char *target = measured_path(path, measured);
    if (!target)
        return nqm_fail_nomem(err, strlen(measured) + 1);
    nqm_status status = nqm_map_open_sparse(target, &map, err);
    if (status == NQM_OK && map.n_bytes && nqm_materials_probe(&map))
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: its measured file %s is a material file too", path, target);
    nqm_map_close(&map);
    if (status == NQM_OK)
        status = nqm_brdf_open(target, brdf_ret, err);
    nqm_free(target);
    return status;
}

/* ", byte N"; "" when the reader of the format does not know it. */
static const char *byte_text(int64_t byte, char text[40]) {
    *text = 0;
    if (byte >= 0)
        snprintf(text, 40, ", byte %lld", (long long)byte);
    return text;
}

/* The spec of a material; a value outside of its model's range is a fault of the file. */
static nqm_status open_spec(const char *path, const nqm_material_info *info, const char *name, nqm_brdf **brdf_ret,
                            nqm_error *err) {
    nqm_error why = {0};
    nqm_status status = nqm_spec_open(info->spec, name, brdf_ret, &why);
    char byte[40];
    if (status == NQM_ERR_ARG)
        return nqm_fail(err, NQM_ERR_FORMAT, info->byte_offset, "%s: the material '%s' (%s%s): %s", path, info->name,
                        info->surface, byte_text(info->byte_offset, byte), why.message);
    if (status != NQM_OK && err)
        *err = why;
    return status;
}

/* material NULL: the file has only one. `name` is the whole argument. */
static nqm_status open_material(const nqm_map *map, const char *material, const char *name, nqm_brdf **brdf_ret,
                                nqm_error *err) {
    nqm_materials *materials = NULL;
    nqm_material_info info = {.name = ""};
    char byte[40];
    nqm_status status = nqm_materials_read(map, &materials, err);
    if (status == NQM_OK)
        status = select_material(map->path, materials, material, &info, err);
    if (status == NQM_OK && info.refusal)
        status = nqm_fail(err, NQM_ERR_FORMAT, info.byte_offset, "%s: the material '%s' (%s%s) is refused: %s",
                          map->path, info.name, info.surface, byte_text(info.byte_offset, byte), info.refusal);
    if (status == NQM_OK)
        status = nqm_spec_probe(info.spec) ? open_spec(map->path, &info, name, brdf_ret, err)
                                           : open_measured(map->path, info.spec, brdf_ret, err);
    nqm_materials_free(materials);
    return status;
}

/* On success the BRDF owns the map. */
static nqm_status open_map(nqm_map *map, nqm_brdf **brdf_ret, nqm_error *err) {
    const char *path = map->path;
    if (map->n_bytes == 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the file is empty (byte 0)", path);
    if (is_zip(map))
        return request_material(path, err);
    if (nqm_nps_probe(map))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this decoder's nps_latents.csv, '%s:MATERIAL'",
                        path, path);
    const file_format *format = find_format(map);
    if (format)
        return format->open ? format->open(map, path, brdf_ret, err)
                            : format->open_with(map, NULL, path, brdf_ret, err);
    if (nqm_materials_probe(map)) {
        nqm_status status = open_material(map, NULL, path, brdf_ret, err);
        if (status == NQM_OK)
            nqm_map_close(map);
        return status;
    }
    char materials[256];
    nqm_material_format_names(materials, sizeof materials);
    const char *kind = nqm_file_kind(map->data, map->n_bytes);
    return nqm_fail(
        err, NQM_ERR_FORMAT, 0,
        "%s: %s%s: byte 0 begins none of MERL .binary (90x90x180, 90x90x360), RGL .bsdf, .pbsdf, NBRDF .h5, .npy, "
        "CSV with theta_h, theta_d, phi_d or theta_i, phi_i, theta_o, phi_o, nqm's own .safetensors, zip, %s",
        path, kind ? "not a BRDF file but " : "not a BRDF file", kind ? kind : "", materials);
}

/* Open a file, or a material of a file that contains several; `name` is the whole argument. material NULL: the file
 * contains one. */
static nqm_status open_file(const char *path, const char *material, const char *name, nqm_brdf **brdf_ret,
                            nqm_error *err) {
    nqm_map map = {0};
    nqm_status status = nqm_map_open_sparse(path, &map, err);
    if (status == NQM_OK && !material) {
        status = open_map(&map, brdf_ret, err);
        if (status != NQM_OK)
            nqm_map_close(&map);
        return status;
    }
    const file_format *format = status == NQM_OK ? find_format(&map) : NULL;
    if (format && format->open_with) {
        status = format->open_with(&map, material, name, brdf_ret, err);
        if (status != NQM_OK)
            nqm_map_close(&map);
        return status;
    }
    bool zip = is_zip(&map), decoder = nqm_nps_probe(&map), materials = map.n_bytes && nqm_materials_probe(&map);
    if (status == NQM_OK && materials)
        status = open_material(&map, material, name, brdf_ret, err);
    nqm_map_close(&map);
    if (status != NQM_OK || materials)
        return status;
    if (zip)
        return nqm_nbrdf_zip_open(path, material, name, brdf_ret, err);
    if (decoder)
        return nqm_nps_open(path, material, name, brdf_ret, err);
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: neither a zip nor a decoder (byte 0), so '%s' cannot be named in it",
                    path, material);
}

static bool exists(const char *path) {
    struct stat st;
    return stat(path, &st) == 0;
}

/* Neither a file nor a spec: is it a misspelt spec, or one without its colon or with another character there? */
static nqm_status fail_missing(const char *path_or_spec, nqm_brdf **brdf_ret, nqm_error *err) {
    char model[64];
    if (!*path_or_spec)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a BRDF argument is empty");
    if (!strchr(path_or_spec, ':') && nqm_analytic_model_find(path_or_spec, strlen(path_or_spec)))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: no such file; a spec of this model is '%s:key=value;...'",
                        path_or_spec, path_or_spec);
    const char *preset = nqm_preset_named(path_or_spec);
    if (preset)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: no such file; a preset of this name is '%s'", path_or_spec, preset);
    const size_t n_model = nqm_spec_lacks_colon(path_or_spec);
    if (n_model)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%.150s: no such file; in a spec, ':' follows the model: '%.*s:%.150s'",
                        path_or_spec, (int)n_model, path_or_spec, path_or_spec + n_model + 1);
    preset = nqm_preset_without_colon(path_or_spec);
    if (preset)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: No such file or directory (did you mean '%s'?)", path_or_spec,
                        preset);
    snprintf(model, sizeof model, "%.*s", (int)strcspn(path_or_spec, ":"), path_or_spec);
    nqm_nearest nearest = nqm_nearest_begin(model);
    nqm_spec_nearest(&nearest);
    if (!strpbrk(path_or_spec, ":/.")) { /* a word: also a preset without its table */
        nqm_preset_nearest(&nearest);
        return *nearest.advice ? nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: there is no such file, model or preset%s",
                                          path_or_spec, nearest.advice)
                               : open_file(path_or_spec, NULL, path_or_spec, brdf_ret, err);
    }
    if (!strchr(path_or_spec, ':') || (!*nearest.advice && strpbrk(model, "/.")))
        return open_file(path_or_spec, NULL, path_or_spec, brdf_ret, err);
    return *nearest.advice ? nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: no such file, and there is no model '%s'%s",
                                      path_or_spec, model, nearest.advice)
                           : nqm_fail(err, NQM_ERR_IO, -1, "%.200s: No such file or directory, and no model '%s'",
                                      path_or_spec, model);
}

nqm_status nqm_brdf_open(const char *path_or_spec, nqm_brdf **brdf_ret, nqm_error *err) {
    NQM_MAKE(err, brdf_ret, path_or_spec);
    if (nqm_spec_probe(path_or_spec))
        return nqm_spec_open(path_or_spec, path_or_spec, brdf_ret, err);
    const char *colon = strrchr(path_or_spec, ':');
    if (exists(path_or_spec))
        return open_file(path_or_spec, NULL, path_or_spec, brdf_ret, err);
    if (!colon)
        return fail_missing(path_or_spec, brdf_ret, err);
    char *path = nqm_strdup(path_or_spec);
    if (!path)
        return nqm_fail_nomem(err, strlen(path_or_spec) + 1);
    path[colon - path_or_spec] = 0;
    nqm_status status = exists(path) ? open_file(path, colon + 1, path_or_spec, brdf_ret, err)
                                     : fail_missing(path_or_spec, brdf_ret, err);
    nqm_free(path);
    return status;
}

char *nqm_brdf_path_below(const char *path_or_spec, const char *root, size_t n_root) {
    if (n_root == 0 || *path_or_spec == '/' || nqm_spec_probe(path_or_spec))
        return nqm_strdup(path_or_spec);
    size_t n = n_root + strlen(path_or_spec) + 2;
    char *path = nqm_alloc(n, 1);
    if (path)
        snprintf(path, n, "%.*s/%s", (int)n_root, root, path_or_spec);
    return path;
}

nqm_status nqm_brdf_open_below(const char *path_or_spec, const char *root, nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    char *path = nqm_brdf_path_below(path_or_spec, root, root ? strlen(root) : 0);
    if (!path)
        return nqm_fail_nomem(err, strlen(path_or_spec) + 1);
    nqm_status status = nqm_brdf_open(path, brdf_ret, err);
    nqm_free(path);
    return status;
}

void nqm_brdf_free(nqm_brdf *brdf) {
    if (brdf)
        brdf->class_->free(brdf->self);
    nqm_free(brdf);
}

nqm_brdf_info nqm_brdf_get_info(const nqm_brdf *brdf) {
    assert(brdf);
    return brdf->info;
}

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

/* Pairs per block. A block contains the pairs above the horizon in dense arrays on the stack, so that evaluation
 * allocates nothing. */
enum { BLOCK = 512 };

/* Clamp and flag one raw value; rgb (3), in and out. */
static nqm_value_flag settle_value(double *rgb) {
    if (!isfinite(rgb[0]) || !isfinite(rgb[1]) || !isfinite(rgb[2])) {
        rgb[0] = rgb[1] = rgb[2] = 0;
        return NQM_VALUE_INVALID;
    }
    nqm_value_flag flag = NQM_VALUE_OK;
    for (int c = 0; c < 3; ++c) {
        if (rgb[c] < 0) {
            rgb[c] = 0;
            flag = NQM_VALUE_CLAMPED;
        }
    }
    return flag;
}

/* Clamp, flag and store m raw values. place: (m) indices of their pairs; raw: (m, 3); rgb: (n, 3); flag: (n) or
 * NULL. */
static void scatter(size_t m, const size_t *place, double *raw, double *rgb, uint8_t *flag) {
    for (size_t k = 0; k < m; ++k) {
        nqm_value_flag f = settle_value(raw + 3 * k);
        memcpy(rgb + 3 * place[k], raw + 3 * k, 3 * sizeof *rgb);
        if (flag)
            flag[place[k]] = (uint8_t)f;
    }
}

static void mark_horizon(size_t i, double *rgb, uint8_t *flag) {
    rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = 0;
    if (flag)
        flag[i] = NQM_VALUE_HORIZON;
}

/* Written so that NaN counts as below. */
static bool is_above_horizon(const double *wi, const double *wo) {
    return wi[2] > 0 && wo[2] > 0;
}

static void eval_block(const nqm_brdf *brdf, size_t m, const double *wi, const double *wo, double *raw) {
    if (brdf->class_->eval) {
        brdf->class_->eval(brdf->self, m, wi, wo, raw);
        return;
    }
    double hd[3 * BLOCK];
    void (*convert)(const double *, const double *, double *) =
        brdf->class_->reciprocal ? nqm_half_diff_from_pair : nqm_half_diff_full_from_pair;
    for (size_t k = 0; k < m; ++k)
        convert(wi + 3 * k, wo + 3 * k, hd + 3 * k);
    /* NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): a class has one of the two */
    brdf->class_->eval_half_diff(brdf->self, m, hd, raw);
}

void nqm_brdf_eval(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo, double *rgb, uint8_t *flag) {
    assert(brdf);
    double in[3 * BLOCK], out[3 * BLOCK], raw[3 * BLOCK];
    size_t place[BLOCK];
    for (size_t i = 0; i < n;) {
        size_t m = 0;
        for (; i < n && m < BLOCK; ++i) {
            if (!is_above_horizon(wi + 3 * i, wo + 3 * i)) {
                mark_horizon(i, rgb, flag);
                continue;
            }
            memcpy(in + 3 * m, wi + 3 * i, 3 * sizeof *in);
            memcpy(out + 3 * m, wo + 3 * i, 3 * sizeof *out);
            place[m++] = i;
        }
        if (m)
            eval_block(brdf, m, in, out, raw);
        scatter(m, place, raw, rgb, flag);
    }
}

/* Map phi_d to [0, period): pi for a reciprocal BRDF, because exchanging light and viewer adds pi; otherwise 2 pi. */
static double fold_phi(double phi, double period) {
    double folded = fmod(phi, period);
    if (folded < 0)
        folded += period;
    return folded < period ? folded : 0;
}

static void eval_native(const nqm_brdf *brdf, size_t n, const double *hd, double *rgb, uint8_t *flag) {
    double native[3 * BLOCK], raw[3 * BLOCK];
    const double period = brdf->class_->reciprocal ? NQM_PI : 2 * NQM_PI;
    size_t place[BLOCK];
    for (size_t i = 0; i < n;) {
        size_t m = 0;
        for (; i < n && m < BLOCK; ++i) {
            const double *c = hd + 3 * i;
            double mean_z = cos(c[0]) * cos(c[1]), swing_z = fabs(sin(c[0]) * sin(c[1]) * cos(c[2]));
            if (!(mean_z - swing_z > 0)) { /* minimum of wi.z and wo.z */
                mark_horizon(i, rgb, flag);
                continue;
            }
            native[3 * m] = c[0];
            native[3 * m + 1] = c[1];
            native[3 * m + 2] = fold_phi(c[2], period);
            place[m++] = i;
        }
        brdf->class_->eval_half_diff(brdf->self, m, native, raw);
        scatter(m, place, raw, rgb, flag);
    }
}

void nqm_brdf_eval_half_diff(const nqm_brdf *brdf, size_t n, const double *hd, double *rgb, uint8_t *flag) {
    assert(brdf);
    if (brdf->class_->eval_half_diff) {
        eval_native(brdf, n, hd, rgb, flag);
        return;
    }
    double wi[3 * BLOCK], wo[3 * BLOCK];
    for (size_t i = 0; i < n; i += BLOCK) {
        size_t m = n - i < BLOCK ? n - i : BLOCK;
        for (size_t k = 0; k < m; ++k)
            nqm_half_diff_to_pair(hd + 3 * (i + k), wi + 3 * k, wo + 3 * k);
        nqm_brdf_eval(brdf, m, wi, wo, rgb + 3 * i, flag ? flag + i : NULL);
    }
}

/* ---- derivatives by the parameters ------------------------------------------------------------------------------- */

/* Clamp a raw value as eval does; channels that eval replaces by 0 have the derivatives 0. jacobian: (3, n_parameters). */
static void settle_derivatives(size_t n_parameters, double *rgb, double *jacobian) {
    const double raw[3] = {rgb[0], rgb[1], rgb[2]};
    const nqm_value_flag flag = settle_value(rgb);
    for (size_t c = 0; flag != NQM_VALUE_OK && c < 3; ++c)
        if (flag == NQM_VALUE_INVALID || raw[c] < 0)
            memset(jacobian + c * n_parameters, 0, n_parameters * sizeof *jacobian);
}

nqm_status nqm_brdf_jacobian(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo, double *rgb,
                             double *jacobian, nqm_error *err) {
    NQM_REQUIRE(err, brdf);
    NQM_REQUIRE_IF(n, err, wi, wo, rgb, jacobian);
    enum { RUN = 64 }; /* pairs per call: their rows stay in the L1 cache between memset() and the last change */
    const size_t n_parameters = brdf->info.n_values, row = 3 * n_parameters;
    if (!brdf->class_->jacobian)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: only analytic models have derivatives by their parameters, not '%s'",
                        brdf->info.name, brdf->info.format);
    for (size_t i = 0, m; i < n; i += m) {
        const size_t most = n - i < RUN ? n - i : RUN;
        size_t n_above = 0;
        while (n_above < most && is_above_horizon(wi + 3 * (i + n_above), wo + 3 * (i + n_above)))
            ++n_above;
        m = n_above ? n_above : 1;
        memset(jacobian + row * i, 0, row * m * sizeof *jacobian);
        if (n_above)
            brdf->class_->jacobian(brdf->self, m, wi + 3 * i, wo + 3 * i, rgb + 3 * i, jacobian + row * i);
        else
            mark_horizon(i, rgb, NULL);
        for (size_t k = i; k < i + n_above; ++k)
            settle_derivatives(n_parameters, rgb + 3 * k, jacobian + row * k);
    }
    return NQM_OK;
}

void nqm_half_diff_to_directions(const double *hd, double *wi, double *wo) {
    assert(hd && wi && wo);
    nqm_half_diff_to_pair(hd, wi, wo);
}

void nqm_directions_to_half_diff(const double *wi, const double *wo, double *hd) {
    assert(wi && wo && hd);
    nqm_half_diff_from_pair(wi, wo, hd);
}
