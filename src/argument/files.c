/* SPDX-License-Identifier: MIT
 *
 * Reads the files of arguments. Material files stay parsed, so that each of their materials costs no more than itself; other files stay
 * mapped until they are opened.
 */
#include "argument/argument.h"
#include "base/os.h"

#include <stdatomic.h>

enum { N_KEPT = 2 }; /* lists pair the materials of two files */

struct nqm_argument_file {
    nqm_materials *materials;
    nqm_argument_file *next; /* in the list */
    atomic_size_t n_holders; /* arguments, textures and the list */
    char path[];
};

struct nqm_argument_files {
    pthread_mutex_t mutex;
    nqm_argument_file *first; /* last used first */
};

static nqm_argument_files shared = {PTHREAD_MUTEX_INITIALIZER, NULL};
static bool is_shared;

void nqm_argument_files_share(void) {
    is_shared = true;
}

nqm_argument_files *nqm_argument_files_create(void) {
    nqm_argument_files *files = nqm_alloc(1, sizeof *files);
    if (files)
        pthread_mutex_init(&files->mutex, NULL);
    return files;
}

nqm_argument_file *nqm_argument_file_hold(nqm_argument_file *file) {
    if (file)
        atomic_fetch_add(&file->n_holders, 1);
    return file;
}

void nqm_argument_file_release(nqm_argument_file *file) {
    if (!file || atomic_fetch_sub(&file->n_holders, 1) > 1)
        return;
    nqm_materials_free(file->materials);
    nqm_free(file);
}

/* Release all but the last used ones and those that somebody holds. */
static void trim(nqm_argument_files *files) {
    size_t n = 0;
    for (nqm_argument_file **at = &files->first; *at;) {
        nqm_argument_file *file = *at;
        if (n++ < N_KEPT || atomic_load(&file->n_holders) > 1) {
            at = &file->next;
        } else {
            *at = file->next;
            nqm_argument_file_release(file);
        }
    }
}

void nqm_argument_files_free(nqm_argument_files *files) {
    if (!files)
        return;
    for (nqm_argument_file *file = files->first, *next; file; file = next) {
        next = file->next;
        nqm_argument_file_release(file);
    }
    pthread_mutex_destroy(&files->mutex);
    nqm_free(files);
}

/* Move the file of a path to the front; NULL: it is not there. */
static nqm_argument_file *find(nqm_argument_files *files, const char *path) {
    nqm_argument_file **at = &files->first;
    while (*at && strcmp((*at)->path, path) != 0)
        at = &(*at)->next;
    nqm_argument_file *found = *at;
    if (found) {
        *at = found->next;
        found->next = files->first;
        files->first = found;
    }
    return found;
}

/* Parse a material file, for one holder. */
static nqm_argument_file *parse(const nqm_map *map, nqm_error *err) {
    nqm_argument_file *file = nqm_alloc(1, sizeof *file + strlen(map->path) + 1);
    if (!file) {
        nqm_fail_nomem(err, sizeof *file);
        return NULL;
    }
    strcpy(file->path, map->path);
    atomic_init(&file->n_holders, 1);
    if (nqm_materials_read(map, &file->materials, err) == NQM_OK)
        return file;
    nqm_free(file);
    return NULL;
}

static void read_file(nqm_argument *a, const char *path, nqm_argument_files *files) {
    a->file = nqm_argument_file_hold(files ? find(files, path) : NULL);
    if (a->file || nqm_map_open_sparse(path, &a->map, &a->err) != NQM_OK)
        return;
    a->format = a->map.n_bytes ? nqm_brdf_format_of(&a->map) : NULL;
    if (a->format != &nqm_material_file_format)
        return;
    a->file = parse(&a->map, &a->err);
    nqm_map_close(&a->map);
    if (a->file && files) {
        a->file->next = files->first;
        files->first = nqm_argument_file_hold(a->file);
        trim(files);
    }
}

void nqm_argument_read(nqm_argument *a, nqm_argument_files *files) {
    files = is_shared ? &shared : files;
    if (files)
        pthread_mutex_lock(&files->mutex);
    read_file(a, a->network ? a->network : a->path, files);
    if (files)
        pthread_mutex_unlock(&files->mutex);
    if (a->file) {
        a->kind = NQM_ARGUMENT_MATERIAL;
        a->materials = a->file->materials;
    }
}
