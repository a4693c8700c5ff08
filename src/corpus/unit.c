/* SPDX-License-Identifier: MIT
 *
 * Labels the rows of one unit of work: sample and render each test once, and compare its picture with that of the reference.
 */
#include "brdf/brdf.h"
#include "corpus/corpus.h"

#include <math.h>
#include <string.h>

/* State of making a unit. */
typedef struct job {
    const nqm_corpus *corpus;
    nqm_corpus_unit *unit;
    size_t n;                   /* directions */
    const nqm_corpus_view *ref; /* NULL: it cannot be opened */
    nqm_error ref_fault;
    nqm_corpus_view made; /* the arrays of tests */
    nqm_corpus_fits fits;
    double saved_s, save_cost_s; /* time of the last save of the unfinished unit, and its duration */
    nqm_error *err;
} job;

/* Errors that are not errors of a pair. */
static bool is_fatal(nqm_status status) {
    return status == NQM_ERR_CANCELLED || status == NQM_ERR_NOMEM;
}

/* A fit is known by its result if that is a spec, any other test by its argument. */
static char *name_of(const char *argument, const nqm_brdf *brdf) {
    const char *spec = strncmp(argument, "fit:", 4) == 0 ? nqm_brdf_get_info(brdf).spec : NULL;
    return nqm_strdup(spec && *spec ? spec : argument);
}

static nqm_status label_with(job *j, size_t row, const nqm_corpus_view *test, nqm_error *err) {
    nqm_corpus_unit *unit = j->unit;
    const nqm_scene_picture of_ref = {j->ref->brdf, j->ref->picture, j->ref->valid},
                            of_test = {test->brdf, test->picture, test->valid};
    nqm_label label;
    const nqm_status status = nqm_scene_label(j->corpus->scene, &of_ref, &of_test, &label, NULL, NULL, err);
    if (status != NQM_OK)
        return status;
    if (!isfinite(label.delta_e))
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "Delta-E is not finite");
    unit->label[row] = label;
    memcpy(unit->test_rgb + 3 * j->n * row, test->rgb, 3 * j->n * sizeof(float));
    memcpy(unit->test_used + j->n * row, test->used, j->n);
    return NQM_OK;
}

static nqm_status label_row(job *j, size_t row, nqm_error *err) {
    const char *argument = j->corpus->list.rows[j->unit->first_row + row].test;
    const nqm_corpus_ref *other = nqm_corpus_ref_of(&j->corpus->list, argument);
    const nqm_corpus_view *view = &j->made;
    bool is_lent = true;
    if (!j->ref) {
        *err = j->ref_fault;
        return err->status;
    }
    nqm_status status = other ? nqm_corpus_cached(j->corpus, (size_t)(other - j->corpus->list.refs), &view, err)
                              : nqm_corpus_open(j->corpus, &j->fits, argument, &j->made.brdf, &is_lent, err);
    if (status == NQM_OK && !other)
        status = nqm_corpus_view_fill(j->corpus, &j->made, err);
    if (status == NQM_OK)
        status = label_with(j, row, view, err);
    if (status == NQM_OK)
        j->unit->names[row] = name_of(argument, view->brdf);
    if (!is_lent)
        nqm_brdf_free(j->made.brdf);
    j->made.brdf = NULL;
    return status;
}

static nqm_status make_row(job *j, size_t row) {
    nqm_corpus_unit *unit = j->unit;
    nqm_error err = {0};
    nqm_status status = label_row(j, row, &err);
    if (status != NQM_OK && !is_fatal(status)) {
        unit->failures[row] = nqm_strdup(*err.message ? err.message : nqm_status_text(status));
        unit->names[row] = nqm_strdup(j->corpus->list.rows[unit->first_row + row].test);
        status = unit->failures[row] ? NQM_OK : NQM_ERR_NOMEM;
    }
    if (status == NQM_OK && !unit->names[row])
        status = NQM_ERR_NOMEM;
    if (status == NQM_ERR_NOMEM)
        return nqm_fail_nomem(j->err, 512);
    if (status != NQM_OK && j->err)
        *j->err = err;
    return status;
}

/* Save the first n_done rows for a later run. Saving takes at most a twentieth of the time unless the run ends here. */
static nqm_status save_rows(job *j, size_t n_done, bool ends, nqm_error *err) {
    const double begin_s = nqm_clock_s();
    if (!j->unit->path || n_done == 0 || n_done == j->unit->n_rows ||
        (!ends && begin_s - j->saved_s < 20 * j->save_cost_s))
        return NQM_OK;
    nqm_status status = nqm_corpus_unit_save(j->n, j->unit, n_done, err);
    j->saved_s = nqm_clock_s();
    j->save_cost_s = j->saved_s - begin_s;
    return status;
}

/* *n_done: the rows that are finished, also after a failure. */
static nqm_status make_rows(job *j, size_t *n_done) {
    nqm_status status = NQM_OK;
    for (size_t row = *n_done; status == NQM_OK && row < j->unit->n_rows; ++row) {
        status = make_row(j, row);
        *n_done += status == NQM_OK;
        if (status == NQM_OK)
            status = save_rows(j, row + 1, false, j->err);
        if (status == NQM_OK && j->corpus->step(j->corpus->step_user, 1))
            status = nqm_fail(j->err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    }
    return status;
}

static nqm_status open_ref(job *j) {
    nqm_status status = nqm_corpus_cached(j->corpus, j->unit->ref, &j->ref, &j->ref_fault);
    if (status != NQM_OK) {
        j->ref = NULL;
        if (is_fatal(status) && j->err)
            *j->err = j->ref_fault;
        return is_fatal(status) ? status : NQM_OK;
    }
    memcpy(j->unit->ref_rgb, j->ref->rgb, 3 * j->n * sizeof(float));
    memcpy(j->unit->ref_used, j->ref->used, j->n);
    return NQM_OK;
}

nqm_status nqm_corpus_unit_make(const nqm_corpus *corpus, nqm_corpus_unit *unit, nqm_error *err) {
    job j = {.corpus = corpus, .unit = unit, .n = corpus->n_directions, .err = err};
    nqm_status status = open_ref(&j);
    if (status == NQM_OK)
        status = nqm_corpus_view_alloc(corpus, &j.made, err);
    if (status == NQM_OK) {
        size_t n_done = unit->path ? nqm_corpus_unit_resume(j.n, unit) : 0;
        corpus->step(corpus->step_user, n_done);
        status = make_rows(&j, &n_done);
        if (status == NQM_ERR_CANCELLED)
            (void)!save_rows(&j, n_done, true, NULL); /* a failure costs the next run this time only */
    }
    nqm_corpus_fits_free(&j.fits);
    nqm_corpus_view_free(&j.made);
    return status;
}
