/* SPDX-License-Identifier: MIT
 *
 * Selects pairs of an evaluation according to the options.
 */
#include "judge/evaluate.h"

#include <string.h>

static bool is(const char *required, const char *value) {
    return !required || strcmp(required, value) == 0;
}

static bool in_range(const nqm_dataset *d, const nqm_eval_options *o, size_t pair) {
    return d->order_only || (d->jod[pair] >= o->jod_from && d->jod[pair] < o->jod_to);
}

static bool selected(const nqm_evaluation *ev, const nqm_eval_options *o, size_t pair) {
    const nqm_dataset *d = ev->dataset;
    const nqm_dataset_kind kind = nqm_dataset_get_kind(d, d->pair_kind[pair]);
    return nqm_evaluation_in_split(d, pair, o->split) && nqm_evaluation_in_split(d, pair, ev->split) &&
           in_range(d, o, pair) && is(o->kind, kind.name) && is(o->family, kind.family) &&
           is(o->material_class, nqm_material_class_name(ev->ref_class[d->pair_ref[pair]]));
}

/* Select the pairs, with a counting sort by group. */
static nqm_status select_pairs(const nqm_evaluation *ev, const nqm_eval_options *o, nqm_selection *s, nqm_error *err) {
    const nqm_dataset *d = ev->dataset;
    size_t *next = nqm_alloc(d->n_groups, sizeof *next);
    s->group_begin = nqm_alloc(d->n_groups + 1, sizeof *s->group_begin);
    s->pairs = nqm_alloc(d->n_pairs, sizeof *s->pairs);
    bool ok = next && s->group_begin && s->pairs;
    for (size_t pair = 0; ok && pair < d->n_pairs; ++pair)
        s->group_begin[d->ref_group[d->pair_ref[pair]] + 1] += selected(ev, o, pair);
    for (size_t g = 0; ok && g < d->n_groups; ++g) {
        next[g] = s->group_begin[g];
        s->group_begin[g + 1] += s->group_begin[g];
    }
    for (size_t pair = 0; ok && pair < d->n_pairs; ++pair)
        if (selected(ev, o, pair))
            s->pairs[next[d->ref_group[d->pair_ref[pair]]]++] = pair;
    nqm_free(next);
    s->n = ok ? s->group_begin[d->n_groups] : 0;
    return ok ? NQM_OK : nqm_fail_nomem(err, (2 * d->n_groups + d->n_pairs) * sizeof *next);
}

nqm_status nqm_selection_create(const nqm_evaluation *ev, const nqm_eval_options *options, nqm_selection *s,
                                nqm_error *err) {
    *s = (nqm_selection){0};
    nqm_status status = select_pairs(ev, options, s, err);
    if (status == NQM_OK && s->n == 0)
        status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "no pair is left to judge on");
    if (status != NQM_OK)
        nqm_selection_free(s);
    return status;
}

void nqm_selection_free(nqm_selection *s) {
    nqm_free(s->group_begin);
    nqm_free(s->pairs);
    *s = (nqm_selection){0};
}
