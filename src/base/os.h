/* SPDX-License-Identifier: MIT
 *
 * os.h - what ISO C does not have: files and folders, locks, pages of memory, texts as streams, numbers without a locale. Each system
 * has one file that implements it (os_posix.c), and nqm_clock_s() and nqm_dynamic_load() of base.h. Paths are UTF-8. Functions that
 * fail return false, NULL or -1 and set errno.
 */
#ifndef NQM_SRC_BASE_OS_H
#define NQM_SRC_BASE_OS_H

#include "base/base.h"

#include <pthread.h> /* mutexes and calls that are made once; compilers for Windows have it, too */

/* ---- what a path names ------------------------------------------------------------------------------------------- */

typedef enum nqm_path_kind { NQM_FILE_REGULAR, NQM_FILE_FOLDER, NQM_FILE_PIPE, NQM_FILE_DEVICE } nqm_path_kind;

typedef struct nqm_file_info {
    nqm_path_kind kind;
    uint64_t volume, number; /* together the same for all paths of a file, and for no other file that exists */
    int64_t n_bytes;
    int64_t changed_s, changed_ns; /* when its content was changed: seconds since 1970, and nanoseconds */
} nqm_file_info;

/** Of the file that a symbolic link points to. */
bool nqm_os_get_info(const char *path, nqm_file_info *info_ret);
bool nqm_os_exists(const char *path);
bool nqm_os_is_folder(const char *path);
/** Whether the path itself is a symbolic link, also one to nothing. */
bool nqm_os_is_link(const char *path);
/** Whether the path belongs to the system's devices and open files (/dev/null, /dev/fd/3), which are never replaced. */
bool nqm_os_is_device(const char *path);
/** Whether this process may write to a file, or into a folder. A file that nobody may write is none, even for root. */
bool nqm_os_is_writable(const char *path);
/** The absolute path without links, "." and ".."; free() it. */
char *nqm_os_real_path(const char *path);

/* ---- files and folders ------------------------------------------------------------------------------------------- */

/** Rename a file, which may be open; one that exists at the new path, which may be mapped, is replaced in one step. */
bool nqm_os_replace(const char *from, const char *to);
/** Remove a file, which may be open. May be called in a signal handler, as the next one may. */
bool nqm_os_remove(const char *path);
/** Remove a folder if it is empty. */
bool nqm_os_remove_folder(const char *path);
bool nqm_os_make_folder(const char *path);
/** Make a folder the working folder. */
bool nqm_os_enter_folder(const char *path);
/** Append the names of what is in a folder, without "." and "..", in the order of their bytes. */
NQM_MUST_CHECK nqm_status nqm_os_list_folder(const char *path, nqm_names *names, nqm_error *err);

typedef enum nqm_open_mode {
    NQM_OPEN_READ,   /* does not wait for the writer of a pipe */
    NQM_OPEN_WRITE,  /* what exists, but not through a link */
    NQM_OPEN_CREATE, /* for writing; created if it does not exist */
    NQM_OPEN_EMPTY   /* for writing; created, or emptied */
} nqm_open_mode;

/** Open a file, which processes that this one starts do not inherit. Returns its descriptor. */
int nqm_os_open(const char *path, nqm_open_mode mode);
/** Create a file for writing, which must not exist, with the permissions of the file `like` if that exists. */
int nqm_os_open_new(const char *path, const char *like);
/** Open a stream for reading. */
FILE *nqm_os_open_text(const char *path);
bool nqm_os_get_info_of(int file, nqm_file_info *info_ret);
/** A stream that writes to an open file, and owns it. */
FILE *nqm_os_stream(int file);
/** Wait until what has been flushed is on the disk. */
bool nqm_os_sync(FILE *stream);
/** Cut a file where its stream, which was flushed, is. */
bool nqm_os_truncate(FILE *stream);
void nqm_os_close(int file);
enum { NQM_TEMPORARY_PATH = 1024 };
/** A temporary file, which goes when it is closed; path: receives a path that opens it, one of nqm_os_is_device(). */
FILE *nqm_os_temporary(char path[NQM_TEMPORARY_PATH]);

/** The lock of an open file is released when the file is closed, or when its process ends in any way. */
typedef enum nqm_lock {
    NQM_LOCK_TAKEN,
    NQM_LOCK_UNSUPPORTED, /* the file system has no locks */
    NQM_LOCK_HELD,        /* by another open file */
    NQM_LOCK_GONE         /* the path does not name this file any more: it was removed or replaced */
} nqm_lock;
/** Lock a file that was opened at this path, without waiting. */
nqm_lock nqm_os_lock(int file, const char *path);

/** How a part of a file, or its mapped pages, will be read. Advice only. */
typedef enum nqm_advice { NQM_ADVICE_NORMAL, NQM_ADVICE_RANDOM, NQM_ADVICE_SOON } nqm_advice;
/** n: 0: to the end of the file. */
void nqm_os_advise(int file, size_t offset, size_t n, nqm_advice advice);
/** Read n bytes; false also if the file ends before. is_cached: only if no disk must be waited for, as far as the system can tell. */
bool nqm_os_read_at(int file, size_t offset, size_t n, void *out, bool is_cached);

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/** n > 0 bytes at a multiple of `alignment`; nqm_os_free() it. Two functions of ISO C, which not every system has. */
void *nqm_os_alloc(size_t alignment, size_t n);
/** As realloc(), for NULL and what this function has given. */
void *nqm_os_realloc(void *block, size_t n);
void nqm_os_free(void *block);

/** Map the first n > 0 bytes of a file for reading; they stay mapped when it is closed. */
void *nqm_os_map(int file, size_t n);
void nqm_os_advise_pages(const void *pages, size_t n, nqm_advice advice);
/** n > 0 zeroed bytes of whole pages, large ones if possible. */
void *nqm_os_alloc_pages(size_t n);
/** Return what one of the two has given for the same n. */
void nqm_os_free_pages(const void *pages, size_t n);

/* ---- the rest ---------------------------------------------------------------------------------------------------- */

/** A stream that writes to memory. */
FILE *nqm_os_memory_stream(char **text, size_t *n);
/** Close it: *text receives what was written, with a NUL behind its n bytes; free() it. false: memory ran out, *text is NULL. */
bool nqm_os_close_memory(FILE *stream, char **text, size_t *n);
/** Let strtod() and printf() of the calling thread use the "C" locale. Returns what nqm_os_leave_locale() restores. */
void *nqm_os_enter_c_locale(void);
void nqm_os_leave_locale(void *before);
void nqm_os_sleep(double seconds);
/** Bytes of the L2 cache of a processor; 0: not known. */
size_t nqm_os_l2_bytes(void);

#endif
