/* SPDX-License-Identifier: MIT
 *
 * The rounds of EVERY_ALLOCATION.
 */
#include "support/allocations.h"
#include "support/check.h"

bool next_allocation(long *n, nqm_status status, long skip) {
    enum { ENDLESS = 1000000 };
    nqm_alloc_fail_after(-1);
    if (*n >= 0 && status != NQM_ERR_NOMEM) {
        if (status != NQM_OK || *n == 0)
            fail_msg("allocation %ld: %s", *n, nqm_status_text(status));
        return false;
    }
    *n += *n >= 0 && skip ? 1 + *n / skip : 1;
    assert_true(*n < ENDLESS);
    nqm_alloc_fail_after(*n);
    return true;
}

long check_brdf_allocations(const char *argument) {
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_brdf *brdf;
        nqm_error err = {0};
        status = nqm_brdf_open(argument, &brdf, &err);
        assert_true((status == NQM_OK) == (brdf != NULL));
        assert_int_equal(err.status, status);
        nqm_brdf_free(brdf);
    }
    return n;
}
