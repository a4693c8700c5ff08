/* SPDX-License-Identifier: MIT
 *
 * Parallel loops and the progress ticker.
 */
#include "base/base.h"

#include <omp.h>

static void parallel_range(size_t begin, size_t end, void (*body)(void *user, size_t i), void *user) {
#pragma omp parallel for schedule(dynamic, 1) if (end - begin > 1)
    for (size_t i = begin; i < end; ++i)
        body(user, i);
}

void nqm_parallel_for(size_t n, void (*body)(void *user, size_t i), void *user) {
    parallel_range(0, n, body, user);
}

int nqm_limit_threads(int n_threads) {
    int before = omp_get_max_threads();
    omp_set_num_threads(n_threads);
    return before;
}

bool nqm_tick(nqm_ticker *ticker, const char *stage, double done, double total) {
    if (!ticker || !ticker->fn)
        return false;
    double now = nqm_clock_s();
    if (now < ticker->next_s && !(total > 0 && done >= total))
        return false;
    ticker->next_s = now + 0.2;
    return ticker->fn(ticker->user, stage, done, total) != 0;
}

bool nqm_parallel_ticking(nqm_ticker *ticker, const char *stage, size_t n, void (*body)(void *user, size_t i),
                          void *user) {
    size_t piece = ticker && ticker->fn ? 16 : n;
    for (size_t begin = 0, end; begin < n; begin = end) {
        const double start_s = nqm_clock_s();
        end = nqm_smaller(n, begin + piece);
        parallel_range(begin, end, body, user);
        if (nqm_clock_s() - start_s < 0.01)
            piece *= 2;
        if (nqm_tick(ticker, stage, (double)end, (double)n))
            return true;
    }
    return false;
}
