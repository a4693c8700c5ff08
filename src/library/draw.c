/* SPDX-License-Identifier: MIT
 *
 * Pictures of the members of a library, and scores of pairs of them.
 */
#include "library/library.h"
#include "percept/percept.h"

#include <math.h>

nqm_status nqm_library_need_scorer(struct nqm_library_state *s, nqm_error *err) {
    return s->scorer ? NQM_OK : nqm_scorer_create(s->model, &s->score, &s->scorer, err);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

enum { SIDE = 8, N_TEXELS = SIDE * SIDE };

/* Texels at the same positions of every surface, without the tilts of their normals, which only the scores know. */
static nqm_status choose_texels(const nqm_texture *texture, nqm_values *values, nqm_subject *subjects, nqm_error *err) {
    double u[N_TEXELS], v[N_TEXELS];
    float *rows = nqm_alloc((size_t)texture->n_rows * NQM_TEXEL_BLOCK + 1, sizeof *rows);
    for (size_t i = 0; i < N_TEXELS; ++i) {
        u[i] = ((double)(i % SIDE) + 0.5) / SIDE;
        v[i] = ((double)(i / SIDE) + 0.5) / SIDE;
    }
    if (rows)
        nqm_texture_evaluate(texture, N_TEXELS, u, v, rows);
    for (size_t i = 0; rows && i < N_TEXELS; ++i)
        subjects[i] = nqm_texture_subject(texture, rows, i, &values[i]);
    nqm_free(rows);
    return rows ? NQM_OK : nqm_fail_nomem(err, (size_t)texture->n_rows * NQM_TEXEL_BLOCK * sizeof *rows);
}

static nqm_status draw_texture(struct nqm_library_state *s, const char *argument, nqm_gallery *gallery, size_t at,
                               nqm_error *why, nqm_error *err) {
    nqm_values values[N_TEXELS];
    nqm_subject subjects[N_TEXELS];
    nqm_error errors[N_TEXELS];
    nqm_texture *texture = NULL;
    nqm_gallery *texels = NULL;
    nqm_error failure = {0};
    nqm_argument *a = nqm_argument_parse(argument, NULL);
    nqm_status status =
        a ? nqm_library_open_texture(&s->terms, a, &texture, &failure) : nqm_fail_nomem(&failure, strlen(argument) + 1);
    nqm_argument_free(a);
    *why = (nqm_error){0};
    if (status == NQM_ERR_CANCELLED || status == NQM_ERR_NOMEM)
        return nqm_fail(err, status, -1, "%s", failure.message);
    if (status != NQM_OK) {
        *why = failure;
        return NQM_OK;
    }
    status = choose_texels(texture, values, subjects, err);
    if (status == NQM_OK)
        status = nqm_gallery_create(s->model, N_TEXELS, NULL, &texels, err);
    if (status == NQM_OK)
        status = nqm_scorer_draw(s->scorer, N_TEXELS, subjects, texels, 0, errors, err);
    for (size_t i = 0; status == NQM_OK && why->status == NQM_OK && i < N_TEXELS; ++i)
        if (errors[i].status != NQM_OK)
            *why = errors[i];
    if (status == NQM_OK)
        nqm_gallery_average(gallery, at, texels, N_TEXELS);
    nqm_gallery_free(texels);
    nqm_texture_free(texture);
    return status;
}

nqm_status nqm_library_draw_one(struct nqm_library_state *s, const nqm_library_member *member, nqm_gallery *gallery,
                                size_t at, nqm_error *why, nqm_error *err) {
    const nqm_subject subject = (nqm_subject){.name = member->argument};
    return member->is_textured ? draw_texture(s, member->argument, gallery, at, why, err)
                               : nqm_scorer_draw(s->scorer, 1, &subject, gallery, at, why, err);
}

/* Members without values have no texts any more. */
static void leave_out(nqm_library_member *member) {
    nqm_free((char *)(uintptr_t)member->argument);
    nqm_free((char *)(uintptr_t)member->key);
    *member = (nqm_library_member){.argument = NULL};
}

/* Draw n members, or one that is textured, as pictures from *first on; those without values are left out, and the others drawn again
 * without them. */
static nqm_status draw_block(nqm_library *of, size_t begin, size_t n, size_t *n_failed, size_t *first, nqm_error *err) {
    enum { MOST_REPORTED = 5 };
    struct nqm_library_state *s = of->state;
    nqm_library_member *members = &s->members[begin];
    nqm_subject subjects[NQM_SCORE_BLOCK];
    nqm_error errors[NQM_SCORE_BLOCK];
    size_t n_good = 0;
    for (size_t i = 0; i < n; ++i)
        subjects[i] = (nqm_subject){.name = members[i].argument};
    nqm_status status = n == 1 ? nqm_library_draw_one(s, members, s->gallery, *first, errors, err)
                               : nqm_scorer_draw(s->scorer, n, subjects, s->gallery, *first, errors, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        if (errors[i].status == NQM_OK) {
            subjects[n_good++] = subjects[i];
            continue;
        }
        if ((*n_failed)++ < MOST_REPORTED)
            nqm_library_report(&s->terms, errors[i].status, "%s", errors[i].message);
        leave_out(&members[i]);
    }
    if (status == NQM_OK && n_good && n_good < n) /* their samples are in the cache */
        status = nqm_scorer_draw(s->scorer, n_good, subjects, s->gallery, *first, errors, err);
    *first += n_good;
    return status;
}

static nqm_status draw_all(nqm_library *of, nqm_error *err) {
    struct nqm_library_state *s = of->state;
    size_t n_drawn = 0, n_failed = of->n_failed;
    nqm_status status = nqm_gallery_create(s->model, of->n, NULL, &s->gallery, err);
    for (size_t begin = 0, n; status == NQM_OK && begin < of->n; begin += n) {
        const size_t n_left = nqm_smaller(of->n - begin, NQM_SCORE_BLOCK);
        n = 1;
        while (n < n_left && !of->members[begin].is_textured && !of->members[begin + n].is_textured)
            ++n;
        status = nqm_library_step(s, "sample", begin, of->n, err);
        if (status == NQM_OK)
            status = draw_block(of, begin, n, &n_failed, &n_drawn, err);
    }
    nqm_library_compact(of);
    if (status != NQM_OK) {
        nqm_gallery_free(s->gallery);
        s->gallery = NULL;
    }
    return status;
}

nqm_status nqm_library_draw(nqm_library *of, nqm_error *err) {
    struct nqm_library_state *s = of->state;
    nqm_status status = nqm_library_need_scorer(s, err);
    if (status == NQM_OK && !s->gallery) {
        status = draw_all(of, err);
        if (status == NQM_OK && s->index_path && of->n)
            status = nqm_library_write_index(of, err);
    }
    if (status == NQM_OK && of->n_failed)
        nqm_library_report(&s->terms, NQM_OK, "%s: %zu of %zu materials have no values and are left out", of->path,
                           of->n_failed, of->n + of->n_failed);
    return status;
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

nqm_status nqm_library_begin_pairs(struct nqm_library_state *s, size_t n, nqm_error *err) {
    for (size_t i = 0; i < s->n_pairs; ++i) {
        nqm_library_pair *pair = &s->pairs[i];
        for (size_t k = 0; k < pair->n_changes; ++k) {
            nqm_free((char *)(uintptr_t)pair->changes[k].before.text);
            nqm_free((char *)(uintptr_t)pair->changes[k].after.text);
        }
        nqm_free((nqm_library_change *)(uintptr_t)pair->changes);
        nqm_free((nqm_texture_result *)(uintptr_t)pair->texture);
    }
    nqm_free(s->pairs);
    s->n_pairs = 0;
    const nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&s->pairs, n, sizeof *s->pairs}, {&s->textured, n, sizeof *s->textured}), err);
    s->n_pairs = status == NQM_OK ? n : 0;
    for (size_t i = 0; i < s->n_pairs; ++i)
        s->pairs[i].result = nqm_no_score(NQM_ERR_ARG);
    return status;
}

void nqm_library_set_pair(struct nqm_library_state *s, size_t at, const nqm_library_member *ref, size_t ref_number,
                          const nqm_library_member *test, size_t test_number) {
    s->pairs[at].ref = ref_number;
    s->pairs[at].test = test_number;
    s->pairs[at].names = (nqm_named_pair){ref ? ref->argument : NULL, test ? test->argument : NULL};
    s->textured[at] = (ref && ref->is_textured) || (test && test->is_textured);
}

/* The pairs with textures that have no score as one of BRDFs. */
static nqm_status score_textures(struct nqm_library_state *s, size_t n, bool near_only, nqm_error *err) {
    nqm_library_kept ref = {.name = NULL};
    nqm_library_terms terms = s->terms;
    nqm_status status = NQM_OK;
    terms.near_only = near_only;
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        nqm_library_pair *pair = &s->pairs[i];
        if (pair->error.status == NQM_OK || !s->textured[i])
            continue;
        nqm_texture_result *t = nqm_alloc(1, sizeof *t);
        if (!t) {
            status = nqm_fail_nomem(err, sizeof *t);
            break;
        }
        pair->error = (nqm_error){0};
        const nqm_status scored =
            nqm_library_score_texture(&terms, &pair->names, &ref, t, &pair->result, NULL, &pair->error);
        pair->error.status = scored;
        pair->texture = scored == NQM_OK ? t : NULL;
        if (scored != NQM_OK)
            nqm_free(t);
        if (scored == NQM_ERR_CANCELLED || scored == NQM_ERR_NOMEM)
            status = nqm_fail(err, scored, -1, "%s", pair->error.message);
    }
    nqm_texture_free(ref.texture);
    return status;
}

/* Scores as BRDFs of n pairs, at most NQM_SCORE_BLOCK, from `begin` on. */
static nqm_status score_block(struct nqm_library_state *s, size_t begin, size_t n, nqm_error *err) {
    nqm_named_pair names[NQM_SCORE_BLOCK] = {{NULL, NULL}};
    nqm_score_result results[NQM_SCORE_BLOCK];
    nqm_error errors[NQM_SCORE_BLOCK];
    for (size_t i = 0; i < n; ++i)
        names[i] = s->pairs[begin + i].names;
    const nqm_status status = nqm_scorer_run_named(s->scorer, n, names, results, errors, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        errors[i].status = results[i].status;
        s->pairs[begin + i].result = results[i];
        s->pairs[begin + i].error = errors[i];
    }
    return status;
}

nqm_status nqm_library_score(struct nqm_library_state *s, size_t n, bool near_only, nqm_error *err) {
    nqm_status status = nqm_library_need_scorer(s, err);
    for (size_t begin = 0; status == NQM_OK && begin < n; begin += NQM_SCORE_BLOCK) {
        status = nqm_library_step(s, "score", begin, n, err);
        if (status == NQM_OK)
            status = score_block(s, begin, nqm_smaller(n - begin, NQM_SCORE_BLOCK), err);
    }
    return status == NQM_OK ? score_textures(s, n, near_only, err) : status;
}

nqm_status nqm_library_score_few(struct nqm_library_state *s, size_t n, nqm_error *err) {
    const nqm_status status = score_block(s, 0, n, err);
    return status == NQM_OK ? score_textures(s, n, true, err) : status;
}

/* The network corrects the Delta-E of estimates: of 152 pairs of glTF materials with a JOD above 9 by at most 4 %. */
double nqm_library_least_estimate(double jod) {
    static const double factor = 2;
    return nqm_curve_jod(&nqm_curve_published, factor * nqm_curve_delta_e(&nqm_curve_published, jod));
}
