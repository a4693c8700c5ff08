/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the JSON of an evaluation, which `nqm plot bars` draws. A document that is refused must get a message.
 */
#include "figures/plot.h"
#include "fuzz.h"

#include <unistd.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    char path[FUZZ_PATH];
    nqm_error err = {0};
    const int fd = fuzz_file(data, n_bytes, path);
    if (nqm_plot_bars(fuzz_drawing(), path, NULL, &err) != NQM_OK && !err.message[0])
        abort();
    close(fd);
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "{\"dataset\":{\"split\":\"test\"},\"human\":{\"kind\":\"choice\",\"choices\":9,\"triplets\":3,\"materials\":2,"
        "\"ceiling\":0.9},\"results\":[{\"name\":\"default\",\"n\":4,\"n_materials\":2,\"spearman\":0.9,\"ci95\":[0.8,"
        "1],"
        "\"spearman_mean_by_material\":0.7,\"ci95_mean_by_material\":[0.5,null],\"majority\":0.75,\"agreement\":0.6},"
        "{\"name\":\"mse\",\"spearman\":-0.2,\"agreement\":0.5,\"ci95\":[0.4,0.6]}]}";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
