/* SPDX-License-Identifier: MIT
 *
 * Completions of bash, zsh and fish. Where nothing else is known, they complete names of presets, which `nqm info list`
 * prints, and of files.
 */
#include "nqm/help.h"

#include <string.h>

/* Text between single quotes: POSIX shells end and reopen the quotes around an escaped one, fish escapes it. Brackets and
 * colons have a meaning for zsh. */
static void put_quoted(const char *text, const char *quote, const char *escaped) {
    for (; *text; ++text)
        if (*text == '\'')
            fputs(quote, stdout);
        else
            printf("%s%c", strchr(escaped, *text) ? "\\" : "", *text);
}

static void put_words(const char *const *words) {
    for (size_t i = 0; words[i]; ++i)
        if (*words[i])
            printf("%s%s", i ? " " : "", words[i]);
}

/* The values that an option may have, the names of models, or NULL: files. */
static const char *const *offered(const help_row *row) {
    static const char *models[16];
    if (row->words || !row->metavar || strcmp(row->metavar, "MODEL") != 0)
        return row->words;
    for (size_t i = 0; i < nqm_model_builtin_count() && i + 1 < sizeof models / sizeof *models; ++i)
        models[i] = nqm_model_builtin_name(i);
    return *models ? models : NULL;
}

/* ---- bash -------------------------------------------------------------------------------------------------------- */

void begin_bash(void) {
    printf(
        "# Completion of nqm for bash; made by `nqm help --format bash`.\n"
        "_nqm() {\n"
        "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} options='' choices='' values=''\n"
        "    COMPREPLY=()\n"
        "    # bash splits --name=value into three words.\n"
        "    if [[ $cur == = ]]; then\n        cur=''\n"
        "    elif [[ $prev == = ]]; then\n        prev=${COMP_WORDS[COMP_CWORD - 2]}\n    fi\n"
        "    if ((COMP_CWORD == 1)); then\n        mapfile -t COMPREPLY < <(compgen -W '");
    for (const verb *v = verbs; v->name; ++v)
        printf("%s ", v->name);
    printf("--help --version' -- \"$cur\")\n        return\n    fi\n    case ${COMP_WORDS[1]} in\n");
}

static void put_bash_option(void *user, const help_row *row) {
    (void)user;
    if (row->letter)
        printf("-%c ", row->letter);
    printf("--%s ", row->name);
}

static void put_bash_values(void *user, const help_row *row) {
    (void)user;
    if (!offered(row))
        return;
    printf("        ");
    if (row->letter)
        printf("-%c | ", row->letter);
    printf("--%s) values='", row->name);
    put_words(offered(row));
    printf("' ;;\n");
}

void print_bash_verb(const command *cmd) {
    printf("    %s)\n        options='", verb_name());
    each_option(cmd, put_bash_option, NULL);
    printf("'\n        choices='");
    for (const choice *c = cmd->choices; c && c->name; ++c)
        printf("%s ", c->name);
    printf("'\n        case $prev in\n");
    each_option(cmd, put_bash_values, NULL);
    printf("        esac\n        ;;\n");
}

void end_bash(void) {
    printf("    esac\n"
           "    if [[ -n $values ]]; then\n"
           "        mapfile -t COMPREPLY < <(compgen -W \"$values\" -- \"$cur\")\n"
           "    elif [[ $cur == -* ]]; then\n"
           "        mapfile -t COMPREPLY < <(compgen -W \"$options\" -- \"$cur\")\n"
           "    elif ((COMP_CWORD == 2)); then\n"
           "        mapfile -t COMPREPLY < <(compgen -W \"$choices\" -- \"$cur\")\n"
           "    fi\n"
           "    [[ ${#COMPREPLY[@]} == 0 && $cur != -* && -n $cur ]] || return 0\n"
           "    # A preset family:material, which bash splits at the colon; it replaces the last part.\n"
           "    local i before='' typed=''\n"
           "    for ((i = COMP_CWORD; i > 1; --i)); do\n"
           "        typed=${COMP_WORDS[i]}$typed\n"
           "        [[ ${COMP_WORDS[i]} == : || ${COMP_WORDS[i - 1]} == : ]] || break\n"
           "    done\n"
           "    [[ $typed == *:* && $cur != ?*:* ]] && before=${typed%%%%:*}:\n"
           "    mapfile -t COMPREPLY < <(compgen -W \"$(nqm info list 2>/dev/null)\" -- \"$typed\")\n"
           "    COMPREPLY=(\"${COMPREPLY[@]#\"$before\"}\")\n"
           "    mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- \"$cur\")\n"
           "}\n"
           "complete -o default -o bashdefault -F _nqm nqm\n");
}

/* ---- zsh --------------------------------------------------------------------------------------------------------- */

static void put_zsh(const char *text) {
    put_quoted(text, "'\\''", "[]:\\");
}

void begin_zsh(void) {
    printf("#compdef nqm\n# Completion of nqm for zsh; made by `nqm help --format zsh`.\n"
           "_nqm_brdf() {\n    local -a presets=(${(f)\"$(nqm info list 2>/dev/null)\"})\n"
           "    _alternative 'presets:preset:compadd -a presets' 'files:file:_files'\n}\n"
           "_nqm() {\n    local context state state_descr line curcontext=\"$curcontext\"\n    typeset -A opt_args\n   "
           " local -a verbs\n"
           "    _arguments -C '--version[list the libraries of this build]' '1:verb:->verb' '*::argument:->argument'\n"
           "    if [[ $state == verb ]]; then\n        verbs=(\n");
    for (const verb *v = verbs; v->name; ++v) {
        printf("            '%s:", v->name);
        put_zsh(v->summary);
        printf("'\n");
    }
    printf("        )\n        _describe verb verbs\n        return\n    fi\n    case $words[1] in\n");
}

static void put_zsh_row(void *user, const help_row *row) {
    (void)user;
    printf(" \\\n            ");
    if (row->letter)
        printf("'(-%c --%s)'{-%c,--%s}'", row->letter, row->name, row->letter, row->name);
    else
        printf("'--%s", row->name);
    printf("[");
    put_zsh(row->help);
    printf("]");
    if (row->metavar) {
        printf(":");
        put_zsh(row->metavar);
        printf(offered(row) ? ":(" : ":_files");
        if (offered(row))
            put_words(offered(row));
        printf("%s", offered(row) ? ")" : "");
    }
    printf("'");
}

void print_zsh_verb(const command *cmd) {
    printf("    %s)\n        _arguments", verb_name());
    each_option(cmd, put_zsh_row, NULL);
    if (cmd->choices) {
        printf(" \\\n            '1:word:(");
        for (const choice *c = cmd->choices; c->name; ++c)
            printf("%s%s", c == cmd->choices ? "" : " ", c->name);
        printf(")'");
    }
    printf(" \\\n            '*:BRDF or file:_nqm_brdf'\n        ;;\n");
}

void end_zsh(void) {
    printf("    esac\n}\n_nqm \"$@\"\n");
}

/* ---- fish -------------------------------------------------------------------------------------------------------- */

static void put_fish(const char *text) {
    put_quoted(text, "\\'", "\\");
}

void begin_fish(void) {
    printf("# Completion of nqm for fish; made by `nqm help --format fish`.\n"
           "complete -c nqm -n __fish_use_subcommand -l version -d 'list the libraries of this build'\n");
    puts("complete -c nqm -n 'not __fish_use_subcommand' -a '(nqm info list 2>/dev/null)'");
    for (const verb *v = verbs; v->name; ++v) {
        printf("complete -c nqm -f -n __fish_use_subcommand -a %s -d '", v->name);
        put_fish(v->summary);
        printf("'\n");
    }
}

static void put_fish_row(void *user, const help_row *row) {
    (void)user;
    printf("complete -c nqm -n '__fish_seen_subcommand_from %s' ", verb_name());
    if (row->letter)
        printf("-s %c ", row->letter);
    printf("-l %s ", row->name);
    if (row->metavar)
        printf("-r ");
    if (offered(row)) {
        printf("-f -a '");
        put_words(offered(row));
        printf("' ");
    }
    printf("-d '");
    put_fish(row->help);
    printf("'\n");
}

void print_fish_verb(const command *cmd) {
    each_option(cmd, put_fish_row, NULL);
    for (const choice *c = cmd->choices; c && c->name; ++c) {
        printf("complete -c nqm -n '__fish_seen_subcommand_from %s' -a %s -d '", verb_name(), c->name);
        put_fish(c->help);
        printf("'\n");
    }
}
