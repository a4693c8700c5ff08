/* SPDX-License-Identifier: MIT
 *
 * Textured materials as text: see map_text.h.
 */
#include "support/map_text.h"
#include "support/check.h"
#include "support/material_text.h"

enum { TEXT = 1000 };

static const struct {
    const char *name;
    size_t n; /* operands */
} operations[NQM_MAP_OPS] = {[NQM_MAP_ADD] = {"add", 2},
                             [NQM_MAP_SUBTRACT] = {"subtract", 2},
                             [NQM_MAP_MULTIPLY] = {"multiply", 2},
                             [NQM_MAP_DIVIDE] = {"divide", 2},
                             [NQM_MAP_POWER] = {"power", 2},
                             [NQM_MAP_MINIMUM] = {"minimum", 2},
                             [NQM_MAP_MAXIMUM] = {"maximum", 2},
                             [NQM_MAP_MIX] = {"mix", 3},
                             [NQM_MAP_CHANNEL] = {"channel", 1},
                             [NQM_MAP_COMBINE] = {"combine", 2},
                             [NQM_MAP_LUMINANCE] = {"luminance", 1},
                             [NQM_MAP_NORMAL] = {"normal", 2}};

static void append(char text[TEXT], const char *more) {
    assert_true(strlen(text) + strlen(more) < TEXT);
    strcat(text, more);
}

static void describe(const nqm_textured *t, uint16_t at, char text[TEXT]) {
    static const char *const wraps[] = {"repeat", "mirror", "clamp", "border"};
    char part[300];
    assert_true(at < t->n_nodes);
    const nqm_map_node *node = &t->nodes[at];
    if (node->op == NQM_MAP_IMAGE) {
        assert_true(node->image < t->n_images);
        assert_int_equal(node->wrap[0], node->wrap[1]);
        snprintf(part, sizeof part, "image(%s %s%s%s)", t->images[node->image].name, t->images[node->image].space,
                 *t->images[node->image].space ? " " : "", wraps[node->wrap[0]]);
        append(text, part);
    } else if (node->op == NQM_MAP_VALUE) {
        append(text, nqm_format_doubles(part, sizeof part, node->n, node->v, " "));
    } else {
        assert_non_null(operations[node->op].name);
        append(text, operations[node->op].name);
        for (size_t i = 0; i < operations[node->op].n; ++i) {
            append(text, i ? ", " : "(");
            describe(t, node->in[i], text);
        }
        snprintf(part, sizeof part, node->op == NQM_MAP_CHANNEL ? " %g)" : ")", node->v[0]);
        append(text, part);
    }
}

void expect_map(const char *text, size_t i, const char *reason, const char *key, const char *value) {
    char found[TEXT] = "";
    nqm_materials *materials = open_text(text);
    assert_true(i < nqm_materials_count(materials));
    const nqm_material_info info = nqm_materials_get(materials, i);
    const nqm_textured *t = nqm_materials_textured(materials, i);
    if (!t)
        fail_msg("no maps: %s", info.refusal ? info.refusal : info.spec);
    if (!strstr(info.refusal, reason))
        fail_msg("'%s' does not contain '%s'", info.refusal, reason);
    for (size_t o = 0; o < t->n_outputs; ++o)
        if (strcmp(t->outputs[o].key, key) == 0)
            describe(t, t->outputs[o].node, found);
    if (strcmp(key, "normal") == 0)
        describe(t, t->normal, found);
    assert_string_equal(found, value);
    nqm_materials_free(materials);
}

void expect_position(const char *text, double u, double v, double x, double y) {
    nqm_materials *materials = open_text(text);
    const nqm_textured *t = nqm_materials_textured(materials, 0);
    assert_non_null(t);
    size_t i = 0;
    while (i < t->n_nodes && t->nodes[i].op != NQM_MAP_IMAGE)
        ++i;
    assert_true(i < t->n_nodes);
    const double(*uv)[3] = t->nodes[i].uv;
    assert_near(uv[0][0] * u + uv[0][1] * v + uv[0][2], x, 1e-12);
    assert_near(uv[1][0] * u + uv[1][1] * v + uv[1][2], y, 1e-12);
    nqm_materials_free(materials);
}
