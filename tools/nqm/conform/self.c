/* SPDX-License-Identifier: MIT
 *
 * `nqm conform MODEL --self`: the model's own values, from directions and parameters in float32 as a shader gets them,
 * pass; and each mistake is named from its values.
 */
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A kit whose inputs are rounded to float32; free() it. It borrows from the kit. */
static conform_kit *round_kit(const conform_kit *kit) {
    conform_kit *rounded = allocate(1, sizeof *rounded);
    *rounded = *kit;
    for (size_t turn = 0; turn < KIT_TURNS; ++turn) {
        rounded->wi[turn] = allocate(3 * kit->n_directions, sizeof(double));
        rounded->wo[turn] = allocate(3 * kit->n_directions, sizeof(double));
        for (size_t i = 0; i < 3 * kit->n_directions; ++i) {
            rounded->wi[turn][i] = (double)(float)kit->wi[turn][i];
            rounded->wo[turn][i] = (double)(float)kit->wo[turn][i];
        }
    }
    for (size_t set = 0; set < kit->n_sets; ++set)
        for (size_t k = 0; k < kit->model->schema.n_keys; ++k)
            for (size_t c = 0; c < 3; ++c)
                rounded->sets[set].values.v[k][c] = (double)(float)kit->sets[set].values.v[k][c];
    return rounded;
}

static void free_rounded(conform_kit *rounded) {
    for (size_t turn = 0; turn < KIT_TURNS; ++turn) {
        free(rounded->wi[turn]);
        free(rounded->wo[turn]);
    }
    free(rounded);
}

/* The lowest JOD of a kit's values without a mistake. */
static double lowest_of(const conform_kit *kit, const conform_kit *rounded) {
    const suspect none = {.mistakes = 0};
    const nqm_score_options options = nqm_score_options_default();
    float *values = allocate(3 * kit->n_sets * kit->n_directions, sizeof *values);
    nqm_score_result *results = allocate(kit->n_sets, sizeof *results);
    nqm_scorer *scorer;
    nqm_error err = {0};
    must(nqm_scorer_create(kit->metric, &options, &scorer, &err), &err);
    for (size_t set = 0; set < kit->n_sets; ++set)
        sample_suspect(rounded, set, &none, values + 3 * set * kit->n_directions);
    score_values(kit, scorer, values, &none, results);
    double lowest = 10;
    for (size_t set = 0; set < kit->n_sets; ++set)
        lowest = fmin(lowest, results[set].jod);
    nqm_scorer_free(scorer);
    free(results);
    free(values);
    return lowest;
}

/* How many suspects explain the values of suspect t better than itself; those with equal values (to float32) count as itself. */
static size_t rank_of(size_t n, size_t t, const double *left) {
    size_t rank = 0;
    for (size_t s = 0; s < n; ++s)
        rank += left[s] < left[t] - 1e-6;
    return rank;
}

int prove_kit(const conform_kit *kit, result_format format) {
    const double noticed = 1e-4;
    size_t n, n_seen = 0, n_first = 0, n_three = 0;
    suspect *list = list_suspects(kit, &n);
    conform_kit *rounded = round_kit(kit);
    double *left = allocate(n * n, sizeof *left);
    json_t *missed = json_array();
    const double lowest = lowest_of(kit, rounded);
    compare_suspects(kit, n, list, &(suspect_targets){.n = n, .planted = rounded}, left);
    for (size_t t = 1; t < n; ++t) {
        if (left[t * n] < noticed) /* this model does not have it */
            continue;
        const size_t rank = rank_of(n, t, left + t * n);
        ++n_seen;
        n_first += rank == 0;
        n_three += rank < 3;
        if (rank)
            json_array_append_new(missed, json_string(list[t].text));
    }
    const bool passes = lowest >= conform_pass && 10 * n_first >= 9 * n_seen && 100 * n_three >= 98 * n_seen;
    json_t *document =
        json_pack("{s:s,s:I,s:I,s:o,s:I,s:I,s:I,s:o,s:b}", "model", kit->model->schema.model, "sets",
                  (json_int_t)kit->n_sets, "directions", (json_int_t)kit->n_directions, "lowest_jod",
                  json_number(lowest), "mistakes", (json_int_t)n_seen, "named_first", (json_int_t)n_first,
                  "named_in_three", (json_int_t)n_three, "not_first", missed, "passes", passes);
    if (format == FORMAT_JSON)
        print_document(document);
    else
        print_members(document);
    free_rounded(rounded);
    free(left);
    free(list);
    return passes ? EXIT_OK : EXIT_GATE;
}
