/* SPDX-License-Identifier: MIT
 *
 * Manual pages and the reference of the command line in Markdown.
 */
#include "nqm/help.h"

#include <ctype.h>
#include <string.h>

/* ---- man --------------------------------------------------------------------------------------------------------- */

/* Text of a page: '-' must not become a hyphen, and a '.' or '\'' at the begin of a line is a command. */
static void put_roff(const char *text, size_t n) {
    if (n && (*text == '.' || *text == '\''))
        fputs("\\&", stdout);
    for (size_t i = 0; i < n; ++i)
        if (text[i] == '\\')
            fputs("\\e", stdout);
        else if (text[i] == '-')
            fputs("\\-", stdout);
        else
            putchar(text[i]);
}

static void put_roff_text(const char *text) {
    put_roff(text, strlen(text));
}

/* A line of a paragraph; an indented line is not filled. */
static void put_roff_line(const char *line, size_t n) {
    if (*line == ' ')
        printf(".br\n");
    put_roff(line, n);
    putchar('\n');
}

static void put_man_row(void *user, const help_row *row) {
    (void)user;
    printf(".TP\n");
    if (row->letter)
        printf("\\fB\\-%c\\fR, ", row->letter);
    printf("\\fB\\-\\-");
    put_roff_text(row->name);
    printf("\\fR");
    if (row->metavar) {
        printf(" \\fI");
        put_roff_text(row->metavar);
        printf("\\fR");
    }
    putchar('\n');
    put_roff_text(row->text);
    putchar('\n');
}

static void put_man_title(const char *verb_or_empty, const char *summary) {
    char name[64] = "nqm";
    snprintf(name, sizeof name, "nqm%s%s", *verb_or_empty ? "-" : "", verb_or_empty);
    printf(".\\\" Made by nqm help --format man.\n.TH ");
    for (const char *p = name; *p; ++p)
        putchar(toupper((unsigned char)*p));
    printf(" 1 \"\" \"nqm %s\" \"nqm manual\"\n.SH NAME\n", nqm_version());
    put_roff_text(name);
    printf(" \\- ");
    put_roff_text(summary);
    printf("\n.SH SYNOPSIS\n");
}

static void put_synopsis(const char *line, size_t n) {
    const char *begin = line;
    while (begin < line + n && *begin == ' ')
        ++begin;
    if (begin > line) { /* a further line of a usage begins with "nqm VERB" */
        printf(".br\n");
        put_roff(begin, n - (size_t)(begin - line));
    } else {
        printf("\\fBnqm %s\\fR ", verb_name());
        put_roff(line, n);
    }
    putchar('\n');
}

void print_man_page(const command *cmd) {
    put_man_title(verb_name(), find_verb(verb_name())->summary);
    each_line(cmd->usage, put_synopsis);
    printf(".SH DESCRIPTION\n");
    each_line(cmd->about, put_roff_line);
    for (const choice *c = cmd->choices; c && c->name; ++c) {
        printf(".TP\n\\fB");
        put_roff_text(c->name);
        printf("\\fR%s\\fI", *c->arguments ? " " : "");
        put_roff_text(c->arguments);
        printf("\\fR\n");
        put_roff_text(c->help);
        putchar('\n');
    }
    printf(".SH OPTIONS\n");
    each_option(cmd, put_man_row, NULL);
    printf(".SH EXAMPLES\n.nf\n");
    each_line(cmd->example, put_roff_line);
    printf(".fi\n.SH EXIT STATUS\n0 on success; \\fBnqm\\fR(1) lists the others.\n.SH SEE ALSO\n\\fBnqm\\fR(1)\n");
}

static const struct exit_status {
    int code;
    const char *meaning;
} exit_statuses[] = {{EXIT_OK, "success"},
                     {EXIT_GATE, "a gate failed: a score below --fail-under, a BRDF that fails check"},
                     {EXIT_USAGE, "usage: an option, an argument or a spec is wrong"},
                     {EXIT_OPEN, "a file cannot be opened, read or written"},
                     {EXIT_MALFORMED, "a file is malformed"},
                     {EXIT_INCOMPATIBLE, "inputs are incompatible, or too few directions have a value"},
                     {EXIT_MODEL, "a model is missing or damaged"},
                     {EXIT_LIMIT, "out of memory, or a size limit"},
                     {EXIT_NUMERIC, "a computation failed; the self-test of doctor failed"},
                     {EXIT_PARTIAL, "some items of a batch failed"},
                     {EXIT_INTERRUPTED, "interrupted"}};

void print_man_overview(void) {
    put_man_title("", "how good a BRDF approximation looks beside its reference");
    printf(
        "\\fBnqm\\fR \\fIVERB\\fR [\\fIarguments\\fR]\n.SH DESCRIPTION\n"
        "Predicts how good a BRDF approximation looks compared with its reference, in JOD (just\\-objectionable\n"
        "differences), without rendering: 10 is no visible difference; one JOD less means that three in four people "
        "see\n"
        "the approximation as worse. A BRDF argument is a file, a spec (ggx:kd=.2;alpha=.1) or a preset (sgd:nickel).\n"
        ".SH VERBS\n");
    for (const verb *v = verbs; v->name; ++v) {
        if (begins_heading(v))
            printf(".SS %s\n", v->heading);
        printf(".TP\n\\fBnqm\\-%s\\fR(1)\n", v->name);
        put_roff_text(v->summary);
        putchar('\n');
    }
    printf(".SH ENVIRONMENT\n.TP\n\\fBNQM_KERNELS\\fR\nthe code of the network's products: avx512+bf16, avx512, "
           "avx2, generic or scalar.\nDefault: the fastest that the processor supports.\n.SH EXIT STATUS\n");
    for (size_t i = 0; i < sizeof exit_statuses / sizeof *exit_statuses; ++i) {
        printf(".TP\n%d\n", exit_statuses[i].code);
        put_roff_text(exit_statuses[i].meaning);
        putchar('\n');
    }
    printf(".SH EXAMPLES\n.nf\nnqm score sgd:nickel ward:nickel\nnqm fit sgd:nickel \\-\\-model ward\nnqm "
           "doctor\n.fi\n.SH SEE ALSO\n");
    for (const verb *v = verbs; v->name; ++v)
        printf("\\fBnqm\\-%s\\fR(1)%s\n", v->name, v[1].name ? "," : "");
}

/* ---- Markdown ---------------------------------------------------------------------------------------------------- */

/* Text outside of code. */
static void put_markdown_text(const char *text) {
    for (; *text; ++text)
        fputs(*text == '<' ? "&lt;" : (char[]){*text, '\0'}, stdout);
}

/* Rows that the page has already. An option is described once; a verb that has the same row again refers to it. */
static struct shown_row { char name[NQM_OPTION_TEXT_MAX], text[1024], verb[32]; } shown_rows[512];
static size_t n_shown_rows, n_before; /* n_before: those of earlier verbs */

static const struct shown_row *find_shown_row(const help_row *row) {
    for (size_t i = 0; i < n_shown_rows; ++i)
        if (strcmp(shown_rows[i].name, row->name) == 0 && strcmp(shown_rows[i].text, row->text) == 0 &&
            strcmp(shown_rows[i].verb, verb_name()) != 0)
            return &shown_rows[i];
    return NULL;
}

static void put_markdown_row(void *user, const help_row *row) {
    (void)user;
    if (find_shown_row(row) || strcmp(row->name, "help") == 0)
        return;
    if (n_shown_rows < sizeof shown_rows / sizeof *shown_rows) {
        struct shown_row *shown = &shown_rows[n_shown_rows++];
        snprintf(shown->name, sizeof shown->name, "%s", row->name);
        snprintf(shown->text, sizeof shown->text, "%s", row->text);
        snprintf(shown->verb, sizeof shown->verb, "%s", verb_name());
    }
    if (strncmp(row->name, "no-", 3) == 0) /* begin_markdown() says it */
        return;
    printf("- ");
    if (row->letter)
        printf("`-%c`, ", row->letter);
    printf("`--%s%s%s`: ", row->name, row->metavar ? " " : "", row->metavar ? row->metavar : "");
    put_markdown_text(row->text);
    putchar('\n');
}

/* Options of an earlier verb that are named together: the first three, and the last one of more. */
typedef struct repeated {
    const char *verb; /* NULL: none yet */
    size_t n;
    char last[NQM_OPTION_TEXT_MAX];
} repeated;

static void end_repeated(const repeated *r) {
    if (r->n > 3)
        printf("%s`--%s`", r->n > 4 ? " ... " : ", ", r->last);
}

static void put_repeated_row(void *user, const help_row *row) {
    const struct shown_row *shown = find_shown_row(row);
    repeated *r = user;
    if (!shown)
        return;
    if (!r->verb || strcmp(r->verb, shown->verb) != 0) {
        end_repeated(r);
        printf("%s `%s`: ", r->verb ? "; as for" : n_shown_rows > n_before ? "\nAs for" : "As for", shown->verb);
        *r = (repeated){.verb = shown->verb};
    }
    snprintf(r->last, sizeof r->last, "%s", row->name);
    if (++r->n <= 3)
        printf("%s`--%s`", r->n > 1 ? ", " : "", row->name);
}

/* The first sentence of a description; doc/cli.md has the rest. */
static void put_first_sentence(const char *about) {
    size_t n = 1;
    while (about[n] && !((about[n] == ' ' || about[n] == '\n') && strchr(".?", about[n - 1])))
        ++n;
    printf("%.*s\n", (int)n, about);
}

void begin_markdown(void) {
    puts("# Reference of the command line\n\n"
         "Which options does a verb have? This page is made from the option tables of the tool (`./dev pages`). `nqm "
         "VERB\n"
         "--help` and `man nqm-VERB` add the rest of the description and examples; [cli.md](cli.md) has output, JSON "
         "and\n"
         "failures. An option that several verbs have is described at the first one. A flag is switched off by "
         "`no-` before its name.");
    for (const verb *v = verbs; v->name; ++v) {
        if (begins_heading(v))
            printf("\n- %s:", v->heading);
        printf(" [%s](#nqm-%s)", v->name, v->name);
    }
    putchar('\n');
}

void print_markdown(const command *cmd) {
    printf("\n## nqm %s\n\n<!-- test: text -->\n\n    nqm %s ", verb_name(), verb_name());
    for (const char *p = cmd->usage; *p; ++p)
        if (*p == '\n') {
            printf("\n    ");
            while (p[1] == ' ')
                ++p;
        } else {
            putchar(*p);
        }
    printf("\n\n");
    put_first_sentence(cmd->about);
    putchar('\n');
    const choice *choices = cmd->has_verbs ? NULL : cmd->choices; /* verbs have their own sections */
    for (const choice *c = choices; c && c->name; ++c) {
        printf("- `%s%s%s`: ", c->name, *c->arguments ? " " : "", c->arguments);
        put_markdown_text(c->help);
        putchar('\n');
    }
    if (choices)
        putchar('\n');
    n_before = n_shown_rows;
    each_option(cmd, put_markdown_row, NULL);
    repeated r = {0};
    each_option(cmd, put_repeated_row, &r);
    end_repeated(&r);
    printf("%s", r.verb ? "\n" : "");
}
