/* SPDX-License-Identifier: MIT
 *
 * Facts about the machine and this process from the operating system, where it provides them.
 */
#include "bench/bench.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The value of the first line "key : value" of a file of the system; "" when there is none. */
static void read_value(const char *path, const char *key, char *value, size_t n_value) {
    char line[512];
    FILE *file = fopen(path, "r");
    value[0] = '\0';
    while (file && !*value && fgets(line, sizeof line, file)) {
        char *colon = strchr(line, ':');
        if (!colon || strncmp(line, key, strlen(key)) != 0)
            continue;
        line[strcspn(line, "\n")] = '\0';
        snprintf(value, n_value, "%s", colon + 1 + strspn(colon + 1, " \t"));
    }
    if (file)
        fclose(file);
}

/* Size of a cache, bytes: level 0 is the data cache of L1; 0: unknown. */
static size_t cache_bytes(size_t level) {
    static const struct {
        const char *file;
        int name;
    } caches[NQM_BENCH_LEVELS - 1] = {{"/sys/devices/system/cpu/cpu0/cache/index0/size", _SC_LEVEL1_DCACHE_SIZE},
                                      {"/sys/devices/system/cpu/cpu0/cache/index2/size", _SC_LEVEL2_CACHE_SIZE},
                                      {"/sys/devices/system/cpu/cpu0/cache/index3/size", _SC_LEVEL3_CACHE_SIZE}};
    long kib = 0;
    FILE *file =
        fopen(caches[level].file, "r"); /* sysconf() counts a shared L3 several times on some virtual machines */
    const bool has_size = file && fscanf(file, "%ldK", &kib) == 1;
    if (file)
        fclose(file);
    const long n_bytes = has_size ? kib * 1024 : sysconf(caches[level].name);
    return n_bytes > 0 ? (size_t)n_bytes : 0;
}

size_t nqm_bench_level_bytes(size_t level) {
    if (level == NQM_BENCH_LEVELS - 1)
        return NQM_BENCH_MEMORY;
    const size_t threads = (size_t)omp_get_max_threads();
    const bool is_shared = level == 2; /* L1 and L2 belong to one core */
    const size_t n_bytes = cache_bytes(level) / 2 * (is_shared ? 1 : threads);
    return n_bytes > (level ? cache_bytes(level - 1) * threads : 0) ? n_bytes : 0;
}

void nqm_bench_reset_peak_memory(void) {
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (!file)
        return;
    fputs("5", file); /* proc(5): sets the peak to the current value */
    fclose(file);
}

double nqm_bench_peak_memory_mb(void) {
    char text[40];
    const char *end;
    double kib;
    read_value("/proc/self/status", "VmHWM", text, sizeof text);
    return nqm_parse_double(text, &end, &kib) ? kib * 1024e-6 : NAN;
}

/* ---- for the results -----------------------------------------------------------------------------------------------*/

/* Vendor, family, model and stepping, which tell processors of the same name apart. */
static json_t *cpu_id_json(void) {
    static const char *const keys[][2] = {
        {"vendor", "vendor_id"}, {"family", "cpu family"}, {"model", "model\t"}, {"stepping", "stepping"}};
    json_t *id = json_object();
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        char value[80];
        read_value("/proc/cpuinfo", keys[i][1], value, sizeof value);
        json_object_set_new(id, keys[i][0], json_string(value));
    }
    return id;
}

/* From the operating system, where it provides them; 0 or "": unknown. */
json_t *nqm_bench_machine(void) {
    char cpu[200];
    double load;
    json_t *caches = json_array();
    read_value("/proc/cpuinfo", "model name", cpu, sizeof cpu);
    for (size_t level = 0; level + 1 < NQM_BENCH_LEVELS; ++level)
        json_array_append_new(caches, json_integer((json_int_t)(cache_bytes(level) / 1024)));
    if (getloadavg(&load, 1) != 1)
        load = 0;
    return json_pack("{s:o,s:o,s:s,s:i,s:i,s:o,s:f,s:s}", "cpu", json_string(cpu), "cpu_id", cpu_id_json(), "compiler",
                     __VERSION__, "cores", omp_get_num_procs(), "threads", omp_get_max_threads(), "cache_kib", caches,
                     "load_average", load, "build", nqm_build_info());
}
