/* SPDX-License-Identifier: MIT
 *
 * Options from tables: parsing, ranges, defaults and help text come from one place. Options may stand anywhere; `--`
 * ends them.
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

static void print_help(const command *cmd) {
    printf("usage: nqm %s %s\n\n%s\n\noptions:\n", cmd->name, cmd->usage, cmd->about);
    for (const option *o = cmd->options; o->name; ++o) {
        char left[64];
        char letter[8] = "    ";
        if (o->letter)
            snprintf(letter, sizeof letter, "-%c, ", o->letter);
        snprintf(left, sizeof left, "  %s--%s%s%s", letter, o->name, o->metavar ? " " : "",
                 o->metavar ? o->metavar : "");
        printf("%-30s %s", left, o->help);
        print_default(o);
        putchar('\n');
    }
    printf("%-30s %s\n\nexample:\n", "      --help", "this text");
    for (const char *line = cmd->example; *line;) {
        size_t n = strcspn(line, "\n");
        printf("  %.*s\n", (int)n, line);
        line += n + (line[n] == '\n');
    }
}

static bool usage_error(const command *cmd, int *exit_code, const char *what, const char *which) {
    fprintf(stderr, "nqm %s: %s%s%s\n", cmd->name, what, *which ? ": " : "", which);
    fprintf(stderr, "usage: nqm %s %s\n('nqm %s --help' says more)\n", cmd->name, cmd->usage, cmd->name);
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
    double number = strtod(value, &end); /* the tool never calls setlocale: this is the "C" locale */
    bool any_range = o->min == 0 && o->max == 0;
    bool whole = o->kind != OPTION_COUNT || (number >= 0 && number == floor(number) && number <= 9007199254740992.0);
    if (end == value || *end || !isfinite(number) || !whole || (!any_range && (number < o->min || number > o->max))) {
        if (any_range)
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

/* The option that `word` names ("--name", "--name=value", "-x"); *value points at what follows '=', or is NULL. */
static const option *find_option(const command *cmd, const char *word, const char **value) {
    *value = NULL;
    if (word[1] != '-') {
        for (const option *o = cmd->options; o->name; ++o)
            if (o->letter && word[1] == o->letter && !word[2])
                return o;
        return NULL;
    }
    size_t n = strcspn(word + 2, "=");
    for (const option *o = cmd->options; o->name; ++o)
        if (strlen(o->name) == n && memcmp(o->name, word + 2, n) == 0) {
            if (word[2 + n] == '=')
                *value = word + 3 + n;
            return o;
        }
    return NULL;
}

bool parse_arguments(const command *cmd, int argc, char **argv, int *n_arguments, int *exit_code) {
    int n = 0;
    bool options_end = false;
    for (int i = 1; i < argc; ++i) {
        char *word = argv[i];
        if (options_end || word[0] != '-' || !word[1]) {
            argv[n++] = word;
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
        const option *o = find_option(cmd, word, &value);
        if (!o)
            return usage_error(cmd, exit_code, "unknown option", word);
        if (o->kind == OPTION_FLAG) {
            if (value)
                return usage_error(cmd, exit_code, "this option takes no value", word);
            *(bool *)o->target = true;
            continue;
        }
        if (!value) {
            if (i + 1 >= argc)
                return usage_error(cmd, exit_code, "a value is missing behind", word);
            value = argv[++i];
        }
        if (!store_value(cmd, o, value, exit_code))
            return false;
    }
    if (n < cmd->min_arguments)
        return usage_error(cmd, exit_code, n ? "too few arguments" : "arguments are missing", "");
    if (cmd->max_arguments >= 0 && n > cmd->max_arguments)
        return usage_error(cmd, exit_code, "too many arguments, from", argv[cmd->max_arguments]);
    *n_arguments = n;
    return true;
}
