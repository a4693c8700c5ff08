/* SPDX-License-Identifier: MIT
 *
 * The rows of a benchmark as JSON and as tables in Markdown, which can be read as they are and be put into a document.
 */
#include "nqm/bench/bench_print.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

/* What the user told OpenMP: waiting threads that sleep ("passive") cost small batches a good deal. */
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

static json_t *machine_json(void) {
    const nqm_bench_machine m = nqm_bench_get_machine();
    json_t *caches = json_array();
    for (size_t i = 0; i < sizeof m.cache_kib / sizeof *m.cache_kib; ++i)
        json_array_append_new(caches, json_integer((json_int_t)m.cache_kib[i]));
    return json_pack("{s:o,s:o,s:I,s:I,s:f,s:o,s:f,s:f,s:s,s:s,s:o}", "cpu", json_name(m.cpu), "system",
                     json_name(m.system), "cores", (json_int_t)m.cores, "threads", (json_int_t)m.threads, "mhz", m.mhz,
                     "cache_kib", caches, "memory_mb", m.memory_mb, "load_average", m.load, "kernels",
                     nqm_kernels_selected(), "build", nqm_build_info(), "openmp", openmp_json());
}

static void add_text(json_t *object, const char *key, const char *text) {
    if (text)
        json_object_set_new(object, key, json_name(text));
}

static void add_count(json_t *object, const char *key, size_t n) {
    if (n)
        json_object_set_new(object, key, json_integer((json_int_t)n));
}

static void add_number(json_t *object, const char *key, double value) {
    if (isfinite(value))
        json_object_set_new(object, key, json_real(value));
}

static json_t *row_json(const nqm_bench_row *r) {
    json_t *o = json_object();
    add_text(o, "bench", r->bench);
    add_text(o, "name", r->name);
    add_text(o, "subject", r->subject);
    add_text(o, "model", r->model);
    add_text(o, "by", r->by);
    add_text(o, "kernels", r->kernels);
    add_text(o, "precision", r->precision < 0 ? NULL : nqm_precision_name((nqm_precision)r->precision));
    const struct {
        const char *key;
        size_t n;
    } counts[] = {{"batch", r->batch}, {"threads", r->threads}, {"epochs", r->epochs}, {"seed", r->seed},
                  {"pairs", r->pairs}, {"layer", r->layer},     {"m", r->m},           {"n", r->n},
                  {"k", r->k},         {"rounds", r->rounds}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i)
        add_count(o, counts[i].key, counts[i].n);
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"seconds", r->seconds},
                   {"seconds_median", r->seconds_median},
                   {"seconds_worst", r->seconds_worst},
                   {"best_epoch_seconds", r->best_epoch_seconds},
                   {"seconds_100_epochs", r->seconds_100},
                   {"ms_per_pair", r->ms_per_pair},
                   {"gflop", r->gflop},
                   {"gflops", r->gflops},
                   {"peak_gflops", r->peak_gflops},
                   {"peak_median_gflops", r->peak_median},
                   {"megabytes", r->megabytes},
                   {"gb_per_s", r->gb_per_s},
                   {"peak_gb_per_s", r->peak_gb_per_s},
                   {"floor_seconds", r->floor_seconds},
                   {"floor_f32_seconds", r->floor_f32},
                   {"ratio", r->ratio},
                   {"times_floor", r->times_floor},
                   {"times_alternative", r->times_alternative},
                   {"cpu_share", r->cpu_share},
                   {"max_rss_mb", r->max_rss_mb},
                   {"train_loss", r->train_loss},
                   {"validation_loss", r->validation_loss}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        add_number(o, numbers[i].key, numbers[i].value);
    return o;
}

json_t *bench_json(const nqm_bench *bench) {
    json_t *rows = json_array();
    for (size_t i = 0; i < nqm_bench_count(bench); ++i) {
        const nqm_bench_row row = nqm_bench_get_row(bench, i);
        json_array_append_new(rows, row_json(&row));
    }
    return json_pack("{s:i,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(), "machine", machine_json(), "rows", rows);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static const char *precision_text(const nqm_bench_row *r) {
    return r->precision < 0 ? "" : nqm_precision_name((nqm_precision)r->precision);
}

/* A cell of a table: a number with so many significant digits, or nothing. */
static void cell(double value, int n_digits) {
    if (!isfinite(value)) {
        printf(" |");
        return;
    }
    int after = n_digits - 1 - (value != 0 ? (int)floor(log10(fabs(value))) : 0);
    printf(" %.*f |", after < 0 ? 0 : after, value);
}

static void print_peak(const nqm_bench_row *r) {
    printf("| %s |", r->kernels);
    if (r->megabytes > 0) {
        printf(" reading %.3g MB | %zu |", r->megabytes, r->threads);
        cell(r->peak_gb_per_s, 3);
        printf(" GB/s |");
        cell(r->megabytes / 1000 / r->seconds_median, 3);
    } else {
        printf(" %s | %zu |", precision_text(r), r->threads);
        cell(r->peak_gflops, 3);
        printf(" GFLOP/s |");
        cell(r->peak_median, 3);
    }
    putchar('\n');
}

static void print_gemm(const nqm_bench_row *r) {
    printf("| %s | %s, layer %zu %s | %zu | %zu x %zu x %zu | %s | %s |", r->kernels, r->model, r->layer, r->name,
           r->batch, r->m, r->n, r->k, precision_text(r), r->by);
    cell(r->gflops, 3);
    cell(r->gb_per_s, 3);
    cell(r->ratio, 3);
    cell(r->seconds_median / r->seconds, 3);
    putchar('\n');
}

static void print_train(const nqm_bench_row *r) {
    printf("| %s | %s | %s | %zu | %zu | %zu |", r->model, precision_text(r), r->kernels, r->seed, r->pairs, r->epochs);
    const double best = (double)r->epochs * r->best_epoch_seconds;
    cell(r->gflop / 1000, 4);
    cell(r->seconds, 3);
    cell(best, 3);
    cell(r->seconds_100, 3);
    cell(r->gflops, 3);
    cell(r->floor_seconds, 3);
    cell(r->times_floor, 3);
    cell(best / r->floor_seconds, 3);
    cell(r->cpu_share, 2);
    cell(r->times_floor * r->cpu_share, 3);
    cell(r->max_rss_mb, 3);
    cell(r->validation_loss, 4);
    putchar('\n');
}

static void print_score(const nqm_bench_row *r) {
    printf("| %s | %s | %s | %s | %zu |", r->model, r->name, precision_text(r), r->kernels, r->batch);
    cell(r->ms_per_pair, 3);
    cell(1e3 * r->floor_seconds / (double)r->batch, 3);
    cell(r->times_floor, 3);
    cell(r->gflops, 3);
    cell(r->gb_per_s, 3);
    cell(r->times_alternative, 3);
    cell(r->seconds_median / r->seconds, 3);
    putchar('\n');
}

static void print_load(const nqm_bench_row *r) {
    printf("| %s | %s |", r->subject, r->name);
    cell(r->megabytes, 3);
    cell(1e3 * r->seconds, 3);
    cell(1e3 * r->seconds_median, 3);
    cell(1e3 * r->seconds_worst, 3);
    putchar('\n');
}

static const struct table {
    const char *bench, *title, *head, *rule;
    void (*print)(const nqm_bench_row *row);
} tables[] = {
    {"peak", "Peaks", "| kernels | what | threads | best | | median |", "|---|---|---|---|---|---|", print_peak},
    {"gemm", "Matrix products",
     "| kernels | product | batch | m x n x k | precision | by | GFLOP/s | GB/s | of the peak | median / best |",
     "|---|---|---|---|---|---|---|---|---|---|", print_gemm},
    {"train", "Training",
     "| recipe | precision | kernels | seed | pairs | epochs | TFLOP | s | s, all as the best epoch | s, extrapolated "
     "to 100 epochs | GFLOP/s "
     "| floor, s | x floor | best x floor | share of processors | x floor, processor time | MB | validation loss |",
     "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|", print_train},
    {"score", "Scoring",
     "| model | what | precision | kernels | pairs | ms a pair | floor, ms | x floor | GFLOP/s | GB/s | gain of one "
     "reference | median / best |",
     "|---|---|---|---|---|---|---|---|---|---|---|---|", print_score},
    {"load", "Loading and starting", "| what | | MB | best, ms | median, ms | worst, ms |", "|---|---|---|---|---|---|",
     print_load},
};

static void print_machine(void) {
    const nqm_bench_machine m = nqm_bench_get_machine();
    printf("%s, %zu cores, %zu threads, caches %zu / %zu / %zu KiB, %.0f GB; %s; load average %.1f\n"
           "nqm %s, kernels %s; %s\n",
           m.cpu, m.cores, m.threads, m.cache_kib[0], m.cache_kib[1], m.cache_kib[2], m.memory_mb / 1000, m.system,
           m.load, nqm_version(), nqm_kernels_selected(), nqm_build_info());
    json_t *openmp = openmp_json();
    const char *name;
    json_t *value;
    json_object_foreach(openmp, name, value) printf("%s=%s\n", name, json_string_value(value));
    json_decref(openmp);
}

void print_bench_tables(const nqm_bench *bench) {
    end_progress();
    print_machine();
    for (size_t t = 0; t < sizeof tables / sizeof *tables; ++t) {
        bool begun = false;
        for (size_t i = 0; i < nqm_bench_count(bench); ++i) {
            const nqm_bench_row row = nqm_bench_get_row(bench, i);
            if (strcmp(row.bench, tables[t].bench) != 0)
                continue;
            if (!begun)
                printf("\n### %s\n\n%s\n%s\n", tables[t].title, tables[t].head, tables[t].rule);
            begun = true;
            tables[t].print(&row);
        }
    }
}
