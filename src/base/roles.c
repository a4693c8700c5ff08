/* SPDX-License-Identifier: MIT
 *
 * Which files a process reads and which it replaces (base.h, "roles of files"): a hash table of their identities.
 */
#include "base/os.h"

enum { ROLE_INPUT = 1, ROLE_OUTPUT = 2 };

/* A slot is empty while `is_used` is false; a file without roles keeps its slot, so that searches may end at an empty one. */
typedef struct slot {
    uint64_t volume, number;
    bool is_used;
    unsigned char roles;
} slot;

static struct {
    pthread_mutex_t mutex; /* guards all members */
    bool is_on;
    slot *slots; /* (n_slots), a power of two; at most half of them are used */
    size_t n_slots, n_used;
} table = {.mutex = PTHREAD_MUTEX_INITIALIZER};

static slot *find_slot(slot *slots, size_t n_slots, const nqm_file_info *file) {
    size_t i = (size_t)nqm_hash_u64(file->volume, file->number) & (n_slots - 1);
    while (slots[i].is_used && (slots[i].number != file->number || slots[i].volume != file->volume))
        i = (i + 1) & (n_slots - 1);
    return &slots[i];
}

static bool make_room(void) {
    if (2 * (table.n_used + 1) <= table.n_slots)
        return true;
    const size_t n = nqm_larger(2 * table.n_slots, 64);
    slot *slots = nqm_alloc(n, sizeof *slots);
    for (size_t i = 0; slots && i < table.n_slots; ++i)
        if (table.slots[i].is_used)
            *find_slot(slots, n, &(nqm_file_info){.volume = table.slots[i].volume, .number = table.slots[i].number}) =
                table.slots[i];
    if (!slots)
        return false;
    nqm_free(table.slots);
    table.slots = slots;
    table.n_slots = n;
    return true;
}

/* Add a role to a regular file, and fail if it has the other one, too. */
static nqm_status add_role(const nqm_file_info *file, unsigned char role, const char *path, nqm_error *err) {
    nqm_status status = NQM_OK;
    unsigned char roles = 0;
    pthread_mutex_lock(&table.mutex);
    if (table.is_on && file->kind == NQM_FILE_REGULAR) {
        if (make_room()) {
            slot *s = find_slot(table.slots, table.n_slots, file);
            table.n_used += !s->is_used;
            roles = s->roles | role;
            /* an input stays one, and only that, when an output is refused */
            *s = (slot){file->volume, file->number, true, s->roles == ROLE_INPUT ? ROLE_INPUT : roles};
        } else {
            status = nqm_fail_nomem(err, 2 * table.n_slots * sizeof(slot));
        }
    }
    pthread_mutex_unlock(&table.mutex);
    if (roles == (ROLE_INPUT | ROLE_OUTPUT))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: an output of this run would replace an input; give it another name",
                        path);
    return status;
}

void nqm_roles_enforce(void) {
    pthread_mutex_lock(&table.mutex);
    table.is_on = true;
    pthread_mutex_unlock(&table.mutex);
}

nqm_status nqm_role_input(const nqm_file_info *file, const char *path, nqm_error *err) {
    return add_role(file, ROLE_INPUT, path, err);
}

nqm_status nqm_role_output(const char *path, nqm_error *err) {
    nqm_file_info file;
    return nqm_os_get_info(path, &file) ? add_role(&file, ROLE_OUTPUT, path, err) : NQM_OK;
}

void nqm_role_forget(const nqm_file_info *file) {
    pthread_mutex_lock(&table.mutex);
    if (table.n_slots)
        find_slot(table.slots, table.n_slots, file)->roles = 0;
    pthread_mutex_unlock(&table.mutex);
}
