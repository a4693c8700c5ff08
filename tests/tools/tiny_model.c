/* SPDX-License-Identifier: MIT
 *
 * tiny_model FILE [N]: write a model with N (default 500) directions and random weights, so that the command-line tests
 * do not depend on the built-in models. Its scores have no meaning, except that equal BRDFs are reported as identical.
 */
#include "support/tiny_model.h"

#include <nqm/train.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv) {
    if (argc < 2) {
        fputs("usage: tiny_model FILE [N]\n", stderr);
        return 2;
    }
    nqm_error err = {0};
    nqm_model *model;
    nqm_status status = make_tiny_model(argc > 2 ? strtoul(argv[2], NULL, 10) : 500, &model, &err);
    if (status == NQM_OK)
        status = nqm_model_save(model, argv[1], &err);
    nqm_model_free(model);
    if (status != NQM_OK)
        fprintf(stderr, "tiny_model: %s\n", err.message);
    return status != NQM_OK;
}
