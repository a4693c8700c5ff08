/* SPDX-License-Identifier: MIT
 *
 * encode_with - codes BRDFs with an encoder file as `nqm fit --model sparse-*` or `hyper-*` would with the embedded one, and prints the loss of
 * each. usage: encode_with sparse|hyper FILE N BRDF...   (N: atoms, or samples that the hypernetwork reads)
 */
#include "encode/encode.h"
#include "nqm/tool.h"

#include <string.h>

static nqm_status encode(bool sparse, const nqm_map *file, const nqm_brdf *ref, const nqm_encode_options *options,
                         double *loss_ret, nqm_error *err) {
    nqm_encode_report report = {0};
    nqm_sparse_dictionary *dictionary = NULL;
    nqm_hyper hyper = {0};
    nqm_brdf *coded = NULL;
    nqm_status status = sparse ? nqm_sparse_dictionary_parse(file->data, file->n_bytes, "file", &dictionary, err)
                               : nqm_hyper_read(file->data, file->n_bytes, "file", &hyper, err);
    if (status == NQM_OK)
        status = sparse ? nqm_sparse_encode(dictionary, ref, options, &report, &coded, err)
                        : nqm_hyper_encode_brdf(&hyper, ref, options, &report, &coded, err);
    *loss_ret = report.loss;
    nqm_brdf_free(coded);
    nqm_free(hyper.block);
    nqm_free(dictionary);
    return status;
}

int main(int argc, char **argv) {
    nqm_map file;
    if (argc < 5)
        return 2;
    const nqm_encode_options options = {
        .n = strtoul(argv[3], NULL, 10), .n_directions = 6000, .seed = 1, .name = "coded"};
    must(nqm_map_open(argv[2], &file, &fault));
    for (int i = 4; i < argc; ++i) {
        nqm_brdf *ref;
        double loss;
        must(nqm_brdf_open(argv[i], &ref, &fault));
        must(encode(strcmp(argv[1], "sparse") == 0, &file, ref, &options, &loss, &fault));
        printf("%.9g\n", loss);
        nqm_brdf_free(ref);
    }
    nqm_map_close(&file);
    return 0;
}
