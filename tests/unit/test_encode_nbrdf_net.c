/* SPDX-License-Identifier: MIT
 *
 * Training of an NBRDF network: its loss against the formula in double with the evaluation of src/brdf, its gradient
 * against central differences of that loss, and both against PyTorch (tests/vectors/nbrdf.py).
 */
#include "encode/encode.h"
#include "math/math.h"
#include "support/check.h"

enum { N = 150 }; /* two blocks and a partial third block */

typedef struct problem {
    float weights[NQM_NBRDF_WEIGHTS], input[6 * N], weight[N], goal[3 * N];
    double hd[3 * N];
} problem;

static problem make_problem(double spread) {
    problem p;
    nqm_rng rng = nqm_rng_make(5, 0);
    for (size_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i)
        p.weights[i] = (float)(spread * nqm_rng_normal(&rng));
    for (size_t i = 0; i < N; ++i) {
        p.hd[3 * i] = 0.7 * nqm_rng_uniform(&rng);
        p.hd[3 * i + 1] = 0.7 * nqm_rng_uniform(&rng);
        p.hd[3 * i + 2] = NQM_PI * nqm_rng_uniform(&rng);
        for (size_t c = 0; c < 3; ++c)
            p.goal[c * N + i] = (float)nqm_rng_uniform(&rng);
    }
    nqm_nbrdf_inputs(N, p.hd, p.input, p.weight);
    return p;
}

static nqm_nbrdf_batch batch_of(const problem *p) {
    return (nqm_nbrdf_batch){.n = N, .input = p->input, .weight = p->weight, .goal = p->goal};
}

/* y (n_out) = b + w^T x, with ReLU for hidden layers; returns a pointer to the weights of the next layer. */
static const double *layer(const double *w, size_t n_in, size_t n_out, const double *x, bool hidden, double *y) {
    for (size_t j = 0; j < n_out; ++j) {
        y[j] = w[n_in * n_out + j];
        for (size_t k = 0; k < n_in; ++k)
            y[j] += w[k * n_out + j] * x[k];
        y[j] = hidden ? fmax(y[j], 0) : y[j];
    }
    return w + n_in * n_out + n_out;
}

/* The definition of the loss, in double. */
static double plain_loss(const double *weights, const problem *p) {
    double sum = 0;
    for (size_t i = 0; i < N; ++i) {
        double x[6], first[21], second[21], out[3];
        for (size_t k = 0; k < 6; ++k)
            x[k] = (double)p->input[k * N + i];
        const double *w = layer(weights, 6, 21, x, true, first);
        w = layer(w, 21, 21, first, true, second);
        layer(w, 21, 3, second, false, out);
        for (size_t c = 0; c < 3; ++c)
            sum += fabs(log1p((double)p->weight[i] * expm1(out[c])) - (double)p->goal[c * N + i]);
    }
    return sum / (3 * N);
}

static void to_double(const problem *p, double *weights) {
    for (size_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i)
        weights[i] = (double)p->weights[i];
}

/* The loss is almost 0 if the targets are the same network's values, evaluated by src/brdf. */
TEST(inputs_are_those_of_evaluation) {
    problem p = make_problem(0.2);
    nqm_brdf *brdf;
    for (size_t c = 1; c <= 3; ++c)
        p.weights[NQM_NBRDF_WEIGHTS - c] = 2; /* f_r > 0 everywhere: nothing is clamped */
    assert_int_equal(nqm_nbrdf_create(p.weights, "network", &brdf, NULL), NQM_OK);
    for (size_t i = 0; i < N; ++i) {
        double rgb[3], wi[3], wo[3];
        nqm_brdf_eval_half_diff(brdf, 1, p.hd + 3 * i, rgb, NULL);
        nqm_half_diff_to_directions(p.hd + 3 * i, wi, wo);
        for (size_t c = 0; c < 3; ++c) {
            assert_true(rgb[c] > 0.1);
            p.goal[c * N + i] = (float)log1p(wi[2] * rgb[c]);
        }
    }
    nqm_brdf_free(brdf);
    nqm_nbrdf_batch batch = batch_of(&p);
    assert_near(nqm_nbrdf_loss(p.weights, &batch, NULL), 0, 1e-6);
}

TEST(loss_is_its_formula) {
    for (double spread = 0.01; spread < 1; spread *= 3) {
        problem p = make_problem(spread);
        nqm_nbrdf_batch batch = batch_of(&p);
        double weights[NQM_NBRDF_WEIGHTS];
        to_double(&p, weights);
        double loss = nqm_nbrdf_loss(p.weights, &batch, NULL), plain = plain_loss(weights, &p);
        assert_near(loss, plain, 3e-6 * plain);
    }
}

TEST(gradient_is_the_slope_of_the_loss) {
    problem p = make_problem(0.3);
    nqm_nbrdf_batch batch = batch_of(&p);
    float gradient[NQM_NBRDF_WEIGHTS];
    double weights[NQM_NBRDF_WEIGHTS], largest = 0;
    double with = nqm_nbrdf_loss(p.weights, &batch, gradient);
    assert_true(with == nqm_nbrdf_loss(p.weights, &batch, NULL));
    to_double(&p, weights);
    for (size_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i) {
        const double step = 1e-7; /* small, so that few kinks of ReLU and |x| are crossed */
        double kept = weights[i];
        weights[i] = kept + step;
        double up = plain_loss(weights, &p);
        weights[i] = kept - step;
        double slope = (up - plain_loss(weights, &p)) / (2 * step);
        weights[i] = kept;
        assert_near((double)gradient[i], slope, 2e-5);
        largest = fmax(largest, fabs(slope));
    }
    assert_true(largest > 0.1); /* gradients are much larger than the tolerance */
}

static nqm_csv *load_vectors(const char *name, size_t n_rows) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector(name), &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), n_rows);
    return csv;
}

TEST(agrees_with_pytorch) {
    enum { ROWS = 200 };
    nqm_csv *rows = load_vectors("nbrdf_batch.csv", ROWS),
            *numbers = load_vectors("nbrdf_weights.csv", NQM_NBRDF_WEIGHTS);
    float weights[NQM_NBRDF_WEIGHTS], gradient[NQM_NBRDF_WEIGHTS], input[6 * ROWS], weight[ROWS], goal[3 * ROWS];
    double hd[3 * ROWS], loss = 0, difference2 = 0, norm2 = 0;
    for (size_t i = 0; i < ROWS; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            hd[3 * i + c] = csv_number(rows, i, (int)c);
            goal[c * ROWS + i] = (float)csv_number(rows, i, (int)(3 + c));
        }
        loss += csv_number(rows, i, 6) / ROWS;
    }
    for (size_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i)
        weights[i] = (float)csv_number(numbers, i, 0);
    nqm_nbrdf_inputs(ROWS, hd, input, weight);
    const nqm_nbrdf_batch batch = {.n = ROWS, .input = input, .weight = weight, .goal = goal};
    assert_near(nqm_nbrdf_loss(weights, &batch, gradient), loss, 1e-6 * loss);
    for (size_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i) {
        double expected = csv_number(numbers, i, 1), difference = (double)gradient[i] - expected;
        difference2 += difference * difference;
        norm2 += expected * expected;
        assert_near((double)gradient[i], expected, 1e-5 * (fabs(expected) + 0.05));
    }
    assert_true(sqrt(difference2) < 1e-5 * sqrt(norm2) && norm2 > 0.01);
    nqm_csv_free(rows);
    nqm_csv_free(numbers);
}

TEST(huge_outputs_stay_finite) {
    for (double sign = -1; sign <= 1; sign += 2) {
        problem p = make_problem(0.3);
        nqm_nbrdf_batch batch = batch_of(&p);
        float gradient[NQM_NBRDF_WEIGHTS];
        p.weight[0] = 1;
        for (size_t c = 1; c <= 3; ++c)
            p.weights[NQM_NBRDF_WEIGHTS - c] = (float)(sign * 500);
        assert_true(isfinite(nqm_nbrdf_loss(p.weights, &batch, gradient)));
        for (size_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i)
            assert_true(isfinite(gradient[i]));
        assert_true(sign * (double)gradient[NQM_NBRDF_WEIGHTS - 1] > 0); /* gradient descent reduces the overshoot */
    }
}
