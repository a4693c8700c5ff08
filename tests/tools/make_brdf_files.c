/* SPDX-License-Identifier: MIT
 *
 * make_brdf_files FOLDER - write BRDF files of every format into an existing folder: `valid.*` and, for the
 * command-line tests, broken ones, `FORMAT-FAULT.*`. Large ones are sparse.
 */
#include "base/base.h"
#include "support/brdf_files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *folder;

static const char *in_folder(const char *name) {
    static char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* Faults that are possible in every format. n_full: the file size in bytes that the format requires, 0 if none. */
static void put_common_faults(const char *format, const char *ending, const blob *valid, size_t n_full) {
    char name[64];
    blob b = {valid->data, valid->n_bytes / 2};
    snprintf(name, sizeof name, "%s-truncated.%s", format, ending);
    blob_save_sparse(&b, n_full / 2, in_folder(name));
    snprintf(name, sizeof name, "%s-empty.%s", format, ending);
    b.n_bytes = 0;
    blob_save(&b, in_folder(name));
    if (n_full) {
        snprintf(name, sizeof name, "%s-longer.%s", format, ending);
        blob_save_sparse(valid, n_full + 8, in_folder(name));
    }
}

static void put_wrong_magic(const char *name, const blob *valid) {
    valid->data[1] ^= 0x55;
    blob_save(valid, in_folder(name));
    valid->data[1] ^= 0x55;
}

static void put_merl(void) {
    blob valid = make_merl();
    blob_save(&valid, in_folder("valid.binary"));
    blob head = {valid.data, 5000};
    put_common_faults("merl", "binary", &head, MERL_BYTES);
    put_wrong_magic("merl-magic.binary", &valid);
    nqm_store_u32(valid.data, 0x80000000U);
    nqm_store_u32(valid.data + 4, 0x80000000U);
    blob_save(&head, in_folder("merl-2e31.binary"));
    blob_save_sparse(&head, MERL_BYTES, in_folder("merl-2e31-full.binary"));
    nqm_store_u32(valid.data, 90);
    nqm_store_u32(valid.data + 4, 90);
    memset(valid.data + 12, 0xff, valid.n_bytes - 12); /* all bits set is a NaN */
    blob_put(valid, in_folder("merl-nan.binary"));
}

static void put_rgl(void) {
    const float not_a_number[4] = {1, NAN, 1, 1};
    const size_t huge = (size_t)1 << 31;
    blob valid = make_rgl(NULL);
    blob_save(&valid, in_folder("valid.bsdf"));
    put_common_faults("rgl", "bsdf", &valid, 0);
    put_wrong_magic("rgl-magic.bsdf", &valid);
    blob_free(&valid);
    blob_put(make_rgl(&(rgl_change){"ndf", false, 10, 2, {2, 2}, not_a_number}), in_folder("rgl-nan.bsdf"));
    blob_put(make_rgl(&(rgl_change){"rgb", false, 10, 5, {1, 4, 2, 5, 7}, NULL}), in_folder("rgl-size.bsdf"));
    blob_put(make_rgl(&(rgl_change){"vndf", false, 10, 4, {1, 4, huge, huge}, NULL}), in_folder("rgl-2e31.bsdf"));
}

static void put_nbrdf(void) {
    blob valid = make_nbrdf(NBRDF_VALID);
    blob_save(&valid, in_folder("valid.h5"));
    put_common_faults("nbrdf", "h5", &valid, 0);
    put_wrong_magic("nbrdf-magic.h5", &valid);
    blob_put(make_zip("valid.h5", &valid), in_folder("valid.zip"));
    blob short_one = {valid.data, valid.n_bytes / 2};
    blob_put(make_zip("short.h5", &short_one), in_folder("nbrdf-truncated.zip"));
    blob_free(&valid);
    blob_put(make_nbrdf(NBRDF_NAN), in_folder("nbrdf-nan.h5"));
    blob_put(make_nbrdf(NBRDF_SHAPE), in_folder("nbrdf-size.h5"));
}

static void put_nps(void) {
    blob valid = make_nps_decoder();
    blob_put(make_nps_latents(), in_folder("nps_latents.csv"));
    blob_save(&valid, in_folder("valid.bin"));
    put_common_faults("nps", "bin", &valid, 0);
    memset(valid.data, 0xff, valid.n_bytes);
    blob_put(valid, in_folder("nps-nan.bin"));
}

static void put_saved(void) {
    blob valid = make_saved(SAVED_TABLE);
    blob_put(make_saved(SAVED_NETWORK), in_folder("valid-network.safetensors"));
    blob_save(&valid, in_folder("valid-table.safetensors"));
    blob cut = {valid.data, valid.n_bytes - 100};
    blob_save(&cut, in_folder("saved-truncated.safetensors"));
    blob_free(&valid);
    blob_put(make_saved(SAVED_NAN), in_folder("saved-nan.safetensors"));
    blob_put(make_saved(SAVED_SHAPE), in_folder("saved-size.safetensors"));
    blob_put(make_saved(SAVED_CHECKSUM), in_folder("saved-checksum.safetensors"));
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: make_brdf_files FOLDER\n");
        return 2;
    }
    folder = argv[1];
    put_merl();
    put_rgl();
    put_nbrdf();
    put_nps();
    put_saved();
    return 0;
}
