/* SPDX-License-Identifier: MIT
 *
 * Output of the tool: errors with exit codes, progress on a terminal, Ctrl-C, JSON and CSV.
 */
#include "io/json.h"
#include "nqm/tool.h"

#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static const char *current_verb = "";
static volatile sig_atomic_t interrupt_count;
static progress_style progress;
static volatile sig_atomic_t progress_shown; /* the cursor is in a progress line */
static char progress_note[100];
static const char clear_line[] = "\r\033[K";

int exit_code_of(nqm_status status) {
    static const int codes[] = {[-NQM_OK] = EXIT_OK,
                                [-NQM_ERR_ARG] = EXIT_USAGE,
                                [-NQM_ERR_IO] = EXIT_OPEN,
                                [-NQM_ERR_FORMAT] = EXIT_MALFORMED,
                                [-NQM_ERR_INCOMPATIBLE] = EXIT_INCOMPATIBLE,
                                [-NQM_ERR_MODEL] = EXIT_MODEL,
                                [-NQM_ERR_NOMEM] = EXIT_LIMIT,
                                [-NQM_ERR_LIMIT] = EXIT_LIMIT,
                                [-NQM_ERR_NUMERIC] = EXIT_NUMERIC,
                                [-NQM_ERR_CANCELLED] = EXIT_INTERRUPTED};
    return codes[-status];
}

void set_verb(const char *name) {
    current_verb = name;
}

const char *verb_name(void) {
    return current_verb;
}

int report_error(const nqm_error *err) {
    const char *message = err->message[0] ? err->message : nqm_status_text(err->status);
    size_t n_prefix;
    const char *stream = stream_name(message, &n_prefix);
    end_progress();
    fprintf(stderr, "nqm %s: %s%s\n", current_verb, stream, shown(message + n_prefix));
    return exit_code_of(err->status);
}

static void print_message(const char *format, va_list args) {
    enum { MAX_MESSAGE = 1 << 14 }; /* names in it may be long */
    char message[MAX_MESSAGE];
    vsnprintf(message, sizeof message, format, args);
    end_progress();
    fprintf(stderr, "nqm %s: %s\n", current_verb, shown(message));
}

int report(int exit_code, const char *format, ...) {
    va_list args;
    va_start(args, format);
    print_message(format, args);
    va_end(args);
    return exit_code;
}

void report_part(void *user, nqm_status status, const char *message) {
    nqm_error err = {.status = status};
    (void)user;
    snprintf(err.message, sizeof err.message, "%s", message);
    if (status == NQM_OK)
        report(EXIT_OK, "%s", message);
    else
        report_error(&err);
}

/* Without the handlers of exit(): leak checkers would report the memory that is left to the system. */
static _Noreturn void leave(int exit_code) {
    abandon_outputs();
    _exit(finish(exit_code));
}

void stop(int exit_code, const char *format, ...) {
    va_list args;
    va_start(args, format);
    print_message(format, args);
    va_end(args);
    leave(exit_code);
}

void stop_error(const nqm_error *err) {
    leave(report_error(err));
}

nqm_error fault;

void must(nqm_status status) {
    if (status != NQM_OK)
        stop_error(&fault);
}

static json_malloc_t json_malloc;

static void *json_malloc_or_stop(size_t n) {
    return must_have(json_malloc(n));
}

void stop_without_json_memory(void) {
    json_free_t release;
    json_get_alloc_funcs(&json_malloc, &release);
    json_set_alloc_funcs(json_malloc_or_stop, release);
}

json_t *parse_json(const char *text) {
    json_t *json;
    must(nqm_json_parse(text, &json, &fault));
    return json;
}

int finish(int exit_code) {
    bool has_arrived = exit_code != EXIT_OK || flush_output_path();
    has_arrived = fflush(stdout) == 0 && !ferror(stdout) && has_arrived;
    if (has_arrived || exit_code > EXIT_GATE) /* otherwise the reason has been reported */
        return exit_code;
    return report(EXIT_OPEN, "standard output: cannot write");
}

/* ---- Ctrl-C ------------------------------------------------------------------------------------------------------ */

/* Verbs stop where they ask interrupted(), or where a progress callback says so. Work that does not ask in time is
 * ended here. A verb that saves work for a later run has more time: on a busy machine until it has had this much
 * processor time, unless the process waits for input. */
static const double grace_s = 0.3, saving_s = 0.7, saving_processor_s = 0.6, waiting_processor_s = 0.002;
static double interrupt_s, interrupt_processor_s;
static volatile sig_atomic_t saves_work, child_group;

void note_child(int group) {
    child_group = group;
}

static double processor_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* End at once without a trace: only calls that are allowed in a signal handler. */
static _Noreturn void vanish(int exit_code) {
    nqm_outfile_unlink_all();
    remove_empty_folder();
    if (child_group)
        kill(-child_group, SIGKILL);
    _exit(exit_code);
}

static void on_alarm(int signal_number) {
    static const char message[] = ": interrupted\n";
    const double used_s = processor_s() - interrupt_processor_s;
    (void)signal_number;
    if (nqm_clock_s() - interrupt_s < (saves_work ? saving_s : grace_s) ||
        (saves_work && used_s < saving_processor_s && used_s > waiting_processor_s))
        return;
    if (progress_shown)
        (void)!write(STDERR_FILENO, clear_line, sizeof clear_line - 1);
    (void)!write(STDERR_FILENO, "nqm ", 4);
    (void)!write(STDERR_FILENO, current_verb, strlen(current_verb));
    (void)!write(STDERR_FILENO, message, sizeof message - 1);
    vanish(EXIT_INTERRUPTED);
}

static void on_interrupt(int signal_number) {
    const struct itimerval often = {{0, 100000}, {0, 100000}};
    if (++interrupt_count > 2) /* the third time */
        vanish(128 + signal_number);
    if (interrupt_count > 1)
        return;
    interrupt_s = nqm_clock_s();
    interrupt_processor_s = processor_s();
    setitimer(ITIMER_REAL, &often, NULL);
}

void catch_interrupt(void) {
    struct sigaction action = {.sa_handler = on_interrupt};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    struct sigaction hangup;
    if (sigaction(SIGHUP, NULL, &hangup) == 0 && hangup.sa_handler != SIG_IGN) /* ignored, as under nohup */
        sigaction(SIGHUP, &action, NULL);
    action.sa_handler = on_alarm;
    action.sa_flags = SA_RESTART;
    sigaction(SIGALRM, &action, NULL);
    signal(SIGPIPE, SIG_DFL);
}

void save_when_interrupted(void) {
    saves_work = 1;
}

bool interrupted(void) {
    return interrupt_count != 0;
}

void set_progress(progress_style style) {
    progress = style;
}

/* Estimate the remaining time from the speed of about the last minute, so that work done before the run and a quicker
 * first part do not distort it. NaN: too early to tell. */
static double seconds_left(bool begins, double now_s, double done, double total) {
    enum { N = 32 };
    static struct { double time_s, done; } sample[N];
    static size_t n;
    const double spacing_s = 2;
    n = begins ? 0 : n;
    if (n == 0 || now_s - sample[(n - 1) % N].time_s >= spacing_s) {
        sample[n % N].time_s = now_s;
        sample[n++ % N].done = done;
    }
    const size_t oldest = n > N ? n % N : 0;
    const double elapsed_s = now_s - sample[oldest].time_s, more = done - sample[oldest].done;
    return elapsed_s >= spacing_s && more > 0 ? elapsed_s * (total - done) / more : (double)NAN;
}

int show_progress(void *user, const char *stage, double done, double total) {
    static char last_stage[64];
    static int last_percent;
    const int percent = total > 0 ? (int)(100 * done / total) : 0;
    const bool begins = strncmp(last_stage, stage, sizeof last_stage - 1) != 0;
    (void)user;
    if (begins) {
        snprintf(last_stage, sizeof last_stage, "%s", stage);
        last_percent = -1;
    }
    const double left_s = seconds_left(begins, nqm_clock_s(), done, total);
    char left[40] = "", count[80] = ""; /* a total of 100 is percent */
    if (left_s >= 0)                    /* false for NaN */
        snprintf(left, sizeof left, ", %.0f %s left", left_s < 600 ? left_s : left_s / 60, left_s < 600 ? "s" : "min");
    if (total != 100)
        snprintf(count, sizeof count, " (%.0f of %.0f)", floor(done), total);
    progress_shown = progress != PROGRESS_NONE && isatty(STDERR_FILENO);
    if (progress_shown && total > 0)
        fprintf(stderr, "\r%s: %d %%%s%s%s \033[K", stage, percent, count, left, progress_note);
    else if (progress_shown)
        fprintf(stderr, "\r%s: %.0f \033[K", stage, done);
    else if (progress == PROGRESS_LOG && percent != last_percent)
        fprintf(stderr, "%s: %d %%%s%s\n", stage, percent, count, left);
    last_percent = percent;
    return interrupt_count != 0;
}

void note_progress(const char *format, ...) {
    progress_note[0] = ',';
    progress_note[1] = ' ';
    va_list args;
    va_start(args, format);
    vsnprintf(progress_note + 2, sizeof progress_note - 2, format, args);
    va_end(args);
}

void step_progress(const char *stage, size_t done, size_t total) {
    if (show_progress(NULL, stage, (double)done, (double)total))
        stop(EXIT_INTERRUPTED, "interrupted");
}

void end_progress(void) {
    if (progress_shown)
        fputs(clear_line, stderr);
    progress_shown = false;
}

int print_json(json_t *value) {
    end_progress();
    if (!value)
        stop(EXIT_LIMIT, "cannot write JSON: a name is not UTF-8, or out of memory");
    json_dumpf(value, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9)); /* finish() notices a failure */
    json_decref(value);
    putchar('\n');
    return EXIT_OK;
}

int print_document(json_t *members) {
    json_t *document = json_row("schema:i tool:o", 1, json_tool());
    if (json_object_update_new(document, members) != 0) {
        json_decref(document);
        document = NULL;
    }
    return print_json(document);
}

static void print_value(const json_t *value) {
    const char *key, *comma = "";
    size_t i;
    json_t *item;
    if (json_is_string(value))
        fputs(shown(json_string_value(value)), stdout);
    else if (json_is_boolean(value))
        fputs(json_is_true(value) ? "yes" : "no", stdout);
    else if (json_is_number(value))
        printf("%.9g", json_number_value(value));
    else if (json_is_null(value))
        putchar('-');
    json_array_foreach(value, i, item) {
        fputs(i ? ", " : "", stdout);
        print_value(item);
    }
    json_object_foreach((json_t *)(uintptr_t)value, key, item) {
        printf("%s%s ", comma, key);
        print_value(item);
        comma = ", ";
    }
}

int print_members(json_t *members) {
    const char *key;
    json_t *value;
    json_object_foreach(members, key, value) {
        if (json_is_null(value) || (json_is_string(value) && !*json_string_value(value)))
            continue;
        printf("%-14s ", key);
        print_value(value);
        putchar('\n');
    }
    json_decref(members);
    return EXIT_OK;
}

const char *shown(const char *text) {
    static struct copy {
        struct copy *next;
        char text[];
    } * copies; /* kept to the end: there are few such texts */
    struct copy *made = NULL;
    for (size_t i = 0; text[i]; ++i) {
        const unsigned char *c = (const unsigned char *)text + i;
        const size_t n = *c < ' ' || *c == 0x7f ? 1 : *c == 0xc2 && c[1] >= 0x80 && c[1] <= 0x9f ? 2 : 0;
        if (n && !made) {
            made = allocate(1, sizeof *made + strlen(text) + 1);
            strcpy(made->text, text);
            made->next = copies;
            copies = made;
        }
        if (n)
            memset(made->text + i, '?', n);
        i += n == 2;
    }
    return made ? made->text : text;
}

json_t *json_name(const char *text) {
    json_t *string = json_string(text);
    char *ascii = string ? NULL : strdup(text);
    for (char *p = ascii; p && *p; ++p)
        if (*p & 0x80)
            *p = '?';
    if (ascii)
        string = json_string(ascii);
    free(ascii);
    return string;
}

json_t *json_number(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static void set_members(json_t *object, const char **format, va_list *values);

/* The value of a letter, a list "[ff]" or an object "{key:f}"; *format moves behind it. */
static json_t *take_value(const char **format, va_list *values) {
    json_t *group = NULL;
    const char *text;
    switch (*(*format)++) {
    case 's':
        text = va_arg(*values, const char *);
        return text ? json_name(text) : json_null();
    case 't':
        text = va_arg(*values, const char *);
        return text && *text ? json_name(text) : json_null();
    case 'f':
        return json_number(va_arg(*values, double));
    case 'z':
        return json_integer((json_int_t)va_arg(*values, size_t));
    case 'i':
        return json_integer(va_arg(*values, int));
    case 'b':
        return json_boolean(va_arg(*values, int));
    case '{':
        group = json_object();
        set_members(group, format, values);
        break;
    case '[':
        for (group = json_array(); **format != ']';)
            json_array_append_new(group, take_value(format, values));
        break;
    case 'O':
        return json_incref(va_arg(*values, json_t *));
    default:
        return va_arg(*values, json_t *);
    }
    ++*format;
    return group;
}

static void set_members(json_t *object, const char **format, va_list *values) {
    while (**format && **format != '}') {
        char key[40];
        const size_t n = strcspn(*format, ":");
        snprintf(key, sizeof key, "%.*s", (int)n, *format);
        *format += n + 1;
        json_t *value = take_value(format, values);
        if (value)
            json_object_set_new(object, key, value);
        *format += strspn(*format, " ");
    }
}

json_t *json_set(json_t *object, const char *format, ...) {
    va_list values;
    va_start(values, format);
    set_members(object, &format, &values);
    va_end(values);
    return object;
}

json_t *json_tool(void) {
    return json_row("name:s version:s", "nqm", nqm_version());
}

/* Readers strip blanks around unquoted fields, and skip lines that begin with '#'. */
static bool is_plain(const char *text) {
    size_t n = strlen(text);
    return !strpbrk(text, ",\"\r\n") && (n == 0 || !strchr("# \t", text[0])) && (n == 0 || !strchr(" \t", text[n - 1]));
}

void print_csv_text(FILE *out, const char *text) {
    if (is_plain(text)) {
        fputs(text, out);
        return;
    }
    fputc('"', out);
    for (; *text; ++text) {
        if (*text == '"')
            fputc('"', out);
        fputc(*text, out);
    }
    fputc('"', out);
}

void print_csv_field(FILE *out, const char *text) {
    fputc(',', out);
    print_csv_text(out, text);
}

void print_csv_number(FILE *out, double value) {
    if (isfinite(value))
        fprintf(out, "%.9g", value);
}

void print_csv_numbers(FILE *out, size_t n, const double *values) {
    for (size_t i = 0; i < n; ++i) {
        fputc(',', out);
        print_csv_number(out, values[i]);
    }
}

void print_phrases(const char *text) {
    enum { INDENT = 9, N_LINE = 80 - INDENT };
    while (strlen(text) > N_LINE) {
        size_t n = 0;
        for (size_t i = 0; i < N_LINE && text[i + 1]; ++i)
            if ((text[i] == ',' || text[i] == ';') && text[i + 1] == ' ')
                n = i + 1;
        if (n == 0)
            break;
        printf("%*s%.*s\n", INDENT, "", (int)n, text);
        text += n + 1;
    }
    printf("%*s%s\n", INDENT, "", text);
}
