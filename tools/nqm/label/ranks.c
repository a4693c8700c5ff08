/* SPDX-License-Identifier: MIT
 *
 * Rank and number of processes from the environment variables of launchers: Open MPI's mpirun, MPICH and compatible ones
 * (PMI), Slurm's srun. nqm needs no MPI library: its processes share a folder.
 */
#include "nqm/tool.h"

#include <stdlib.h>

static bool number_of(const char *variable, size_t *value_ret) {
    const char *text = getenv(variable);
    char *end;
    if (!text || *text < '0' || *text > '9')
        return false;
    *value_ret = strtoul(text, &end, 10);
    return *end == 0;
}

ranks my_ranks(void) {
    static const char *const launchers[][2] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                               {"PMI_RANK", "PMI_SIZE"},
                                               {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}};
    for (size_t i = 0; i < sizeof launchers / sizeof *launchers; ++i) {
        ranks r;
        if (number_of(launchers[i][0], &r.rank) && number_of(launchers[i][1], &r.count) && r.rank < r.count)
            return r;
    }
    return (ranks){0, 1};
}
