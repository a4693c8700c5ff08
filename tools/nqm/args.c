/* SPDX-License-Identifier: MIT
 *
 * Options from tables, which drive parsing, ranges, defaults and help. Options may be anywhere among the arguments; `--` ends
 * them.
 */
#include "nqm/tool.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void print_default(const option *o) {
    switch (o->kind) {
    case OPTION_FLAG:
        break;
    case OPTION_TEXT:
        if (*(const char **)o->target)
            printf(" [default: %s]", *(const char **)o->target);
        break;
    case OPTION_NUMBER:
        if (isfinite(*(double *)o->target))
            printf(" [default: %g]", *(double *)o->target);
        break;
    case OPTION_COUNT:
        printf(" [default: %llu]", (unsigned long long)*(uint64_t *)o->target);
        break;
    }
}

static void print_option(char letter, const char *name, const char *metavar, const char *help) {
    char left[NQM_OPTION_TEXT_MAX + 64], short_form[8] = "    ";
    if (letter)
        snprintf(short_form, sizeof short_form, "-%c, ", letter);
    snprintf(left, sizeof left, "  %s--%s%s%s", short_form, name, metavar ? " " : "", metavar ? metavar : "");
    printf("%-30s %s", left, help);
}

/* Help, what is allowed, unit and default of an option of a table; then the name that switches it off. */
static void print_table_option(const nqm_option *o, const void *target) {
    char name[NQM_OPTION_TEXT_MAX], text[NQM_OPTION_TEXT_MAX];
    if (!*nqm_option_name(o, name))
        return;
    print_option(0, name, o->metavar, o->help);
    if (o->words || o->min != 0 || o->max != 0)
        printf("; %s", nqm_option_allowed(o, text));
    if (o->unit)
        printf(", %s", o->unit);
    if (!nqm_option_is_flag(o)) {
        if (*nqm_option_format(o, target, text))
            printf(" [default: %s]", text);
    } else if (!o->off_name || *o->off_name) {
        const bool is_on = *(const int *)((const char *)target + o->offset) != 0;
        snprintf(text, sizeof text, "%.20s%.60s", o->off_name ? "" : "no-", o->off_name ? o->off_name : name);
        printf("%s\n", is_on ? " [default]" : "");
        print_option(0, text, NULL, is_on ? "do not" : "do not [default]");
    }
    putchar('\n');
}

static void print_help(const command *cmd) {
    printf("usage: nqm %s %s\n\n%s\n\noptions:\n", cmd->name, cmd->usage, cmd->about);
    for (const option *o = cmd->options; o->name; ++o) {
        print_option(o->letter, o->name, o->metavar, o->help);
        print_default(o);
        putchar('\n');
    }
    for (size_t i = 0; cmd->table && i < cmd->table->n; ++i)
        print_table_option(&cmd->table->rows[i], cmd->table_target);
    print_option(0, "help", NULL, "print this text");
    printf("\n\nexample:\n");
    for (const char *line = cmd->example; *line;) {
        size_t n = strcspn(line, "\n");
        printf("  %.*s\n", (int)n, line);
        line += n + (line[n] == '\n');
    }
}

static bool usage_error(const command *cmd, int *exit_code, const char *what, const char *which) {
    fprintf(stderr, "nqm %s: %s%s%s\n", cmd->name, what, *which ? ": " : "", which);
    fprintf(stderr, "usage: nqm %s %s\n(see 'nqm %s --help')\n", cmd->name, cmd->usage, cmd->name);
    *exit_code = EXIT_USAGE;
    return false;
}

static bool store_value(const command *cmd, const option *o, const char *value, int *exit_code) {
    char message[200];
    if (o->kind == OPTION_TEXT) {
        *(const char **)o->target = value;
        return true;
    }
    char *end;
    errno = 0;
    double number = strtod(value, &end); /* in the "C" locale: the tool never calls setlocale() */
    bool has_any_range = o->min == 0 && o->max == 0;
    bool is_whole = o->kind != OPTION_COUNT || (number >= 0 && number == floor(number) && number <= 9007199254740992.0);
    if (end == value || *end || !isfinite(number) || !is_whole ||
        (!has_any_range && (number < o->min || number > o->max))) {
        if (has_any_range)
            snprintf(message, sizeof message, "--%s needs a %s, not '%.80s'", o->name,
                     o->kind == OPTION_COUNT ? "whole number" : "number", value);
        else
            snprintf(message, sizeof message, "--%s needs a %s from %g to %g, not '%.80s'", o->name,
                     o->kind == OPTION_COUNT ? "whole number" : "number", o->min, o->max, value);
        return usage_error(cmd, exit_code, message, "");
    }
    if (o->kind == OPTION_COUNT)
        *(uint64_t *)o->target = (uint64_t)number;
    else
        *(double *)o->target = number;
    return true;
}

/* The option with the name in `word` ("--name", "--name=value", "-x"); *value is the text after '=', or NULL. A flag of the
 * table (*from_table_ret) whose name sets it to 0 has *is_off_ret. */
static const option *find_option(const command *cmd, const char *word, const char **value,
                                 const nqm_option **from_table_ret, bool *is_off_ret) {
    *value = NULL;
    *from_table_ret = NULL;
    if (word[1] != '-') {
        for (const option *o = cmd->options; o->name; ++o)
            if (o->letter && word[1] == o->letter && !word[2])
                return o;
        return NULL;
    }
    size_t n = strcspn(word + 2, "=");
    if (word[2 + n] == '=')
        *value = word + 3 + n;
    for (const option *o = cmd->options; o->name; ++o)
        if (strlen(o->name) == n && memcmp(o->name, word + 2, n) == 0)
            return o;
    if (cmd->table)
        *from_table_ret = nqm_option_by_name(cmd->table, word + 2, n, is_off_ret);
    return NULL;
}

static bool store_table_value(const command *cmd, const nqm_option *o, const char *value, int *exit_code) {
    char message[sizeof(nqm_error) + 2];
    nqm_error err = {0};
    if (nqm_option_set(o, cmd->table_target, value, &err) == NQM_OK)
        return true;
    snprintf(message, sizeof message, "--%s", err.message);
    return usage_error(cmd, exit_code, message, "");
}

int set_option(const char *verb, const nqm_option_table *table, const char *key, void *target, const char *text) {
    nqm_error err = {0};
    if (nqm_option_set(nqm_option_by_key(table, key), target, text, &err) == NQM_OK)
        return EXIT_OK;
    return report(verb, EXIT_USAGE, "--%s", err.message);
}

bool parse_arguments(const command *cmd, int argc, char **argv, int *n_arguments, int *exit_code) {
    int n = 0;
    bool options_end = false;
    for (int i = 1; i < argc; ++i) {
        char *word = argv[i];
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
            *exit_code = EXIT_OK;
            return false;
        }
        const char *value;
        const nqm_option *from_table;
        bool is_off = false;
        const option *o = find_option(cmd, word, &value, &from_table, &is_off);
        if (!o && !from_table)
            return usage_error(cmd, exit_code, "unknown option", word);
        if (from_table ? nqm_option_is_flag(from_table) : o->kind == OPTION_FLAG) {
            if (value)
                return usage_error(cmd, exit_code, "this option takes no value", word);
            if (from_table)
                *(int *)((char *)cmd->table_target + from_table->offset) = !is_off;
            else
                *(bool *)o->target = true;
            continue;
        }
        if (!value) {
            if (i + 1 >= argc)
                return usage_error(cmd, exit_code, "a value is missing after", word);
            value = argv[++i];
        }
        if (!(from_table ? store_table_value(cmd, from_table, value, exit_code)
                         : store_value(cmd, o, value, exit_code)))
            return false;
    }
    if (n < cmd->min_arguments)
        return usage_error(cmd, exit_code, n ? "too few arguments" : "the arguments are missing", "");
    if (cmd->max_arguments >= 0 && n > cmd->max_arguments)
        return usage_error(cmd, exit_code, "too many arguments, beginning with", argv[cmd->max_arguments]);
    *n_arguments = n;
    return true;
}
