/* SPDX-License-Identifier: MIT
 *
 * Lists of pairs: references by group, rows by reference, defaults, contradictions; checksums of files; selection by label.
 */
#include "corpus/corpus.h"
#include "support/check.h"
#include "support/scratch.h"

/* ---- lists ------------------------------------------------------------------------------------------------------- */

static const nqm_corpus_pair pairs[] = {
    {.reference = "sgd:brass", .test = "t1", .name = "b", .group = "brass", .kind = "gloss", .family = "perturbation"},
    {.reference = "x.bsdf", .test = "t2"},
    {.reference = "sgd:brass", .test = "t3", .name = "b", .group = "brass", .kind = "ggx"},
    {.reference = "ward:brass", .test = "t4", .name = "w", .group = "brass", .kind = "gloss", .other = "x.bsdf"},
    {.reference = "sgd:gold", .test = "t5", .split = NQM_SPLIT_TEST, .kind = "hue", .source = "sgd"},
    {.reference = "sgd:gold", .test = "t6", .split = NQM_SPLIT_TEST, .kind = "gloss", .source = "sgd"},
};
enum { N_PAIRS = sizeof pairs / sizeof *pairs };

static nqm_status make_list(size_t n, const nqm_corpus_pair *all, nqm_corpus_part part, nqm_corpus_list *list,
                            nqm_error *err) {
    nqm_corpus_options options = nqm_corpus_options_default();
    options.part = part;
    return nqm_corpus_list_make(n, all, &options, list, err);
}

TEST(rows_go_by_reference_and_group) {
    static const char *const tests[] = {"t1", "t3", "t4", "t2"}, *const names[] = {"b", "w", "x.bsdf"};
    nqm_corpus_list list;
    assert_int_equal(make_list(N_PAIRS, pairs, NQM_CORPUS_TRAINING, &list, NULL), NQM_OK);
    assert_int_equal(list.n_refs, 3);
    assert_int_equal(list.n_rows, 4);
    for (size_t i = 0; i < 3; ++i)
        assert_string_equal(list.refs[i].name, names[i]);
    for (size_t i = 0; i < 4; ++i)
        assert_string_equal(list.rows[i].test, tests[i]);
    assert_string_equal(list.groups[list.refs[0].group].name, "brass");
    assert_int_equal(list.refs[0].group, list.refs[1].group);
    assert_int_equal(list.refs[0].n_rows, 2);
    assert_string_equal(list.refs[2].source, "list");
    assert_string_equal(list.groups[list.refs[2].group].name, "x.bsdf");
    assert_string_equal(list.rows[0].family, "perturbation");
    assert_string_equal(list.rows[1].family, "ggx");
    assert_string_equal(list.rows[2].other, "x.bsdf");
    assert_string_equal(list.rows[3].kind, "pair");
    assert_int_equal(list.n_unseen, 1);
    assert_string_equal(list.unseen[0], "hue");
    assert_ptr_equal(nqm_corpus_ref_of(&list, "ward:brass"), &list.refs[1]);
    assert_null(nqm_corpus_ref_of(&list, "sgd:gold"));
    nqm_corpus_list_free(&list);

    assert_int_equal(make_list(N_PAIRS, pairs, NQM_CORPUS_TEST, &list, NULL), NQM_OK);
    assert_int_equal(list.n_refs, 1);
    assert_int_equal(list.n_rows, 2);
    nqm_corpus_list_free(&list);
}

TEST(contradictions_are_refused) {
    const struct {
        nqm_corpus_pair pair;
        nqm_status status;
        const char *message;
    } bad[] = {
        {{.reference = "", .test = "t"}, NQM_ERR_ARG, "pair 7"},
        {{.reference = "r"}, NQM_ERR_ARG, "no test"},
        {{.reference = "r", .test = "t", .split = (nqm_split)3}, NQM_ERR_ARG, "split"},
        {{.reference = "r", .test = "t", .name = "b"}, NQM_ERR_ARG, "'b'"},
        {{.reference = "sgd:brass", .test = "t", .name = "b", .group = "other"}, NQM_ERR_ARG, "'b'"},
        {{.reference = "sgd:brass", .test = "t", .name = "b", .group = "brass", .source = "s"}, NQM_ERR_ARG, "'b'"},
        {{.reference = "r", .test = "t", .group = "brass", .split = NQM_SPLIT_VALIDATION}, NQM_ERR_ARG, "one split"},
        {{.reference = "r", .test = "t", .other = "nobody"}, NQM_ERR_ARG, "'nobody'"},
        {{.reference = "r", .test = "t", .other = "sgd:gold"}, NQM_ERR_ARG, "'sgd:gold' is in 'test'"},
    };
    nqm_corpus_pair all[N_PAIRS + 1];
    memcpy(all, pairs, sizeof pairs);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_error err = {0};
        nqm_corpus_list list;
        all[N_PAIRS] = bad[i].pair;
        assert_int_equal(make_list(N_PAIRS + 1, all, NQM_CORPUS_TRAINING, &list, &err), bad[i].status);
        if (!strstr(err.message, bad[i].message))
            fail_msg("%zu: %s", i, err.message);
        assert_null(list.refs);
    }
    nqm_corpus_list list;
    nqm_error err = {0};
    assert_int_equal(make_list(4, pairs, NQM_CORPUS_TEST, &list, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "(test)"));
}

/* ---- checksums --------------------------------------------------------------------------------------------------- */

TEST(files_are_hashed_below_the_root) {
    /* sha256sum of the seven bytes "content" */
    static const char sha[] = "ed7002b439e9ac845f22357d822bac1444730fbdb6016d3ec9432297b9ec9f73";
    char hex[65];
    scratch_text("one.bsdf", "content");
    char root[256];
    snprintf(root, sizeof root, "%s", scratch_path(""));
    root[strlen(root) - 1] = 0;
    nqm_corpus_list list = {.root = root};
    assert_int_equal(nqm_corpus_hash_content(&list, "one.bsdf", hex, NULL), NQM_OK);
    assert_string_equal(hex, sha);
    assert_int_equal(nqm_corpus_hash_content(&list, "one.bsdf:inside", hex, NULL), NQM_OK);
    assert_string_equal(hex, sha);
    assert_int_equal(nqm_corpus_hash_content(&list, "sgd:brass", hex, NULL), NQM_OK);
    assert_string_equal(hex, "");
    assert_int_equal(nqm_corpus_hash_content(&list, "two.bsdf", hex, NULL), NQM_ERR_IO);
}

TEST(a_decoder_is_hashed_with_its_latents) {
    enum { N_BYTES = 808003 * 4 };
    char decoder[256], hex[2][65];
    snprintf(decoder, sizeof decoder, "%s:m", scratch_path("decoder.bin"));
    FILE *f = fopen(scratch_path("decoder.bin"), "wb");
    assert_non_null(f);
    assert_int_equal(fseek(f, N_BYTES - 1, SEEK_SET), 0);
    fputc(0, f);
    fclose(f);
    const nqm_corpus_list list = {.root = NULL};
    for (int k = 0; k < 2; ++k) {
        scratch_text("nps_latents.csv", k ? "material,mean0\nm,1\n" : "material,mean0\nm,0\n");
        assert_int_equal(nqm_corpus_hash_content(&list, decoder, hex[k], NULL), NQM_OK);
    }
    assert_string_not_equal(hex[0], hex[1]);
    remove(scratch_path("nps_latents.csv"));
    assert_int_equal(nqm_corpus_hash_content(&list, decoder, hex[0], NULL), NQM_ERR_IO);
}

/* ---- selection --------------------------------------------------------------------------------------------------- */

TEST(selections_are_spread) {
    enum { N_JOD = 60, N_KEPT = 20 };
    double jod[N_JOD];
    uint8_t kept[N_JOD], again[N_JOD];
    nqm_rng rng = nqm_rng_make(1, 0);
    for (size_t i = 0; i < N_JOD; ++i) /* most are near 0 */
        jod[i] = 10 * pow(nqm_rng_uniform(&rng), 3);
    jod[7] = NAN;
    assert_int_equal(nqm_corpus_spread(N_JOD, jod, N_KEPT, kept, NULL), NQM_OK);
    assert_int_equal(nqm_corpus_spread(N_JOD, jod, N_KEPT, again, NULL), NQM_OK);
    assert_memory_equal(kept, again, sizeof kept);
    assert_int_equal(kept[7], 0);
    size_t n = 0, n_low = 0, n_low_kept = 0, n_high = 0, n_high_kept = 0;
    for (size_t i = 0; i < N_JOD; ++i) {
        n += kept[i];
        n_low += jod[i] < 1;
        n_low_kept += jod[i] < 1 && kept[i];
        n_high += jod[i] > 3;
        n_high_kept += jod[i] > 3 && kept[i];
    }
    assert_int_equal(n, N_KEPT);
    assert_true(n_low > 20 && n_low_kept < 6);
    assert_true(n_high_kept >= nqm_smaller(n_high, 10));
}

TEST(small_selections) {
    const double jod[] = {1, 1, 1, NAN, 9};
    uint8_t kept[5];
    assert_int_equal(nqm_corpus_spread(5, jod, 10, kept, NULL), NQM_OK);
    assert_memory_equal(kept, ((const uint8_t[]){1, 1, 1, 0, 1}), 5);
    assert_int_equal(nqm_corpus_spread(5, jod, 2, kept, NULL), NQM_OK);
    assert_int_equal(kept[0] + kept[1] + kept[2], 1);
    assert_int_equal(kept[4], 1);
    assert_int_equal(nqm_corpus_spread(5, jod, 0, kept, NULL), NQM_OK);
    assert_memory_equal(kept, ((const uint8_t[]){0, 0, 0, 0, 0}), 5);
    assert_int_equal(nqm_corpus_spread(0, NULL, 3, NULL, NULL), NQM_OK);
}

TEST(the_option_names_a_family) {
    static const char *const bad[] = {"far", "=3", "far=", "far=0", "far=2.5", "far=x", "far=1e7"};
    size_t n_name, n_kept;
    assert_int_equal(nqm_corpus_parse_keep("far=20", &n_name, &n_kept, NULL), NQM_OK);
    assert_int_equal(n_name, 3);
    assert_int_equal(n_kept, 20);
    assert_int_equal(nqm_corpus_parse_keep(NULL, &n_name, &n_kept, NULL), NQM_OK);
    assert_int_equal(n_name, 0);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i)
        assert_int_equal(nqm_corpus_parse_keep(bad[i], &n_name, &n_kept, NULL), NQM_ERR_ARG);
}
