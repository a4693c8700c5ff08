/* SPDX-License-Identifier: MIT
 *
 * The table of what a score consists of. Outputs of scores are made from it, so that a new number is one line here.
 */
#include "pairs/pairs.h"

#include <math.h>

/* A column, and where its number is in the result of its group. */
typedef struct entry {
    nqm_column column;
    size_t offset;
} entry;

#define ENTRY(group, kind, digits, name, member, of, field, about)                                                     \
    {                                                                                                                  \
        {name, member, "", about, NQM_COLUMN_##group, NQM_COLUMN_##kind, NQM_METRIC_RMSE, digits, 0, ""},              \
            offsetof(of, field)                                                                                        \
    }
#define SCORE(kind, digits, name, field, about) ENTRY(SCORE, kind, digits, name, name, nqm_score_result, field, about)
#define PART(group, kind, digits, name, member, field, about)                                                          \
    ENTRY(group, kind, digits, name, member, nqm_score_result, field, about)
#define TEXTURE(digits, name, field, about) ENTRY(TEXTURE, REAL, digits, name, name, nqm_texture_result, field, about)

static const entry scores[] = {
    SCORE(REAL, 2, "jod", jod, "quality: 10 is no visible difference; one less: 75 % of people see that it is worse"),
    SCORE(REAL, 2, "jod_low", jod_low, "lower end of the 95 % interval; none: the model has no intervals"),
    SCORE(REAL, 2, "jod_high", jod_high, "upper end"),
    SCORE(REAL, 3, "delta_e_itp", delta_e, "the mean Delta-E ITP of pictures that has this JOD"),
    SCORE(FLAG, 0, "identical", identical, "both are equal at every direction"),
    SCORE(WHOLE, 0, "n_valid", n_valid, "directions at which both have a value"),
    SCORE(REAL, 2, "novelty", novelty, "distance from the nearest training pair; 95 % of new materials are below 1"),
    SCORE(TEXT, 0, "verdict", jod, "what the interval means, in words"),
    PART(PARTS, REAL, 2, "shift_i", "shift_itp.0", parts.shift[0], "mean difference in units of Delta-E: brighter"),
    PART(PARTS, REAL, 2, "shift_t", "shift_itp.1", parts.shift[1], "bluer"),
    PART(PARTS, REAL, 2, "shift_p", "shift_itp.2", parts.shift[2], "redder"),
    PART(PARTS, REAL, 3, "contrast", "contrast", parts.contrast, "above 0 the test has more contrast"),
    PART(PARTS, REAL, 3, "structure", "structure", parts.structure, "what remains without the shift, Delta-E ITP"),
    PART(LABEL, REAL, 2, "adapted_jod", "adapted_jod", parts, "JOD of people who adapt to most of the shift"),
    PART(SIMILARITY, REAL, 2, "similarity_jod", "similarity_jod", similarity[0], "how similar they are seen apart"),
    PART(SIMILARITY, REAL, 2, "similarity_low", "similarity_low", similarity[1], "lower end of its 95 % interval"),
    PART(SIMILARITY, REAL, 2, "similarity_high", "similarity_high", similarity[2], "upper end"),
    PART(PARTS, TEXT, 0, "words", "words", parts, "what differs, in words"),
};
static const entry textures[] = {
    TEXTURE(2, "median_jod", median, "of the median texel"),
    TEXTURE(2, "worst_jod", worst, "of the 5 % of texels that differ most, at most"),
    TEXTURE(3, "below_9", below[0], "share of texels below JOD 9"),
    TEXTURE(3, "below_8", below[1], "the same below 8"),
    TEXTURE(2, "far_jod", far_jod[0], "from so far that no texel is seen"),
    TEXTURE(2, "far_jod_low", far_jod[1], "lower end of its 95 % interval"),
    TEXTURE(2, "far_jod_high", far_jod[2], "upper end"),
};
enum { N_SCORES = sizeof scores / sizeof *scores, N_TEXTURES = sizeof textures / sizeof *textures };

static void set_value(const entry *e, const nqm_score_result *score, const nqm_texture_result *texture, nqm_column *c) {
    const char *at = c->group == NQM_COLUMN_TEXTURE ? (const char *)texture : (const char *)score;
    if (!at)
        return;
    at += e->offset;
    if (c->group == NQM_COLUMN_LABEL)
        c->number = nqm_label_get_info(&score->parts).adapted_jod;
    else if (c->kind == NQM_COLUMN_REAL)
        memcpy(&c->number, at, sizeof c->number);
    else if (c->kind == NQM_COLUMN_TEXT && c->group == NQM_COLUMN_PARTS)
        snprintf(c->text, sizeof c->text, "%s",
                 isnan(score->parts.structure) ? "" : nqm_label_get_info(&score->parts).words);
    else if (c->kind == NQM_COLUMN_TEXT)
        strcpy(c->text, nqm_verdict(score, (char[NQM_VERDICT_TEXT]){""}));
    else if (score->status == NQM_OK)
        c->number =
            c->kind == NQM_COLUMN_FLAG ? *(const int *)(const void *)at : (double)*(const size_t *)(const void *)at;
}

nqm_column nqm_score_column(size_t i, const nqm_score_result *score, const nqm_texture_result *texture) {
    static const char *const objects[] = {"", "parts", "parts", "parts", "metrics", "texture"};
    nqm_column c = {.name = NULL};
    if (i >= N_SCORES && i < N_SCORES + NQM_METRIC_COUNT) {
        const nqm_metric m = (nqm_metric)(i - N_SCORES);
        const nqm_metric_info info = nqm_metric_get_info(m);
        c = (nqm_column){info.name, info.name, "", info.description, NQM_COLUMN_METRIC, NQM_COLUMN_REAL, m,
                         -4,        NAN,       ""};
        c.number = score ? score->metrics[m] : (double)NAN;
    } else if (i < N_SCORES + NQM_METRIC_COUNT + N_TEXTURES) {
        const entry *e = i < N_SCORES ? &scores[i] : &textures[i - N_SCORES - NQM_METRIC_COUNT];
        c = e->column;
        c.number = NAN;
        set_value(e, score, texture, &c);
    }
    c.object = objects[c.group];
    return c;
}
