/* SPDX-License-Identifier: MIT
 *
 * help.h - what is made from the option tables of the verbs: help, man pages, the reference in Markdown, completions of shells.
 */
#ifndef NQM_HELP_H
#define NQM_HELP_H

#include "nqm/tool.h"

/** An option as people see it; a flag that can be switched off is two rows. Valid during the call. */
typedef struct help_row {
    char letter;              /* short form, 0 for none */
    const char *name;         /* without "--" */
    const char *metavar;      /* NULL: takes no value */
    const char *help;         /* one line */
    const char *text;         /* the same with the allowed values, unit and default */
    const char *const *words; /* the allowed values; NULL: not words */
} help_row;
typedef void help_row_fn(void *user, const help_row *row);
/** Call fn for every option of a verb, and for --help. */
void each_option(const command *cmd, help_row_fn *fn, void *user);

/** Prints the help of the verb verb_name() in some format. */
typedef void help_printer(const command *cmd);
help_printer print_help, print_man_page, print_markdown;
/** Call it for every verb. */
void describe_verbs(help_printer *print);
/** Completions of all verbs, the page of the tool itself, the reference of all verbs in Markdown. */
void print_bash(void);
void print_zsh(void);
void print_fish(void);
void print_man_overview(void);
void print_reference(void);

/** From now on parse_arguments() calls `printer`, which must not return, instead of reading arguments. */
void set_help_printer(help_printer *printer);
/** The row of an option that is not in a table. */
nqm_option own_row(const command *cmd, const option *o);
void print_usage(FILE *out);
/** Versions of the tool and of the libraries of this build. */
void print_version(void);
/** Call fn for every line of a text, without its newline. */
void each_line(const char *text, void (*fn)(const char *line, size_t n));

#endif
