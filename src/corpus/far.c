/* SPDX-License-Identifier: MIT
 *
 * Far tests: BRDFs that really differ from the reference, as in fits that begin far away and in searches for the nearest
 * material; and the opposite, copies that differ by rounding only.
 */
#include "corpus/corpus.h"
#include "fit/fit.h"

#include <math.h>
#include <string.h>

/* A kind of far test. */
typedef struct far_kind {
    const char *name;
    enum {
        SAME,        /* another material from the same source */
        SOURCE,      /* another material from another source */
        BETWEEN,     /* between the reference and another material: the arithmetic mean */
        LOG_BETWEEN, /* the geometric mean */
        RANDOM,      /* the model after "random-" with random parameters */
        PATH,        /* a point on the path of an optimiser of the model after "path-" */
        ALBEDO,      /* a Lambert BRDF with an albedo in [low, high] */
        MIRROR,      /* a metal with a GGX width in [low, high] */
        SCALED       /* the reference times 10^x, abs(x) in [low, high] */
    } form;
    unsigned per_round; /* times in a round of draws */
    bool unseen;        /* occurs in the test part only */
    double low, high;   /* log-uniform; of SCALED uniform */
} far_kind;

/* clang-format off */
static const far_kind kinds[] = {
    {"other-same", SAME, 8, false, 0, 0},
    {"other-source", SOURCE, 8, false, 0, 0},
    {"between", BETWEEN, 8, false, 0, 0},
    {"between-log", LOG_BETWEEN, 4, true, 0, 0},
    {"random-lambert", RANDOM, 1, false, 0, 0},
    {"random-ggx", RANDOM, 1, false, 0, 0},
    {"random-ward", RANDOM, 1, false, 0, 0},
    {"random-sgd", RANDOM, 1, false, 0, 0},
    {"random-ward-duer", RANDOM, 1, false, 0, 0},
    {"random-blinn-phong", RANDOM, 1, false, 0, 0},
    {"random-lafortune", RANDOM, 3, true, 0, 0},
    {"random-cook-torrance", RANDOM, 1, false, 0, 0},
    {"random-low-cook-torrance", RANDOM, 1, false, 0, 0},
    {"random-ashikhmin-shirley", RANDOM, 1, false, 0, 0},
    {"random-low-ashikhmin-shirley", RANDOM, 1, false, 0, 0},
    {"random-abc", RANDOM, 1, false, 0, 0},
    {"random-smooth", RANDOM, 3, true, 0, 0},
    {"path-ward", PATH, 1, false, 0, 0},
    {"path-ggx", PATH, 1, false, 0, 0},
    {"path-ward-duer", PATH, 1, false, 0, 0},
    {"path-blinn-phong", PATH, 1, false, 0, 0},
    {"path-lafortune", PATH, 1, false, 0, 0},
    {"path-cook-torrance", PATH, 1, false, 0, 0},
    {"path-ashikhmin-shirley", PATH, 1, false, 0, 0},
    {"path-abc", PATH, 1, false, 0, 0},
    {"path-smooth", PATH, 1, false, 0, 0},
    {"black", ALBEDO, 1, false, 1e-5, 0.005},
    {"white", ALBEDO, 2, true, 0.7, 1},
    {"mirror", MIRROR, 1, false, 0.001, 0.05},
    {"scaled", SCALED, 1, false, 0.5, 3},
};
/* clang-format on */
enum { N_KINDS = sizeof kinds / sizeof *kinds, MAX_ROUND = 64, MAX_STEPS = 8 };

const char *nqm_corpus_far_kind(size_t i) {
    return i < N_KINDS ? kinds[i].name : NULL;
}

bool nqm_corpus_far_unseen(const char *name) {
    for (size_t i = 0; i < N_KINDS; ++i)
        if (strcmp(kinds[i].name, name) == 0)
            return kinds[i].unseen;
    return false;
}

/* ---- other materials --------------------------------------------------------------------------------------------- */

/* State of drawing the tests of a reference. */
typedef struct draw {
    const nqm_corpus_list *list;
    size_t ref; /* in the list */
    uint64_t seed;
    nqm_rng rng;
    uint64_t last[N_KINDS]; /* hash of the material that a kind used last */
} draw;

static bool may_use(const draw *d, const far_kind *kind, size_t other) {
    const nqm_corpus_list *list = d->list;
    const nqm_corpus_ref *a = &list->refs[d->ref], *b = &list->refs[other];
    bool is_same_source = strcmp(a->source, b->source) == 0;
    return a->group != b->group && list->groups[a->group].split == list->groups[b->group].split &&
           (kind->form == SAME ? is_same_source : kind->form != SOURCE || !is_same_source);
}

/* Each kind takes materials in the order of a hash of both names, so that adding a material to the list changes the choice of
 * few references. false: no material is left. */
static bool next_other(draw *d, const far_kind *kind, size_t *other_ret) {
    uint64_t *last = &d->last[kind - kinds], least = UINT64_MAX;
    uint64_t key = nqm_hash_u64(d->seed ^ nqm_corpus_stream(kind->name), nqm_corpus_stream(d->list->refs[d->ref].name));
    bool found = false;
    for (size_t i = 0; i < d->list->n_refs; ++i) {
        if (!may_use(d, kind, i))
            continue;
        uint64_t hash = nqm_hash_u64(key, nqm_corpus_stream(d->list->refs[i].name));
        if (hash <= *last || hash >= least)
            continue;
        least = hash;
        *other_ret = i;
        found = true;
    }
    *last = least; /* UINT64_MAX if none was found: none will be */
    return found;
}

/* ---- one test ---------------------------------------------------------------------------------------------------- */

static nqm_status set_spec(nqm_corpus_test *test, const char *text, nqm_error *err) {
    test->base = NQM_BASE_SPEC;
    test->spec = nqm_strdup(text);
    return test->spec ? NQM_OK : nqm_fail_nomem(err, strlen(text) + 1);
}

static nqm_status draw_albedo(draw *d, const far_kind *kind, nqm_corpus_test *test, nqm_error *err) {
    char text[64], number[32];
    double kd = nqm_round_digits(nqm_rng_log_uniform(&d->rng, kind->low, kind->high), 4);
    kd = kd < 1e-4 ? 0 : kd; /* entirely black */
    snprintf(text, sizeof text, "lambert:kd=%s", nqm_format_double(number, sizeof number, kd));
    return set_spec(test, text, err);
}

static nqm_status draw_mirror(draw *d, const far_kind *kind, nqm_corpus_test *test, nqm_error *err) {
    char text[160], number[4][32];
    double alpha = nqm_rng_log_uniform(&d->rng, kind->low, kind->high);
    nqm_format_double(number[3], sizeof number[3], nqm_round_digits(alpha, 4));
    for (int c = 0; c < 3; ++c)
        nqm_format_double(number[c], sizeof number[c], nqm_round_digits(0.5 + 0.5 * nqm_rng_uniform(&d->rng), 4));
    snprintf(text, sizeof text, "ggx:ks=1;alpha=%s;f0=%s,%s,%s", number[3], number[0], number[1], number[2]);
    return set_spec(test, text, err);
}

static void draw_between(draw *d, const far_kind *kind, nqm_corpus_test *test) {
    char number[32];
    double t = 0.02 + 0.96 * nqm_rng_uniform(&d->rng);
    test->base = NQM_BASE_BETWEEN;
    nqm_format_double(number, sizeof number, nqm_round_digits(t, 4));
    snprintf(test->between, sizeof test->between, "t=%s%s", number, kind->form == LOG_BETWEEN ? ";log=1" : "");
}

static void draw_path(draw *d, const char *model, nqm_corpus_test *test) {
    size_t k = 0;
    while (strcmp(nqm_fit_model(k), model) != 0)
        ++k;
    test->base = NQM_BASE_PATH;
    test->path.model = nqm_fit_model(k);
    test->path.loss = (nqm_fit_loss)nqm_rng_below(&d->rng, NQM_FIT_N_CORPUS_LOSSES);
    test->path.n_steps = (size_t)nqm_rng_below(&d->rng, MAX_STEPS + 1);
    test->path.seed = nqm_rng_below(&d->rng, 1000000);
}

static void draw_scale(draw *d, const far_kind *kind, nqm_corpus_test *test) {
    char number[32];
    double x = kind->low + (kind->high - kind->low) * nqm_rng_uniform(&d->rng);
    double scale = pow(10, nqm_rng_uniform(&d->rng) < 0.5 ? -x : x);
    test->base = NQM_BASE_REF;
    snprintf(test->perturbation[0], sizeof test->perturbation[0], "scale=%s",
             nqm_format_double(number, sizeof number, nqm_round_digits(scale, 4)));
}

static nqm_status draw_test(draw *d, const far_kind *kind, nqm_corpus_test *test, nqm_error *err) {
    const char *model = strchr(kind->name, '-') ? strchr(kind->name, '-') + 1 : "";
    switch (kind->form) {
    case SAME:
    case SOURCE:
        test->base = NQM_BASE_OTHER;
        break;
    case BETWEEN:
    case LOG_BETWEEN:
        draw_between(d, kind, test);
        break;
    case RANDOM:
        test->base = NQM_BASE_SPEC;
        return nqm_corpus_random_spec(&d->rng, model, &test->spec, err);
    case PATH:
        draw_path(d, model, test);
        break;
    case ALBEDO:
        return draw_albedo(d, kind, test, err);
    case MIRROR:
        return draw_mirror(d, kind, test, err);
    case SCALED:
        draw_scale(d, kind, test);
        break;
    }
    return NQM_OK;
}

/* ---- all tests of a reference ------------------------------------------------------------------------------------ */

static size_t make_round(nqm_corpus_part part, size_t *choices) {
    size_t n = 0;
    for (size_t i = 0; i < N_KINDS; ++i)
        for (unsigned k = 0; k < kinds[i].per_round && n < MAX_ROUND; ++k)
            if (part == NQM_CORPUS_TEST || !kinds[i].unseen)
                choices[n++] = i;
    return n;
}

/* Choose the other material of a kind that needs one; false: there is none, or all have been used. */
static bool find_other(draw *d, const far_kind *kind, size_t *other_ret) {
    bool is_mixture = kind->form == BETWEEN || kind->form == LOG_BETWEEN;
    if (kind->form != SAME && kind->form != SOURCE && !is_mixture)
        return true;
    if (next_other(d, kind, other_ret))
        return true;
    if (!is_mixture)
        return false;
    d->last[kind - kinds] = 0; /* a second mixture with the same material is another test */
    return next_other(d, kind, other_ret);
}

nqm_status nqm_corpus_draw_far(const nqm_corpus_list *list, size_t list_ref, uint64_t seed, nqm_corpus_part part,
                               size_t n, nqm_corpus_test *tests, nqm_error *err) {
    draw d = {.list = list, .ref = list_ref, .seed = seed};
    d.rng = nqm_rng_make(seed, nqm_hash_u64(nqm_corpus_stream(list->refs[list_ref].name), 1));
    size_t choices[MAX_ROUND], n_round = 0, at = 0;
    for (size_t i = 0; i < n; ++at) {
        if (at == n_round) {
            n_round = make_round(part, choices);
            nqm_rng_shuffle(&d.rng, n_round, choices);
            at = 0;
        }
        const far_kind *kind = &kinds[choices[at]];
        nqm_corpus_test *test = &tests[i];
        *test = (nqm_corpus_test){.kind.family = NQM_FAMILY_FAR};
        if (!find_other(&d, kind, &test->which))
            continue;
        snprintf(test->kind.name, sizeof test->kind.name, "%s", kind->name);
        nqm_status status = draw_test(&d, kind, test, err);
        if (status != NQM_OK)
            return status;
        ++i;
    }
    return NQM_OK;
}

/* ---- rounding ---------------------------------------------------------------------------------------------------- */

void nqm_corpus_draw_roundings(nqm_rng *rng, size_t ref, size_t n, nqm_corpus_test *tests) {
    static const char *const names[] = {"float32", "float16", "bits"};
    static const char *const settings[] = {"bits=24", "half=1", NULL};
    for (size_t i = 0; i < n; ++i) {
        nqm_corpus_test *test = &tests[i];
        size_t k = i % 3;
        *test = (nqm_corpus_test){.ref = ref, .kind.family = NQM_FAMILY_ROUNDING, .base = NQM_BASE_REF};
        snprintf(test->kind.name, sizeof test->kind.name, "%s", names[k]);
        if (settings[k])
            snprintf(test->perturbation[0], sizeof test->perturbation[0], "%s", settings[k]);
        else
            snprintf(test->perturbation[0], sizeof test->perturbation[0], "bits=%u",
                     5 + (unsigned)nqm_rng_below(rng, 19));
    }
}
