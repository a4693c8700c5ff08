/* SPDX-License-Identifier: MIT
 *
 * OpenMP where there is one thread.
 */
#ifndef NQM_WEB_OMP_H
#define NQM_WEB_OMP_H
static inline void omp_set_num_threads(int n) {
    (void)n;
}
static inline int omp_get_max_threads(void) {
    return 1;
}
static inline int omp_get_num_threads(void) {
    return 1;
}
static inline int omp_get_thread_num(void) {
    return 0;
}
#endif
