/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the labels of a dataset in the authors' layout, whose folder has one material. An accepted dataset has a pair for
 * each row, with the JOD of that row.
 */
#include "sample/sample.h"
#include "fuzz.h"

#include <nqm/brdf.h>
#include <nqm/data.h>
#include <nqm/samples.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

/* ROOT/ref/a.mat and ROOT/model/a.mat are the same file: ref and model are links to ROOT. */
static const char *make_folder(void) {
    static const double degrees[3] = {10, 20, 30};
    static const float rgb[3] = {1, 2, 3};
    const char *file = scratch_path("a.mat"), *ref = scratch_path("ref"), *model = scratch_path("model");
    static char root[256];
    nqm_directions *directions;
    must(nqm_directions_from_degrees(1, degrees, &directions, NULL) == NQM_OK);
    must(nqm_samples_save_mat(directions, rgb, file, NULL) == NQM_OK);
    nqm_directions_free(directions);
    must(symlink(".", ref) == 0 && symlink(".", model) == 0);
    snprintf(root, sizeof root, "%.*s", (int)(strrchr(file, '/') - file), file);
    return root;
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    static const char *root;
    char path[FUZZ_PATH];
    nqm_dataset *dataset;
    nqm_error err = {0};
    if (!root)
        root = make_folder();
    const int fd = fuzz_file(data, n_bytes, path);
    const nqm_status status = nqm_dataset_load(root, path, NQM_SPLIT_TEST, &dataset, &err);
    must((status == NQM_OK) == (dataset != NULL) && (status == NQM_OK || err.message[0]));
    for (size_t i = 0; dataset && i < nqm_dataset_get_info(dataset).n_pairs; ++i) {
        const nqm_dataset_pair pair = nqm_dataset_get_pair(dataset, i);
        must(pair.jod >= 0 && pair.jod <= 11 && pair.ref[0] == 'a' && pair.test[0] == 'a');
    }
    nqm_dataset_free(dataset);
    close(fd);
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "material,model,level,DeltaE,JOD,class\na_1,ward,0,5,9.4,metal\na_2,sbrdf,2,60,4.1,metal\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
