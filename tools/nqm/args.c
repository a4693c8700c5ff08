/* SPDX-License-Identifier: MIT
 *
 * Options from tables, which drive parsing, ranges, defaults and help. Options may be anywhere among the arguments; `--` ends
 * them.
 */
#include "nqm/tool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An option of the command line: a row of the verb's own options, or of its table. */
typedef struct found {
    nqm_option row;
    void *target;
    const option *own; /* NULL: from the table */
    bool is_flag, is_off;
} found;

static found own_option(const option *o) {
    static const nqm_option_kind kinds[] = {
        [OPTION_FLAG] = NQM_OPTION_BOOL,     [OPTION_TEXT] = NQM_OPTION_TEXT, [OPTION_NEEDED] = NQM_OPTION_TEXT,
        [OPTION_NUMBER] = NQM_OPTION_DOUBLE, [OPTION_COUNT] = NQM_OPTION_U64, [OPTION_FORMAT] = NQM_OPTION_BOOL};
    return (found){.row = {.name = o->name,
                           .off_name = "",
                           .metavar = o->metavar,
                           .help = o->help,
                           .kind = kinds[o->kind],
                           .min = o->min,
                           .max = o->max},
                   .target = o->target,
                   .own = o,
                   .is_flag = kinds[o->kind] == NQM_OPTION_BOOL};
}

static found table_option(const command *cmd, const nqm_option *o) {
    return (found){.row = *o, .target = cmd->table_target, .is_flag = nqm_option_is_flag(o)};
}

/* ---- help -------------------------------------------------------------------------------------------------------- */

static void print_help_line(char letter, const char *name, const char *metavar, const char *help) {
    char left[NQM_OPTION_TEXT_MAX + 64], short_form[8] = "    ";
    if (letter)
        snprintf(short_form, sizeof short_form, "-%c, ", letter);
    snprintf(left, sizeof left, "  %s--%s%s%s", short_form, name, metavar ? " " : "", metavar ? metavar : "");
    printf("%-30s %s", left, help);
}

/* Help, what is allowed, unit and default; then the name that switches a flag off. */
static void print_option(found f) {
    const nqm_option *o = &f.row;
    char name[NQM_OPTION_TEXT_MAX], text[NQM_OPTION_TEXT_MAX];
    if (!*nqm_option_name(o, name))
        return;
    print_help_line(f.own ? f.own->letter : 0, name, o->metavar, o->help);
    if (!f.is_flag && (o->words || o->min != 0 || o->max != 0))
        printf("; %s", nqm_option_allowed(o, text));
    if (o->unit)
        printf(", %s", o->unit);
    bool has_default = o->kind != NQM_OPTION_DOUBLE || isfinite(*(double *)((char *)f.target + o->offset));
    if (!f.is_flag && has_default && *nqm_option_format(o, f.target, text))
        printf(" [default: %s]", text);
    if (f.is_flag && (!o->off_name || *o->off_name)) {
        const bool is_on = *(const int *)((const char *)f.target + o->offset) != 0;
        snprintf(text, sizeof text, "%.20s%.60s", o->off_name ? "" : "no-", o->off_name ? o->off_name : name);
        printf("%s\n", is_on ? " [default]" : "");
        print_help_line(0, text, NULL, is_on ? "do not" : "do not [default]");
    }
    putchar('\n');
}

static void print_help(const command *cmd) {
    printf("usage: nqm %s %s\n\n%s\n\noptions:\n", verb_name(), cmd->usage, cmd->about);
    for (const option *o = cmd->options; o->name; ++o)
        print_option(own_option(o));
    for (size_t i = 0; cmd->table && i < cmd->table->n; ++i)
        print_option(table_option(cmd, &cmd->table->rows[i]));
    print_help_line(0, "help", NULL, "print this text");
    printf("\n\nexample:\n");
    for (const char *line = cmd->example; *line;) {
        size_t n = strcspn(line, "\n");
        printf("  %.*s\n", (int)n, line);
        line += n + (line[n] == '\n');
    }
}

/* ---- parsing ----------------------------------------------------------------------------------------------------- */

static _Noreturn void usage_error(const command *cmd, const char *what, const char *which) {
    fprintf(stderr, "nqm %s: %s%s\nusage: nqm %s %s\n(see 'nqm %s --help')\n", verb_name(), what, which, verb_name(),
            cmd->usage, verb_name());
    exit(EXIT_USAGE);
}

/* Find the option with the name in `word`: "--name", "--name=value" or "-x". */
static bool find_option(const command *cmd, const char *word, found *f) {
    const bool is_long = word[1] == '-';
    const size_t n = strcspn(word + 2, "=");
    for (const option *o = cmd->options; o->name; ++o)
        if (is_long ? strlen(o->name) == n && memcmp(o->name, word + 2, n) == 0 : o->letter == word[1] && !word[2]) {
            *f = own_option(o);
            return true;
        }
    bool is_off = false;
    const nqm_option *row = is_long && cmd->table ? nqm_option_by_name(cmd->table, word + 2, n, &is_off) : NULL;
    if (row)
        *f = table_option(cmd, row);
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
            const char name[] = {o->letter, '\0'};
            char what[80];
            snprintf(what, sizeof what, "-%s%s %s is missing: ", *name ? "" : "-", *name ? name : o->name, o->metavar);
            usage_error(cmd, what, o->help);
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

int parse_arguments(const command *cmd, int argc, char **argv) {
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
        if (!find_option(cmd, word, &f))
            usage_error(cmd, "unknown option: ", word);
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
    if (n < cmd->min_arguments)
        usage_error(cmd, n ? "too few arguments" : "the arguments are missing", "");
    const int max = cmd->max_arguments ? cmd->max_arguments : cmd->min_arguments;
    if (max >= 0 && n > max)
        usage_error(cmd, "too many arguments, beginning with: ", argv[max]);
    check_needed(cmd);
    return n;
}
