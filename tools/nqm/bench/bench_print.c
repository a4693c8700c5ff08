/* SPDX-License-Identifier: MIT
 *
 * The rows of a benchmark as JSON and as Markdown tables.
 */
#include "nqm/bench/bench_print.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

/* The user's OpenMP settings, because small batches are much slower with OMP_WAIT_POLICY=passive. */
static json_t *openmp_json(void) {
    static const char *const names[] = {"OMP_NUM_THREADS", "OMP_PROC_BIND", "OMP_WAIT_POLICY"};
    json_t *openmp = json_object();
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        const char *value = getenv(names[i]);
        if (value)
            json_object_set_new(openmp, names[i], json_name(value));
    }
    return openmp;
}

/* Vendor, family, model and stepping, which tell processors of the same name apart. */
static json_t *cpu_id_json(void) {
    static const char *const keys[] = {"vendor_id", "cpu family", "model\t", "stepping"}, *const names[] = {
                                                                                              "vendor", "family",
                                                                                              "model", "stepping"};
    json_t *id = json_object();
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        char value[80];
        nqm_bench_read_value("/proc/cpuinfo", keys[i], value, sizeof value);
        json_object_set_new(id, names[i], json_name(value));
    }
    return id;
}

/* Facts about the machine from the operating system, where it provides them; 0 or "": unknown. */
static json_t *machine_json(void) {
    char cpu[200], mhz_text[40], system_text[200] = "";
    const char *end;
    double mhz, load;
    struct utsname names;
    json_t *caches = json_array();
    nqm_bench_read_value("/proc/cpuinfo", "model name", cpu, sizeof cpu);
    nqm_bench_read_value("/proc/cpuinfo", "cpu MHz", mhz_text, sizeof mhz_text);
    if (!nqm_parse_double(mhz_text, &end, &mhz))
        mhz = 0;
    if (uname(&names) == 0)
        snprintf(system_text, sizeof system_text, "%.60s %.60s %.60s", names.sysname, names.release, names.machine);
    for (size_t level = 0; level + 1 < NQM_BENCH_LEVELS; ++level)
        json_array_append_new(caches, json_integer((json_int_t)(nqm_bench_cache_bytes(level) / 1024)));
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    if (getloadavg(&load, 1) != 1)
        load = 0;
    return json_pack("{s:o,s:o,s:o,s:s,s:i,s:i,s:f,s:o,s:f,s:f,s:s,s:s,s:o}", "cpu", json_name(cpu), "cpu_id",
                     cpu_id_json(), "system", json_name(system_text), "compiler", __VERSION__, "cores",
                     omp_get_num_procs(), "threads", omp_get_max_threads(), "mhz", mhz, "cache_kib", caches,
                     "memory_mb", pages > 0 && page > 0 ? 1e-6 * (double)pages * (double)page : 0, "load_average", load,
                     "kernels", nqm_kernels_selected(), "build", nqm_build_info(), "openmp", openmp_json());
}

static json_t *row_json(const nqm_bench_row *row) {
    json_t *object = json_object();
    for (const nqm_bench_field *f = nqm_bench_fields; f->key; ++f) {
        const bool is_text = f->kind == NQM_BENCH_TEXT || f->kind == NQM_BENCH_PRECISION;
        const char *text = is_text ? nqm_bench_text(row, f) : NULL;
        const double number = is_text ? 0 : nqm_bench_number(row, f);
        if (text)
            json_object_set_new(object, f->key, json_name(text));
        else if (f->kind == NQM_BENCH_COUNT && number > 0)
            json_object_set_new(object, f->key, json_integer((json_int_t)number));
        else if (f->kind == NQM_BENCH_NUMBER && isfinite(number))
            json_object_set_new(object, f->key, json_real(number));
    }
    return object;
}

json_t *bench_json(const nqm_bench *bench) {
    json_t *rows = json_array();
    for (size_t i = 0; i < bench->n_entries; ++i)
        json_array_append_new(rows, row_json(&bench->entry[i].row));
    return json_pack("{s:i,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(), "machine", machine_json(), "rows", rows);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

enum { MAX_COLUMNS = 18 };

/* A column: fields of a row, by their keys. */
typedef struct column {
    const char *heading;
    const char *key;             /* field: a text, a count, or a number with n_digits significant digits */
    const char *times, *divisor; /* fields by which the number is multiplied and divided; NULL: none */
    double factor;               /* 0: 1 */
    int n_digits;                /* 0: a text or a count */
} column;

typedef struct table {
    const char *bench, *title;
    column columns[MAX_COLUMNS + 1]; /* a NULL heading ends them */
} table;

#define TEXT(heading, key)                                                                                             \
    { heading, key, NULL, NULL, 0, 0 }
#define NUMBER(heading, key, n_digits)                                                                                 \
    { heading, key, NULL, NULL, 0, n_digits }
#define MEDIAN_COLUMN                                                                                                  \
    { "median / best", "seconds_median", .divisor = "seconds", .n_digits = 3 }

static const table tables[] = {
    {"peak",
     "Peaks of arithmetic",
     {TEXT("unit", "unit"), TEXT("precision", "precision"), TEXT("", "name"), TEXT("threads", "threads"),
      NUMBER("best, GFLOP/s", "peak_gflops", 3), NUMBER("median, GFLOP/s", "peak_median_gflops", 3)}},
    {"peak",
     "Peaks of reading memory",
     {NUMBER("MB", "megabytes", 3),
      TEXT("threads", "threads"),
      NUMBER("best, GB/s", "peak_gb_per_s", 3),
      {"median, GB/s", "megabytes", .divisor = "seconds_median", .factor = 1e-3, .n_digits = 3}}},
    {"gemm",
     "Matrix products",
     {TEXT("kernels", "kernels"), TEXT("product", NULL), TEXT("batch", "batch"), TEXT("m x n x k", NULL),
      TEXT("precision", "precision"), TEXT("by", "by"), NUMBER("GFLOP/s", "gflops", 3), NUMBER("GB/s", "gb_per_s", 3),
      NUMBER("of the peak", "ratio", 3), TEXT("peak of", "unit"), MEDIAN_COLUMN}},
    {"train",
     "Training",
     {TEXT("recipe", "model"),
      TEXT("precision", "precision"),
      TEXT("kernels", "kernels"),
      TEXT("seed", "seed"),
      TEXT("pairs", "pairs"),
      TEXT("epochs", "epochs"),
      {"TFLOP", "gflop", .factor = 1e-3, .n_digits = 4},
      NUMBER("s", "seconds", 3),
      {"s, all as the best epoch", "best_epoch_seconds", "epochs", .n_digits = 3},
      NUMBER("s, extrapolated to 100 epochs", "seconds_100_epochs", 3),
      NUMBER("GFLOP/s", "gflops", 3),
      NUMBER("floor, s", "floor_seconds", 3),
      NUMBER("x floor", "times_floor", 3),
      {"best x floor", "best_epoch_seconds", "epochs", "floor_seconds", .n_digits = 3},
      NUMBER("share of processors", "cpu_share", 2),
      {"x floor, processor time", "times_floor", "cpu_share", .n_digits = 3},
      NUMBER("MB", "max_rss_mb", 3),
      NUMBER("validation loss", "validation_loss", 4)}},
    {"score",
     "Scoring",
     {TEXT("model", "model"),
      TEXT("what", "name"),
      TEXT("kernels", "kernels"),
      TEXT("pairs", "batch"),
      NUMBER("ms a pair", "ms_per_pair", 3),
      {"floor, ms", "floor_seconds", .divisor = "batch", .factor = 1e3, .n_digits = 3},
      NUMBER("x floor", "times_floor", 3),
      NUMBER("GFLOP/s", "gflops", 3),
      NUMBER("GB/s", "gb_per_s", 3),
      NUMBER("relative speed", "times_alternative", 3),
      MEDIAN_COLUMN}},
    {"load",
     "Loading and starting",
     {TEXT("what", "subject"),
      TEXT("", "name"),
      NUMBER("MB", "megabytes", 3),
      {"best, ms", "seconds", .factor = 1e3, .n_digits = 3},
      {"median, ms", "seconds_median", .factor = 1e3, .n_digits = 3},
      {"worst, ms", "seconds_worst", .factor = 1e3, .n_digits = 3}}},
};

static const nqm_bench_field *find_field(const char *key) {
    const nqm_bench_field *f = nqm_bench_fields;
    while (strcmp(f->key, key) != 0)
        ++f;
    return f;
}

/* Print a number with n_digits significant digits, or an empty cell if it is not finite. */
static void print_number(double value, int n_digits) {
    int n_after = n_digits - 1 - (value != 0 && isfinite(value) ? (int)floor(log10(fabs(value))) : 0);
    if (isfinite(value))
        printf(" %.*f |", n_after < 0 ? 0 : n_after, value);
    else
        printf(" |");
}

static void print_cell(const nqm_bench_row *row, const column *c) {
    if (!c->key) { /* composed of several fields */
        if (strcmp(c->heading, "product") == 0)
            printf(" %s, layer %zu %s |", row->model, row->size.layer, row->name);
        else
            printf(" %zu x %zu x %zu |", row->size.m, row->size.n, row->size.k);
        return;
    }
    const nqm_bench_field *f = find_field(c->key);
    if (c->n_digits > 0)
        print_number(nqm_bench_number(row, f) * (c->factor != 0 ? c->factor : 1) *
                         (c->times ? nqm_bench_number(row, find_field(c->times)) : 1) /
                         (c->divisor ? nqm_bench_number(row, find_field(c->divisor)) : 1),
                     c->n_digits);
    else if (f->kind == NQM_BENCH_COUNT)
        printf(" %.0f |", nqm_bench_number(row, f));
    else
        printf(" %s |", nqm_bench_text(row, f) ? nqm_bench_text(row, f) : "");
}

static bool belongs_to(const nqm_bench_row *row, const table *t) {
    bool is_reading = strcmp(row->bench, "peak") == 0 && row->precision < 0;
    return strcmp(row->bench, t->bench) == 0 && is_reading == (strcmp(t->title, "Peaks of reading memory") == 0);
}

static void print_machine(const json_t *machine) {
    const char *name;
    json_t *value;
    printf("nqm %s", nqm_version());
    json_object_foreach((json_t *)(uintptr_t)machine, name, value) {
        char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(6));
        printf("; %s %s", name, text ? text : "");
        free(text);
    }
    putchar('\n');
}

static void print_headings(const table *t) {
    printf("\n### %s\n\n|", t->title);
    for (const column *c = t->columns; c->heading; ++c)
        printf(" %s |", c->heading);
    printf("\n|");
    for (const column *c = t->columns; c->heading; ++c)
        printf("---|");
    putchar('\n');
}

void print_bench_tables(const nqm_bench *bench, const json_t *machine) {
    end_progress();
    print_machine(machine);
    for (const table *t = tables; t < tables + sizeof tables / sizeof *tables; ++t) {
        bool has_begun = false;
        for (size_t i = 0; i < bench->n_entries; ++i) {
            const nqm_bench_row *row = &bench->entry[i].row;
            if (!belongs_to(row, t))
                continue;
            if (!has_begun)
                print_headings(t);
            has_begun = true;
            putchar('|');
            for (const column *c = t->columns; c->heading; ++c)
                print_cell(row, c);
            putchar('\n');
        }
    }
}
