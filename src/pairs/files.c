/* SPDX-License-Identifier: MIT
 *
 * The materials of files that are named again and again.
 */
#include "brdf/brdf.h"
#include "pairs/pairs.h"

char *nqm_pairs_join(const char *a, const char *b) {
    return nqm_strdupf("%s%s%s", a, *a && *b ? ":" : "", b);
}

static void forget(struct nqm_pairs_file *file) {
    nqm_free(file->path);
    nqm_materials_free(file->materials);
    *file = (struct nqm_pairs_file){NULL, NULL};
}

void nqm_pairs_forget(nqm_pairs_files *files) {
    forget(&files->last[0]);
    forget(&files->last[1]);
}

const nqm_materials *nqm_pairs_materials(nqm_pairs_files *files, const char *path) {
    struct nqm_pairs_file *other = &files->last[1], first = files->last[0];
    if (first.path && strcmp(first.path, path) == 0)
        return first.materials;
    if (!other->path || strcmp(other->path, path) != 0) {
        struct stat about;
        forget(other);
        other->path = nqm_strdup(path);
        if (other->path && stat(path, &about) == 0 && S_ISREG(about.st_mode) &&
            nqm_materials_open(path, &other->materials, NULL) == NQM_ERR_NOMEM)
            files->is_short = true;
        files->is_short = files->is_short || !other->path;
    }
    files->last[0] = *other;
    *other = first;
    return files->last[0].materials;
}

bool nqm_pairs_find_material(nqm_pairs_files *files, const char *argument, nqm_material_info *info) {
    static const size_t only[] = {0};
    unsigned ignored;
    argument += nqm_ignore_prefix(argument, &ignored);
    if (nqm_spec_probe(argument))
        return false;
    const char *colon = nqm_member_colon(argument);
    char *path = colon ? nqm_strdupf("%.*s", (int)(colon - argument), argument) : nqm_strdup(argument);
    const nqm_materials *materials = path ? nqm_pairs_materials(files, path) : NULL;
    files->is_short = files->is_short || !path;
    size_t n = materials && nqm_materials_count(materials) == 1;
    const size_t *found = materials && colon ? nqm_materials_named(materials, colon + 1, &n) : only;
    nqm_free(path);
    if (n == 1)
        *info = nqm_materials_reflecting(materials, found[0], ignored);
    return n == 1;
}

char *nqm_pairs_reflecting(nqm_pairs_files *files, const char *argument, unsigned ignored) {
    unsigned needed;
    nqm_material_info info;
    if (!ignored || nqm_ignore_prefix(argument, &needed) || !nqm_pairs_find_material(files, argument, &info) ||
        !info.ignorable || !nqm_ignore_parse(info.ignorable, strlen(info.ignorable), &needed) || (needed & ~ignored))
        return NULL;
    char *text = nqm_strdupf("ignore:%s:%s", info.ignorable, argument);
    files->is_short = files->is_short || !text;
    return text;
}

bool nqm_pairs_refused_alike(nqm_pairs_files *files, const nqm_named_pair *pair) {
    nqm_material_info ref, test;
    return nqm_pairs_find_material(files, pair->ref, &ref) && nqm_pairs_find_material(files, pair->test, &test) &&
           ref.refusal && test.refusal && strcmp(ref.refusal, test.refusal) == 0;
}
