/* SPDX-License-Identifier: MIT
 *
 * score_files.c - how good do the TESTs look next to REF? Each argument is a file, a spec or a preset.
 *
 *   cc score_files.c $(pkg-config --cflags --libs nqm) -o score_files
 *   ./score_files sgd:nickel ward:nickel abc:nickel
 */
#include <nqm/metric.h>
#include <stdio.h>

enum { MAX_TESTS = 64 };

int main(int argc, char **argv) {
    size_t n = argc > 2 ? (size_t)argc - 2 : 0;
    if (n == 0 || n > MAX_TESTS) {
        fprintf(stderr, "usage: score_files REF TEST... (at most %d tests)\n", MAX_TESTS);
        return 2;
    }
    nqm_error err = {0};
    nqm_model *model = NULL;
    nqm_brdf *ref = NULL, *tests[MAX_TESTS] = {NULL};
    nqm_score_result results[MAX_TESTS];

    /* Every function that can fail returns a status, NQM_OK = 0, and explains a failure in err. */
    nqm_status status = nqm_model_load("default", &model, &err);
    if (status == NQM_OK)
        status = nqm_brdf_open(argv[1], &ref, &err);
    for (size_t i = 0; i < n && status == NQM_OK; ++i)
        status = nqm_brdf_open(argv[2 + i], &tests[i], &err);
    if (status == NQM_OK)
        status = nqm_score(model, ref, n, (const nqm_brdf *const *)tests, NULL, results, &err);

    if (status != NQM_OK)
        fprintf(stderr, "score_files: %s\n", err.message);
    for (size_t i = 0; i < n && status == NQM_OK; ++i) {
        const nqm_score_result *r = &results[i];
        if (r->status != NQM_OK) /* this test alone failed, for example because too few directions hold a value */
            printf("%s: %s\n", argv[2 + i], nqm_status_text(r->status));
        else
            printf("%s: %.2f JOD [%.2f, %.2f]\n", argv[2 + i], r->jod, r->jod_low, r->jod_high);
    }
    for (size_t i = 0; i < n; ++i)
        nqm_brdf_free(tests[i]);
    nqm_brdf_free(ref);
    nqm_model_free(model);
    return status == NQM_OK ? 0 : 1;
}
