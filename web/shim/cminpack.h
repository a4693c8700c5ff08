/* SPDX-License-Identifier: MIT
 *
 * The curve from Delta-E to JOD is not regressed here: the call fails as one that has not converged.
 */
#ifndef NQM_WEB_CMINPACK_H
#define NQM_WEB_CMINPACK_H
typedef int (*cminpack_func_mn)(void *p, int m, int n, const double *x, double *fvec, int iflag);
static inline int lmdif1(cminpack_func_mn fn, void *p, int m, int n, double *x, double *fvec, double tol, int *iwa,
                         double *wa, int lwa) {
    (void)fn, (void)p, (void)m, (void)n, (void)x, (void)fvec, (void)tol, (void)iwa, (void)wa, (void)lwa;
    return -1;
}
#endif
