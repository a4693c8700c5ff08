/* SPDX-License-Identifier: MIT
 *
 * os.h for POSIX systems. What only some of them have (reading from the page cache, advice, huge pages) is left out on the others.
 */
/* NOLINTBEGIN(bugprone-reserved-identifier): the feature-test macros of the C libraries */
#define _GNU_SOURCE      /* preadv2 */
#define _DARWIN_C_SOURCE /* flock */
/* NOLINTEND(bugprone-reserved-identifier) */
#include "base/os.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <locale.h>
#include <omp.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>
#ifdef __APPLE__
#include <xlocale.h>
#define st_mtim st_mtimespec
#endif

/* ---- what a path names ------------------------------------------------------------------------------------------- */

static bool take_info(bool is_found, const struct stat *st, nqm_file_info *info_ret) {
    if (is_found)
        *info_ret = (nqm_file_info){.kind = S_ISREG(st->st_mode)    ? NQM_FILE_REGULAR
                                            : S_ISDIR(st->st_mode)  ? NQM_FILE_FOLDER
                                            : S_ISFIFO(st->st_mode) ? NQM_FILE_PIPE
                                                                    : NQM_FILE_DEVICE,
                                    .volume = (uint64_t)st->st_dev,
                                    .number = (uint64_t)st->st_ino,
                                    .n_bytes = (int64_t)st->st_size,
                                    .changed_s = (int64_t)st->st_mtim.tv_sec,
                                    .changed_ns = (int64_t)st->st_mtim.tv_nsec};
    return is_found;
}

bool nqm_os_get_info(const char *path, nqm_file_info *info_ret) {
    struct stat st;
    return take_info(stat(path, &st) == 0, &st, info_ret);
}

bool nqm_os_get_info_of(int file, nqm_file_info *info_ret) {
    struct stat st;
    return take_info(fstat(file, &st) == 0, &st, info_ret);
}

bool nqm_os_exists(const char *path) {
    return access(path, F_OK) == 0;
}

bool nqm_os_is_folder(const char *path) {
    struct stat st;
    return stat(path, &st) == 0 && S_ISDIR(st.st_mode);
}

bool nqm_os_is_link(const char *path) {
    struct stat st;
    return lstat(path, &st) == 0 && S_ISLNK(st.st_mode);
}

bool nqm_os_is_device(const char *path) {
    return strncmp(path, "/dev/", 5) == 0;
}

bool nqm_os_is_writable(const char *path) {
    struct stat st;
    return access(path, W_OK) == 0 && stat(path, &st) == 0 && (!S_ISREG(st.st_mode) || st.st_mode & 0222);
}

char *nqm_os_real_path(const char *path) {
    return realpath(path, NULL);
}

/* ---- files and folders ------------------------------------------------------------------------------------------- */

bool nqm_os_replace(const char *from, const char *to) {
    return rename(from, to) == 0;
}

bool nqm_os_remove(const char *path) {
    return unlink(path) == 0;
}

bool nqm_os_remove_folder(const char *path) {
    return rmdir(path) == 0;
}

bool nqm_os_make_folder(const char *path) {
    return mkdir(path, 0777) == 0;
}

bool nqm_os_enter_folder(const char *path) {
    return chdir(path) == 0;
}

static int by_bytes(const struct dirent **a, const struct dirent **b) {
    return strcmp((*a)->d_name, (*b)->d_name);
}

nqm_status nqm_os_list_folder(const char *path, nqm_names *names, nqm_error *err) {
    struct dirent **files;
    const int n = scandir(path, &files, NULL, by_bytes);
    if (n < 0)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: the folder cannot be read", path);
    nqm_status status = NQM_OK;
    for (int i = 0; i < n; ++i) {
        const char *name = files[i]->d_name;
        if (status == NQM_OK && strcmp(name, ".") != 0 && strcmp(name, "..") != 0)
            status = nqm_names_add(names, name, strlen(name), err);
        free(files[i]);
    }
    free(files);
    return status;
}

int nqm_os_open(const char *path, nqm_open_mode mode) {
    static const int flags[] = {[NQM_OPEN_READ] = O_RDONLY | O_NONBLOCK,
                                [NQM_OPEN_WRITE] = O_WRONLY | O_NOFOLLOW | O_NONBLOCK,
                                [NQM_OPEN_CREATE] = O_WRONLY | O_CREAT,
                                [NQM_OPEN_EMPTY] = O_WRONLY | O_CREAT | O_TRUNC};
    return open(path, flags[mode] | O_CLOEXEC, 0666);
}

/* A new file has the permissions that the umask leaves; one like a private file is private from the beginning. */
int nqm_os_open_new(const char *path, const char *like) {
    struct stat st;
    const bool exists = stat(like, &st) == 0;
    const int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, exists ? st.st_mode & 0666 : 0666);
    if (file >= 0 && exists)
        (void)fchmod(file, st.st_mode & 0777); /* a file system without permissions refuses */
    return file;
}

FILE *nqm_os_open_text(const char *path) {
    return fopen(path, "rb");
}

FILE *nqm_os_stream(int file) {
    return fdopen(file, "wb");
}

bool nqm_os_sync(FILE *stream) {
    return fsync(fileno(stream)) == 0;
}

bool nqm_os_truncate(FILE *stream) {
    return ftruncate(fileno(stream), ftello(stream)) == 0;
}

FILE *nqm_os_temporary(char path[NQM_TEMPORARY_PATH]) {
    FILE *stream = tmpfile();
    if (stream)
        snprintf(path, NQM_TEMPORARY_PATH, "/dev/fd/%d", fileno(stream));
    return stream;
}

void nqm_os_close(int file) {
    close(file);
}

/* flock() also works over NFS, as a lock of the server. */
nqm_lock nqm_os_lock(int file, const char *path) {
    struct stat open_file, named;
    const bool is_locked = flock(file, LOCK_EX | LOCK_NB) == 0;
    if (!is_locked && errno == EWOULDBLOCK)
        return NQM_LOCK_HELD;
    if (fstat(file, &open_file) != 0 || stat(path, &named) != 0 || open_file.st_dev != named.st_dev ||
        open_file.st_ino != named.st_ino)
        return NQM_LOCK_GONE;
    return is_locked ? NQM_LOCK_TAKEN : NQM_LOCK_UNSUPPORTED;
}

void nqm_os_advise(int file, size_t offset, size_t n, nqm_advice advice) {
#ifdef POSIX_FADV_NORMAL
    static const int advices[] = {[NQM_ADVICE_NORMAL] = POSIX_FADV_NORMAL,
                                  [NQM_ADVICE_RANDOM] = POSIX_FADV_RANDOM,
                                  [NQM_ADVICE_SOON] = POSIX_FADV_WILLNEED};
    (void)posix_fadvise(file, (off_t)offset, (off_t)n, advices[advice]);
#else
    (void)file, (void)offset, (void)n, (void)advice;
#endif
}

bool nqm_os_read_at(int file, size_t offset, size_t n, void *out, bool is_cached) {
#ifdef RWF_NOWAIT
    const struct iovec to = {.iov_base = out, .iov_len = n};
    if (is_cached)
        return preadv2(file, &to, 1, (off_t)offset, RWF_NOWAIT) == (ssize_t)n;
#endif
    return !is_cached && pread(file, out, n, (off_t)offset) == (ssize_t)n;
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

void *nqm_os_alloc(size_t alignment, size_t n) {
    return aligned_alloc(alignment, n);
}

void *nqm_os_realloc(void *block, size_t n) {
    return realloc(block, n);
}

void nqm_os_free(void *block) {
    free(block);
}

void *nqm_os_map(int file, size_t n) {
    void *pages = mmap(NULL, n, PROT_READ, MAP_PRIVATE, file, 0);
    return pages == MAP_FAILED ? NULL : pages;
}

void nqm_os_advise_pages(const void *pages, size_t n, nqm_advice advice) {
    static const int advices[] = {[NQM_ADVICE_NORMAL] = POSIX_MADV_NORMAL,
                                  [NQM_ADVICE_RANDOM] = POSIX_MADV_RANDOM,
                                  [NQM_ADVICE_SOON] = POSIX_MADV_WILLNEED};
    (void)posix_madvise((void *)(uintptr_t)pages, n, advices[advice]);
}

void *nqm_os_alloc_pages(size_t n) {
    void *pages = mmap(NULL, n, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED)
        return NULL;
#ifdef MADV_HUGEPAGE
    (void)madvise(pages, n, MADV_HUGEPAGE); /* advice only, failure is harmless */
#endif
    return pages;
}

void nqm_os_free_pages(const void *pages, size_t n) {
    munmap((void *)(uintptr_t)pages, n);
}

/* ---- the rest ---------------------------------------------------------------------------------------------------- */

FILE *nqm_os_memory_stream(char **text, size_t *n) {
    return open_memstream(text, n);
}

bool nqm_os_close_memory(FILE *stream, char **text, size_t *n) {
    const bool is_complete = !ferror(stream);
    if (fclose(stream) == 0 && is_complete)
        return true;
    free(*text);
    *text = NULL;
    *n = 0;
    return false;
}

static pthread_once_t once = PTHREAD_ONCE_INIT;
static locale_t c_locale; /* created once and never freed: a few hundred bytes */

static void make_c_locale(void) {
    c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

void *nqm_os_enter_c_locale(void) {
    pthread_once(&once, make_c_locale);
    return uselocale(c_locale);
}

void nqm_os_leave_locale(void *before) {
    uselocale(before);
}

double nqm_clock_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void nqm_os_sleep(double seconds) {
    const time_t whole = (time_t)seconds;
    nanosleep(&(struct timespec){.tv_sec = whole, .tv_nsec = (long)(1e9 * (seconds - (double)whole))}, NULL);
}

size_t nqm_os_l2_bytes(void) {
#ifdef _SC_LEVEL2_CACHE_SIZE
    const long n = sysconf(_SC_LEVEL2_CACHE_SIZE);
    return n > 0 ? (size_t)n : 0;
#else
    return 0;
#endif
}

bool nqm_dynamic_load(const char *soname, size_t n, const char *const *names, void *functions) {
    void *handle = dlopen(soname, RTLD_NOW | RTLD_LOCAL);
    bool found = handle != NULL;
    for (size_t i = 0; i < n && found; ++i) {
        void *address = dlsym(handle, names[i]);
        /* ISO C has no conversion from void * to a function pointer; POSIX guarantees that the bytes are the same. */
        memcpy((char *)functions + i * sizeof address, &address, sizeof address);
        found = address != NULL;
    }
    return found;
}

static void use_one_thread(void) {
    omp_set_num_threads(1);
}

/* The child of fork() has one thread; OpenMP's runtime would wait there for those of the parent. */
__attribute__((constructor)) static void prepare_for_fork(void) {
    (void)pthread_atfork(NULL, NULL, use_one_thread);
}
