/* SPDX-License-Identifier: MIT
 *
 * nqm learn - learn the dictionary or hypernetwork that the encodings sparse-* and hyper-* of `nqm fit` use.
 */
#include "nqm/tool.h"

#include <string.h>

static int learn(nqm_encoder what, int n, char **names, const nqm_learn_options *options, const char *path) {
    nqm_error err = {0};
    nqm_brdf **refs;
    int exit_code = open_brdfs("learn", n, names, &refs);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (nqm_learn(what, (size_t)n, (const nqm_brdf *const *)refs, (const char *const *)names, options, path, &err) !=
        NQM_OK)
        exit_code = report_error("learn", &err);
    end_progress();
    close_brdfs(n, refs);
    return exit_code;
}

int cmd_learn(int argc, char **argv) {
    nqm_learn_options learning = nqm_learn_options_default();
    learning.progress = show_progress;
    const char *path = NULL;
    bool json = false;
    uint64_t steps = 0;
    const option options[] = {
        {"output", 'o', OPTION_TEXT, &path, "FILE", "the encoder file to write", 0, 0},
        {"seed", 0, OPTION_COUNT, &learning.seed, "N", "seed of the optimiser", 0, 0},
        {"steps", 0, OPTION_COUNT, &steps, "N", "steps of the optimiser (0: 40 for sparse, 16000 for hyper)", 0, 1e7},
        {"json", 0, OPTION_FLAG, &json, NULL, "print the result as JSON", 0, 0},
        {0}};
    const command cmd = {
        .name = "learn",
        .usage = "sparse|hyper BRDF... -o FILE [options]",
        .about = "Learn the dictionary that the encodings sparse-* use, or the hypernetwork of hyper-*, from BRDFs. "
                 "The file\n"
                 "lists its references. models/make.sh learns those of this build, from training materials only; CMake "
                 "embeds\n"
                 "the files of models/encoders.",
        .example = "nqm learn sparse materials/*.bsdf -o models/encoders/sparse.safetensors",
        .options = options,
        .min_arguments = 2,
        .max_arguments = -1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    bool sparse = strcmp(argv[0], "sparse") == 0;
    if (!sparse && strcmp(argv[0], "hyper") != 0)
        return report("learn", EXIT_USAGE, "the first argument must be sparse or hyper, not '%s'", argv[0]);
    if (!path)
        return report("learn", EXIT_USAGE, "-o FILE is needed");
    learning.n_steps = (size_t)steps;
    exit_code = learn(sparse ? NQM_ENCODER_SPARSE : NQM_ENCODER_HYPER, n_arguments - 1, argv + 1, &learning, path);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (json)
        return print_json(json_pack("{s:i,s:o,s:s,s:o,s:i,s:I}", "schema", 1, "tool", json_tool(), "encoder", argv[0],
                                    "output", json_name(path), "references", n_arguments - 1, "seed",
                                    (json_int_t)learning.seed));
    fprintf(stderr, "nqm learn: %s: learned from %d BRDFs\n", path, n_arguments - 1);
    return EXIT_OK;
}
