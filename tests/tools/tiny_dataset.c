/* SPDX-License-Identifier: MIT
 *
 * tiny_dataset FILE [SEED [MATERIALS [parts]]]: write the small labelled dataset of support/toy_dataset.h, for the
 * command-line tests. parts: labels with parts, and the kind "gloss" is far and unseen.
 */
#include "support/toy_dataset.h"

#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv) {
    if (argc < 2) {
        fputs("usage: tiny_dataset FILE [SEED [MATERIALS [parts]]]\n", stderr);
        return 2;
    }
    toy_options options = toy_options_default();
    options.seed = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    options.n_groups = argc > 3 ? strtoul(argv[3], NULL, 10) : options.n_groups;
    if (argc > 4) {
        options.with_transport = true;
        options.families[1] = "far";
        options.unseen = "gloss";
    }
    nqm_dataset *dataset = toy_dataset(&options);
    nqm_error err = {0};
    nqm_status status = nqm_dataset_write(dataset, argv[1], NULL, &err);
    if (status != NQM_OK)
        fprintf(stderr, "tiny_dataset: %s\n", err.message);
    nqm_dataset_free(dataset);
    return status != NQM_OK;
}
