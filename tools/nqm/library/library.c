/* SPDX-License-Identifier: MIT
 *
 * The implementation of library.h.
 */
#include "nqm/library/library.h"

#include "base/names.h"
#include "io/io.h"
#include "material/maps.h"
#include "model/model.h"

#include <ftw.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static char *copy_text(const char *text) {
    char *copy = strdup(text);
    if (!copy)
        stop(EXIT_LIMIT, "out of memory");
    return copy;
}

static void add_member(library *to, char *argument, char *key, bool is_left_out) {
    member *grown = nqm_grow(to->members, &to->max_n, to->n + 1, sizeof *grown);
    if (!grown)
        stop(EXIT_LIMIT, "out of memory");
    to->members = grown;
    to->members[to->n++] = (member){argument, key, is_left_out};
}

/* "A:B", or one of them where the other is "". */
static char *join(const char *a, const char *b) {
    char *text = allocate(strlen(a) + strlen(b) + 2, 1);
    sprintf(text, "%s%s%s", a, *a && *b ? ":" : "", b);
    return text;
}

/* key: what the names of its materials begin with; "": nothing. */
static void add_materials(library *to, const char *path, const nqm_materials *materials, const char *key) {
    const size_t n = nqm_materials_count(materials);
    for (size_t i = 0; i < n; ++i) {
        const nqm_material_info info = nqm_materials_reflecting(materials, i, ignored_set());
        char *argument = join(path, n > 1 ? info.name : "");
        if (info.ignorable && (info.spec || info.n_maps)) {
            char *plain = argument, prefix[NQM_IGNORE_SIZE + 10];
            snprintf(prefix, sizeof prefix, "ignore:%s", info.ignorable);
            argument = join(prefix, plain);
            free(plain);
        }
        add_member(to, argument, join(key, n > 1 || !*key ? info.name : ""), info.n_maps > 0);
    }
}

/* Files that are no material files are BRDFs if they have such a name. */
static bool is_brdf_name(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot && nqm_contains_word(".binary .bsdf .npy .safetensors .h5 .mat", dot, true);
}

static void add_file(library *to, const char *path, const char *key, bool is_only) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    if (nqm_materials_open(path, &materials, &err) == NQM_OK)
        add_materials(to, path, materials, is_only ? "" : key);
    else if (is_brdf_name(path))
        add_member(to, copy_text(path), copy_text(key), false);
    else if (is_only)
        stop_error(&err);
    nqm_materials_free(materials);
}

static nqm_names found; /* paths of the folder that is walked */

static int note_file(const char *path, const struct stat *st, int type, struct FTW *at) {
    (void)st;
    if (type == FTW_F && path[at->base] != '.' && nqm_names_add(&found, path, strlen(path), NULL) != NQM_OK)
        stop(EXIT_LIMIT, "out of memory");
    return interrupted();
}

static int compare_texts(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static void add_folder(library *to, const char *path) {
    const size_t n_before = to->n, n_path = strlen(path);
    found = (nqm_names){0};
    if (nftw(path, note_file, 16, FTW_PHYS) != 0)
        stop(interrupted() ? EXIT_INTERRUPTED : EXIT_OPEN, "%s: the folder cannot be read", path);
    const char **paths = allocate(found.n, sizeof *paths);
    for (size_t i = 0; i < found.n; ++i)
        paths[i] = nqm_name(&found, i);
    qsort(paths, found.n, sizeof *paths, compare_texts);
    for (size_t i = 0; i < found.n; ++i) {
        const char *key = paths[i] + n_path;
        if (show_progress(NULL, "read", (double)i, (double)found.n))
            stop(EXIT_INTERRUPTED, "interrupted");
        add_file(to, paths[i], key + strspn(key, "/"), false);
    }
    end_progress();
    free(paths);
    nqm_names_free(&found);
    if (to->n == n_before)
        stop(EXIT_OPEN, "%s: this folder has no file of materials or BRDFs", path);
}

void list_library(const char *path, library *to) {
    to->path = path;
    const char *slash = strrchr(path, '/');
    if (is_folder(path))
        add_folder(to, path);
    else if (strcmp(path, "/dev/null") != 0)
        add_file(to, path, slash ? slash + 1 : path, true);
}

void free_library(library *of) {
    for (size_t i = 0; i < of->n; ++i) {
        free(of->members[i].argument);
        free(of->members[i].key);
    }
    nqm_free(of->members);
    nqm_gallery_free(of->gallery);
    nqm_map_close(&of->index);
    nqm_free(of->block);
    *of = (library){.path = NULL};
}

/* ---- the index --------------------------------------------------------------------------------------------------- */

/* What pictures depend on: the model, and path, size and time of each file. */
static void identify(const library *of, const nqm_model *model, char hash[65]) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        stop(EXIT_LIMIT, "out of memory");
    nqm_sha256_add(&sha, nqm_model_get_info(model).sha256, 64);
    for (size_t i = 0; i < of->n; ++i) {
        const char *argument = of->members[i].argument, *name = member_name(argument);
        unsigned ignored;
        char *path = copy_text(argument + nqm_ignore_prefix(argument, &ignored));
        struct stat st = {0};
        if (name)
            path[strlen(path) - strlen(name) - 1] = 0;
        (void)!stat(path, &st);
        nqm_sha256_add(&sha, argument, strlen(argument) + 1);
        nqm_sha256_add_values(
            &sha, 3, sizeof(int64_t),
            (int64_t[]){(int64_t)st.st_size, (int64_t)st.st_mtim.tv_sec, (int64_t)st.st_mtim.tv_nsec});
        free(path);
    }
    nqm_sha256_end(&sha, hash);
}

/* Use the pictures of the index file; false: there is none that fits. */
static bool read_index(library *of, const nqm_model *model, const char *path, const char *hash) {
    nqm_safetensors *st = NULL;
    nqm_gallery *none;
    size_t n_floats;
    nqm_error err = {0};
    must(nqm_gallery_create(model, 0, NULL, &none, &err), &err);
    nqm_gallery_pictures(none, &n_floats);
    nqm_gallery_free(none);
    if (!is_file(path) || nqm_map_open_own(path, &of->index, NULL) != NQM_OK)
        return false;
    const nqm_tensor *t = NULL;
    if (nqm_safetensors_parse(of->index.data, of->index.n_bytes, path, &st, NULL) == NQM_OK)
        t = nqm_safetensors_find(st, "pictures");
    const char *stored = t ? nqm_safetensors_meta(st, "library") : NULL;
    const bool fits = stored && strcmp(stored, hash) == 0 && t->dtype == NQM_F32 && t->n_dims == 2 &&
                      t->dims[0] == of->n && t->dims[1] == n_floats && (uintptr_t)t->data % sizeof(float) == 0;
    if (fits)
        must(nqm_gallery_create(model, of->n, t->data, &of->gallery, &err), &err);
    of->block = fits ? nqm_safetensors_take(st) : NULL;
    nqm_safetensors_free(st);
    if (!fits)
        nqm_map_close(&of->index);
    return fits;
}

static void write_index(const library *of, const char *path, const char *hash) {
    size_t n_floats;
    nqm_error err = {0};
    const float *pictures = nqm_gallery_pictures(of->gallery, &n_floats);
    nqm_tensor tensor = {
        .name = "pictures", .dtype = NQM_F32, .n_dims = 2, .dims = {of->n, n_floats}, .data = pictures};
    if (!nqm_tensor_measure(&tensor))
        stop(EXIT_LIMIT, "%s: %zu pictures are too many", path, of->n);
    const nqm_meta meta[] = {{"format", "nqm-index"}, {"library", hash}};
    must(nqm_safetensors_write(path, 1, &tensor, 2, meta, NULL, &err), &err);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* Remove those that are left out. Returns how many. */
static size_t compact(library *of) {
    size_t n = 0;
    for (size_t i = 0; i < of->n; ++i) {
        if (of->members[i].is_left_out) {
            free(of->members[i].argument);
            free(of->members[i].key);
        } else {
            of->members[n++] = of->members[i];
        }
    }
    const size_t n_removed = of->n - n;
    of->n = n;
    return n_removed;
}

/* Draw the members. Returns how many have no values. */
static size_t draw_all(library *of, nqm_scorer *scorer, nqm_gallery *gallery) {
    enum { BLOCK = NQM_SCORE_BLOCK, MOST_SHOWN = 5 };
    size_t n_failed = 0;
    for (size_t begin = 0, n; begin < of->n; begin += n) {
        const char *names[BLOCK];
        nqm_error errors[BLOCK], err = {0};
        n = nqm_smaller(of->n - begin, BLOCK);
        if (show_progress(NULL, "sample", (double)begin, (double)of->n))
            stop(EXIT_INTERRUPTED, "interrupted");
        for (size_t i = 0; i < n; ++i)
            names[i] = of->members[begin + i].argument;
        must(nqm_scorer_draw(scorer, n, names, gallery, begin, errors, &err), &err);
        for (size_t i = 0; i < n; ++i) {
            of->members[begin + i].is_left_out = errors[i].status != NQM_OK;
            if (errors[i].status != NQM_OK && n_failed++ < MOST_SHOWN)
                report_error(&errors[i]);
        }
    }
    end_progress();
    if (n_failed > MOST_SHOWN)
        report(EXIT_PARTIAL, "%zu more materials are left out", n_failed - MOST_SHOWN);
    return n_failed;
}

size_t draw_library(library *of, const nqm_model *model, nqm_scorer *scorer, const char *index) {
    nqm_error err = {0};
    char hash[65] = "";
    const size_t n_textured = compact(of);
    if (n_textured)
        report(EXIT_OK, "%s: %zu textured material%s left out: `nqm score` and `nqm diff` compare them", of->path,
               n_textured, n_textured > 1 ? "s are" : " is");
    if (index)
        identify(of, model, hash);
    if (index && read_index(of, model, index, hash))
        return 0;
    must(nqm_gallery_create(model, of->n, NULL, &of->gallery, &err), &err);
    const size_t n_failed = draw_all(of, scorer, of->gallery);
    if (n_failed) { /* once more without them; most samples are in the cache */
        compact(of);
        nqm_gallery_free(of->gallery);
        must(nqm_gallery_create(model, of->n, NULL, &of->gallery, &err), &err);
        draw_all(of, scorer, of->gallery);
    } else if (index) {
        write_index(of, index, hash);
    }
    return n_failed;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

/* The network corrects the Delta-E of the estimate by less than this factor in 99.9 % of pairs with a JOD above 9 (doc/batch.md). */
double least_estimate(double jod) {
    static const double factor = 2.5;
    const nqm_curve *curve = &nqm_curve_published;
    double low = 0, high = 1000;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        *(nqm_curve_jod(curve, middle) > jod ? &low : &high) = middle;
    }
    return nqm_curve_jod(curve, factor * high);
}

typedef struct row_job {
    const library *of;
    double least;
    near_pair **rows;     /* (n) */
    size_t *n_rows;       /* (n) */
    atomic_bool is_short; /* of memory */
} row_job;

static void find_row(void *user, size_t a) {
    row_job *job = user;
    enum { BLOCK = 1024 };
    float jod[BLOCK];
    size_t max_n = 0;
    for (size_t begin = a + 1, n; begin < job->of->n; begin += n) {
        n = nqm_smaller(job->of->n - begin, BLOCK);
        nqm_gallery_jods(job->of->gallery, a, job->of->gallery, begin, n, false, jod);
        for (size_t i = 0; i < n; ++i) {
            if ((double)jod[i] < job->least)
                continue;
            near_pair *grown = nqm_grow(job->rows[a], &max_n, job->n_rows[a] + 1, sizeof *grown);
            if (!grown) {
                job->is_short = true;
                return;
            }
            job->rows[a] = grown;
            grown[job->n_rows[a]++] = (near_pair){a, begin + i, jod[i]};
        }
    }
}

size_t find_near_pairs(const library *of, double jod, near_pair **pairs) {
    row_job job = {.of = of, .least = least_estimate(jod)};
    job.rows = allocate(of->n, sizeof *job.rows);
    job.n_rows = allocate(of->n, sizeof *job.n_rows);
    nqm_ticker ticker = {.fn = show_progress};
    if (nqm_parallel_ticking(&ticker, "compare", of->n, find_row, &job))
        stop(EXIT_INTERRUPTED, "interrupted");
    if (job.is_short)
        stop(EXIT_LIMIT, "out of memory");
    size_t n = 0;
    for (size_t a = 0; a < of->n; ++a)
        n += job.n_rows[a];
    *pairs = allocate(n, sizeof **pairs);
    n = 0;
    for (size_t a = 0; a < of->n; ++a) {
        if (job.n_rows[a])
            memcpy(*pairs + n, job.rows[a], job.n_rows[a] * sizeof **pairs);
        n += job.n_rows[a];
        nqm_free(job.rows[a]);
    }
    free(job.rows);
    free(job.n_rows);
    end_progress();
    return n;
}

void score_rows(score_run *run, size_t n, const nqm_named_pair *pairs, const char *const *names) {
    free(run->rows);
    run->n_rows = n;
    run->rows = allocate(n, sizeof *run->rows);
    for (size_t i = 0; i < n; ++i)
        run->rows[i] = (scored_pair){.pair = pairs[i], .name = names[i]};
    make_scores(run);
}
