/* SPDX-License-Identifier: MIT
 *
 * Class balancing, splits, noise, whitening and the gathering of batches; the paper's counts for the authors' own
 * labels.
 */
#include "io/io.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/toy_dataset.h"

#include <omp.h>

static nqm_train_options recipe(const char *name) {
    nqm_train_options o;
    assert_int_equal(nqm_train_options_recipe(name, &o, NULL), NQM_OK);
    return o;
}

/* Of training examples, or of the validation examples from `first` on: x (n, e->width), target (n, e->n_outputs). */
static void gather_from(const nqm_examples *e, size_t n, const size_t *index, size_t first, float *x, float *target) {
    const nqm_net_shape shape = {2, {e->width, 2, e->n_outputs}};
    const nqm_trainer_options options = {NQM_PRECISION_F32, n};
    nqm_trainer *trainer;
    assert_int_equal(nqm_trainer_create(&shape, &options, &trainer, NULL), NQM_OK);
    nqm_examples_gather(e, n, index, first, trainer, target);
    for (size_t i = 0; i < n; ++i)
        memcpy(x + i * e->width, nqm_trainer_input(trainer, i), e->width * sizeof *x);
    nqm_trainer_free(trainer);
}

static void gather(const nqm_examples *e, size_t n, const size_t *index, float *x, float *target) {
    gather_from(e, n, index, 0, x, target);
}

TEST(fills_every_bin) {
    /* Range 0..7, bins of width 1. Counts 1, 2, 0, 3, 0, 0, 1: the four non-empty bins are filled up to 3 each. */
    const double label[] = {0, 1.1, 1.2, 3.1, 3.2, 3.3, 7};
    const uint32_t expected[] = {2, 1, 0, 0, 0, 0, 2};
    uint32_t copies[7];
    assert_int_equal(nqm_balance(7, label, copies), 5);
    assert_memory_equal(copies, expected, sizeof expected);
    const double equal[] = {5, 5, 5};
    assert_int_equal(nqm_balance(3, equal, copies), 0);
}

/* The 1,242 distinct pairs of the authors' label file are balanced to 7 bins of 477, 3,339 rows, as in that file. */
TEST(authors_counts) {
    const char *path = shared_data("labels/labels_balanced_train.csv");
    if (!path)
        skip();
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(path, &csv, NULL), NQM_OK);
    size_t n_rows = nqm_csv_rows(csv), n = 0;
    assert_int_equal(n_rows, 3339);
    int columns[3] = {nqm_csv_column(csv, "material"), nqm_csv_column(csv, "model"), nqm_csv_column(csv, "level")};
    char(*keys)[128] = calloc(n_rows, sizeof *keys);
    double *label = calloc(n_rows, sizeof *label);
    uint32_t *copies = calloc(n_rows, sizeof *copies);
    size_t *bin = calloc(n_rows, sizeof *bin);
    for (size_t i = 0; i < n_rows; ++i) {
        const char *name = nqm_csv_text(csv, i, columns[0]);
        int stem = (int)(strrchr(name, '_') - name);
        snprintf(keys[n], sizeof *keys, "%.*s %s %s", stem, name, nqm_csv_text(csv, i, columns[1]),
                 nqm_csv_text(csv, i, columns[2]));
        assert_int_equal(nqm_csv_number(csv, i, nqm_csv_column(csv, "JOD"), &label[n], NULL), NQM_OK);
        bin[n] = (size_t)atoi(nqm_csv_text(csv, i, nqm_csv_column(csv, "class")));
        size_t k = 0;
        while (strcmp(keys[k], keys[n]) != 0)
            ++k;
        n += k == n;
    }
    assert_int_equal(n, 1242);
    assert_int_equal(n + nqm_balance(n, label, copies), 3339);
    size_t count[7] = {0};
    for (size_t i = 0; i < n; ++i) /* bins of the original rows */
        count[bin[i]] += 1 + copies[i];
    for (size_t k = 0; k < 7; ++k)
        assert_int_equal(count[k], 477);
    free(keys);
    free(label);
    free(copies);
    free(bin);
    nqm_csv_free(csv);
}

TEST(noise_keeps_the_difference) {
    enum { N = 20000 };
    float *v = calloc(4 * N, sizeof *v);
    float *ref = v, *test = v + N, *noisy_ref = v + 2 * N, *noisy_test = v + 3 * N;
    for (size_t i = 0; i < N; ++i) {
        ref[i] = i < N / 2 ? 1 : 0;
        test[i] = i < N / 2 ? 0.75f : 0;
    }
    nqm_rng rng = nqm_rng_make(3, 0);
    nqm_add_noise(N, ref, test, 0.01, &rng, noisy_ref, noisy_test);
    double sum = 0, squares = 0;
    for (size_t i = 0; i < N / 2; ++i) {
        assert_near((double)noisy_ref[i] - (double)noisy_test[i], 0.25, 1e-6);
        sum += (double)noisy_ref[i] - 1;
        squares += pow((double)noisy_ref[i] - 1, 2);
    }
    assert_near(sum / (N / 2), 0, 4 * 0.01 / sqrt(N / 2));
    assert_near(sqrt(squares / (N / 2)), 0.01, 4 * 0.01 / sqrt(N));
    for (size_t i = N / 2; i < N; ++i)
        assert_true(noisy_ref[i] >= 0 && noisy_ref[i] == noisy_test[i]);
    free(v);
}

/* No material is in both training and validation, no test pair is used, every other pair occurs once plus its
 * copies. */
TEST(group_splits) {
    for (int own_split = 0; own_split < 2; ++own_split) {
        toy_options toy = toy_options_default();
        toy.splits = own_split != 0;
        nqm_dataset *d = toy_dataset(&toy);
        nqm_train_options o = recipe("notebook");
        nqm_rows rows;
        assert_int_equal(nqm_rows_create(d, &o, &rows, NULL), NQM_OK);
        uint8_t side[24] = {0}; /* of each material: 1 training, 2 validation */
        size_t n_originals = 0, n_noisy = 0;
        for (size_t i = 0; i < rows.n_train + rows.n_validation; ++i) {
            uint32_t group = d->ref_group[d->pair_ref[rows.row[i].pair]];
            side[group] |= i < rows.n_train ? 1 : 2;
            n_originals += rows.row[i].copy == 0;
            n_noisy += rows.row[i].copy != 0;
            assert_int_not_equal(d->group_split[group], NQM_SPLIT_TEST);
        }
        assert_int_equal(n_originals, own_split ? d->n_pairs * 3 / 4 : d->n_pairs);
        assert_int_equal(n_noisy, rows.n_noisy);
        size_t n_validation_groups = 0;
        for (size_t g = 0; g < 24; ++g) {
            assert_int_not_equal(side[g], 3);
            n_validation_groups += side[g] == 2;
            if (own_split && side[g])
                assert_int_equal(side[g] == 2, d->group_split[g] == NQM_SPLIT_VALIDATION);
        }
        assert_int_equal(n_validation_groups, own_split ? 6 : 5); /* round(0.2 * 24) */
        nqm_rows_free(&rows);
        nqm_dataset_free(d);
    }
}

TEST(pair_splits) {
    toy_options toy = toy_options_default();
    nqm_dataset *d = toy_dataset(&toy);
    nqm_train_options o = recipe("paper");
    nqm_rows a, b;
    assert_int_equal(nqm_rows_create(d, &o, &a, NULL), NQM_OK);
    size_t n = a.n_train + a.n_validation;
    assert_int_equal(n, d->n_pairs * 3 / 4 + a.n_noisy);
    assert_int_equal(a.n_validation, (size_t)round(0.2 * (double)n));
    o.optimiser.seed = 2;
    assert_int_equal(nqm_rows_create(d, &o, &b, NULL), NQM_OK);
    assert_int_equal(b.n_train, a.n_train);
    assert_memory_not_equal(a.row, b.row, n * sizeof *a.row);
    nqm_rows_free(&a);
    nqm_rows_free(&b);
    nqm_dataset_free(d);
}

TEST(too_little_to_split) {
    toy_options toy = toy_options_default();
    toy.n_groups = 1;
    toy.splits = false;
    nqm_dataset *d = toy_dataset(&toy);
    nqm_train_options o = recipe("nqm");
    nqm_rows rows;
    nqm_error err = {0};
    assert_int_equal(nqm_rows_create(d, &o, &rows, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "too few"));
    nqm_dataset_free(d);
}

/* Inputs of the unscaled training examples are whitened: mean 0, deviation 1 over the reference half; targets too. */
TEST(whitening) {
    toy_options toy = toy_options_default();
    nqm_dataset *d = toy_dataset(&toy);
    nqm_train_options o = recipe("paper");
    for (int scalar = 0; scalar < 2; ++scalar) {
        o.input.whitening = scalar ? NQM_WHITEN_SCALAR : NQM_WHITEN_CHANNEL;
        o.augmentation.scale_copy = NQM_SCALE_NONE;
        nqm_examples e;
        assert_int_equal(nqm_examples_create(d, &o, 7, &e, NULL), NQM_OK);
        assert_int_equal(e.n_train, e.rows.n_train);
        double sum[3] = {0}, squares[3] = {0}, target_sum = 0, lo = INFINITY, hi = -INFINITY;
        float *x = calloc(e.width, sizeof *x), target;
        for (size_t i = 0; i < e.n_train; ++i) {
            gather(&e, 1, &i, x, &target);
            for (size_t k = 0; k < 48; ++k) {
                sum[k % 3] += (double)x[k];
                squares[k % 3] += (double)x[k] * (double)x[k];
            }
            target_sum += (double)target;
            lo = fmin(lo, (double)target);
            hi = fmax(hi, (double)target);
        }
        double n = (double)e.n_train * 16;
        if (scalar) {
            assert_near((sum[0] + sum[1] + sum[2]) / (3 * n), 0, 1e-5);
            assert_near((squares[0] + squares[1] + squares[2]) / (3 * n), 1, 1e-3);
            assert_true(e.features.mean[0] == e.features.mean[2] && e.features.std[0] == e.features.std[1]);
        }
        for (size_t k = 0; k < 3 && !scalar; ++k) {
            assert_near(sum[k] / n, 0, 1e-5);
            assert_near(squares[k] / n, 1, 1e-3);
        }
        assert_near(target_sum / (double)e.n_train, 0, 1e-5);
        assert_near(lo, e.output[0].lo, 1e-6);
        assert_near(hi, e.output[0].hi, 1e-6);
        free(x);
        nqm_examples_free(&e);
    }
    nqm_dataset_free(d);
}

/* Invert an input to reflectance: the scaled copy is the reflectance times one factor, the same for both members. */
static double reflectance(const nqm_examples *e, float x, size_t channel) {
    double t = (double)x * (double)e->features.std[channel] + (double)e->features.mean[channel];
    return pow(expm1(t), 3);
}

TEST(scaled_by_pair) {
    toy_options toy = toy_options_default();
    nqm_dataset *d = toy_dataset(&toy);
    nqm_train_options o = recipe("paper");
    nqm_examples e;
    assert_int_equal(nqm_examples_create(d, &o, 2, &e, NULL), NQM_OK);
    assert_int_equal(e.n_train, 2 * e.rows.n_train);
    float x[2 * 96], target[2];
    double lowest = 2, highest = 0;
    for (size_t i = 0; i < e.rows.n_train; ++i) {
        const size_t index[2] = {i, i + e.rows.n_train};
        gather(&e, 2, index, x, target);
        assert_true(target[0] == target[1]);
        double first = reflectance(&e, x[96], 0) / reflectance(&e, x[0], 0);
        for (size_t k = 0; k < 96; ++k) {
            double base = reflectance(&e, x[k], k % 3);
            if (base > 1e-3)
                assert_relative(reflectance(&e, x[96 + k], k % 3) / base, first, 1e-4);
        }
        lowest = fmin(lowest, first);
        highest = fmax(highest, first);
    }
    assert_true(lowest > 0.9499 && lowest < 0.955 && highest < 1.0501 && highest > 1.045);
    nqm_examples_free(&e);
    nqm_dataset_free(d);
}

TEST(scaled_by_element) {
    toy_options toy = toy_options_default();
    nqm_dataset *d = toy_dataset(&toy);
    nqm_train_options o = recipe("notebook");
    nqm_examples e;
    assert_int_equal(nqm_examples_create(d, &o, 2, &e, NULL), NQM_OK);
    float x[2 * 96], target[2];
    const size_t index[2] = {3, 3 + e.rows.n_train};
    gather(&e, 2, index, x, target);
    double std = (double)e.features.std[0], mean = (double)e.features.mean[0];
    double previous = 0;
    for (size_t k = 0; k < 48; ++k) {
        double ref = ((double)x[96 + k] * std + mean) / ((double)x[k] * std + mean);
        double test = ((double)x[144 + k] * std + mean) / ((double)x[48 + k] * std + mean);
        assert_near(ref, test, 1e-4);
        assert_true(ref > 0.9499 && ref < 1.0501 && ref != previous);
        previous = ref;
    }
    nqm_examples_free(&e);
    nqm_dataset_free(d);
}

/* A dropped direction is replaced by the mean in both members; log Delta-E targets have a lower limit. */
TEST(masks_and_log_targets) {
    toy_options toy = toy_options_default();
    toy.with_masks = true;
    nqm_dataset *d = toy_dataset(&toy);
    double *delta_e = malloc(d->n_pairs * sizeof *delta_e);
    memcpy(delta_e, d->delta_e, d->n_pairs * sizeof *delta_e);
    nqm_train_options o = recipe("nqm");
    nqm_examples e;
    nqm_dataset with_identity = *d;
    with_identity.delta_e = delta_e;
    for (size_t i = 0; i < d->n_pairs; i += 12)
        delta_e[i] = 0;
    assert_int_equal(nqm_examples_create(&with_identity, &o, 1, &e, NULL), NQM_OK);
    assert_int_equal(e.width, 9 * 16 + NQM_SCALAR_COUNT);
    assert_near(e.output[0].mean + e.output[0].std * e.output[0].lo, log(0.05), 1e-9);
    for (size_t i = 0; i < e.rows.n_train; ++i) {
        float x[9 * 16 + NQM_SCALAR_COUNT], target;
        uint8_t used[16];
        gather(&e, 1, &i, x, &target);
        uint32_t pair = e.rows.row[i].pair;
        assert_near(e.output[0].mean + e.output[0].std * (double)target, log(fmax(delta_e[pair], 0.05)), 1e-5);
        assert_non_null(nqm_dataset_samples(d, pair, used).used);
        for (size_t k = 0; k < 48; ++k)
            if (!used[k / 3])
                assert_true(x[k] == 0 && x[48 + k] == 0 && x[96 + k] == 0);
    }
    free(delta_e);
    nqm_examples_free(&e);
    nqm_dataset_free(d);
}

/* The scalar features of examples are computed from the samples, those of a scaled copy from the scaled samples;
 * both are whitened with the statistics of the training examples. */
TEST(scalars_of_examples) {
    toy_options t = toy_options_default();
    t.with_masks = true;
    nqm_dataset *d = toy_dataset(&t);
    nqm_train_options o = recipe("nqm");
    o.augmentation.swap = 0;
    nqm_examples e;
    assert_int_equal(nqm_examples_create(d, &o, 16, &e, NULL), NQM_OK);
    size_t n = 3 * d->n_directions, n_columns = NQM_SCALAR_COUNT;
    assert_int_equal(e.width, 3 * n + n_columns);
    double sum = 0, squares = 0;
    for (size_t i = 0; i < e.n_train; ++i) {
        double x = (double)e.scalars[i * n_columns + NQM_SCALAR_RMS];
        sum += x;
        squares += x * x;
    }
    assert_near(sum / (double)e.n_train, 0, 1e-4);
    assert_near(squares / (double)e.n_train, o.input.scalar_scale * o.input.scalar_scale, 1e-2);
    float *x = nqm_alloc(3, e.width * sizeof *x), target[3];
    const size_t index[2] = {5, 5 + e.rows.n_train};
    gather(&e, 2, index, x, target);
    gather_from(&e, 1, NULL, 7, x + 2 * e.width, target + 2);
    const size_t rows[3] = {5, 5, e.rows.n_train + 7};
    for (size_t r = 0; r < 3; ++r) {
        uint8_t used[16];
        size_t pair = e.rows.row[rows[r]].pair;
        double scalars[NQM_SCALAR_COUNT];
        float expected[NQM_SCALAR_COUNT];
        const nqm_sample_pair samples = nqm_dataset_samples(d, pair, used);
        compute_scalars(d->directions, NULL, samples.ref, samples.test, samples.used, scalars);
        nqm_scalars_whiten(&e.scalar_whitening, scalars, expected);
        for (size_t k = 0; k < n_columns; ++k) {
            double got = (double)x[r * e.width + 3 * n + k];
            if (r != 1)
                assert_near(got, (double)expected[k], 1e-3);
        }
        /* the copy is scaled by up to 5 %; its ratios are equal except for the floor */
        if (r == 1) {
            double level = (double)x[r * e.width + 3 * n + NQM_SCALAR_REF_LEVEL];
            double step = (level - (double)expected[NQM_SCALAR_REF_LEVEL]) / o.input.scalar_scale *
                          (double)e.scalar_whitening.std[NQM_SCALAR_REF_LEVEL];
            assert_true(fabs(step) > 1e-4 && fabs(step) < 0.052);
        }
    }
    nqm_free(x);
    nqm_examples_free(&e);
    nqm_dataset_free(d);
}

/* The second copy of an example exchanges reference and test: shifts and contrast change their sign, the rest stays. */
TEST(exchanged_copies) {
    toy_options t = toy_options_default();
    nqm_dataset *d = toy_dataset(&t);
    nqm_train_options o = recipe("nqm");
    o.augmentation.scale_copy = NQM_SCALE_NONE;
    o.input.layout = NQM_LAYOUT_REF_TEST;
    o.input.scalars = 0;
    d->parts = nqm_alloc(d->n_pairs, NQM_LABEL_PARTS * sizeof *d->parts);
    for (size_t i = 0; i < d->n_pairs * NQM_LABEL_PARTS; ++i)
        d->parts[i] = 0.5 + (double)(i * 7 % 13);
    nqm_examples e;
    assert_int_equal(nqm_examples_create(d, &o, 16, &e, NULL), NQM_OK);
    assert_int_equal(e.n_train, 2 * e.rows.n_train);
    const size_t index[2] = {3, 3 + e.rows.n_train}, n = 3 * d->n_directions;
    float *x = nqm_alloc(2, e.width * sizeof *x), target[2 * (1 + NQM_LABEL_PARTS)];
    gather(&e, 2, index, x, target);
    assert_memory_equal(x, x + e.width + n, n * sizeof *x);
    assert_memory_equal(x + n, x + e.width, n * sizeof *x);
    for (size_t k = 0; k <= NQM_LABEL_PARTS; ++k) {
        const nqm_output_range *o_k = &e.output[k];
        const double plain = o_k->mean + o_k->std * (double)target[k],
                     exchanged = o_k->mean + o_k->std * (double)target[1 + NQM_LABEL_PARTS + k];
        const bool is_signed = k >= 1 && k <= 4;
        assert_near(exchanged, is_signed ? -plain : plain, 1e-5);
    }
    nqm_free(x);
    nqm_free(d->parts);
    d->parts = NULL;
    nqm_examples_free(&e);
    nqm_dataset_free(d);
}

TEST(recipes_are_as_published) {
    nqm_train_options paper = recipe("paper"), notebook = recipe("notebook"), nqm;
    assert_int_equal(paper.optimiser.batch, 512);
    assert_int_equal(paper.optimiser.epochs, 100);
    assert_near(paper.optimiser.lr_first, 1e-4, 0);
    assert_near(paper.optimiser.lr_deeper, 1e-3, 0);
    assert_true(paper.split.by_pair && paper.augmentation.balance && !paper.network.freeze_first_layernorm);
    assert_true(!notebook.split.by_pair && notebook.network.freeze_first_layernorm);
    assert_int_equal(notebook.input.whitening, NQM_WHITEN_SCALAR);
    assert_int_equal(notebook.augmentation.scale_copy, NQM_SCALE_ELEMENT_TRANSFORMED);
    nqm_net_shape shape = {.n_layers = 4,
                           .sizes = {nqm_features_width(paper.input.layout, 500), paper.network.hidden[0],
                                     paper.network.hidden[1], paper.network.hidden[2], 1}};
    assert_int_equal(nqm_params_count(&shape), 4171125);
    nqm = recipe("nqm");
    shape.sizes[0] = nqm_features_width(nqm.input.layout, 500);
    assert_int_equal(nqm_params_count(&shape), 4171125 + 1500 * 1024);
    assert_true(nqm.input.scalars && !paper.input.scalars && !notebook.input.scalars);
    nqm_error err = {0};
    assert_int_equal(nqm_train_options_recipe("best", &nqm, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "notebook"));
}

TEST(options_out_of_range) {
    nqm_error err = {0};
    nqm_train_options o = recipe("nqm");
    assert_int_equal(nqm_train_options_check(&o, NULL), NQM_OK);
    o.network.dropout = 1;
    assert_int_equal(nqm_train_options_check(&o, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "dropout"));
    o = recipe("nqm");
    o.optimiser.batch = 0;
    assert_int_equal(nqm_train_options_check(&o, NULL), NQM_ERR_ARG);
    o = recipe("nqm");
    o.optimiser.lr_deeper = NAN;
    assert_int_equal(nqm_train_options_check(&o, NULL), NQM_ERR_ARG);
    o = recipe("nqm");
    o.network.hidden[1] = 0;
    assert_int_equal(nqm_train_options_check(&o, NULL), NQM_ERR_ARG);
    o = recipe("nqm");
    o.input.scalar_scale = 0;
    assert_int_equal(nqm_train_options_check(&o, NULL), NQM_ERR_ARG);
    o = recipe("nqm");
    o.run.resume = 1;
    assert_int_equal(nqm_train_options_check(&o, NULL), NQM_ERR_ARG);
}

static int use_one_thread(void **state) {
    (void)state;
    omp_set_num_threads(1); /* the tasks are too small to use more threads */
    return 0;
}

TEST_FILE(use_one_thread, NULL)
