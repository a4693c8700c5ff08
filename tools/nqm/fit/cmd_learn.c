/* SPDX-License-Identifier: MIT
 *
 * nqm learn - learn the dictionary or hypernetwork that the encodings sparse-* and hyper-* of `nqm fit` use.
 */
#include "nqm/tool.h"

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static nqm_learn_options learning;
static const char *path;
static bool json;
static uint64_t steps;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &path, "FILE.safetensors", "the encoder file to write", 0, 0},
    {"seed", 0, OPTION_COUNT, &learning.seed, "N", "seed of the optimiser", 0, 0},
    {"steps", 0, OPTION_COUNT, &steps, "N", "steps of the optimiser (0: 40 for sparse, 16000 for hyper)", 0, 1e7},
    {"json", 0, OPTION_FLAG, &json, NULL, "print the result as JSON", 0, 0},
    {0}};
static const choice choices[] = {{"sparse", "BRDF...", "the dictionary of the encodings sparse-*"},
                                 {"hyper", "BRDF...", "the hypernetwork of the encodings hyper-*"},
                                 {0}};

static const command cmd = {
    .usage = "sparse|hyper BRDF... -o FILE [options]",
    .about = "Learn what an encoding needs from BRDFs. The file lists its references. models/make.sh learns the "
             "files of\n"
             "this build from training materials only; CMake embeds the files of models/encoders.",
    .example = "nqm learn sparse materials/*.bsdf -o models/encoders/sparse.safetensors",
    .options = options,
    .choices = choices,
    .min_arguments = 2,
    .max_arguments = -1,
};

int cmd_learn(int argc, char **argv) {
    learning = nqm_learn_options_default();
    learning.progress = show_progress;
    const int n = parse_arguments(&cmd, argc, argv) - 1;
    char **names = argv + 1;
    nqm_error err = {0};
    const bool sparse = choose_first(&cmd, argv[0]) == 0;
    learning.n_steps = (size_t)steps;
    nqm_brdf **refs = open_brdfs(n, names);
    must(nqm_learn(sparse ? NQM_ENCODER_SPARSE : NQM_ENCODER_HYPER, (size_t)n, (const nqm_brdf *const *)refs,
                   (const char *const *)names, &learning, path, &err),
         &err);
    end_progress();
    close_brdfs(n, refs);
    if (json)
        return print_document(json_pack("{s:s,s:o,s:i,s:I}", "encoder", argv[0], "output", json_name(path),
                                        "references", n, "seed", (json_int_t)learning.seed));
    return report(EXIT_OK, "%s: learned from %d BRDFs", path, n);
}
