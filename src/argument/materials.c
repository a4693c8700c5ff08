/* SPDX-License-Identifier: MIT
 *
 * Arguments that are materials of renderers' files: BRDFs of a spec, or of the measured file that a material names, and image maps.
 */
#include "argument/argument.h"

/* There is no material of that name, or it is to be named (NULL). */
static nqm_status fail_select(const nqm_argument *a, nqm_error *err) {
    enum { MOST = 1000 }; /* materials of which the nearest name is found */
    char names[256] = "";
    size_t used = 0;
    nqm_nearest nearest = nqm_nearest_begin(a->member ? a->member : "");
    for (size_t i = 0; i < nqm_smaller(nqm_materials_count(a->materials), MOST); ++i) {
        const char *name = nqm_materials_get(a->materials, i).name;
        nqm_nearest_add(&nearest, name);
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", name);
    }
    return a->member ? nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no material '%s' in this file%s; it has %s",
                                a->path, a->member, nearest.advice, names)
                     : nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this file, '%s:MATERIAL': %s", a->path,
                                a->path, names);
}

/* The material that the argument means, and another one of its name; SIZE_MAX: there is none. */
static size_t find_meant(const nqm_argument *a, size_t *other_ret) {
    *other_ret = SIZE_MAX;
    return a->member                                ? nqm_materials_find(a->materials, a->member, other_ret)
           : nqm_materials_count(a->materials) == 1 ? 0
                                                    : SIZE_MAX;
}

static nqm_status select_material(const nqm_argument *a, size_t *index_ret, nqm_error *err) {
    size_t other;
    *index_ret = find_meant(a, &other);
    if (*index_ret == SIZE_MAX)
        return fail_select(a, err);
    if (other == SIZE_MAX)
        return NQM_OK;
    const int64_t first_byte = nqm_materials_get(a->materials, *index_ret).byte_offset,
                  other_byte = nqm_materials_get(a->materials, other).byte_offset;
    return nqm_fail(err, NQM_ERR_FORMAT, other_byte,
                    "%s: two materials have the name '%s' (bytes %lld and %lld); rename one", a->path, a->member,
                    (long long)first_byte, (long long)other_byte);
}

bool nqm_argument_material(const nqm_argument *a, nqm_material_info *info) {
    size_t i = SIZE_MAX, other = SIZE_MAX;
    if (a->materials)
        i = find_meant(a, &other);
    if (i != SIZE_MAX && other == SIZE_MAX)
        *info = nqm_materials_reflecting(a->materials, i, a->ignored);
    return i != SIZE_MAX && other == SIZE_MAX;
}

const nqm_materials *nqm_argument_library(const nqm_argument *a) {
    return a->materials && !a->member && !a->ignored && nqm_materials_count(a->materials) > 1 ? a->materials : NULL;
}

/* ---- BRDFs ------------------------------------------------------------------------------------------------------- */

static nqm_status open_measured(const nqm_argument *a, const char *measured, nqm_brdf **brdf_ret, nqm_error *err) {
    char *target = nqm_path_beside(a->path, measured);
    nqm_argument *of = target ? nqm_argument_parse(target, NULL) : NULL;
    *brdf_ret = NULL;
    nqm_status status = !of             ? nqm_fail_nomem(err, strlen(measured) + 1)
                        : of->materials ? nqm_fail(err, NQM_ERR_FORMAT, -1,
                                                   "%s: its measured file %s is a material file too", a->path, target)
                                        : nqm_argument_open(of, brdf_ret, err);
    nqm_argument_free(of);
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
static nqm_status open_spec(const nqm_argument *a, const nqm_material_info *info, const char *name, nqm_brdf **brdf_ret,
                            nqm_error *err) {
    nqm_error why = {0};
    nqm_status status = nqm_argument_open_text(info->spec, name, NULL, brdf_ret, &why);
    char byte[40];
    if (status == NQM_ERR_ARG)
        return nqm_fail(err, NQM_ERR_FORMAT, info->byte_offset, "%s: the material '%s' (%s%s): %s", a->path, info->name,
                        info->surface, byte_text(info->byte_offset, byte), why.message);
    if (status != NQM_OK && err)
        *err = why;
    return status;
}

nqm_status nqm_argument_open_material(const nqm_argument *a, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_material_info info = {.name = ""};
    char byte[40];
    size_t index;
    nqm_status status = select_material(a, &index, err);
    if (status == NQM_OK)
        info = nqm_materials_reflecting(a->materials, index, a->ignored);
    if (status == NQM_OK && info.refusal) {
        const char *way_out = info.ignorable && info.reflection ? info.ignorable : "";
        status = nqm_fail(err, NQM_ERR_FORMAT, info.byte_offset, "%s: the material '%s' (%s%s) is refused: %s%s%s",
                          a->path, info.name, info.surface, byte_text(info.byte_offset, byte), info.refusal,
                          *way_out      ? "; what of it reflects is taken with --ignore "
                          : info.n_maps ? NQM_TEXTURE_ADVICE
                                        : "",
                          way_out);
    }
    if (status == NQM_OK)
        status = nqm_argument_kind_of(info.spec) != NQM_ARGUMENT_NOTHING ? open_spec(a, &info, name, brdf_ret, err)
                                                                         : open_measured(a, info.spec, brdf_ret, err);
    if (status == NQM_OK && info.remark)
        status = nqm_brdf_remark(brdf_ret, info.remark, err);
    return status;
}

/* ---- image maps -------------------------------------------------------------------------------------------------- */

bool nqm_argument_is_textured(const nqm_argument *a) {
    nqm_material_info info;
    return a->kind == NQM_ARGUMENT_MAPS || a->kind == NQM_ARGUMENT_FOLDER ||
           (nqm_argument_material(a, &info) && info.n_maps > 0);
}

nqm_status nqm_argument_maps(const nqm_argument *a, const nqm_textured **maps_ret, nqm_textured **owned_ret,
                             nqm_error *err) {
    size_t index;
    *maps_ret = *owned_ret = NULL;
    nqm_status status = NQM_OK;
    if (a->kind == NQM_ARGUMENT_MAPS || a->kind == NQM_ARGUMENT_FOLDER) {
        status = nqm_maps_open(a->rest, owned_ret, err);
        *maps_ret = *owned_ret;
    } else if (a->materials) {
        status = select_material(a, &index, err);
        *maps_ret = status == NQM_OK ? nqm_materials_maps(a->materials, index, a->ignored) : NULL;
    }
    return status;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

nqm_status nqm_argument_companion(const nqm_argument *a, char **path_ret, nqm_error *err) {
    size_t index;
    *path_ret = NULL;
    if (!a->materials)
        return a->map.path && a->format && a->format->find_companion ? a->format->find_companion(&a->map, path_ret, err)
                                                                     : NQM_OK;
    nqm_status status = select_material(a, &index, err);
    const char *spec = status == NQM_OK ? nqm_materials_get(a->materials, index).spec : NULL;
    if (!spec || nqm_argument_kind_of(spec) != NQM_ARGUMENT_NOTHING)
        return status;
    *path_ret = nqm_path_beside(a->path, spec);
    return *path_ret ? NQM_OK : nqm_fail_nomem(err, strlen(spec) + 1);
}

typedef struct visitor {
    void (*visit)(void *user, const char *path);
    void *user;
} visitor;

/* What is made from others has no files of its own. */
static void visit_own(const nqm_argument *a, const visitor *v) {
    char *companion;
    const nqm_textured *maps;
    nqm_textured *owned;
    if (a->kind == NQM_ARGUMENT_FILE || a->kind == NQM_ARGUMENT_MATERIAL)
        v->visit(v->user, a->path);
    (void)!nqm_argument_companion(a, &companion, NULL);
    if (companion)
        v->visit(v->user, companion);
    nqm_free(companion);
    (void)!nqm_argument_maps(a, &maps, &owned, NULL);
    for (size_t i = 0; maps && i < maps->n_images; ++i)
        if (maps->images[i].path)
            v->visit(v->user, maps->images[i].path);
    nqm_textured_free(owned);
}

static nqm_status visit_base(void *user, const char *base, nqm_error *err) {
    nqm_argument *a = nqm_argument_parse(base, NULL);
    if (!a)
        return nqm_fail_nomem(err, strlen(base) + 1);
    visit_own(a, user);
    nqm_argument_free(a);
    return NQM_OK;
}

void nqm_argument_visit_files(const nqm_argument *a, void (*visit)(void *user, const char *path), void *user) {
    visitor v = {visit, user};
    if (a->of)
        (void)!nqm_argument_visit_bases(a->text, visit_base, &v, NULL);
    else
        visit_own(a, &v);
}
