/* SPDX-License-Identifier: MIT
 *
 * The layout of the authors' dataset: a tiny one written by SciPy (tests/vectors/authors.py) is read correctly, and
 * messages name what is missing or inconsistent.
 */
#include "io/io.h"
#include "support/check.h"
#include "support/toy_dataset.h"

static const char csv_path[] = "test_train_authors.csv";

static char root[512];

static int find_root(void **state) {
    (void)state;
    snprintf(root, sizeof root, "%s", test_vector("authors"));
    return 0;
}

static void write_labels(const char *labels) {
    FILE *f = fopen(csv_path, "w");
    assert_non_null(f);
    fputs(labels, f);
    fclose(f);
}

static nqm_dataset *load(const char *labels, nqm_split split) {
    nqm_dataset *d;
    nqm_error err = {0};
    if (nqm_dataset_load(root, labels, split, &d, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return d;
}

TEST(reads_the_layout) {
    nqm_dataset *d = load(test_vector("authors/labels.csv"), NQM_SPLIT_ALL);
    nqm_dataset_info info = nqm_dataset_get_info(d);
    assert_int_equal(info.n_directions, 7);
    assert_int_equal(info.n_pairs, 5);
    assert_int_equal(info.n_groups, 2);
    assert_int_equal(info.n_refs, 3); /* brass_1 and brass_2 are equal, brass_10 is noisy; felt occurs once */
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_TRAIN], 5);
    assert_non_null(strstr(info.manifest, "\"negative_values_read_as_0\": 1"));
    assert_int_equal(strlen(info.sha256), 64);
    const struct {
        const char *ref, *group, *test, *kind;
        double delta_e, jod;
    } expected[] = {{"brass_1", "brass", "brass_1", "ward", 22.5, 6.5},
                    {"brass_1", "brass", "brass_2", "sbrdf.2", 9.25, 8.75},
                    {"brass_10", "brass", "brass_10", "sbrdf.2", 9.25, 8.75},
                    {"felt_m_68_rgb_1", "felt_m_68_rgb", "felt_m_68_rgb_1", "ggx", 3.5, 9.875},
                    {"felt_m_68_rgb_1", "felt_m_68_rgb", "felt_m_68_rgb_2", "ggx", 4.5, 10.25}};
    for (size_t i = 0; i < 5; ++i) {
        nqm_dataset_pair pair = nqm_dataset_get_pair(d, i);
        assert_string_equal(pair.ref, expected[i].ref);
        assert_string_equal(pair.group, expected[i].group);
        assert_string_equal(pair.test, expected[i].test);
        assert_string_equal(pair.kind, expected[i].kind);
        assert_string_equal(pair.family, "encoding");
        assert_near(pair.delta_e, expected[i].delta_e, 0);
        assert_near(pair.jod, expected[i].jod, 0);
    }
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("authors_expected.csv"), &csv, NULL), NQM_OK);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        size_t pair = (size_t)atoi(nqm_csv_text(csv, row, 0)), direction = (size_t)atoi(nqm_csv_text(csv, row, 2));
        bool is_ref = strcmp(nqm_csv_text(csv, row, 1), "ref") == 0;
        const float *rgb = (is_ref ? d->ref_rgb + d->pair_ref[pair] * 21 : d->test_rgb + pair * 21) + 3 * direction;
        for (int k = 0; k < 3; ++k) {
            double value;
            assert_int_equal(nqm_csv_number(csv, row, 3 + k, &value, NULL), NQM_OK);
            assert_near((double)rgb[k], value, 0);
        }
    }
    nqm_csv_free(csv);
    nqm_dataset_free(d);
}

/* Levels of sbrdf and hbrdf are part of the kind, also level 0. */
TEST(kinds_keep_their_levels) {
    write_labels("material,model,level,DeltaE,JOD\n"
                 "brass_1,sbrdf,0,7,9\nbrass_2,sbrdf,1,8,8\nbrass_10,hbrdf,0,8,8\n"
                 "felt_m_68_rgb_1,hbrdf,2,9,7\nfelt_m_68_rgb_2,nbrdf,0,9,7\n");
    nqm_dataset *d = load(csv_path, NQM_SPLIT_ALL);
    static const char *const kinds[] = {"sbrdf.0", "sbrdf.1", "hbrdf.0", "hbrdf.2", "nbrdf"};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        assert_string_equal(nqm_dataset_get_pair(d, i).kind, kinds[i]);
    nqm_dataset_free(d);
    unlink(csv_path);
}

TEST(split_as_asked) {
    nqm_dataset *d = load(test_vector("authors/labels.csv"), NQM_SPLIT_TEST);
    assert_int_equal(nqm_dataset_get_info(d).n_pairs_in[NQM_SPLIT_TEST], 5);
    nqm_dataset_free(d);
}

/* The imported dataset can be used for training. */
TEST(goes_on_from_there) {
    nqm_dataset *d = load(test_vector("authors/labels.csv"), NQM_SPLIT_ALL);
    nqm_train_options o;
    nqm_train_report report;
    nqm_model *model;
    assert_int_equal(nqm_train_options_recipe("notebook", &o, NULL), NQM_OK);
    o.network.n_hidden = 1;
    o.network.hidden[0] = 8;
    o.optimiser.epochs = 2;
    assert_int_equal(nqm_train(d, &o, &model, &report, NULL), NQM_OK);
    assert_int_equal(nqm_model_get_info(model).n_parameters, 42 * 8 + 8 + 8 + 8 + 8 + 1);
    nqm_model_free(model);
    nqm_dataset_free(d);
}

static void refuse(const char *labels, nqm_status status, const char *words) {
    write_labels(labels);
    nqm_dataset *d;
    nqm_error err = {0};
    assert_int_equal(nqm_dataset_load(root, csv_path, NQM_SPLIT_ALL, &d, &err), status);
    assert_null(d);
    if (!strstr(err.message, words))
        fail_msg("'%s' is not in '%s'", words, err.message);
}

TEST(names_what_is_wrong) {
    refuse("material,model,level,DeltaE,JOD,class\nglass_3,ward,0,1,9,6\n", NQM_ERR_IO, "neither glass_3.mat nor");
    refuse("material,model,level,DeltaE,JOD,class\nbrass_3,ward,0,1,9,6\n", NQM_ERR_IO, "row 'brass_3'");
    refuse("material,model,level,DeltaE,JOD,class\n../ref/brass_1,ward,0,1,9,6\n", NQM_ERR_FORMAT, "'/'");
    refuse("material,model,level,DeltaE\nbrass_1,ward,0,1\n", NQM_ERR_FORMAT, "'JOD'");
    refuse("material,model,level,DeltaE,JOD\nbrass_1,ward,0,many,9\n", NQM_ERR_FORMAT, csv_path);
    refuse("material,model,level,DeltaE,JOD\nbrass_1,ward,0,1,12\n", NQM_ERR_FORMAT, "JOD of pair 0");
    refuse("material,model,level,DeltaE,JOD\n", NQM_ERR_FORMAT, "no rows");
    nqm_dataset *d;
    assert_int_equal(nqm_dataset_load(root, "no such file", NQM_SPLIT_ALL, &d, NULL), NQM_ERR_IO);
    unlink(csv_path);
}

/* A copy of the dataset whose first file of a test has another first direction. */
TEST(refuses_other_directions) {
    enum { SIZE = 1 << 16 };
    static unsigned char bytes[SIZE];
    char command[1200];
    nqm_dataset *d = load(test_vector("authors/labels.csv"), NQM_SPLIT_ALL);
    const double theta_h = nqm_directions_get_info(d->directions).degrees[0];
    nqm_dataset_free(d);
    snprintf(command, sizeof command, "rm -rf other_authors; cp -R '%s' other_authors && chmod -R u+w other_authors",
             root);
    assert_int_equal(system(command), 0);
    FILE *f = fopen("other_authors/model/brass_1.mat", "r+b");
    assert_non_null(f);
    const size_t n = fread(bytes, 1, SIZE, f);
    size_t at = 0;
    while (at + 8 <= n && nqm_load_f64(bytes + at) != theta_h)
        at += 4;
    assert_true(at + 8 <= n);
    unsigned char other[8];
    nqm_store_f64(other, theta_h + 1e-6);
    assert_int_equal(fseek(f, (long)at, SEEK_SET), 0);
    assert_int_equal(fwrite(other, 1, 8, f), 8);
    fclose(f);
    nqm_error err = {0};
    assert_int_equal(nqm_dataset_load("other_authors", "other_authors/labels.csv", NQM_SPLIT_ALL, &d, &err),
                     NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "brass_1.mat: random_locations differ from those of the first file (row 1:"));
    assert_int_equal(system("rm -rf other_authors"), 0);
}

TEST_FILE(find_root, NULL)
