/* SPDX-License-Identifier: MIT
 *
 * Fits of an unfinished group, which take most of its time: each is saved when it is finished, in a folder beside the file of the
 * group, and an interrupted corpus continues from them. A file is that of nqm_brdf_save() with more metadata; without tensors
 * where a spec has the result, or the fit failed.
 */
#include "brdf/formats/format.h"
#include "corpus/corpus.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Metadata of a file. KEY identifies the fit; NAME is that of a BRDF without a spec. */
enum { KEY, FAULT, MESSAGE, LOSS, SPEC, NAME, N_META };
static const char *const meta_names[N_META] = {"fit", "fault", "message", "loss", "spec", "name"};

/* The folder of a group's fits; with a model, the file of one. nqm_free() it. NULL: out of memory. */
static char *path_of(const nqm_corpus_item *item, size_t ref, const char *model) {
    const size_t n = strlen(item->path) + (model ? strlen(model) : 0) + 40;
    char *path = nqm_alloc(n, 1);
    const int used = path ? snprintf(path, n, "%s.fits", item->path) : 0;
    if (path && model)
        snprintf(path + used, n - (size_t)used, "/%zu-%s", ref, model);
    return path;
}

/* The path below the folder of all groups; it begins with a hash of all inputs. */
static const char *key_of(const nqm_corpus_item *item, const char *path) {
    const char *slash = strrchr(item->path, '/');
    return slash ? path + (slash - item->path) + 1 : path;
}

nqm_status nqm_corpus_fit_save(const nqm_corpus_item *item, size_t ref, const char *model, const nqm_corpus_fit *fit,
                               nqm_error *err) {
    char loss[32], fault[16];
    const bool is_good = fit->fault.status == NQM_OK;
    if (!item->path)
        return NQM_OK;
    char *folder = path_of(item, ref, NULL), *path = path_of(item, ref, model);
    if (!folder || !path) {
        nqm_free(folder);
        nqm_free(path);
        return nqm_fail_nomem(err, strlen(item->path));
    }
    snprintf(fault, sizeof fault, "%d", (int)fit->fault.status);
    const char *values[N_META] = {key_of(item, path), fault, fit->fault.message, "0", "", ""};
    if (is_good) {
        values[LOSS] = nqm_format_double(loss, sizeof loss, fit->report.loss);
        values[SPEC] = fit->report.spec;
        values[NAME] = nqm_brdf_get_info(fit->view.brdf).name;
    }
    nqm_meta meta[N_META];
    for (size_t i = 0; i < N_META; ++i)
        meta[i] = (nqm_meta){meta_names[i], values[i]};
    (void)mkdir(folder, 0777); /* writing reports a failure */
    nqm_status status = is_good && !*values[SPEC] ? nqm_brdf_save_with(fit->view.brdf, path, N_META, meta, err)
                                                  : nqm_safetensors_write(path, 0, NULL, N_META, meta, NULL, err);
    nqm_free(folder);
    nqm_free(path);
    return status;
}

/* false: the file is damaged, or of another fit. */
static bool read_meta(const nqm_safetensors *st, const char *key, const char *values[N_META]) {
    char hex[65];
    bool is_intact = false;
    bool good = nqm_safetensors_checksum(st, hex, &is_intact) && is_intact;
    for (size_t i = 0; i < N_META; ++i)
        good = good && (values[i] = nqm_safetensors_meta(st, meta_names[i])) != NULL;
    return good && strcmp(values[KEY], key) == 0;
}

/* Set the fit from the metadata and, unless it has a spec or failed, from the tensors of the file. */
static bool take(const char *const values[N_META], nqm_map *map, nqm_corpus_fit *fit) {
    const char *end;
    fit->fault = (nqm_error){.status = (nqm_status)strtol(values[FAULT], NULL, 10), .byte_offset = -1};
    snprintf(fit->fault.message, sizeof fit->fault.message, "%s", values[MESSAGE]);
    snprintf(fit->report.spec, sizeof fit->report.spec, "%s", values[SPEC]);
    if (!nqm_parse_double(values[LOSS], &end, &fit->report.loss))
        return false;
    if (fit->fault.status != NQM_OK)
        return true;
    return (*values[SPEC] ? nqm_brdf_open(values[SPEC], &fit->view.brdf, NULL)
                          : nqm_saved_format.open(map, &(nqm_brdf_argument){.name = values[NAME]}, &fit->view.brdf,
                                                  NULL)) == NQM_OK;
}

bool nqm_corpus_fit_load(const nqm_corpus_item *item, size_t ref, const char *model, nqm_corpus_fit *fit) {
    char *path = item->path ? path_of(item, ref, model) : NULL;
    nqm_map map = {0};
    nqm_safetensors *st = NULL;
    const char *values[N_META];
    const bool loaded = path && access(path, R_OK) == 0 && nqm_map_open_own(path, &map, NULL) == NQM_OK &&
                        nqm_safetensors_parse(map.data, map.n_bytes, path, &st, NULL) == NQM_OK &&
                        read_meta(st, key_of(item, path), values) && take(values, &map, fit);
    if (!loaded)
        fit->fault = (nqm_error){0};
    nqm_safetensors_free(st);
    nqm_map_close(&map);
    nqm_free(path);
    return loaded;
}

void nqm_corpus_fits_remove(const nqm_corpus_item *item) {
    char *path = path_of(item, 0, NULL);
    DIR *folder = path ? opendir(path) : NULL;
    for (struct dirent *entry; folder && (entry = readdir(folder)) != NULL;)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            unlinkat(dirfd(folder), entry->d_name, 0);
    if (folder) {
        closedir(folder);
        rmdir(path);
    }
    nqm_free(path);
}
