/* SPDX-License-Identifier: MIT
 *
 * The search of a fit by least squares. For a given lobe shape f_r is linear in the albedos kd and ks, so each start solves two unknowns
 * per channel by non-negative least squares with weights that make the transformed residual linear. The best starts are
 * then refined over all parameters by Levenberg-Marquardt, in unbounded coordinates (logarithms, logits). Its finite
 * differences use absolute steps: relative ones vanish where a logarithm crosses 0.
 */
#include "fit/fit.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { N_ROUNDS = 3, N_REWEIGHTED = 6, MAX_PARAMETERS = 6 + NQM_FIT_MAX_SHAPE };
static const double MIN_ALBEDO = 1e-7, MAX_KD = NQM_FIT_MAX_KD, MAX_KS = NQM_FIT_MAX_KS;

typedef nqm_fit_search search;
typedef nqm_fit_candidate candidate;

static nqm_status set_shape(search *s, const double *shape) {
    return nqm_fit_lobes_set(&s->lobes, shape, s->err);
}

/* Root mean square residual of the values; residual (n, 3) receives the residuals, NULL: not stored. */
static double loss_of(const search *s, const nqm_fit_values *v, double *residual) {
    const nqm_fit_target *t = s->target;
    double sum = 0;
    for (size_t i = 0; i < t->n; ++i)
        for (size_t c = 0; c < 3; ++c) {
            double f = v->kd[c] * s->lobes.diffuse[i] + v->ks[c] * s->lobes.lobe[i];
            double r = nqm_fit_transform(t->loss, t->weight[i], f) - t->goal[3 * i + c];
            if (residual)
                residual[3 * i + c] = r;
            sum += r * r;
        }
    return sqrt(sum / (3 * (double)t->n));
}

/* ---- albedos for a given shape ----------------------------------------------------------------------------------- */

/* Minimise |w (kd a + ks b - y)| over kd, ks >= 0 from the sums of the normal equations. */
static void solve_two(const double sums[5], double *kd, double *ks) {
    double aa = sums[0], ab = sums[1], bb = sums[2], ay = sums[3], by = sums[4];
    double det = aa * bb - ab * ab;
    double x = 0, y = 0;
    if (det > 1e-12 * aa * bb) {
        x = (bb * ay - ab * by) / det;
        y = (aa * by - ab * ay) / det;
    }
    if (det > 1e-12 * aa * bb && x >= 0 && y >= 0) {
        *kd = x;
        *ks = y;
        return;
    }
    /* One of them is 0: the one that reduces the residual less. */
    double gain_a = ay > 0 && aa > 0 ? ay * ay / aa : 0, gain_b = by > 0 && bb > 0 ? by * by / bb : 0;
    *kd = gain_a >= gain_b && gain_a > 0 ? ay / aa : 0;
    *ks = gain_b > gain_a ? by / bb : 0;
}

/* Slope of the secant of the loss's transform between y and f: times this weight, the residual f - y equals the residual
 * of the loss. */
static double secant(nqm_fit_loss loss, double weight, double f, double y, double goal) {
    double difference = f - y, tiny = 1e-6 * (y + 1e-3);
    if (fabs(difference) < tiny) {
        f = y + tiny;
        difference = tiny;
    }
    return (nqm_fit_transform(loss, weight, f) - goal) / difference;
}

static void solve_albedos(const search *s, nqm_fit_values *v) {
    const nqm_fit_target *t = s->target;
    for (size_t c = 0; c < 3; ++c)
        for (int round = 0; round < N_REWEIGHTED; ++round) {
            double sums[5] = {0};
            for (size_t i = 0; i < t->n; ++i) {
                double a = s->lobes.diffuse[i], b = s->lobes.lobe[i], y = t->rgb[3 * i + c];
                double f = round ? v->kd[c] * a + v->ks[c] * b : y; /* round 0: the tangent at the reference */
                double w = secant(t->loss, t->weight[i], f, y, t->goal[3 * i + c]);
                double ww = w * w;
                sums[0] += ww * a * a;
                sums[1] += ww * a * b;
                sums[2] += ww * b * b;
                sums[3] += ww * a * y;
                sums[4] += ww * b * y;
            }
            solve_two(sums, &v->kd[c], &v->ks[c]);
            v->kd[c] = fmin(v->kd[c], MAX_KD);
            v->ks[c] = fmin(v->ks[c], MAX_KS);
        }
}

/* ---- refinement -------------------------------------------------------------------------------------------------- */

static double logit(double p) {
    return log(p / (1 - p));
}

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

static void to_free(const nqm_fit_entry *model, const nqm_fit_values *v, double *x) {
    for (size_t k = 0; k < model->n_shape; ++k)
        *x++ = logit(clamp(nqm_fit_shape_position(&model->shape[k], v->shape[k]), 1e-3, 1 - 1e-3));
    for (size_t c = 0; c < 3; ++c) {
        x[c] = log(fmax(v->kd[c], MIN_ALBEDO));
        x[3 + c] = log(fmax(v->ks[c], MIN_ALBEDO));
    }
}

static void from_free(const nqm_fit_entry *model, const double *x, nqm_fit_values *v) {
    for (size_t k = 0; k < model->n_shape; ++k)
        v->shape[k] = nqm_fit_shape_value(&model->shape[k], 1 / (1 + exp(-*x++)));
    for (size_t c = 0; c < 3; ++c) {
        v->kd[c] = exp(clamp(x[c], log(MIN_ALBEDO), log(MAX_KD)));
        v->ks[c] = exp(clamp(x[3 + c], log(MIN_ALBEDO), log(MAX_KS)));
    }
}

static int lsq_residuals(void *user, const double *x, double *residual) {
    search *s = user;
    nqm_fit_values v;
    from_free(s->lobes.model, x, &v);
    s->failure = nqm_fit_tick(s) ? nqm_fit_cancelled(s->err) : set_shape(s, v.shape);
    if (s->failure != NQM_OK)
        return -1;
    (void)loss_of(s, &v, residual);
    return 0;
}

/* Set albedos at the lower end of their range to 0. */
static void drop_traces(nqm_fit_values *v) {
    for (size_t c = 0; c < 3; ++c) {
        v->kd[c] = v->kd[c] < 2 * MIN_ALBEDO ? 0 : v->kd[c];
        v->ks[c] = v->ks[c] < 2 * MIN_ALBEDO ? 0 : v->ks[c];
    }
}

/* Replace `best` by `v` if v has the smaller loss. */
static nqm_status keep_better(search *s, const nqm_fit_values *v, candidate *best) {
    nqm_status status = set_shape(s, v->shape);
    double loss = status == NQM_OK ? loss_of(s, v, NULL) : 0;
    if (status == NQM_OK && loss < best->loss) {
        best->values = *v;
        best->loss = loss;
    }
    return status;
}

/* One run of Levenberg-Marquardt over all parameters, starting from *values; they are unchanged if it diverges. */
static nqm_status descend(search *s, int max_evaluations, nqm_fit_values *values) {
    double x[MAX_PARAMETERS], rms;
    nqm_lsq_problem problem = {.n_parameters = s->lobes.model->n_shape + 6,
                               .n_residuals = 3 * s->target->n,
                               .residuals = lsq_residuals,
                               .user = s,
                               .step = 1e-5,
                               .tolerance = 1e-6,
                               .max_evaluations = max_evaluations};
    to_free(s->lobes.model, values, x);
    nqm_error err = {0};
    nqm_status status = nqm_lsq_solve(&problem, x, &rms, &err);
    if (status == NQM_ERR_NUMERIC)
        return NQM_OK;
    if (status == NQM_ERR_CANCELLED)
        return s->failure;
    if (status != NQM_OK) {
        if (s->err)
            *s->err = err;
        return status;
    }
    from_free(s->lobes.model, x, values);
    drop_traces(values);
    return NQM_OK;
}

/* Replace a candidate by the result of a run from it, if that is better. */
static nqm_status refine_once(search *s, candidate *best) {
    nqm_fit_values refined = best->values;
    nqm_status status = descend(s, 400, &refined);
    return status == NQM_OK ? keep_better(s, &refined, best) : status;
}

/* In logarithms an albedo near 0 cannot grow again; the linear solution between the rounds lets it. */
static nqm_status refine(search *s, candidate *best) {
    nqm_status status = NQM_OK;
    double before = INFINITY;
    for (int round = 0; status == NQM_OK && round < N_ROUNDS && best->loss < 0.999 * before; ++round) {
        before = best->loss;
        status = refine_once(s, best);
        nqm_fit_values solved = best->values;
        if (status == NQM_OK)
            status = set_shape(s, solved.shape);
        if (status == NQM_OK) {
            solve_albedos(s, &solved);
            status = keep_better(s, &solved, best);
        }
    }
    return status;
}

/* ---- starts ------------------------------------------------------------------------------------------------------ */

static nqm_status score_start(search *s, candidate *start) {
    nqm_status status = set_shape(s, start->values.shape);
    if (status != NQM_OK)
        return status;
    solve_albedos(s, &start->values);
    start->loss = loss_of(s, &start->values, NULL);
    return NQM_OK;
}

/* Number of starts that are refined: more if they differ in more than the width. */
static size_t n_refined(const nqm_fit_entry *model) {
    return model->n_start > 2 ? NQM_FIT_MAX_REFINED : 2;
}

/* Insert `c` into the sorted list of at most n_max candidates with the smallest losses. */
static void insert(candidate *best, size_t *n_best, size_t n_max, const candidate *c) {
    size_t at = *n_best;
    while (at > 0 && best[at - 1].loss > c->loss)
        --at;
    if (at == n_max)
        return;
    size_t n_moved = (*n_best < n_max ? *n_best : n_max - 1) - at;
    memmove(best + at + 1, best + at, n_moved * sizeof *best);
    best[at] = *c;
    *n_best += *n_best < n_max;
}

/* Start i: widths are spaced evenly in their logarithm, each with all starting points of the model. */
static void make_start(const nqm_fit_entry *model, size_t i, size_t n_widths, double *shape) {
    static const double low = 0.001, high = 0.8;
    size_t width = i / model->n_start;
    double u = ((double)width + 0.5) / (double)n_widths;
    model->start(low * pow(high / low, u), i % model->n_start, shape);
    for (size_t k = 0; k < model->n_shape; ++k)
        shape[k] = clamp(shape[k], model->shape[k].low, model->shape[k].high);
}

static nqm_status scan_starts(search *s, const nqm_fit_options *options, candidate *best, size_t *n_best) {
    size_t n = options->n_starts * s->lobes.model->n_start;
    s->total = (double)(n + n_refined(s->lobes.model));
    for (size_t i = 0; i < n; ++i) {
        candidate c = {.start = i};
        make_start(s->lobes.model, i, options->n_starts, c.values.shape);
        nqm_status status = score_start(s, &c);
        if (status != NQM_OK)
            return status;
        insert(best, n_best, n_refined(s->lobes.model), &c);
        s->done = (double)(i + 1);
        if (nqm_fit_tick(s))
            return nqm_fit_cancelled(s->err);
    }
    return NQM_OK;
}

bool nqm_fit_tick(search *s) {
    return nqm_tick(s->ticker, "fit", s->done, s->total);
}

nqm_status nqm_fit_cancelled(nqm_error *err) {
    return nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted");
}

nqm_status nqm_fit_search_begin(const nqm_fit_entry *model, const nqm_fit_target *target, nqm_ticker *ticker, search *s,
                                nqm_error *err) {
    *s = (search){.target = target, .ticker = ticker, .err = err};
    return nqm_fit_lobes_make(model, target->n, target->wi, target->wo, &s->lobes, err);
}

void nqm_fit_search_end(search *s) {
    nqm_free(s->lobes.rgb);
}

nqm_status nqm_fit_search_starts(search *s, const nqm_fit_options *options, candidate *best, size_t *n_best) {
    *n_best = 0;
    nqm_status status = scan_starts(s, options, best, n_best);
    for (size_t i = 0; status == NQM_OK && i < *n_best; ++i) {
        status = refine(s, &best[i]);
        s->done += 1;
    }
    return status;
}

nqm_status nqm_fit_search_refine(search *s, candidate *c, bool with_albedos) {
    nqm_status status = set_shape(s, c->values.shape);
    if (status != NQM_OK)
        return status;
    c->loss = loss_of(s, &c->values, NULL);
    return with_albedos ? refine(s, c) : refine_once(s, c);
}

/* ---- random starts ------------------------------------------------------------------------------------------------------- */

/* Albedos times random factors in [1/20, 20]. */
static void scatter_albedos(nqm_rng *rng, double albedo[3]) {
    for (size_t c = 0; c < 3; ++c)
        albedo[c] = fmax(albedo[c], 1e-3) * pow(20, 2 * nqm_rng_uniform(rng) - 1);
}

nqm_status nqm_fit_search_random(search *s, nqm_rng *rng, nqm_fit_values *values) {
    nqm_fit_values start = {.kd = {0}};
    for (size_t k = 0; k < s->lobes.model->n_shape; ++k)
        start.shape[k] = nqm_fit_shape_value(&s->lobes.model->shape[k], nqm_rng_uniform(rng));
    nqm_status status = set_shape(s, start.shape);
    if (status != NQM_OK)
        return status;
    solve_albedos(s, &start);
    scatter_albedos(rng, start.kd);
    scatter_albedos(rng, start.ks);
    for (size_t c = 0; c < 3; ++c) {
        start.kd[c] = fmin(start.kd[c], MAX_KD);
        start.ks[c] = fmin(start.ks[c], MAX_KS);
    }
    *values = start;
    return NQM_OK;
}

nqm_status nqm_fit_follow(const nqm_fit_entry *model, const nqm_fit_target *target, uint64_t seed, size_t n_steps,
                          nqm_fit_values *values, nqm_error *err) {
    search s;
    nqm_rng rng = nqm_rng_make(seed, 0);
    nqm_fit_values start;
    nqm_status status = nqm_fit_search_begin(model, target, NULL, &s, err);
    if (status == NQM_OK)
        status = nqm_fit_search_random(&s, &rng, &start);
    if (status == NQM_OK && n_steps > 0)
        status = descend(&s, 1 + (int)n_steps, &start); /* the first evaluation is at the start */
    if (status == NQM_OK)
        *values = start;
    nqm_fit_search_end(&s);
    return status;
}
