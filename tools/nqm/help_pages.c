/* SPDX-License-Identifier: MIT
 *
 * Manual pages, the reference of the command line in Markdown, and completions of shells. Where nothing else is known, these complete
 * names of presets, which `nqm info list` prints, and of files.
 */
#include "nqm/help.h"
#include "nqm/template.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* ---- templates --------------------------------------------------------------------------------------------------- */

/* The texts of help/ (cmake/embed_text.cmake). */
extern const char help_bash[], help_zsh[], help_fish[], help_man[], help_overview[];

/* The values that an option may have, the names of models, or NULL: files. */
static const char *const *offered(const help_row *row) {
    static const char *models[16];
    if (row->words || !row->metavar || strcmp(row->metavar, "MODEL") != 0)
        return row->words;
    for (size_t i = 0; nqm_model_builtin_name(i) && i + 1 < sizeof models / sizeof *models; ++i)
        models[i] = nqm_model_builtin_name(i);
    return *models ? models : NULL;
}

static void add_option(void *list, const help_row *row) {
    const char *const *values = offered(row);
    char *words, letter[] = {row->letter, '\0'};
    size_t n;
    FILE *out = open_text(&words, &n);
    for (size_t i = 0; values && values[i]; ++i)
        if (*values[i])
            fprintf(out, "%s%s", i ? " " : "", values[i]);
    close_text(out, &words, &n);
    json_array_append_new(list, json_row("letter:t name:s metavar:s help:s text:s words:t", letter, row->name,
                                         row->metavar, row->help, row->text, words));
    free(words);
}

static json_t *list; /* that the functions below append to */

static void add_line(const char *line, size_t n) {
    const size_t n_blank = strspn(line, " ");
    json_array_append_new(list, json_row("line:o bare:o indented:b", json_stringn(line, n),
                                         json_stringn(line + n_blank, n - n_blank), n_blank > 0));
}

static json_t *json_lines(const char *text) {
    json_t *outer = list, *lines = list = json_array();
    each_line(text, add_line);
    list = outer;
    return lines;
}

static json_t *json_verb(const command *cmd) {
    const verb *v = find_verb(verb_name());
    json_t *choices = json_array(), *rows = json_array();
    char title[32], words[512] = "";
    for (size_t i = 0; i <= strlen(v->name) && i < sizeof title; ++i)
        title[i] = (char)toupper((unsigned char)v->name[i]);
    for (const choice *c = cmd->choices; c && c->name; ++c) {
        const size_t n = strlen(words);
        json_array_append_new(choices, json_row("name:s arguments:s help:s", c->name, c->arguments, c->help));
        snprintf(words + n, sizeof words - n, "%s%s", n ? " " : "", c->name);
    }
    each_option(cmd, add_option, rows);
    return json_row("verb:s summary:s title:s version:s usage:o about:o example:o options:o choices:o words:t", v->name,
                    v->summary, title, nqm_version(), json_lines(cmd->usage), json_lines(cmd->about),
                    json_lines(cmd->example), rows, choices, words);
}

static void add_verb(const command *cmd) {
    json_array_append_new(list, json_verb(cmd));
}

static void fill_for_all(const char *text, template_escape *escape) {
    list = json_array();
    describe_verbs(add_verb);
    fill_template(stdout, text, escape, json_row("verbs:o", list), NULL, NULL);
}

/* ---- completions ------------------------------------------------------------------------------------------------- */

/* Text between single quotes: POSIX shells end and reopen the quotes around an escaped one, fish escapes it. Brackets and
 * colons have a meaning for zsh. */
static void put_quoted(FILE *out, const char *text, const char *quote, const char *escaped) {
    for (; *text; ++text)
        if (*text == '\'')
            fputs(quote, out);
        else
            fprintf(out, "%s%c", strchr(escaped, *text) ? "\\" : "", *text);
}

static void put_zsh(FILE *out, const char *text) {
    put_quoted(out, text, "'\\''", "[]:\\");
}

static void put_fish(FILE *out, const char *text) {
    put_quoted(out, text, "\\'", "\\");
}

void print_bash(void) {
    fill_for_all(help_bash, NULL);
}

void print_zsh(void) {
    fill_for_all(help_zsh, put_zsh);
}

void print_fish(void) {
    fill_for_all(help_fish, put_fish);
}

/* ---- man --------------------------------------------------------------------------------------------------------- */

/* Text of a page: '-' must not become a hyphen, and a '.' or '\'' at the begin of a line is a command. */
static void put_roff(FILE *out, const char *text) {
    if (*text == '.' || *text == '\'')
        fputs("\\&", out);
    for (; *text; ++text)
        if (*text == '\\')
            fputs("\\e", out);
        else
            fprintf(out, "%s%c", *text == '-' ? "\\" : "", *text);
}

void print_man_page(const command *cmd) {
    fill_template(stdout, help_man, put_roff, json_verb(cmd), NULL, NULL);
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
    json_t *all = json_array(), *statuses = json_array();
    for (const verb *v = verbs; v->name; ++v)
        json_array_append_new(all, json_row("heading:s verb:s summary:s is_last:b",
                                            begins_heading(v) ? v->heading : NULL, v->name, v->summary, !v[1].name));
    for (size_t i = 0; i < sizeof exit_statuses / sizeof *exit_statuses; ++i)
        json_array_append_new(statuses, json_row("code:i meaning:s", exit_statuses[i].code, exit_statuses[i].meaning));
    fill_template(stdout, help_overview, put_roff,
                  json_row("version:s verbs:o statuses:o", nqm_version(), all, statuses), NULL, NULL);
}

/* ---- Markdown ---------------------------------------------------------------------------------------------------- */

/* Text outside of code. */
static void put_markdown_text(const char *text) {
    for (; *text; ++text)
        fputs(*text == '<' ? "&lt;" : (char[]){*text, '\0'}, stdout);
}

/* The verb that has an option first, by its name and text. An option is described once; a verb that has the same one again refers to it. */
static json_t *first_verbs;
static bool has_own; /* the verb describes an option */

/* An earlier verb that has the option; NULL: none. */
static const char *earlier_verb(const help_row *row) {
    const json_t *texts = json_object_get(first_verbs, row->name);
    const char *name = json_string_value(json_object_get(texts, row->text));
    return name && strcmp(name, verb_name()) != 0 ? name : NULL;
}

static void put_markdown_row(void *user, const help_row *row) {
    (void)user;
    if (earlier_verb(row) || strcmp(row->name, "help") == 0)
        return;
    has_own = true;
    if (!json_object_get(first_verbs, row->name))
        json_object_set_new(first_verbs, row->name, json_object());
    json_object_set_new(json_object_get(first_verbs, row->name), row->text, json_string(verb_name()));
    if (strncmp(row->name, "no-", 3) == 0) /* print_reference() says it */
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
    const char *earlier = earlier_verb(row);
    repeated *r = user;
    if (!earlier)
        return;
    if (!r->verb || strcmp(r->verb, earlier) != 0) {
        end_repeated(r);
        printf("%s `%s`: ", r->verb ? "; as for" : has_own ? "\nAs for" : "As for", earlier);
        *r = (repeated){.verb = earlier};
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

/* The table of what a score consists of. */
static void put_columns(void) {
    puts("\n## Columns of a score\n\n| CSV, Python | JSON | what |\n|---|---|---|");
    nqm_column c;
    for (size_t i = 0; (c = nqm_pairs_column(i, NULL, NULL)).name; ++i)
        printf("| `%s` | `%s%s%s` | %s |\n", c.name, c.object, *c.object ? "." : "", c.member, c.about);
}

void print_reference(void) {
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
    describe_verbs(print_markdown);
    put_columns();
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
    first_verbs = first_verbs ? first_verbs : json_object();
    has_own = false;
    each_option(cmd, put_markdown_row, NULL);
    repeated r = {0};
    each_option(cmd, put_repeated_row, &r);
    end_repeated(&r);
    printf("%s", r.verb ? "\n" : "");
}
