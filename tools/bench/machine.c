/* SPDX-License-Identifier: MIT
 *
 * Facts about the machine and this process from the operating system, where it provides them.
 */
#include "bench/bench.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

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
    read_value("/proc/cpuinfo", "model name", cpu, sizeof cpu);
    if (getloadavg(&load, 1) != 1)
        load = 0;
    return json_pack("{s:o,s:o,s:s,s:i,s:i,s:f,s:s}", "cpu", json_string(cpu), "cpu_id", cpu_id_json(), "compiler",
                     __VERSION__, "cores", omp_get_num_procs(), "threads", omp_get_max_threads(), "load_average", load,
                     "build", nqm_build_info());
}
