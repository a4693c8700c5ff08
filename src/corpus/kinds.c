/* SPDX-License-Identifier: MIT
 *
 * The kinds of test with their families, and random perturbed copies. Strengths are log-uniform, so that faint differences,
 * where metrics fail, are as common as strong ones.
 */
#include "corpus/corpus.h"

#include <math.h>
#include <string.h>

const char *nqm_corpus_family_name(nqm_corpus_family family) {
    static const char *const names[NQM_FAMILY_COUNT] = {
        [NQM_FAMILY_ENCODING] = "encoding",         [NQM_FAMILY_PUBLISHED] = "published", [NQM_FAMILY_FORM] = "form",
        [NQM_FAMILY_PERTURBATION] = "perturbation", [NQM_FAMILY_COMPOSED] = "composed",   [NQM_FAMILY_FAR] = "far",
        [NQM_FAMILY_ROUNDING] = "rounding",         [NQM_FAMILY_VARIANT] = "variant"};
    return names[family];
}

/* A perturbation with the range of its strength, log-uniform in [faint, strong]. */
typedef struct perturbation {
    const char *kind;
    const char *key; /* key in the spec; NULL: `kind` */
    double faint, strong;
    enum {
        PLAIN,  /* the value is the strength */
        SIGNED, /* the strength with a random sign */
        FACTOR, /* exp(+-strength) */
        PEAK,   /* FACTOR, or a weak or missing highlight */
        TINT    /* one factor per channel */
    } form;
    bool slow;        /* evaluates its base many times: not used in compositions */
    bool unseen;      /* occurs in the test part only */
    const char *more; /* a further key with a whole number in [more_from, more_to); NULL: none */
    unsigned more_from, more_to;
} perturbation;

static const perturbation perturbations[] = {
    {.kind = "gloss", .faint = 0.02, .strong = 1.6, .form = FACTOR},
    {.kind = "tint", .faint = 0.01, .strong = 0.8, .form = TINT},
    {.kind = "scale", .faint = 0.01, .strong = 1.2, .form = FACTOR},
    {.kind = "fresnel", .faint = 0.3, .strong = 4.5, .form = FACTOR},
    {.kind = "blur", .key = "smooth", .faint = 0.4, .strong = 15, .form = PLAIN, .slow = true}, /* degrees */
    {.kind = "mix", .faint = 0.01, .strong = 0.9, .form = PLAIN},
    {.kind = "noise", .faint = 0.02, .strong = 1.2, .form = PLAIN, .more = "cells", .more_from = 6, .more_to = 25},
    {.kind = "peak", .faint = 0.03, .strong = 2, .form = PEAK},
    {.kind = "desaturate", .faint = 0.03, .strong = 1, .form = SIGNED},
    {.kind = "quantise", .faint = 1, .strong = 40, .form = PLAIN},        /* steps per decade: fewer are stronger */
    {.kind = "shift", .faint = 0.2, .strong = 12, .form = SIGNED},        /* degrees */
    {.kind = "lopsided", .faint = 0.025, .strong = 0.35, .form = SIGNED}, /* logarithms: halves differ by 1.05 to 2 */
    {.kind = "clamp", .faint = 0.01, .strong = 0.9, .form = PLAIN, .unseen = true},
    {.kind = "ripple",
     .faint = 0.02,
     .strong = 0.8,
     .form = PLAIN,
     .unseen = true,
     .more = "bands",
     .more_from = 2,
     .more_to = 25},
    {.kind = "hue", .faint = 2, .strong = 90, .form = SIGNED, .unseen = true}, /* degrees */
};
enum { N_PERTURBATIONS = sizeof perturbations / sizeof *perturbations };

const char *nqm_corpus_perturbation(size_t i) {
    return i < N_PERTURBATIONS ? perturbations[i].kind : NULL;
}

bool nqm_corpus_kind_unseen(const char *name) {
    for (size_t i = 0; i < N_PERTURBATIONS; ++i)
        if (strcmp(perturbations[i].kind, name) == 0)
            return perturbations[i].unseen;
    return nqm_corpus_far_unseen(name);
}

/* ---- one perturbation -------------------------------------------------------------------------------------------- */

static size_t put_number(char *text, size_t n_text, double value) {
    char number[32];
    nqm_format_double(number, sizeof number, nqm_round_digits(value, 4));
    return (size_t)snprintf(text, n_text, "%s", number);
}

/* Three factors with geometric mean 1. */
static void put_tint(nqm_rng *rng, double size, char *text, size_t n_text) {
    double d[3], mean = 0, largest = 0;
    for (int c = 0; c < 3; ++c) {
        d[c] = nqm_rng_normal(rng);
        mean += d[c] / 3;
    }
    for (int c = 0; c < 3; ++c)
        largest = fmax(largest, fabs(d[c] - mean));
    size_t used = 0;
    for (int c = 0; c < 3; ++c) {
        if (c > 0)
            used += (size_t)snprintf(text + used, n_text - used, ",");
        used += put_number(text + used, n_text - used, exp(size * (d[c] - mean) / fmax(largest, 1e-9)));
    }
}

/* Fits often miss a sharp highlight: one copy in six has no highlight, one in six a very weak one. */
static double draw_peak(nqm_rng *rng, double factor) {
    double u = nqm_rng_uniform(rng);
    if (u < 1.0 / 6)
        return 0;
    return u < 2.0 / 6 ? 0.002 * pow(50, nqm_rng_uniform(rng)) : factor;
}

static double draw_value(nqm_rng *rng, const perturbation *p, double size) {
    double sign = nqm_rng_uniform(rng) < 0.5 ? -1 : 1;
    switch (p->form) {
    case SIGNED:
        return sign * size;
    case FACTOR:
        return exp(sign * size);
    case PEAK:
        return draw_peak(rng, exp(sign * size));
    case PLAIN:
    case TINT:
        break;
    }
    return size;
}

/* Draw the settings of a perturbation spec. */
static void draw_perturbation(nqm_rng *rng, const perturbation *p, char text[80]) {
    double size = nqm_rng_log_uniform(rng, p->faint, p->strong);
    size_t used = (size_t)snprintf(text, 80, "%s=", p->key ? p->key : p->kind);
    if (p->form == TINT) {
        put_tint(rng, size, text + used, 80 - used);
        return;
    }
    used += put_number(text + used, 80 - used, draw_value(rng, p, size));
    if (strcmp(p->kind, "noise") == 0)
        used += (size_t)snprintf(text + used, 80 - used, ";seed=%u", (unsigned)nqm_rng_below(rng, 1000000));
    if (p->more)
        snprintf(text + used, 80 - used, ";%s=%u", p->more,
                 p->more_from + (unsigned)nqm_rng_below(rng, p->more_to - p->more_from));
}

/* ---- the perturbed copies of a reference ------------------------------------------------------------------------- */

/* Two different perturbations that are fast and not unseen. */
static void draw_two(nqm_rng *rng, const perturbation *two[2]) {
    const perturbation *quick[N_PERTURBATIONS];
    size_t n = 0;
    for (size_t i = 0; i < N_PERTURBATIONS; ++i)
        if (!perturbations[i].slow && !perturbations[i].unseen)
            quick[n++] = &perturbations[i];
    size_t first = (size_t)nqm_rng_below(rng, n);
    two[0] = quick[first];
    two[1] = quick[(first + 1 + (size_t)nqm_rng_below(rng, n - 1)) % n];
}

enum { COMPOSED = N_PERTURBATIONS, REFIT, N_CHOICES }; /* further choices of a copy */

static nqm_corpus_test draw_test(nqm_rng *rng, size_t ref, size_t n_fits, size_t choice) {
    nqm_corpus_test test = {.ref = ref, .kind.family = NQM_FAMILY_COMPOSED, .base = NQM_BASE_REF};
    const perturbation *two[2];
    if (choice < N_PERTURBATIONS) {
        test.kind.family = NQM_FAMILY_PERTURBATION;
        snprintf(test.kind.name, sizeof test.kind.name, "%s", perturbations[choice].kind);
        draw_perturbation(rng, &perturbations[choice], test.perturbation[0]);
        return test;
    }
    draw_two(rng, two);
    draw_perturbation(rng, two[0], test.perturbation[0]);
    if (choice == REFIT) {
        test.base = NQM_BASE_FIT;
        test.which = (size_t)nqm_rng_below(rng, n_fits);
    } else {
        draw_perturbation(rng, two[1], test.perturbation[1]);
    }
    snprintf(test.kind.name, sizeof test.kind.name, "%s", choice == REFIT ? "refit" : "composed");
    return test;
}

/* One round of choices: each perturbation once, slow ones in every fourth round, COMPOSED and REFIT twice. */
static size_t make_round(nqm_corpus_part part, size_t round, bool with_fits, size_t *choices) {
    size_t n = 0;
    for (size_t i = 0; i < N_PERTURBATIONS; ++i)
        if ((part == NQM_CORPUS_TEST || !perturbations[i].unseen) && (!perturbations[i].slow || round % 4 == 0))
            choices[n++] = i;
    for (int k = 0; k < 2; ++k) {
        choices[n++] = COMPOSED;
        choices[n++] = with_fits ? REFIT : COMPOSED;
    }
    return n;
}

void nqm_corpus_draw_tests(nqm_rng *rng, size_t ref, size_t n_fits, nqm_corpus_part part, size_t n,
                           nqm_corpus_test *tests) {
    size_t choices[N_CHOICES + 2], n_round = 0, at = 0, round = 0;
    for (size_t i = 0; i < n; ++i, ++at) {
        if (at == n_round) {
            n_round = make_round(part, round++, n_fits > 0, choices);
            nqm_rng_shuffle(rng, n_round, choices);
            at = 0;
        }
        tests[i] = draw_test(rng, ref, n_fits, choices[at]);
    }
}
