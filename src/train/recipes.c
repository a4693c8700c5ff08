/* SPDX-License-Identifier: MIT
 *
 * The table of training options, one row each, with their values in three recipes: "paper" (as printed), "notebook"
 * (the authors' notebook where it differs) and "nqm" (values that were chosen on validation materials,
 * doc/training.md).
 */
#include "io/json.h"
#include "train/train.h"

#define FIELD(member) .offset = offsetof(nqm_train_options, member)

static const char *const recipe_names[] = {"paper", "notebook", "nqm", NULL};
static const char *const whitening_words[] = {"channel", "scalar", NULL};
static const char *const scale_copy_words[] = {"pair_reflectance", "element_transformed", "none", NULL};
static const char *const split_words[] = {"group", "pair", NULL};
static const char *const schedule_words[] = {"plateau", "cosine", NULL};

/* clang-format off */
static const nqm_option rows[] = {
    {"recipe", FIELD(recipe), .kind = NQM_OPTION_TEXT, .metavar = "NAME", .values = {"paper", "notebook", "nqm"},
     .help = "paper, notebook or nqm: sets the defaults of the options below"},
    {"id", FIELD(id), .kind = NQM_OPTION_TEXT, .metavar = "NAME", .values = {"paper", "notebook", "nqm"},
     .help = "id of the model", .storage = NQM_NOT_STORED},
    {"licence", FIELD(licence), .kind = NQM_OPTION_TEXT, .metavar = "SPDX", .storage = NQM_NOT_STORED,
     .help = "licence of the model"},

    {"layout", FIELD(input.layout), .kind = NQM_OPTION_ENUM, .metavar = "WORD", .words = nqm_layout_words,
     .help = "samples in the input", .values = {"ref_test", NULL, "ref_diff_absdiff"}},
    {"difference_scale", FIELD(input.difference_scale), .metavar = "S",
     .help = "factor of the differences in the input", .min = 1e-6, .max = 1e6, .values = {"3"}},
    {"scalars", FIELD(input.scalars), .kind = NQM_OPTION_BOOL, .values = {"0", NULL, "1"},
     .help = "scalar features of the pair as further inputs"},
    {"scalar_scale", FIELD(input.scalar_scale), .metavar = "S", .help = "factor of the whitened scalar features",
     .min = 1e-6, .max = 1e6, .values = {"1", NULL, "8"}},
    {"transport", FIELD(input.transport), .kind = NQM_OPTION_BOOL, .values = {"0", NULL, "1"},
     .help = "if the dataset has a transport matrix, correct the label that it estimates"},
    {"hidden", FIELD(network.n_hidden), .kind = NQM_OPTION_SIZES, .metavar = "LIST", .max_sizes = NQM_TRAIN_MAX_HIDDEN,
     .help = "widths of the hidden layers", .min = 1, .max = 16384, .values = {"1024,716,501", NULL, "64,64"}},
    {"target", FIELD(labels.target), .kind = NQM_OPTION_ENUM, .metavar = "WORD", .words = nqm_target_words,
     .help = "what the network predicts", .values = {"jod", NULL, "log_delta_e"}},
    {"min_delta_e", FIELD(labels.min_delta_e), .metavar = "E", .unit = "Delta-E ITP",
     .help = "smaller labels are raised to this value (log_delta_e)", .min = 1e-6, .max = 10, .values = {"0.05"}},
    {"parts_weight", FIELD(labels.parts_weight), .metavar = "W",
     .help = "weight in the loss of each part of the label, if the dataset has them (0: not predicted)", .min = 0, .max = 100,
     .values = {"0", NULL, "0.2"}},
    {"whitening", FIELD(input.whitening), .kind = NQM_OPTION_ENUM, .metavar = "WORD", .words = whitening_words,
     .help = "mean and deviation of the samples", .values = {"channel", "scalar", "channel"}},
    {"scale_copy", FIELD(augmentation.scale_copy), .kind = NQM_OPTION_ENUM, .metavar = "WORD",
     .words = scale_copy_words, .help = "second copy of the pairs, scaled by 0.95 to 1.05",
     .values = {"pair_reflectance", "element_transformed", "pair_reflectance"}},
    {"swap", FIELD(augmentation.swap), .kind = NQM_OPTION_BOOL, .values = {"0", NULL, "1"},
     .help = "exchange reference and test in the second copy"},
    {"split_by_pair", "split", FIELD(split.by_pair), .kind = NQM_OPTION_BOOL, .metavar = "WORD", .words = split_words,
     .help = "validation drawn by group (of material) or by pair", .values = {"pair", "group", "group"}},
    {"validation_fraction", "validation", FIELD(split.validation_fraction), .metavar = "F",
     .help = "fraction that validates, if the dataset has no such split", .min = 0.001, .max = 0.9, .values = {"0.2"}},
    {"balance", FIELD(augmentation.balance), .kind = NQM_OPTION_BOOL, .help = "fill rare label bins with noisy copies",
     .values = {"1", NULL, "0"}},
    {"balance_sigma", FIELD(augmentation.balance_sigma), .metavar = "S", .unit = "1/sr",
     .help = "standard deviation of that noise", .min = 0, .max = 10, .values = {"0.01"}},
    {"freeze_first_layernorm", "freeze-norm", "train-norm", FIELD(network.freeze_first_layernorm),
     .kind = NQM_OPTION_BOOL, .help = "leave the first LayerNorm at its initial values", .values = {"0", "1", "0"}},
    {"dropout", FIELD(network.dropout), .metavar = "P", .help = "probability of dropping an activation", .min = 0,
     .max = 0.9, .values = {"0.2", NULL, "0.1"}},
    {"lr_first", FIELD(optimiser.lr_first), .metavar = "R", .help = "learning rate of the first linear layer", .min = 0,
     .max = 1, .values = {"1e-4"}},
    {"lr_deeper", "lr", FIELD(optimiser.lr_deeper), .metavar = "R", .help = "learning rate of all other parameters",
     .min = 0, .max = 1, .values = {"1e-3"}},
    {"weight_decay", FIELD(optimiser.weight_decay), .metavar = "W", .help = "L2, added to the gradient", .min = 0,
     .max = 1, .values = {"1e-4", NULL, "1e-5"}},
    {"schedule", FIELD(optimiser.schedule), .kind = NQM_OPTION_ENUM, .metavar = "WORD", .words = schedule_words,
     .help = "how the learning rates fall", .values = {"plateau", NULL, "cosine"}},
    {"plateau_factor", FIELD(optimiser.plateau_factor), .metavar = "F", .help = "factor of the rates on a plateau",
     .min = 0.001, .max = 1, .values = {"0.1"}},
    {"plateau_patience", FIELD(optimiser.plateau_patience), .kind = NQM_OPTION_SIZE, .metavar = "N", .unit = "epochs",
     .help = "without a better validation loss before that", .min = 0, .max = 1e6, .values = {"5"}},
    {"batch", FIELD(optimiser.batch), .kind = NQM_OPTION_SIZE, .metavar = "N", .help = "pairs per step", .min = 1,
     .max = 65536, .values = {"512", NULL, "128"}},
    {"seed", FIELD(optimiser.seed), .kind = NQM_OPTION_U64, .metavar = "N", .values = {"1"},
     .help = "of weights, split, augmentation, order and dropout"},
    {"precision", FIELD(optimiser.precision), .kind = NQM_OPTION_ENUM, .metavar = "WORD", .words = nqm_precision_words,
     .help = "of the factors of all matrix products", .storage = NQM_STORED_UNLESS_ZERO, .values = {"f32"}},
    {"epochs", FIELD(optimiser.epochs), .kind = NQM_OPTION_SIZE, .metavar = "N",
     .help = "passes over the training pairs", .min = 1, .max = 1e6, .values = {"100", NULL, "16"}},

    {"checkpoint", FIELD(run.checkpoint), .kind = NQM_OPTION_TEXT, .metavar = "FILE", .storage = NQM_NOT_STORED,
     .help = "rewritten after each epoch"},
    {"resume", .off_name = "", FIELD(run.resume), .kind = NQM_OPTION_BOOL, .storage = NQM_NOT_STORED,
     .help = "continue from the checkpoint"},
};
/* clang-format on */

const nqm_option_table nqm_train_option_table = {rows, sizeof rows / sizeof rows[0], recipe_names};

nqm_status nqm_train_options_recipe(const char *recipe, nqm_train_options *options_ret, nqm_error *err) {
    NQM_REQUIRE(err, recipe, options_ret);
    nqm_train_options o = {0};
    nqm_status status = nqm_options_begin(&nqm_train_option_table, recipe, &o, err);
    if (status == NQM_OK)
        *options_ret = o;
    return status;
}

nqm_status nqm_train_options_check(const nqm_train_options *o, nqm_error *err) {
    nqm_status status = nqm_options_check(&nqm_train_option_table, o, err);
    if (status == NQM_OK && (!o->recipe || !o->id))
        status = nqm_fail(err, NQM_ERR_ARG, -1, "the options name no recipe or no model id");
    if (status == NQM_OK && o->run.resume && !o->run.checkpoint)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "resuming needs a checkpoint");
    if (status == NQM_OK && o->input.transport && o->labels.target == NQM_TARGET_JOD)
        status = nqm_fail(err, NQM_ERR_ARG, -1,
                          "the option transport corrects a Delta-E: it needs the target log_delta_e (or no transport)");
    return status;
}

json_t *nqm_train_options_json(const nqm_train_options *o) {
    json_t *json = nqm_json_from_options(&nqm_train_option_table, o);
    if (o->optimiser.schedule != NQM_SCHEDULE_COSINE) /* only the rates of the cosine schedule depend on it */
        json_object_del(json, "epochs");
    return json;
}
