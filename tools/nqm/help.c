/* SPDX-License-Identifier: MIT
 *
 * The rows of a verb's options, and --help.
 */
#include "nqm/help.h"

#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

/* What is allowed, unit and default. An upper limit that nobody meets is not worth a word; the message of an error names it. */
static void put_values(FILE *out, const nqm_option *o, const void *target) {
    char text[NQM_OPTION_TEXT_MAX];
    const bool is_any_count = o->kind != NQM_OPTION_DOUBLE && o->min <= 1 && o->max >= 1e5;
    if (o->words || (!is_any_count && (o->min != 0 || o->max != 0))) {
        const char *allowed = nqm_option_allowed(o, text), *number = "a number ";
        fprintf(out, "; %s", allowed + (strncmp(allowed, number, strlen(number)) == 0 ? strlen(number) : 0));
    }
    if (o->unit)
        fprintf(out, ", %s", o->unit);
    const bool has_default =
        o->kind != NQM_OPTION_DOUBLE || isfinite(*(const double *)((const char *)target + o->offset));
    if (has_default && *nqm_option_format(o, target, text))
        fprintf(out, " [default: %s]", text);
}

nqm_option own_row(const command *cmd, const option *o) {
    const option_words *w = cmd->words;
    while (w && w->name && strcmp(w->name, o->name) != 0)
        ++w;
    static const nqm_option_kind kinds[] = {
        [OPTION_FLAG] = NQM_OPTION_BOOL,     [OPTION_TEXT] = NQM_OPTION_TEXT, [OPTION_NEEDED] = NQM_OPTION_TEXT,
        [OPTION_NUMBER] = NQM_OPTION_DOUBLE, [OPTION_COUNT] = NQM_OPTION_U64, [OPTION_FORMAT] = NQM_OPTION_BOOL};
    return (nqm_option){.name = o->name,
                        .off_name = "",
                        .metavar = o->metavar,
                        .help = o->help,
                        .kind = kinds[o->kind],
                        .min = kinds[o->kind] == NQM_OPTION_BOOL ? 0 : o->min, /* its value, for a format */
                        .max = o->max,
                        .words = w ? w->words : NULL};
}

static void call_for(const nqm_option *o, char letter, const void *target, help_row_fn *fn, void *user) {
    char name[NQM_OPTION_TEXT_MAX], off[NQM_OPTION_TEXT_MAX + 3], *text;
    size_t n;
    if (!*nqm_option_name(o, name))
        return;
    const bool is_flag = nqm_option_is_flag(o), has_off = is_flag && (!o->off_name || *o->off_name);
    const bool is_on = has_off && *(const int *)((const char *)target + o->offset) != 0;
    FILE *out = open_text(&text, &n);
    fprintf(out, "%s%s", o->help, is_on ? " [default]" : "");
    if (!is_flag)
        put_values(out, o, target);
    close_text(out, &text, &n);
    fn(user, &(help_row){letter, name, is_flag ? NULL : o->metavar, o->help, text, is_flag ? NULL : o->words});
    free(text);
    if (!has_off)
        return;
    snprintf(off, sizeof off, "%s%s", o->off_name ? "" : "no-", o->off_name ? o->off_name : name);
    fn(user, &(help_row){0, off, NULL, "do not", is_on ? "do not" : "do not [default]", NULL});
}

void each_option(const command *cmd, help_row_fn *fn, void *user) {
    for (const option *o = cmd->options; o->name; ++o)
        call_for(&(nqm_option[]){own_row(cmd, o)}[0], o->letter, o->target, fn, user);
    for (size_t i = 0; cmd->table && i < cmd->table->n; ++i)
        call_for(&cmd->table->rows[i], 0, cmd->table_target, fn, user);
    fn(user, &(help_row){0, "help", NULL, "print this text", "print this text", NULL});
}

void each_line(const char *text, void (*fn)(const char *line, size_t n)) {
    while (*text) {
        const size_t n = strcspn(text, "\n");
        fn(text, n);
        text += n + (text[n] == '\n');
    }
}

enum { LEFT_WIDTH = 30, LINE_WIDTH = 110 };

/* Lines that end between words, but not after a colon, the second and later ones indented. */
static void print_filled(int indent, const char *text, size_t n_text) {
    const size_t room = (size_t)(LINE_WIDTH - indent);
    for (size_t n; n_text > room; text += n + 1, n_text -= n + 1) {
        for (n = room; n > 0 && (text[n] != ' ' || text[n - 1] == ':');)
            --n;
        if (n == 0)
            break;
        printf("%.*s\n%*s", (int)n, text, indent, "");
    }
    printf("%.*s\n", (int)n_text, text);
}

static void print_columns(const char *left, const char *right) {
    printf("%-*s ", LEFT_WIDTH, left);
    print_filled(LEFT_WIDTH + 1, right, strlen(right));
}

static void print_paragraph(const char *line, size_t n) {
    print_filled(0, line, n);
}

static void print_row(void *user, const help_row *row) {
    char left[NQM_OPTION_TEXT_MAX + 64], short_form[8] = "    ";
    (void)user;
    if (row->letter)
        snprintf(short_form, sizeof short_form, "-%c, ", row->letter);
    snprintf(left, sizeof left, "  %s--%s%s%s", short_form, row->name, row->metavar ? " " : "",
             row->metavar ? row->metavar : "");
    print_columns(left, row->text);
}

static void print_indented(const char *line, size_t n) {
    printf("  %.*s\n", (int)n, line);
}

void print_help(const command *cmd) {
    printf("usage: nqm %s %s\n\n", verb_name(), cmd->usage);
    each_line(cmd->about, print_paragraph);
    for (const choice *c = cmd->choices; c && c->name; ++c) {
        char left[80];
        snprintf(left, sizeof left, "  %s%s%s", c->name, *c->arguments ? " " : "", c->arguments);
        print_columns(left, c->help);
    }
    printf("\noptions:\n");
    each_option(cmd, print_row, NULL);
    printf("\nexample:\n");
    each_line(cmd->example, print_indented);
}

/* ---- nqm help ---------------------------------------------------------------------------------------------------- */

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

void describe_verbs(help_printer *print) {
    for (const verb *v = verbs; v->name; ++v)
        describe(v, print);
}

static void print_usage_text(void) {
    print_usage(stdout);
}

/* print NULL: there is no page of one verb. */
static const struct style {
    const char *name;
    help_printer *print;
    void (*print_all)(void);
} styles[] = {{"text", print_help, print_usage_text},
              {"man", print_man_page, print_man_overview},
              {"markdown", print_markdown, print_reference},
              {"bash", NULL, print_bash},
              {"zsh", NULL, print_zsh},
              {"fish", NULL, print_fish}};
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
             "shell. Installed packages contain the man pages and completions; otherwise add for instance this line "
             "to ~/.bashrc:\n"
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
    if (n && !style->print)
        stop(EXIT_USAGE, "the completion of %s is for all verbs: give none", style->name);
    if (n)
        describe(find_verb(argv[0]), style->print);
    else
        style->print_all();
    return EXIT_OK;
}
