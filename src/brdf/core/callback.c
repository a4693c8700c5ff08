/* SPDX-License-Identifier: MIT
 *
 * BRDFs that a callback of the caller evaluates: nqm_brdf_create(). Values pass through the same checks as those of
 * files (brdf.c).
 */
#include "base/os.h"
#include "brdf/brdf.h"

typedef struct callback {
    nqm_brdf_eval_fn eval;
    void (*free)(void *user);
    void *user;
    pthread_mutex_t mutex;
    pthread_mutex_t *lock; /* &mutex; NULL when the callback may run in several threads at once */
} callback;

static void callback_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    const callback *c = self;
    if (c->lock)
        pthread_mutex_lock(c->lock);
    c->eval(c->user, n, wi, wo, rgb);
    if (c->lock)
        pthread_mutex_unlock(c->lock);
}

static void callback_free(void *self) {
    callback *c = self;
    if (c->free)
        c->free(c->user);
    pthread_mutex_destroy(&c->mutex);
    nqm_free(c);
}

static const nqm_brdf_class callback_class = {
    .format = "callback", .anisotropic = true, .eval = callback_eval, .free = callback_free};

nqm_status nqm_brdf_create(const nqm_brdf_callbacks *callbacks, nqm_brdf **brdf_ret, nqm_error *err) {
    NQM_MAKE(err, brdf_ret, callbacks);
    if (!callbacks->eval)
        return nqm_fail(err, NQM_ERR_ARG, -1, "nqm_brdf_create: the callback `eval` is NULL");
    callback *c = nqm_alloc(1, sizeof *c);
    if (!c)
        return nqm_fail_nomem(err, sizeof *c);
    c->eval = callbacks->eval;
    c->user = callbacks->user;
    pthread_mutex_init(&c->mutex, NULL);
    c->lock = callbacks->serialize ? &c->mutex : NULL;
    const nqm_brdf_info info = {.name = callbacks->name ? callbacks->name : "callback",
                                .reciprocal = callbacks->reciprocal != 0};
    nqm_status status = nqm_brdf_wrap(&callback_class, c, &info, brdf_ret, err);
    if (status == NQM_OK) /* only now: on failure the caller keeps `user` */
        c->free = callbacks->free;
    return status;
}
