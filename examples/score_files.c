/* SPDX-License-Identifier: MIT
 *
 * score.c - the smallest program with libnqm: how good does TEST look beside REF?
 *
 *   cc score.c $(pkg-config --cflags --libs nqm) -o score && ./score sgd:nickel ward:nickel
 */
#include <nqm/metric.h>
#include <stdio.h>

static int failed(const char *reason) {
    fprintf(stderr, "score: %s\n", reason);
    return 1;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: score REF TEST\n");
        return 2;
    }
    nqm_error err = {0};
    nqm_model *model = NULL;
    nqm_brdf *ref = NULL, *test = NULL;
    nqm_score_result result;
    int exit_code = 0;

    if (nqm_model_builtin("default", &model, &err) || nqm_brdf_open(argv[1], &ref, &err) ||
        nqm_brdf_open(argv[2], &test, &err) ||
        nqm_score(model, ref, 1, (const nqm_brdf *const *)&test, NULL, &result, &err))
        exit_code = failed(err.message);
    else if (result.status) /* the fault of this test alone, such as too few directions with a value */
        exit_code = failed(nqm_status_text(result.status));
    else
        printf("%.2f JOD%s\n", result.jod, result.identical ? " (identical)" : "");

    nqm_brdf_free(test);
    nqm_brdf_free(ref);
    nqm_model_free(model);
    return exit_code;
}
