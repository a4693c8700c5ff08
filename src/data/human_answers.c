/* SPDX-License-Identifier: MIT
 *
 * Finds the columns of a CSV of answers, detects its form (scores or choices) and reads the values; ceilings of the fraction of
 * choices that a predictor can reproduce.
 */
#include "data/data.h"

#include <math.h>
#include <string.h>

static const double max_choices = 1e9; /* people per row */

static nqm_status need_column(const nqm_answers *a, const char *name, int *column, nqm_error *err) {
    *column = nqm_csv_column(a->csv, name);
    return *column >= 0 ? NQM_OK : nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the header has no column %s", a->path, name);
}

/* Find the column of scores; exactly one of the three must exist. */
static nqm_status find_scores(nqm_answers *a, nqm_error *err) {
    int n_found = 0;
    for (nqm_human_kind kind = NQM_HUMAN_SCORE; kind < NQM_HUMAN_CHOICE; ++kind) {
        int column = nqm_csv_column(a->csv, nqm_human_kind_name(kind));
        if (column < 0)
            continue;
        a->kind = kind;
        a->value[0] = column;
        ++n_found;
    }
    if (n_found != 1)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: the header has %s of the columns score, jod, distance; it needs one (or test_a and "
                        "test_b, for choices)",
                        a->path, n_found ? "several" : "none");
    return need_column(a, "test", &a->test[0], err);
}

static nqm_status find_choices(nqm_answers *a, nqm_error *err) {
    a->kind = NQM_HUMAN_CHOICE;
    a->n_slots = 2;
    a->choice = nqm_csv_column(a->csv, "choice");
    a->value[0] = nqm_csv_column(a->csv, "n_a");
    a->value[1] = nqm_csv_column(a->csv, "n_b");
    bool counts = a->value[0] >= 0 && a->value[1] >= 0;
    if ((a->choice >= 0) == counts)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: choices need either a column choice or columns n_a and n_b",
                        a->path);
    return need_column(a, "test_b", &a->test[1], err);
}

static nqm_status find_columns(nqm_answers *a, nqm_error *err) {
    nqm_status status = need_column(a, "reference", &a->reference, err);
    if (status != NQM_OK)
        return status;
    a->material = nqm_csv_column(a->csv, "material");
    a->n_slots = 1;
    a->choice = -1;
    a->test[0] = nqm_csv_column(a->csv, "test_a");
    status = a->test[0] >= 0 ? find_choices(a, err) : find_scores(a, err);
    a->test_kind = a->n_slots == 1 ? nqm_csv_column(a->csv, "kind") : -1;
    return status;
}

static nqm_status read_choice(const nqm_answers *a, size_t row, double *values, nqm_error *err) {
    const char *text = nqm_csv_text(a->csv, row, a->choice);
    values[0] = strcmp(text, "a") == 0 || strcmp(text, "A") == 0;
    values[1] = strcmp(text, "b") == 0 || strcmp(text, "B") == 0;
    if (values[0] + values[1] > 0)
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: row %zu: the choice is a or b, not '%.40s'", a->path, row + 1, text);
}

static nqm_status read_row(const nqm_answers *a, size_t row, nqm_error *err) {
    double *values = a->values + row * a->n_slots;
    nqm_status status = NQM_OK;
    if (a->choice >= 0)
        status = read_choice(a, row, values, err);
    for (size_t k = 0; a->choice < 0 && status == NQM_OK && k < a->n_slots; ++k) {
        status = nqm_csv_number(a->csv, row, a->value[k], &values[k], err);
        bool counts = a->n_slots == 2 && status == NQM_OK;
        if (counts && !(values[k] >= 0 && values[k] <= max_choices && values[k] == floor(values[k])))
            status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: row %zu: %g is no number of people", a->path, row + 1,
                              values[k]);
    }
    if (status == NQM_OK && a->n_slots == 2 &&
        strcmp(nqm_csv_text(a->csv, row, a->test[0]), nqm_csv_text(a->csv, row, a->test[1])) == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: row %zu: test_a and test_b are the same, '%.100s'", a->path,
                          row + 1, nqm_csv_text(a->csv, row, a->test[0]));
    return status;
}

nqm_status nqm_answers_read(const nqm_csv *csv, const char *path, nqm_answers *answers_ret, nqm_error *err) {
    nqm_answers a = {.csv = csv, .path = path, .n_rows = nqm_csv_rows(csv)};
    nqm_status status = find_columns(&a, err);
    if (status != NQM_OK)
        return status;
    if (a.n_rows == 0)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: has no rows", path);
    if (a.n_rows > UINT32_MAX / 2)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: %zu rows are too many", path, a.n_rows);
    a.values = nqm_alloc(a.n_rows, a.n_slots * sizeof *a.values);
    if (!a.values)
        return nqm_fail_nomem(err, a.n_rows * a.n_slots * sizeof *a.values);
    double sum = 0;
    for (size_t row = 0; status == NQM_OK && row < a.n_rows; ++row) {
        status = read_row(&a, row, err);
        for (size_t k = 0; k < a.n_slots; ++k)
            sum += a.values[row * a.n_slots + k];
    }
    if (status == NQM_OK && a.n_slots == 2 && sum == 0)
        status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: nobody has chosen anything", path);
    if (status == NQM_OK)
        *answers_ret = a;
    else
        nqm_free(a.values);
    return status;
}

/* ---- facts about answers ----------------------------------------------------------------------------------------- */

const char *nqm_human_kind_name(nqm_human_kind kind) {
    static const char *const names[] = {"score", "jod", "distance", "choice"};
    return (size_t)kind < sizeof names / sizeof *names ? names[kind] : NULL;
}

void nqm_human_free(nqm_human *human) {
    if (!human)
        return;
    nqm_dataset_free(human->dataset);
    nqm_free(human->triplets);
    nqm_free(human);
}

/* ---- ceilings ---------------------------------------------------------------------------------------------------- */

/* Number of the n people with the same choice who agree with the majority of all other people: n - 1 with the same
 * choice and n_other with the opposite one. A tie counts half. */
static double follow_others(double n, double n_other) {
    double others = n - 1;
    return others > n_other ? n : others == n_other ? 0.5 * n : 0;
}

nqm_human_info nqm_human_get_info(const nqm_human *human) {
    assert(human);
    nqm_human_info info = {.kind = human->kind,
                           .kind_name = nqm_human_kind_name(human->kind),
                           .n_rows = human->n_rows,
                           .n_refs = human->dataset->n_refs,
                           .n_groups = human->dataset->n_groups,
                           .n_triplets = human->n_triplets};
    double met = 0, with_others = 0, followed = 0;
    for (size_t i = 0; i < human->n_triplets; ++i) {
        const nqm_triplet *t = &human->triplets[i];
        info.n_choices += t->n_a + t->n_b;
        met += fmax(t->n_a, t->n_b);
        if (t->n_a + t->n_b < 2)
            continue;
        with_others += t->n_a + t->n_b;
        followed += follow_others(t->n_a, t->n_b) + follow_others(t->n_b, t->n_a);
    }
    info.ceiling = human->kind != NQM_HUMAN_CHOICE ? human->ceiling : info.n_choices > 0 ? met / info.n_choices : NAN;
    info.ceiling_other_people = with_others > 0 ? followed / with_others : NAN;
    return info;
}
