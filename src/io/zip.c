/* SPDX-License-Identifier: MIT
 *
 * Reads single members of a zip archive with libzip, from the mapped file. A member's declared size is checked
 * before memory is allocated.
 */
#include "io/io.h"

#include <string.h>
#include <zip.h>

/** An open archive over mapped bytes. */
typedef struct archive {
    const nqm_map *map;
    zip_t *zip;
} archive;

static nqm_status archive_open(const nqm_map *map, archive *a, nqm_error *err) {
    zip_error_t why;
    zip_error_init(&why);
    zip_source_t *source = zip_source_buffer_create(map->data, map->n_bytes, 0, &why);
    *a = (archive){map, source ? zip_open_from_source(source, ZIP_RDONLY, &why) : NULL};
    nqm_status status = NQM_OK;
    if (!a->zip) {
        bool nomem = zip_error_code_zip(&why) == ZIP_ER_MEMORY;
        status = nqm_fail(err, nomem ? NQM_ERR_NOMEM : NQM_ERR_FORMAT, 0, "%s: not a readable zip archive (byte 0): %s",
                          map->path, zip_error_strerror(&why));
        zip_source_free(source);
    }
    zip_error_fini(&why);
    return status;
}

/* The last path component of member i; "" for folders and unreadable names. */
static const char *base_name(const archive *a, zip_uint64_t i) {
    const char *name = zip_get_name(a->zip, i, ZIP_FL_ENC_RAW);
    if (!name)
        return "";
    const char *slash = strrchr(name, '/');
    return slash ? slash + 1 : name;
}

static zip_uint64_t member_count(const archive *a) {
    zip_int64_t n = zip_get_num_entries(a->zip, 0);
    return n > 0 ? (zip_uint64_t)n : 0;
}

nqm_status nqm_zip_examples(const nqm_map *map, const char *suffix, char *text, size_t n_text, nqm_error *err) {
    enum { N_SHOWN = 4 };
    archive a;
    nqm_status status = archive_open(map, &a, err);
    if (status != NQM_OK)
        return status;
    size_t n_found = 0, used = 0;
    text[0] = 0;
    for (zip_uint64_t i = 0, n = member_count(&a); i < n; ++i) {
        const char *name = base_name(&a, i);
        const size_t n_name = strlen(name), n_suffix = strlen(suffix);
        if (n_name <= n_suffix || strcmp(name + n_name - n_suffix, suffix) != 0 || n_found++ >= N_SHOWN)
            continue;
        int n_put = snprintf(text + used, n_text - used, "%s%.*s", used ? ", " : "", (int)(n_name - n_suffix), name);
        used = n_put > 0 && (size_t)n_put < n_text - used ? used + (size_t)n_put : strlen(text);
    }
    if (n_found > N_SHOWN)
        snprintf(text + used, n_text - used, ", ... (%zu in all)", n_found);
    zip_discard(a.zip);
    return NQM_OK;
}

/* Read all of an opened member. Reading past its end makes libzip verify the checksum. */
static bool read_exactly(zip_file_t *file, unsigned char *data, size_t n_bytes) {
    for (size_t done = 0; done < n_bytes;) {
        zip_int64_t n = zip_fread(file, data + done, n_bytes - done);
        if (n <= 0)
            return false;
        done += (size_t)n;
    }
    unsigned char beyond;
    return zip_fread(file, &beyond, 1) == 0;
}

static nqm_status read_member(const archive *a, zip_uint64_t index, size_t max_bytes, unsigned char **data_ret,
                              size_t *n_bytes_ret, nqm_error *err) {
    const char *path = a->map->path, *name = base_name(a, index);
    zip_stat_t st;
    if (zip_stat_index(a->zip, index, 0, &st) != 0 || !(st.valid & ZIP_STAT_SIZE))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: '%s' has no readable entry", path, name);
    if (st.size > max_bytes)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: '%s' claims %llu bytes, the limit is %zu", path, name,
                        (unsigned long long)st.size, max_bytes);
    size_t n_bytes = (size_t)st.size;
    zip_file_t *file = zip_fopen_index(a->zip, index, 0);
    if (!file)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: '%s' cannot be unpacked: %s", path, name, zip_strerror(a->zip));
    unsigned char *data = nqm_alloc(n_bytes, 1);
    nqm_status status = NQM_OK;
    if (!data)
        status = nqm_fail_nomem(err, n_bytes);
    else if (!read_exactly(file, data, n_bytes))
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: '%s' is damaged: %s", path, name, zip_file_strerror(file));
    zip_fclose(file);
    if (status != NQM_OK) {
        nqm_free(data);
        return status;
    }
    *data_ret = data;
    *n_bytes_ret = n_bytes;
    return NQM_OK;
}

nqm_status nqm_zip_read(const nqm_map *map, const char *member, size_t max_bytes, unsigned char **data_ret,
                        size_t *n_bytes_ret, nqm_error *err) {
    *data_ret = NULL;
    archive a;
    nqm_status status = archive_open(map, &a, err);
    if (status != NQM_OK)
        return status;
    zip_uint64_t i = 0, n = member_count(&a);
    nqm_nearest nearest = nqm_nearest_begin(member);
    for (; i < n && (!*member || strcmp(base_name(&a, i), member) != 0); ++i)
        nqm_nearest_add(&nearest, base_name(&a, i));
    if (i < n)
        status = read_member(&a, i, max_bytes, data_ret, n_bytes_ret, err);
    else
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: has no member '%s'%s", map->path, member, nearest.advice);
    zip_discard(a.zip);
    return status;
}
