/* SPDX-License-Identifier: MIT
 *
 * Facts about the machine and this process from the operating system, where it provides them.
 */
#include "bench/bench.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

/* The value of the first line "key : value" of a file; "" when there is none. */
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

static size_t cache_kib(int name) {
    long n = sysconf(name);
    return n > 0 ? (size_t)n / 1024 : 0;
}

nqm_bench_machine nqm_bench_get_machine(void) {
    static char cpu[200], system_text[200];
    char mhz[40];
    struct utsname names;
    nqm_bench_machine machine = {.cpu = cpu, .system = system_text, .threads = (size_t)omp_get_max_threads()};
    read_value("/proc/cpuinfo", "model name", cpu, sizeof cpu);
    read_value("/proc/cpuinfo", "cpu MHz", mhz, sizeof mhz);
    const char *end;
    if (!nqm_parse_double(mhz, &end, &machine.mhz))
        machine.mhz = 0;
    if (uname(&names) == 0)
        snprintf(system_text, sizeof system_text, "%.60s %.60s %.60s", names.sysname, names.release, names.machine);
    machine.cores = (size_t)omp_get_num_procs();
    machine.cache_kib[0] = cache_kib(_SC_LEVEL1_DCACHE_SIZE);
    machine.cache_kib[1] = cache_kib(_SC_LEVEL2_CACHE_SIZE);
    machine.cache_kib[2] = cache_kib(_SC_LEVEL3_CACHE_SIZE);
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    machine.memory_mb = pages > 0 && page > 0 ? 1e-6 * (double)pages * (double)page : 0;
    if (getloadavg(&machine.load, 1) != 1)
        machine.load = 0;
    return machine;
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
