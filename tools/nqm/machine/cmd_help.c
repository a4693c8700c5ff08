/* SPDX-License-Identifier: MIT
 *
 * nqm help - prints what is known about the verbs: as help, man page, Markdown or completion of a shell. A verb describes itself
 * when it calls parse_arguments(); here it is called for that, and left from there.
 */
#include "nqm/help.h"

#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

static jmp_buf after_help;
static help_printer *printer;

static void print_and_leave(const command *cmd) {
    printer(cmd);
    longjmp(after_help, 1);
}

static void describe(const verb *v, help_printer *print) {
    char name[32];
    char *argv[] = {name, NULL};
    snprintf(name, sizeof name, "%s", v->name);
    printer = print;
    set_verb(v->name);
    set_help_printer(print_and_leave);
    if (setjmp(after_help) == 0)
        v->run(1, argv);
    set_help_printer(NULL);
}

static void describe_all(void (*begin)(void), help_printer *print, void (*end)(void)) {
    if (begin)
        begin();
    for (const verb *v = verbs; v->name; ++v)
        describe(v, print);
    if (end)
        end();
}

static void print_usage_text(void) {
    print_usage(stdout);
}

/* `print` prints one verb (`single`: alone, too); for all verbs there are `begin`, `print` for each if `each` is set, and `end`. */
static const struct style {
    const char *name;
    help_printer *print;
    void (*begin)(void);
    bool each, single;
    void (*end)(void);
} styles[] = {{"text", print_help, print_usage_text, false, true, NULL},
              {"man", print_man_page, print_man_overview, false, true, NULL},
              {"markdown", print_markdown, begin_markdown, true, true, NULL},
              {"bash", print_bash_verb, begin_bash, true, false, end_bash},
              {"zsh", print_zsh_verb, begin_zsh, true, false, end_zsh},
              {"fish", print_fish_verb, begin_fish, true, false, NULL}};
static const char *const style_names[] = {"text", "man", "markdown", "bash", "zsh", "fish", NULL};

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static const char *format = "text";
static choice choices[64];

static const option options[] = {
    {"format", 0, OPTION_TEXT, &format, "FORMAT", "what to print; bash, zsh and fish: completions of all verbs", 0, 0},
    {0}};

static const command cmd = {
    .usage = "[VERB] [options]",
    .about = "Print the help of a verb, or the list of verbs; as a man page or as Markdown, or the completion of a "
             "shell.\n"
             "Installed packages contain the man pages and completions; otherwise add for instance this line to "
             "~/.bashrc:\n"
             "  eval \"$(nqm help --format bash)\"",
    .example = "nqm help score\nnqm help score --format man | man -l -\nnqm help --format bash",
    .options = options,
    .choices = choices,
    .has_verbs = true,
    .words = (const option_words[]){{"format", style_names}, {0}},
    .max_arguments = 1,
};

int cmd_help(int argc, char **argv) {
    for (size_t i = 0; i + 1 < sizeof choices / sizeof *choices && verbs[i].name; ++i)
        choices[i] = (choice){verbs[i].name, "", verbs[i].summary};
    const int n = parse_arguments(&cmd, argc, argv);
    const struct style *style = &styles[choose("format", style_names, format)];
    format = style_names[0]; /* this verb describes itself, too, with its default */
    if (n && !style->single)
        stop(EXIT_USAGE, "the completion of %s is for all verbs: give none", style->name);
    if (n)
        describe(find_verb(argv[0]), style->print);
    else if (style->each)
        describe_all(style->begin, style->print, style->end);
    else
        style->begin();
    return EXIT_OK;
}
