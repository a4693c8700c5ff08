/* SPDX-License-Identifier: MIT
 *
 * BRDFs as a corpus uses them: opened, sampled and rendered. A reference is made once in a process, because it also serves as
 * another material in the tests of other references; a fit is made once for all tests of a unit of work that contain it.
 */
#include "base/os.h"
#include "brdf/brdf.h"
#include "corpus/corpus.h"
#include "fit/fit.h"

#include <string.h>

nqm_status nqm_corpus_view_alloc(const nqm_corpus *corpus, nqm_corpus_view *view, nqm_error *err) {
    size_t n = corpus->n_directions, n_points = nqm_scene_get_info(corpus->scene).n_points;
    return nqm_alloc_arrays(NQM_ARRAYS({&view->rgb, n, 3 * sizeof *view->rgb}, {&view->used, n, 1},
                                       {&view->picture, n_points, 9 * sizeof *view->picture}),
                            err);
}

void nqm_corpus_view_free(nqm_corpus_view *view) {
    nqm_brdf_free(view->brdf);
    nqm_free(view->rgb);
}

nqm_status nqm_corpus_view_fill(const nqm_corpus *corpus, nqm_corpus_view *view, nqm_error *err) {
    if (!corpus->options->anisotropic && nqm_brdf_anisotropy(view->brdf) > 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "%s: anisotropic, and samples have one azimuth: the option 'anisotropic' is missing",
                        nqm_brdf_get_info(view->brdf).name);
    nqm_status status = nqm_sample(view->brdf, corpus->directions, NQM_INVALID_DROP, view->rgb, view->used, NULL, err);
    for (size_t i = 0; status == NQM_OK && i < corpus->n_directions; ++i)
        view->used[i] = nqm_has_value(view->used[i]);
    if (status == NQM_OK)
        status = nqm_scene_render_halves(corpus->scene, view->brdf, NULL, view->picture, &view->valid, err);
    return status;
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

typedef struct opening {
    const nqm_corpus *corpus;
    nqm_corpus_fits *fits; /* NULL: references are opened, not taken from the cache */
} opening;

static int ask(void *user, const char *stage, double done, double total) {
    const nqm_corpus *corpus = user;
    (void)stage, (void)done, (void)total;
    return corpus->step(corpus->step_user, 0);
}

/* A file, preset or spec. Decoders of neural processes become tables, because dozens of copies are rendered. */
static nqm_status open_leaf(const nqm_corpus *corpus, const char *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_ticker ticker = {.fn = ask, .user = (void *)corpus};
    nqm_brdf *form;
    *brdf_ret = NULL;
    nqm_status status = nqm_argument_open_below(argument, corpus->list.root, &form, err);
    if (status != NQM_OK)
        return status;
    if (!form->class_->is_costly || corpus->options->scene.exact) {
        *brdf_ret = form;
        return NQM_OK;
    }
    status = nqm_brdf_tabulate(form, nqm_table_general, &ticker, brdf_ret, err);
    nqm_brdf_free(form);
    return status;
}

static nqm_status open_any(void *user, const char *argument, nqm_brdf **brdf_ret, bool *is_lent_ret, nqm_error *err);

static nqm_status open_nested(const opening *o, const char *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_fit_context context = {.open = open_any,
                                     .user = (void *)o,
                                     .n_own = o->corpus->n_directions,
                                     .own_deg = nqm_directions_get_info(o->corpus->directions).degrees,
                                     .progress = ask,
                                     .progress_user = (void *)o->corpus};
    return nqm_fit_open(argument, &context, brdf_ret, err);
}

/* Make a fit, or take it from those of the unit; also its failure. */
static nqm_status open_fit(const opening *o, const char *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_corpus_fits *fits = o->fits;
    size_t i = 0;
    while (i < fits->n && strcmp(fits->fits[i].argument, argument) != 0)
        ++i;
    if (i == fits->n) {
        nqm_corpus_fit made = {.argument = nqm_strdup(argument)};
        if (!made.argument)
            return nqm_fail_nomem(err, strlen(argument) + 1);
        made.fault.status = open_nested(o, argument, &made.brdf, &made.fault); /* may add fits that it contains */
        nqm_corpus_fit *grown = nqm_grow(fits->fits, &fits->max_n, fits->n + 1, sizeof *grown);
        if (grown)
            fits->fits = grown;
        else
            made.fault.status = NQM_ERR_NOMEM;
        if (made.fault.status == NQM_ERR_CANCELLED || made.fault.status == NQM_ERR_NOMEM) {
            nqm_free(made.argument);
            nqm_brdf_free(made.brdf);
            if (err)
                *err = made.fault;
            return made.fault.status;
        }
        i = fits->n;
        fits->fits[fits->n++] = made;
    }
    *brdf_ret = fits->fits[i].brdf;
    if (!*brdf_ret && err)
        *err = fits->fits[i].fault;
    return *brdf_ret ? NQM_OK : fits->fits[i].fault.status;
}

static nqm_status open_any(void *user, const char *argument, nqm_brdf **brdf_ret, bool *is_lent_ret, nqm_error *err) {
    const opening *o = user;
    const nqm_corpus_ref *ref = o->fits ? nqm_corpus_ref_of(&o->corpus->list, argument) : NULL;
    *is_lent_ret = true;
    *brdf_ret = NULL;
    if (ref) {
        const nqm_corpus_view *view;
        nqm_status status = nqm_corpus_cached(o->corpus, (size_t)(ref - o->corpus->list.refs), &view, err);
        *brdf_ret = status == NQM_OK ? view->brdf : NULL;
        return status;
    }
    const nqm_argument_kind kind = nqm_argument_kind_of(argument);
    if (o->fits && kind == NQM_ARGUMENT_FIT) /* its argument lives as long as the list */
        return open_fit(o, argument, brdf_ret, err);
    *is_lent_ret = false;
    if (kind == NQM_ARGUMENT_FIT || kind == NQM_ARGUMENT_WRAPPER)
        return open_nested(o, argument, brdf_ret, err);
    return open_leaf(o->corpus, argument, brdf_ret, err);
}

nqm_status nqm_corpus_open(const nqm_corpus *corpus, nqm_corpus_fits *fits, const char *argument, nqm_brdf **brdf_ret,
                           bool *is_lent_ret, nqm_error *err) {
    opening o = {corpus, fits};
    return open_any(&o, argument, brdf_ret, is_lent_ret, err);
}

void nqm_corpus_fits_free(nqm_corpus_fits *fits) {
    for (size_t i = 0; i < fits->n; ++i) {
        nqm_free(fits->fits[i].argument);
        nqm_brdf_free(fits->fits[i].brdf);
    }
    nqm_free(fits->fits);
    *fits = (nqm_corpus_fits){0};
}

const nqm_corpus_ref *nqm_corpus_ref_of(const nqm_corpus_list *list, const char *argument) {
    return nqm_index_find(&list->by_brdf, (nqm_index_key){.name = argument});
}

/* ---- cache ------------------------------------------------------------------------------------------------------- */

typedef struct slot {
    pthread_mutex_t mutex; /* held while the view is made */
    bool is_tried;
    nqm_error fault; /* status NQM_OK: the view is ready */
    nqm_corpus_view view;
} slot;

struct nqm_corpus_cache {
    size_t n;
    slot *slots; /* (n) */
};

nqm_status nqm_corpus_cache_create(size_t n_refs, nqm_corpus_cache **cache_ret, nqm_error *err) {
    nqm_corpus_cache *cache;
    slot *slots;
    *cache_ret = NULL;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&cache, 1, sizeof *cache}, {&slots, n_refs, sizeof *slots}), err);
    if (status != NQM_OK)
        return status;
    *cache = (nqm_corpus_cache){n_refs, slots};
    for (size_t i = 0; i < n_refs; ++i)
        pthread_mutex_init(&slots[i].mutex, NULL);
    *cache_ret = cache;
    return NQM_OK;
}

void nqm_corpus_cache_free(nqm_corpus_cache *cache) {
    if (!cache)
        return;
    for (size_t i = 0; i < cache->n; ++i) {
        nqm_corpus_view_free(&cache->slots[i].view);
        pthread_mutex_destroy(&cache->slots[i].mutex);
    }
    nqm_free(cache);
}

static nqm_status make_view(const nqm_corpus *corpus, size_t ref, nqm_corpus_view *view, nqm_error *err) {
    bool is_lent;
    nqm_status status = nqm_corpus_view_alloc(corpus, view, err);
    if (status == NQM_OK)
        status = nqm_corpus_open(corpus, NULL, corpus->list.refs[ref].brdf, &view->brdf, &is_lent, err);
    if (status == NQM_OK)
        status = nqm_corpus_view_fill(corpus, view, err);
    if (status != NQM_OK) {
        nqm_corpus_view_free(view);
        *view = (nqm_corpus_view){0};
    }
    return status;
}

nqm_status nqm_corpus_cached(const nqm_corpus *corpus, size_t ref, const nqm_corpus_view **view_ret, nqm_error *err) {
    slot *s = &corpus->cache->slots[ref];
    pthread_mutex_lock(&s->mutex);
    if (!s->is_tried) {
        s->fault = (nqm_error){0};
        s->fault.status = make_view(corpus, ref, &s->view, &s->fault);
        s->is_tried = s->fault.status != NQM_ERR_CANCELLED && s->fault.status != NQM_ERR_NOMEM;
    }
    const nqm_error fault = s->fault;
    pthread_mutex_unlock(&s->mutex);
    *view_ret = &s->view;
    if (fault.status != NQM_OK && err)
        *err = fault;
    return fault.status;
}
