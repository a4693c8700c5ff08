/* SPDX-License-Identifier: MIT
 *
 * The implementation of library.h.
 */
#include "nqm/library/library.h"

#include "base/names.h"
#include "io/io.h"
#include "material/maps.h"
#include "model/model.h"
#include "nqm/textured.h"

#include <ftw.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static void add_member(library *to, char *argument, char *key, bool is_textured) {
    to->members = must_have(nqm_grow(to->members, &to->max_n, to->n + 1, sizeof *to->members));
    to->members[to->n++] = (member){argument, key, is_textured, false};
}

member member_of(const char *argument) {
    return (member){(char *)(uintptr_t)argument, NULL, is_textured(argument), false};
}

/* key: what the names of its materials begin with; "": nothing. */
static void add_materials(library *to, const char *path, const nqm_materials *materials, const char *key) {
    const size_t n = nqm_materials_count(materials);
    for (size_t i = 0; i < n; ++i) {
        const nqm_material_info info = nqm_materials_reflecting(materials, i, ignored_set());
        char *argument = join_with_colon(path, n > 1 ? info.name : "");
        if (info.ignorable && (info.spec || info.n_maps)) {
            char *plain = argument, prefix[NQM_IGNORE_SIZE + 10];
            snprintf(prefix, sizeof prefix, "ignore:%s", info.ignorable);
            argument = join_with_colon(prefix, plain);
            free(plain);
        }
        add_member(to, argument, join_with_colon(key, n > 1 || !*key ? info.name : ""), info.n_maps > 0);
    }
}

static bool ends_with(const char *path, const char *extensions) {
    const char *dot = strrchr(path, '.');
    return dot && nqm_contains_word(extensions, dot, true);
}

/* not_read: NQM_REMARK_SIZE characters; files of a folder that may be meant are added. */
static void add_file(library *to, const char *path, const char *key, bool is_only, char *not_read) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    if (nqm_materials_open(path, &materials, &err) == NQM_OK)
        add_materials(to, path, materials, is_only ? "" : key);
    else if (ends_with(path, ".binary .bsdf .npy .safetensors .h5 .mat") ||
             (ends_with(path, ".csv") && nqm_brdf_probe(path)))
        add_member(to, must_have(strdup(path)), must_have(strdup(key)), false);
    else if (is_only)
        stop_error(&err);
    else if (ends_with(path, ".mtlx .gltf .glb .pbrt")) { /* damaged; others of a folder need not be materials */
        report_error(&err);
        ++to->n_failed;
    } else if (ends_with(path, ".csv .txt .xml .json .usd .usda .usdc .usdz .zip .pth .npz"))
        nqm_remark_add(not_read, NQM_REMARK_SIZE, "%s", key);
    nqm_materials_free(materials);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static nqm_names found; /* paths of the folder that is walked */

static void add_found(const char *path) {
    if (nqm_names_add(&found, path, strlen(path), NULL) != NQM_OK)
        stop(EXIT_LIMIT, "out of memory");
}

static int note_file(const char *path, const struct stat *st, int type, struct FTW *at) {
    (void)st;
    if (type == FTW_F && path[at->base] != '.')
        add_found(path);
    return interrupted();
}

static int compare_texts(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* The files of a library in the order of their paths; "/dev/null" has none. free() both. */
typedef struct file_list {
    size_t n;
    const char **paths; /* (n) */
    nqm_names text;
} file_list;

static file_list list_files(size_t n, const char *const *where) {
    found = (nqm_names){0};
    for (size_t i = 0; i < n; ++i) {
        nqm_argument *a = parse_argument(where[i]);
        const char *path = a->rest; /* --ignore is asked for each material */
        if (!is_folder(path) && strcmp(path, "/dev/null") != 0)
            add_found(path);
        if (is_folder(path) && nftw(path, note_file, 16, FTW_PHYS) != 0)
            stop(interrupted() ? EXIT_INTERRUPTED : EXIT_OPEN, "%s: the folder cannot be read", path);
        nqm_argument_free(a);
    }
    file_list files = {0, allocate(found.n, sizeof *files.paths), found};
    for (size_t i = 0; i < found.n; ++i)
        files.paths[i] = nqm_name(&found, i);
    qsort(files.paths, found.n, sizeof *files.paths, compare_texts);
    for (size_t i = 0; i < found.n; ++i) /* each once */
        if (i == 0 || strcmp(files.paths[i], files.paths[files.n - 1]) != 0)
            files.paths[files.n++] = files.paths[i];
    return files;
}

static void free_files(file_list *files) {
    free(files->paths);
    nqm_names_free(&files->text);
}

/* n: of the arguments; materials of several are named by their whole paths. */
static void add_files(library *to, size_t n, const file_list *files) {
    const bool is_only = n == 1 && !is_folder(to->path);
    const char *slash = strrchr(to->path, '/');
    const size_t n_key = n > 1 ? 0 : !is_only ? strlen(to->path) : slash ? (size_t)(slash - to->path) : 0;
    char not_read[NQM_REMARK_SIZE] = "";
    for (size_t i = 0; i < files->n; ++i) {
        const char *key = files->paths[i] + n_key;
        step_progress("read", i, files->n);
        add_file(to, files->paths[i], n > 1 ? key : key + strspn(key, "/"), is_only, not_read);
    }
    end_progress();
    if (*not_read)
        report(EXIT_OK, "%s: these files are no materials or BRDFs: %s", shown(to->path), not_read);
    if (to->n == 0 && !is_only)
        stop(EXIT_OPEN, "%s: no file of materials or BRDFs is there", to->path);
}

void list_library(const char *path, library *to) {
    to->path = path;
    file_list files = list_files(1, &path);
    add_files(to, 1, &files);
    free_files(&files);
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

/* Of n bytes, and of path, size and time of each file. */
static void hash_files(const file_list *files, const char *bytes, size_t n, char hash[65]) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        stop(EXIT_LIMIT, "out of memory");
    nqm_sha256_add(&sha, bytes, n);
    for (size_t i = 0; i < files->n; ++i) {
        struct stat st = {0};
        (void)!stat(files->paths[i], &st);
        nqm_sha256_add(&sha, files->paths[i], strlen(files->paths[i]) + 1);
        nqm_sha256_add_values(
            &sha, 3, sizeof(int64_t),
            (int64_t[]){(int64_t)st.st_size, (int64_t)st.st_mtim.tv_sec, (int64_t)st.st_mtim.tv_nsec});
    }
    nqm_sha256_end(&sha, hash);
}

/* What an index depends on: the model, what is ignored, and the files. */
static void identify(const file_list *files, const nqm_model *model, char hash[65]) {
    char bytes[65];
    snprintf(bytes, sizeof bytes, "%.64s", nqm_model_get_info(model).sha256);
    bytes[64] = (char)ignored_set();
    hash_files(files, bytes, sizeof bytes, hash);
}

/* Remove the members that are left out. */
static void compact(library *of) {
    size_t n = 0;
    for (size_t i = 0; i < of->n; ++i) {
        if (of->members[i].is_left_out) {
            free(of->members[i].argument);
            free(of->members[i].key);
        } else {
            of->members[n++] = of->members[i];
        }
    }
    of->n = n;
}

/* The tensors of an index: arguments and keys of the members with values, each with a NUL, the key after a 't' if the
 * member is textured; their pictures; and the files of the maps
 * of textured members, each with a NUL. */
enum { NAMES, PICTURES, MAPS, N_TENSORS };
static const char *const tensor_names[N_TENSORS] = {"names", "pictures", "maps"};

static void put_path(void *stream, const char *path) {
    fprintf(stream, "%s%c", path, 0);
}

/* The files that an argument reads. */
static void put_files(const char *argument, FILE *to) {
    nqm_argument *a = parse_argument(argument);
    nqm_argument_visit_files(a, put_path, to);
    nqm_argument_free(a);
}

/* Sizes and times of the files in a text of n bytes. */
static void hash_maps(const char *text, size_t n, char hash[65]) {
    file_list files = {0};
    for (size_t at = 0; at < n; at += strlen(text + at) + 1)
        ++files.n;
    files.paths = allocate(files.n, sizeof *files.paths);
    for (size_t at = 0, i = 0; at < n; at += strlen(text + at) + 1)
        files.paths[i++] = text + at;
    hash_files(&files, "", 0, hash);
    free(files.paths);
}

/* The members of an index. Returns whether the text has two names for each of n. */
static bool take_members(library *of, const nqm_tensor *names, size_t n) {
    const char *at = names->data, *end = at + names->n_bytes;
    for (size_t i = 0; i < n; ++i) {
        const char *middle = memchr(at, 0, (size_t)(end - at));
        const char *last = middle ? memchr(middle + 1, 0, (size_t)(end - middle - 1)) : NULL;
        if (!last || last < middle + 2)
            return false;
        add_member(of, must_have(strdup(at)), must_have(strdup(middle + 2)), middle[1] == 't');
        at = last + 1;
    }
    return at == end;
}

/* Use the members and pictures of a parsed index; false: they are not those of these files. */
static bool take_index(library *of, const nqm_model *model, const nqm_safetensors *st, const char *hash) {
    const nqm_tensor *names = nqm_safetensors_find(st, tensor_names[NAMES]),
                     *pictures = nqm_safetensors_find(st, tensor_names[PICTURES]),
                     *maps = nqm_safetensors_find(st, tensor_names[MAPS]);
    const char *stored = nqm_safetensors_meta(st, "library"), *failed = nqm_safetensors_meta(st, "failed"),
               *of_maps = nqm_safetensors_meta(st, "map-files");
    char hash_now[65];
    if (!stored || strcmp(stored, hash) != 0 || !failed || !names || names->dtype != NQM_U8 || !pictures ||
        pictures->dtype != NQM_F32 || pictures->n_dims != 2 || pictures->dims[1] != nqm_gallery_size(model) ||
        (uintptr_t)pictures->data % sizeof(float) != 0 || !nqm_tensor_all_finite(pictures) ||
        !take_members(of, names, pictures->dims[0]) || !maps || maps->dtype != NQM_U8 || maps->n_bytes == 0 ||
        ((const char *)maps->data)[maps->n_bytes - 1] || !of_maps)
        return false;
    hash_maps(maps->data, maps->n_bytes, hash_now);
    if (strcmp(hash_now, of_maps) != 0)
        return false;
    of->n_failed = strtoul(failed, NULL, 10);
    must(nqm_gallery_create(model, of->n, pictures->data, &of->gallery, &fault));
    return true;
}

static bool read_index(library *of, const nqm_model *model, const char *path, const char *hash) {
    nqm_safetensors *st = NULL;
    if (nqm_map_open_own(path, &of->index, NULL) != NQM_OK)
        return false;
    const bool is_read = nqm_safetensors_parse(of->index.data, of->index.n_bytes, path, &st, NULL) == NQM_OK;
    const char *format = is_read ? nqm_safetensors_meta(st, "format") : NULL;
    if (!format || strcmp(format, "nqm-index") != 0)
        stop(EXIT_USAGE, "%s: is no index that nqm has written, and is not replaced: remove it or name another file",
             path);
    const bool fits = take_index(of, model, st, hash);
    of->block = fits ? nqm_safetensors_take(st) : NULL;
    nqm_safetensors_free(st);
    if (!fits) {
        const char *folder = of->path;
        free_library(of);
        of->path = folder;
    }
    return fits;
}

static void write_index(const library *of, const nqm_model *model, const char *path, const char *hash) {
    char *text, *files, failed[24], of_maps[65];
    size_t n_text, n_files;
    FILE *names = open_text(&text, &n_text), *maps = open_text(&files, &n_files);
    put_path(maps, ""); /* a tensor has elements */
    for (size_t i = 0; i < of->n; ++i) {
        fprintf(names, "%s%c%c%s%c", of->members[i].argument, 0, of->members[i].is_textured ? 't' : '-',
                of->members[i].key, 0);
        if (of->members[i].is_textured)
            put_files(of->members[i].argument, maps);
    }
    if (fclose(names) != 0 || fclose(maps) != 0)
        stop(EXIT_LIMIT, "out of memory");
    hash_maps(files, n_files, of_maps);
    snprintf(failed, sizeof failed, "%zu", of->n_failed);
    nqm_tensor tensors[N_TENSORS] = {
        {.name = tensor_names[NAMES], .dtype = NQM_U8, .n_dims = 1, .dims = {n_text}, .data = text},
        {.name = tensor_names[PICTURES],
         .dtype = NQM_F32,
         .n_dims = 2,
         .dims = {of->n, nqm_gallery_size(model)},
         .data = nqm_gallery_pictures(of->gallery)},
        {.name = tensor_names[MAPS], .dtype = NQM_U8, .n_dims = 1, .dims = {n_files}, .data = files}};
    const nqm_meta meta[] = {{"format", "nqm-index"}, {"library", hash}, {"failed", failed}, {"map-files", of_maps}};
    if (!nqm_tensor_measure(&tensors[NAMES]) || !nqm_tensor_measure(&tensors[PICTURES]) ||
        !nqm_tensor_measure(&tensors[MAPS]))
        stop(EXIT_LIMIT, "%s: %zu pictures are too many", path, of->n);
    must(nqm_safetensors_write(path, N_TENSORS, tensors, sizeof meta / sizeof *meta, meta, NULL, &fault));
    free(text);
    free(files);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* Texels at the same positions of every surface, without the tilts of their normals, which only the scores know. */
static nqm_status draw_texture(const char *argument, const nqm_model *model, nqm_scorer *scorer, nqm_gallery *gallery,
                               size_t at, nqm_error *err) {
    enum { SIDE = 8, N = SIDE * SIDE };
    char *specs[N] = {NULL};
    double u[N], v[N];
    nqm_error errors[N];
    nqm_texture *texture = NULL;
    nqm_gallery *texels = NULL;
    nqm_status status = open_texture_named(argument, &texture, err);
    if (status != NQM_OK)
        return status;
    float *rows = allocate((size_t)texture->n_rows * NQM_TEXEL_BLOCK + 1, sizeof *rows);
    for (size_t i = 0; i < N; ++i) {
        u[i] = ((double)(i % SIDE) + 0.5) / SIDE;
        v[i] = ((double)(i / SIDE) + 0.5) / SIDE;
    }
    nqm_texture_evaluate(texture, N, u, v, rows);
    for (size_t i = 0; i < N; ++i)
        specs[i] = must_have(nqm_texture_spec(texture, rows, i));
    must(nqm_gallery_create(model, N, NULL, &texels, &fault));
    must(nqm_scorer_draw(scorer, N, (const char *const *)specs, texels, 0, errors, &fault));
    for (size_t i = 0; i < N; ++i) {
        if (status == NQM_OK && errors[i].status != NQM_OK) {
            *err = errors[i];
            status = err->status;
        }
        nqm_free(specs[i]);
    }
    nqm_gallery_average(gallery, at, texels, N);
    nqm_gallery_free(texels);
    free(rows);
    nqm_texture_free(texture);
    return status;
}

void draw_member(const member *m, const nqm_model *model, nqm_scorer *scorer, nqm_gallery *gallery, size_t at,
                 nqm_error *err) {
    const char *name = m->argument;
    *err = (nqm_error){0};
    if (m->is_textured)
        err->status = draw_texture(name, model, scorer, gallery, at, err);
    else
        must(nqm_scorer_draw(scorer, 1, &name, gallery, at, err, &fault));
    if (err->status == NQM_ERR_CANCELLED)
        stop(EXIT_INTERRUPTED, "interrupted");
}

/* Draw n members, or one that is textured; those without values are left out, and the others drawn again without them. Returns how many
 * are drawn. */
static size_t draw_block(library *of, const nqm_model *model, nqm_scorer *scorer, size_t begin, size_t n,
                         size_t first) {
    enum { MOST_SHOWN = 5 };
    const char *names[NQM_SCORE_BLOCK];
    nqm_error errors[NQM_SCORE_BLOCK];
    size_t n_good = 0;
    for (size_t i = 0; i < n; ++i)
        names[i] = of->members[begin + i].argument;
    if (of->members[begin].is_textured)
        draw_member(&of->members[begin], model, scorer, of->gallery, first, errors);
    else
        must(nqm_scorer_draw(scorer, n, names, of->gallery, first, errors, &fault));
    for (size_t i = 0; i < n; ++i) {
        of->members[begin + i].is_left_out = errors[i].status != NQM_OK;
        if (errors[i].status == NQM_OK)
            names[n_good++] = names[i];
        else if (of->n_failed++ < MOST_SHOWN)
            report_error(&errors[i]);
    }
    if (n_good && n_good < n) /* their samples are in the cache */
        must(nqm_scorer_draw(scorer, n_good, names, of->gallery, first, errors, &fault));
    return n_good;
}

static void draw_all(library *of, const nqm_model *model, nqm_scorer *scorer) {
    size_t n_drawn = 0;
    must(nqm_gallery_create(model, of->n, NULL, &of->gallery, &fault));
    for (size_t begin = 0, n; begin < of->n; begin += n) {
        const size_t n_left = nqm_smaller(of->n - begin, NQM_SCORE_BLOCK);
        n = 1;
        while (n < n_left && !of->members[begin].is_textured && !of->members[begin + n].is_textured)
            ++n;
        step_progress("sample", begin, of->n);
        n_drawn += draw_block(of, model, scorer, begin, n, n_drawn);
    }
    end_progress();
    compact(of);
}

void draw_library(size_t n, const char *const *where, const nqm_model *model, nqm_scorer *scorer, const char *index,
                  library *to) {
    static char several[40];
    char hash[65] = "";
    snprintf(several, sizeof several, "%zu files and folders", n);
    const char *path = to->path = n > 1 ? several : where[0];
    file_list files = list_files(n, where);
    if (index)
        identify(&files, model, hash);
    if (!index || !read_index(to, model, index, hash)) {
        add_files(to, n, &files);
        draw_all(to, model, scorer);
        if (index)
            write_index(to, model, index, hash);
    }
    free_files(&files);
    if (to->n_failed)
        report(EXIT_PARTIAL, "%s: %zu of %zu materials have no values and are left out", path, to->n_failed,
               to->n + to->n_failed);
}

double score_textured(const nqm_named_pair *pair, const nqm_model *with) {
    const texture_terms terms = {.model = with, .near_only = true};
    kept_texture ref = {.name = NULL};
    nqm_texture_result t;
    nqm_score_result r = {.jod = NAN};
    nqm_error err;
    float *heat = NULL;
    score_texture(&terms, pair, &ref, &t, &r, &heat, &err);
    nqm_texture_free(ref.texture);
    return err.status == NQM_OK ? r.jod : NAN;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

/* The network corrects the Delta-E of estimates: of 152 pairs of glTF materials with a JOD above 9 by at most 4 %. */
double least_estimate(double jod) {
    static const double factor = 2;
    return nqm_curve_jod(&nqm_curve_published, factor * nqm_curve_delta_e(&nqm_curve_published, jod));
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

void begin_rows(score_run *run, size_t n) {
    free(run->rows);
    run->n_rows = n;
    run->rows = allocate(n, sizeof *run->rows);
}
