/* SPDX-License-Identifier: MIT
 *
 * read_materials - reads paths from standard input, one a line, and writes for each file a line with all that nqm makes of it: specs,
 * what is computed from maps, remarks, what has no effect, refusals. Two files with equal lines are the same to nqm. Ends like FILE.csv are
 * lists of directions, of which some values are written.
 */
#include "brdf/brdf.h"
#include "brdf/formats/listed.h"
#include "material/maps.h"

#include <string.h>
#include <sys/stat.h>

static void print_text(const char *name, const char *text) {
    printf("\t%s=", name);
    for (; text && *text; ++text)
        putchar(*text == '\n' || *text == '\t' ? ' ' : *text);
}

static void print_numbers(size_t n, const double *v) {
    for (size_t i = 0; i < n; ++i)
        printf(" %.12g", v[i]);
}

/* A value out of the range of its model refuses the material when it is opened. */
static void print_fault(const char *spec) {
    nqm_error err = {0};
    nqm_brdf *brdf = NULL;
    if (spec && nqm_spec_probe(spec) && nqm_brdf_open(spec, &brdf, &err) != NQM_OK)
        print_text("fault", err.message);
    nqm_brdf_free(brdf);
}

static void print_maps(const nqm_textured *t) {
    nqm_values whole = t->values;
    char *constants = nqm_values_spec(&whole);
    for (size_t i = 0; i < t->n_outputs; ++i)
        nqm_values_set(&whole, t->outputs[i].key, 1, (double[]){0.5});
    char *spec = nqm_values_spec(&whole);
    print_text("constants", constants);
    print_fault(spec);
    nqm_free(constants);
    nqm_free(spec);
    print_text("maps", "");
    for (size_t i = 0; i < t->n_outputs; ++i)
        printf(" %s<-%d", t->outputs[i].key, t->outputs[i].node);
    printf(" normal<-%d", t->normal);
    for (size_t i = 0; i < t->n_nodes; ++i) {
        const nqm_map_node *node = &t->nodes[i];
        printf(" | %d %d:", (int)node->op, node->n);
        for (size_t k = 0; k < 4; ++k)
            printf(" %d", node->in[k]);
        print_numbers(4, node->v);
        if (node->op != NQM_MAP_IMAGE)
            continue;
        const nqm_map_image *image = &t->images[node->image];
        printf(" %s '%s' %d %d %d %zu+%zu", image->name, image->space, image->needs_color, image->needs_alpha,
               image->expects_alpha, image->at, image->n_bytes);
        printf(" %d %d", node->wrap[0], node->wrap[1]);
        print_numbers(6, node->uv[0]);
    }
    print_text("remark", t->remark);
}

static void print_materials(const nqm_materials *materials) {
    for (size_t i = 0; i < nqm_materials_count(materials); ++i) {
        const nqm_material_info info = nqm_materials_get(materials, i);
        print_text("name", info.name);
        print_text("surface", info.surface);
        print_text("spec", info.spec);
        print_text("remark", info.remark);
        print_text("unused", info.unused);
        print_text("refusal", info.refusal);
        print_fault(info.spec ? info.spec : info.reflection);
        print_text("ignorable", info.ignorable);
        print_text("reflection", info.reflection);
        if (nqm_materials_maps(materials, i, ~0U))
            print_maps(nqm_materials_maps(materials, i, ~0U));
    }
}

static void print_brdf(const nqm_brdf *brdf) {
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    print_text("spec", info.spec);
    print_text("layout", info.layout);
    print_text("remark", info.remark);
    const size_t n = nqm_scattered_rows(brdf, NULL, NULL);
    double *pairs = nqm_alloc(2 * n + 2, 3 * sizeof *pairs), rgb[3];
    (void)nqm_scattered_rows(brdf, pairs, pairs + 3 * n);
    for (size_t i = 0; i < n; ++i) {
        nqm_brdf_eval(brdf, 1, pairs + 3 * i, pairs + 3 * (n + i), rgb, NULL);
        print_numbers(3, pairs + 3 * i);
        print_numbers(3, pairs + 3 * (n + i));
        print_numbers(3, rgb);
    }
    for (int i = 0; i < 300 && !n; ++i) {
        const double hd[3] = {0.1 * (i % 10), 0.05 + 0.15 * (i / 10 % 6), 0.1 + 0.7 * (i / 60)};
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
        print_numbers(3, rgb);
    }
    nqm_free(pairs);
}

static void print_file(const char *path) {
    nqm_error err = {0};
    nqm_materials *materials = NULL;
    nqm_textured *maps = NULL;
    nqm_brdf *brdf = NULL;
    struct stat st;
    if (stat(path, &st) == 0 && S_ISDIR(st.st_mode)) {
        if (nqm_maps_open(path, &maps, &err) == NQM_OK)
            print_maps(maps);
    } else if (nqm_materials_open(path, &materials, &err) == NQM_OK)
        print_materials(materials);
    else if (!strstr(path, ".mat.") && nqm_brdf_open(path, &brdf, &err) == NQM_OK)
        print_brdf(brdf);
    if (err.status != NQM_OK && !brdf)
        print_text("error", err.message);
    nqm_textured_free(maps);
    nqm_materials_free(materials);
    nqm_brdf_free(brdf);
}

int main(void) {
    char path[4096];
    while (fgets(path, sizeof path, stdin)) {
        path[strcspn(path, "\n")] = '\0';
        print_file(path);
        putchar('\n');
    }
    return 0;
}
