/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: answers of people in a CSV; the BRDFs that it names are not opened. An accepted file must have a finite
 * value for every test of every row; the numbers of choices must not be negative and not all 0.
 */
#include "data/data.h"
#include "fuzz.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void look_at(const nqm_answers *a) {
    double sum = 0;
    must(a->n_rows > 0 && a->n_slots == (a->kind == NQM_HUMAN_CHOICE ? 2u : 1u));
    for (size_t i = 0; i < a->n_rows * a->n_slots; ++i) {
        must(isfinite(a->values[i]) && (a->n_slots == 1 || a->values[i] >= 0));
        sum += a->values[i];
        must(nqm_csv_text(a->csv, i / a->n_slots, a->test[i % a->n_slots]) != NULL);
        must(nqm_csv_text(a->csv, i / a->n_slots, a->reference) != NULL);
    }
    must(a->n_slots == 1 || sum > 0);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    nqm_csv *csv;
    nqm_answers answers;
    nqm_error err = {0};
    if (nqm_csv_parse((const char *)data, n_bytes, "fuzz", &csv, NULL) != NQM_OK)
        return 0;
    if (nqm_answers_read(csv, "fuzz", &answers, &err) == NQM_OK) {
        look_at(&answers);
        nqm_free(answers.values);
    } else {
        must(strstr(err.message, "fuzz") != NULL);
    }
    nqm_csv_free(csv);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "reference,test_a,test_b,n_a,n_b,material\nsgd:nickel,ward:nickel,sgd:brass,8,2,metal\n"
                               "lambert:kd=.5,lambert:kd=.6,lambert:kd=.9,3,1,grey\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
