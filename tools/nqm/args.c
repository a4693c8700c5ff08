/* SPDX-License-Identifier: MIT
 *
 * Options from tables, which drive parsing, ranges, defaults and help (help.c). Options may be anywhere among the
 * arguments; `--` ends them.
 */
#include "argument/argument.h"
#include "metric/metric.h"
#include "nqm/help.h"
#include "pairs/pairs.h"

#include <stdlib.h>
#include <string.h>

/* An option of the command line: a row of the verb's own options, or of its table. */
typedef struct found {
    nqm_option row;
    void *target;
    const option *own; /* NULL: from the table */
    bool is_flag, is_off;
} found;

static help_printer *help_printer_now; /* NULL: arguments are parsed */

void set_help_printer(help_printer *printer) {
    help_printer_now = printer;
}

/* ---- parsing ----------------------------------------------------------------------------------------------------- */

static _Noreturn void usage_error(const command *cmd, const char *what, const char *which) {
    fprintf(stderr, "nqm %s: %s%s\nusage: nqm %s %s\n(see 'nqm %s --help')\n", verb_name(), what, shown(which),
            verb_name(), cmd->usage, verb_name());
    exit(EXIT_USAGE);
}

static void offer_option(void *nearest, const help_row *row) {
    char name[NQM_OPTION_TEXT_MAX + 2];
    snprintf(name, sizeof name, "--%s", row->name);
    nqm_nearest_add(nearest, name);
}

static _Noreturn void unknown_option(const command *cmd, const char *word) {
    char name[64], which[256];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
    nqm_nearest nearest = nqm_nearest_begin(name);
    each_option(cmd, offer_option, &nearest);
    nqm_nearest_add(&nearest, "--version");
    snprintf(which, sizeof which, "%.100s%s", word, nearest.advice);
    usage_error(cmd, "unknown option: ", which);
}

/* Options may be written with '_' for '-'. */
static void write_dashes(char *word) {
    for (; *word && *word != '='; ++word)
        *word = *word == '_' ? '-' : *word;
}

/* Find the option with the name in `word`: "--name", "--name=value" or "-x". */
static bool find_option(const command *cmd, const char *word, found *f) {
    const bool is_long = word[1] == '-';
    const size_t n = strcspn(word + 2, "=");
    for (const option *o = cmd->options; o->name; ++o)
        if (is_long ? strlen(o->name) == n && memcmp(o->name, word + 2, n) == 0 : o->letter == word[1] && !word[2]) {
            *f = (found){.row = own_row(cmd, o), .target = o->target, .own = o};
            f->is_flag = f->row.kind == NQM_OPTION_BOOL;
            return true;
        }
    bool is_off = false;
    const nqm_option *row = is_long && cmd->table ? nqm_option_by_name(cmd->table, word + 2, n, &is_off) : NULL;
    if (row)
        *f = (found){.row = *row, .target = cmd->table_target, .is_flag = nqm_option_is_flag(row)};
    f->is_off = is_off;
    return row != NULL;
}

static void set_flag(const command *cmd, const found *f) {
    if (!f->own) {
        *(int *)((char *)f->target + f->row.offset) = !f->is_off;
    } else if (f->own->kind == OPTION_FLAG) {
        *(bool *)f->target = true;
    } else {
        result_format *format = f->target, given = (result_format)f->own->min;
        if (*format != FORMAT_TEXT && *format != given)
            usage_error(cmd, "two formats of the results exclude each other: --", f->own->name);
        *format = given;
    }
}

static void check_needed(const command *cmd) {
    for (const option *o = cmd->options; o->name; ++o)
        if (o->kind == OPTION_NEEDED && !*(const char **)o->target) {
            const nqm_option row = own_row(cmd, o);
            char what[80], words[NQM_OPTION_TEXT_MAX];
            snprintf(what, sizeof what, "--%s %s is missing: ", o->name, o->metavar);
            usage_error(cmd, what, row.words ? nqm_option_allowed(&row, words) : o->help);
        }
}

static const char *output_of(const option *o) {
    return o->metavar && strncmp(o->metavar, "FILE.", 5) == 0 ? *(const char **)o->target : NULL;
}

/* Before the work: outputs have names of their kind, can be written, and are different files. Opening an input notices
 * that an output would replace it (nqm_roles_enforce()). */
static void check_outputs(const command *cmd) {
    for (const option *o = cmd->options; o->name; ++o) {
        const char *path = output_of(o);
        char name[NQM_OPTION_TEXT_MAX + 2];
        snprintf(name, sizeof name, "-%s%s", o->letter ? "" : "-",
                 o->letter ? (const char[]){o->letter, '\0'} : o->name);
        if (!path)
            continue;
        require_named_output(name, path, o->metavar + 4);
        for (const option *before = cmd->options; before < o; ++before)
            if (output_of(before) && is_same_output(path, output_of(before)))
                stop(EXIT_USAGE, "%s %s would replace the file of --%s", name, path, before->name);
    }
}

void set_option(const nqm_option_table *table, const char *key, void *target, const char *text) {
    nqm_error err = {0};
    if (nqm_option_set(nqm_option_by_key(table, key), target, text, &err) != NQM_OK)
        stop(EXIT_USAGE, "--%s", err.message);
}

int choose(const char *name, const char *const *words, const char *text) {
    const nqm_option row = {.name = name, .kind = NQM_OPTION_ENUM, .words = words};
    nqm_error err = {0};
    int value = 0;
    if (nqm_option_set(&row, &value, text, &err) != NQM_OK)
        stop(EXIT_USAGE, "--%s", err.message);
    return value;
}

/* Stop with the nearest word unless the first argument is one of the choices. */
static void check_first(const command *cmd, const char *word) {
    nqm_nearest nearest = nqm_nearest_begin(word);
    char known[256] = "";
    for (size_t i = 0, at = 0; cmd->choices[i].name; ++i) {
        const char *name = cmd->choices[i].name;
        if (strcmp(name, word) == 0)
            return;
        nqm_nearest_add(&nearest, name);
        if (at < sizeof known)
            at += (size_t)snprintf(known + at, sizeof known - at, "%s%s", i ? ", " : "", name);
    }
    if (cmd->has_verbs)
        exit(report_no_verb(word));
    stop(EXIT_USAGE, "there is no '%s'%s; choose one of: %s", word, nearest.advice, known);
}

/* Verbs that score say what is ignored in their remarks. */
static void take_reflections(const command *cmd, int n, char **argv) {
    for (int i = 0; ignored_words && i < n; ++i) {
        const char *argument = reflecting(argv[i]);
        char text[200];
        const size_t n_name = nqm_argument_name_length(argument);
        if (argument != argv[i] && cmd->table != &nqm_score_option_table &&
            nqm_pairs_describe_ignored(argument + (n_name ? n_name + 1 : 0), sizeof text, text))
            report(EXIT_OK, "%s: %s", argv[i], text);
        argv[i] = (char *)(uintptr_t)argument;
    }
}

int parse_arguments(const command *cmd, int argc, char **argv) {
    if (help_printer_now)
        help_printer_now(cmd);
    int n = 0;
    bool options_end = false;
    for (int i = 1; i < argc; ++i) {
        char *word = argv[i];
        found f = {0};
        nqm_error err = {0};
        if (options_end || word[0] != '-' || !word[1]) {
            argv[n++] = (char *)(uintptr_t)input_path(word);
            continue;
        }
        if (strcmp(word, "--") == 0) {
            options_end = true;
            continue;
        }
        if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
            print_help(cmd);
            exit(finish(EXIT_OK));
        }
        if (strcmp(word, "--version") == 0) {
            print_version();
            exit(finish(EXIT_OK));
        }
        write_dashes(word);
        if (!find_option(cmd, word, &f))
            unknown_option(cmd, word);
        const char *value = strchr(word, '=');
        if (f.is_flag && value)
            usage_error(cmd, "this option takes no value: ", word);
        if (f.is_flag) {
            set_flag(cmd, &f);
            continue;
        }
        if (!value && i + 1 >= argc)
            usage_error(cmd, "a value is missing after: ", word);
        if (nqm_option_set(&f.row, f.target, value ? value + 1 : argv[++i], &err) != NQM_OK)
            usage_error(cmd, "--", err.message);
    }
    if (n && cmd->choices) /* a wrong word counts more than what is missing after it */
        check_first(cmd, argv[0]);
    if (n < cmd->min_arguments)
        usage_error(cmd, n ? "too few arguments" : "the arguments are missing", "");
    const int max = cmd->max_arguments ? cmd->max_arguments : cmd->min_arguments;
    if (max >= 0 && n > max)
        usage_error(cmd, "too many arguments, beginning with: ", argv[max]);
    check_needed(cmd);
    check_outputs(cmd);
    if (within)
        must(nqm_files_within(within, &fault));
    take_reflections(cmd, n, argv);
    return n;
}
