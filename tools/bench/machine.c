/* SPDX-License-Identifier: MIT
 *
 * Facts about this process from the operating system, where it provides them.
 */
#include "bench/bench.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

void nqm_bench_read_value(const char *path, const char *key, char *value, size_t n_value) {
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

size_t nqm_bench_cache_bytes(size_t level) {
    static const int names[] = {_SC_LEVEL1_DCACHE_SIZE, _SC_LEVEL2_CACHE_SIZE, _SC_LEVEL3_CACHE_SIZE};
    static const char *const indices[] = {"index0", "index2", "index3"};
    char path[80], line[40] = "";
    const char *end;
    double kib;
    if (level >= sizeof names / sizeof *names)
        return 0;
    snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cache/%s/size", indices[level]);
    FILE *file = fopen(path, "r"); /* sysconf() counts a shared L3 several times on some virtual machines */
    const bool has_size = file && fgets(line, sizeof line, file) && nqm_parse_double(line, &end, &kib) && *end == 'K';
    if (file)
        fclose(file);
    const long n_bytes = has_size ? (long)kib * 1024 : sysconf(names[level]);
    return n_bytes > 0 ? (size_t)n_bytes : 0;
}

size_t nqm_bench_level_bytes(size_t level, size_t threads) {
    if (level == NQM_BENCH_LEVELS - 1)
        return NQM_BENCH_MEMORY;
    const bool is_shared = level == 2; /* L1 and L2 belong to one core */
    const size_t n_bytes = nqm_bench_cache_bytes(level) / 2 * (is_shared ? 1 : threads);
    return n_bytes > (level ? nqm_bench_cache_bytes(level - 1) * threads : 0) ? n_bytes : 0;
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
    nqm_bench_read_value("/proc/self/status", "VmHWM", text, sizeof text);
    return nqm_parse_double(text, &end, &kib) ? kib * 1024e-6 : NAN;
}
