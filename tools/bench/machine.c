/* SPDX-License-Identifier: MIT
 *
 * Facts about this process from the operating system, where it provides them.
 */
#include "bench/bench.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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
