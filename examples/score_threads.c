/* SPDX-License-Identifier: MIT
 *
 * score_threads.c - score from several threads. Models and BRDFs never change, so threads share them; a scorer is a workspace,
 * so every thread has its own.
 *
 *   cc score_threads.c $(pkg-config --cflags --libs nqm) -pthread -o score_threads && ./score_threads
 */
#include <nqm/metric.h>
#include <pthread.h>
#include <stdio.h>

enum { N_THREADS = 4 };

typedef struct job {
    const nqm_model *model;
    const nqm_brdf *ref;
    const char *test;
    nqm_score_result result;
    nqm_status status;
    nqm_error err;
} job;

static void *score(void *argument) {
    job *j = argument;
    nqm_brdf *test = NULL;
    nqm_scorer *scorer = NULL;
    j->status = nqm_brdf_open(j->test, &test, &j->err);
    if (j->status == NQM_OK)
        j->status = nqm_scorer_create(j->model, NULL, &scorer, &j->err);
    if (j->status == NQM_OK)
        j->status = nqm_scorer_run(scorer, j->ref, 1, (const nqm_brdf *const *)&test, &j->result, &j->err);
    if (j->status == NQM_OK)
        j->status = j->result.status;
    nqm_scorer_free(scorer);
    nqm_brdf_free(test);
    return NULL;
}

int main(void) {
    static const char *const tests[N_THREADS] = {"ward:nickel", "abc:nickel", "cook-torrance:nickel", "sgd:nickel"};
    nqm_error err = {0};
    nqm_model *model = NULL;
    nqm_brdf *ref = NULL;
    job jobs[N_THREADS] = {{0}};
    pthread_t threads[N_THREADS];
    int failed = 0;

    if (nqm_model_load("default", &model, &err) || nqm_brdf_open("sgd:nickel", &ref, &err)) {
        fprintf(stderr, "score_threads: %s\n", err.message);
        nqm_model_free(model);
        return 1;
    }
    int n_started = 0;
    for (; n_started < N_THREADS; ++n_started) {
        jobs[n_started] = (job){.model = model, .ref = ref, .test = tests[n_started]};
        if (pthread_create(&threads[n_started], NULL, score, &jobs[n_started]) != 0)
            break;
    }
    for (int i = 0; i < n_started; ++i) {
        pthread_join(threads[i], NULL);
        if (jobs[i].status == NQM_OK)
            printf("%s: %.2f JOD\n", jobs[i].test, jobs[i].result.jod);
        else
            fprintf(stderr, "%s: %s\n", jobs[i].test, jobs[i].err.message);
        failed |= jobs[i].status != NQM_OK;
    }
    nqm_brdf_free(ref);
    nqm_model_free(model);
    return failed || n_started < N_THREADS;
}
