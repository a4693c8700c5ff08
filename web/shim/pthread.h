/* SPDX-License-Identifier: MIT
 *
 * POSIX threads where there is one thread: locks are always free.
 */
#ifndef NQM_WEB_PTHREAD_H
#define NQM_WEB_PTHREAD_H
#include <sys/types.h>
#define PTHREAD_MUTEX_INITIALIZER                                                                                      \
    { 0 }
#define PTHREAD_ONCE_INIT 0
static inline int pthread_mutex_init(pthread_mutex_t *m, const void *attributes) {
    (void)m, (void)attributes;
    return 0;
}
static inline int pthread_mutex_destroy(pthread_mutex_t *m) {
    (void)m;
    return 0;
}
static inline int pthread_mutex_lock(pthread_mutex_t *m) {
    (void)m;
    return 0;
}
static inline int pthread_mutex_unlock(pthread_mutex_t *m) {
    (void)m;
    return 0;
}
static inline int pthread_once(pthread_once_t *once, void (*fn)(void)) {
    if (!*once) {
        *once = 1;
        fn();
    }
    return 0;
}
static inline int pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void)) {
    (void)prepare, (void)parent, (void)child;
    return 0;
}
#endif
