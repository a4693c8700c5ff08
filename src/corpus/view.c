/* SPDX-License-Identifier: MIT
 *
 * References as a corpus uses them: opened, sampled and rendered. A reference is made once in a process, because it also
 * serves as another material in the tests of other groups.
 */
#include "brdf/brdf.h"
#include "corpus/corpus.h"

#include <pthread.h>

nqm_status nqm_corpus_view_alloc(const nqm_corpus_context *context, nqm_corpus_view *view, nqm_error *err) {
    size_t n = nqm_directions_count(context->directions), n_points = nqm_scene_count(context->scene);
    return nqm_alloc_arrays(NQM_ARRAYS({&view->rgb, n, 3 * sizeof *view->rgb}, {&view->used, n, 1},
                                       {&view->picture, n_points, 9 * sizeof *view->picture}),
                            err);
}

void nqm_corpus_view_free(nqm_corpus_view *view) {
    nqm_brdf_free(view->brdf);
    nqm_free(view->rgb);
}

nqm_status nqm_corpus_view_fill(const nqm_corpus_context *context, nqm_corpus_view *view, nqm_error *err) {
    size_t n = nqm_directions_count(context->directions);
    nqm_status status = nqm_sample(view->brdf, context->directions, NQM_INVALID_DROP, view->rgb, view->used, NULL, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        view->used[i] = nqm_has_value(view->used[i]);
    return status == NQM_OK ? nqm_scene_render_halves(context->scene, view->brdf, view->picture, err) : status;
}

static int ask(void *user, const char *stage, double done, double total) {
    const nqm_corpus_context *context = user;
    (void)stage, (void)done, (void)total;
    return context->step(context->step_user, 0);
}

/* Decoders of neural processes become tables, because dozens of copies are rendered. */
nqm_status nqm_corpus_open(const nqm_corpus_context *context, const char *path, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_ticker ticker = {.fn = ask, .user = (void *)context};
    nqm_brdf *form;
    *brdf_ret = NULL;
    nqm_status status = nqm_brdf_open(path, &form, err);
    if (status != NQM_OK)
        return status;
    if (!form->class_->is_costly || context->options->scene.exact) {
        *brdf_ret = form;
        return NQM_OK;
    }
    status = nqm_brdf_tabulate(form, nqm_table_general, &ticker, brdf_ret, err);
    nqm_brdf_free(form);
    return status;
}

/* ---- cache ------------------------------------------------------------------------------------------------------- */

typedef struct slot {
    pthread_mutex_t mutex; /* held while the view is made */
    bool is_ready;
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

static nqm_status make_view(const nqm_corpus_context *context, size_t list_ref, nqm_corpus_view *view, nqm_error *err) {
    nqm_status status = nqm_corpus_view_alloc(context, view, err);
    if (status == NQM_OK)
        status = nqm_corpus_open(context, context->list->refs[list_ref].path, &view->brdf, err);
    if (status == NQM_OK)
        status = nqm_corpus_view_fill(context, view, err);
    if (status != NQM_OK) {
        nqm_corpus_view_free(view);
        *view = (nqm_corpus_view){0};
    }
    return status;
}

nqm_status nqm_corpus_cached(const nqm_corpus_context *context, size_t list_ref, const nqm_corpus_view **view_ret,
                             nqm_error *err) {
    slot *s = &context->cache->slots[list_ref];
    pthread_mutex_lock(&s->mutex);
    nqm_status status = s->is_ready ? NQM_OK : make_view(context, list_ref, &s->view, err);
    s->is_ready = status == NQM_OK;
    pthread_mutex_unlock(&s->mutex);
    *view_ret = &s->view;
    return status;
}
