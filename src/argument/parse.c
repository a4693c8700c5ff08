/* SPDX-License-Identifier: MIT
 *
 * Takes the text of an argument apart: "ignore:WORDS:", then a spec, "WRAPPER:SETTINGS;with=(WITH);of=OF", "maps:...", or
 * "PATH:MEMBER".
 */
#include "argument/argument.h"
#include "base/os.h"

#include "brdf/core/spec.h"

enum { MAX_DEPTH = 16 };
static const char ignore[] = "ignore:";

static bool begins_with(const char *text, const char *prefix) {
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

/* Length of "ignore:WORDS:" at the beginning, 0: it does not begin so; *set_ret: 0 if the words are wrong. */
static size_t ignore_prefix(const char *text, unsigned *set_ret) {
    const size_t n = strlen(ignore), n_words = begins_with(text, ignore) ? strcspn(text + n, ":") : 0;
    *set_ret = 0;
    if (!begins_with(text, ignore) || !text[n + n_words])
        return 0;
    (void)nqm_ignore_parse(text + n, n_words, set_ret);
    return n + n_words + 1;
}

unsigned nqm_argument_ignored(const char *text) {
    unsigned ignored;
    (void)ignore_prefix(text, &ignored);
    return ignored;
}

const char *nqm_argument_rest(const char *text) {
    unsigned ignored;
    return text + ignore_prefix(text, &ignored);
}

/* After that prefix. */
static nqm_argument_kind kind_of_rest(const char *rest) {
    return nqm_spec_wrapper_of(rest)            ? NQM_ARGUMENT_WRAPPER
           : nqm_spec_probe(rest)               ? NQM_ARGUMENT_SPEC
           : begins_with(rest, "fit:")          ? NQM_ARGUMENT_FIT
           : begins_with(rest, NQM_MAPS_PREFIX) ? NQM_ARGUMENT_MAPS
                                                : NQM_ARGUMENT_NOTHING;
}

nqm_argument_kind nqm_argument_kind_of(const char *text) {
    return kind_of_rest(nqm_argument_rest(text));
}

/* ---- wrappers and fits ------------------------------------------------------------------------------------------- */

/* The parenthesis that closes the one before `text`; NULL: there is none. */
static char *closing(char *text) {
    size_t open = 1;
    for (; *text; ++text) {
        open += *text == '(';
        open -= *text == ')';
        if (open == 0)
            return text;
    }
    return NULL;
}

/* Cut "SETTINGS;of=OF", or with has_with "SETTINGS;with=(WITH);of=OF". false: another form; the text is as it was. */
static bool cut(char *text, bool has_with, nqm_argument *a) {
    static const char begin[] = ";with=(", middle[] = ";of=";
    char *end = begins_with(text, middle + 1) ? text : strstr(text, middle);
    if (has_with) {
        char *at = strstr(text, begin);
        end = at ? closing(at + strlen(begin)) : NULL;
        if (!end || !begins_with(end + 1, middle))
            return false;
        a->with = at + strlen(begin);
        *at = *end++ = 0;
    }
    if (!end)
        return false;
    a->of = end + (*end == ';') + strlen(middle) - 1;
    *end = 0;
    return true;
}

static void cut_bases(nqm_argument *a, char *rest) {
    char *settings = rest + strcspn(rest, ":") + 1;
    a->settings = settings;
    if (cut(settings, a->wrapper && a->wrapper->has_with, a) && (a->wrapper || (*a->of && *settings)))
        return;
    (void)!nqm_fail(&a->err, NQM_ERR_ARG, -1, "%s",
                    a->wrapper ? a->wrapper->form
                               : "fit: 'of=' and a BRDF are missing at the end (fit:model=ggx;of=BRDF)");
}

/* What can be told without looking for files. */
static nqm_argument *split(const char *text) {
    const size_t n = strlen(text) + 1;
    nqm_argument *a = nqm_alloc(1, sizeof *a + 2 * n);
    if (!a)
        return NULL;
    a->text = memcpy(a + 1, text, n);
    const size_t n_prefix = ignore_prefix(text, &a->ignored);
    char *rest = memcpy((char *)(a + 1) + n, text + n_prefix, n - n_prefix);
    a->rest = rest;
    a->wrapper = nqm_spec_wrapper_of(rest);
    a->kind = kind_of_rest(rest);
    if (a->kind == NQM_ARGUMENT_WRAPPER || a->kind == NQM_ARGUMENT_FIT)
        cut_bases(a, rest);
    if (n_prefix && !a->ignored)
        (void)!nqm_ignore_refuse(text + strlen(ignore), &a->err);
    return a;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* The last colon before which there is a file; NULL: there is none. */
static char *find_member(char *rest) {
    for (size_t i = strlen(rest); i--;) {
        if (rest[i] != ':')
            continue;
        rest[i] = 0;
        const bool is_there = nqm_os_exists(rest);
        rest[i] = ':';
        if (is_there)
            return rest + i;
    }
    return NULL;
}

static void find_file(nqm_argument *a, char *rest, nqm_argument_files *files) {
    char *colon = NULL;
    a->path = rest;
    if (!nqm_os_exists(rest)) {
        colon = find_member(rest);
        if (!colon)
            return;
        *colon = 0;
        a->member = colon + 1;
    }
    a->kind = NQM_ARGUMENT_FILE;
    if (nqm_os_is_folder(rest)) {
        a->n_networks = nqm_networks_in_folder(rest, &a->network);
        a->kind = a->n_networks ? NQM_ARGUMENT_NETWORKS : colon ? NQM_ARGUMENT_FILE : NQM_ARGUMENT_FOLDER;
    }
    if (a->kind == NQM_ARGUMENT_FILE || (a->n_networks == 1 && a->network))
        nqm_argument_read(a, files);
}

nqm_argument *nqm_argument_parse(const char *text, nqm_argument_files *files) {
    nqm_argument *a = split(text);
    if (a && a->kind == NQM_ARGUMENT_NOTHING && a->err.status == NQM_OK)
        find_file(a, (char *)(uintptr_t)a->rest, files);
    return a;
}

void nqm_argument_free(nqm_argument *a) {
    if (!a)
        return;
    nqm_argument_file_release(a->file);
    nqm_map_close(&a->map);
    nqm_free(a->network);
    nqm_free(a);
}

/* ---- texts ------------------------------------------------------------------------------------------------------- */

static nqm_status visit_at(const char *text, size_t depth,
                           nqm_status (*visit)(void *user, const char *base, nqm_error *err), void *user,
                           nqm_error *err) {
    if (depth > MAX_DEPTH)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a BRDF argument has more than %d levels", MAX_DEPTH);
    nqm_argument *a = split(text);
    if (!a)
        return nqm_fail_nomem(err, strlen(text) + 1);
    nqm_status status = NQM_OK;
    if (a->kind == NQM_ARGUMENT_FIT && a->err.status != NQM_OK)
        status = nqm_fail(err, a->err.status, -1, "%s", a->err.message);
    else if (!a->of || !*a->of || !*a->settings)
        status = visit(user, text, err); /* what is wrong with it is told when it is opened */
    else if (a->with)
        status = visit_at(a->with, depth + 1, visit, user, err);
    if (status == NQM_OK && a->of && *a->of && *a->settings)
        status = visit_at(a->of, depth + 1, visit, user, err);
    nqm_argument_free(a);
    return status;
}

nqm_status nqm_argument_visit_bases(const char *text, nqm_status (*visit)(void *user, const char *base, nqm_error *err),
                                    void *user, nqm_error *err) {
    return visit_at(text, 0, visit, user, err);
}

char *nqm_argument_below(const char *text, const char *root) {
    unsigned ignored;
    const size_t n = ignore_prefix(text, &ignored);
    if (!root || !*root || text[n] == '/' || nqm_spec_probe(text + n))
        return nqm_strdup(text);
    return nqm_strdupf("%.*s%s/%s", (int)n, text, root, text + n);
}

char *nqm_argument_reflecting(const nqm_argument *a, unsigned set) {
    nqm_material_info info;
    unsigned needed;
    if (a->ignored || !nqm_argument_material(a, &info) || !info.ignorable ||
        !nqm_ignore_parse(info.ignorable, strlen(info.ignorable), &needed) || (needed & ~set))
        return NULL;
    return nqm_strdupf("ignore:%s:%s", info.ignorable, a->text);
}

size_t nqm_argument_name_length(const char *text) {
    const size_t n = strcspn(text, "=:/");
    return text[n] == '=' && text[n + 1] && !nqm_spec_lacks_colon(text) && !nqm_os_exists(text) ? n : 0;
}
