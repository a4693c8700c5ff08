/* SPDX-License-Identifier: MIT
 *
 * Textured materials as text: see map_text.h.
 */
#include "support/map_text.h"
#include "support/check.h"

static const char *const names[NQM_MAP_OPS] = {
    [NQM_MAP_ADD] = "add",         [NQM_MAP_SUBTRACT] = "subtract", [NQM_MAP_MULTIPLY] = "multiply",
    [NQM_MAP_DIVIDE] = "divide",   [NQM_MAP_POWER] = "power",       [NQM_MAP_MINIMUM] = "minimum",
    [NQM_MAP_MAXIMUM] = "maximum", [NQM_MAP_ANGLE] = "angle",       [NQM_MAP_MIX] = "mix",
    [NQM_MAP_CHANNEL] = "channel", [NQM_MAP_COMBINE] = "combine",   [NQM_MAP_LUMINANCE] = "luminance",
    [NQM_MAP_NORMAL] = "normal"};

static void append(char text[MAP_TEXT], const char *more) {
    assert_true(strlen(text) + strlen(more) < MAP_TEXT);
    strcat(text, more);
}

static void describe(const nqm_textured *t, uint16_t at, char text[MAP_TEXT]) {
    static const char *const wraps[] = {"repeat", "mirror", "clamp", "border"};
    char part[300];
    assert_true(at < t->n_nodes);
    const nqm_map_node *node = &t->nodes[at];
    if (node->op == NQM_MAP_IMAGE) {
        assert_true(node->image < t->n_images);
        const nqm_map_image *image = &t->images[node->image];
        const bool same = node->wrap[0] == node->wrap[1];
        snprintf(part, sizeof part, "image(%s %s%s%s%s%s)", image->name, image->space, *image->space ? " " : "",
                 wraps[node->wrap[0]], same ? "" : "/", same ? "" : wraps[node->wrap[1]]);
        append(text, part);
    } else if (node->op == NQM_MAP_VALUE) {
        append(text, nqm_format_doubles(part, sizeof part, node->n, node->v, " "));
    } else {
        assert_non_null(names[node->op]);
        append(text, names[node->op]);
        for (size_t i = 0; i < nqm_graph_operands(node->op, node->n); ++i) {
            append(text, i ? ", " : "(");
            describe(t, node->in[i], text);
        }
        snprintf(part, sizeof part, node->op == NQM_MAP_CHANNEL ? " %g)" : ")", node->v[0]);
        append(text, part);
    }
}

void describe_map(const nqm_textured *t, const char *key, char text[MAP_TEXT]) {
    uint16_t node = strcmp(key, "normal") == 0 ? t->normal : NQM_NO_NODE;
    *text = '\0';
    for (size_t o = 0; o < t->n_outputs; ++o)
        if (strcmp(t->outputs[o].key, key) == 0)
            node = t->outputs[o].node;
    if (node != NQM_NO_NODE)
        describe(t, node, text);
}
