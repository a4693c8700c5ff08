/* SPDX-License-Identifier: MIT
 *
 * The three recipes - the paper as printed, the authors' notebook where it differs, and ours - as one struct of
 * options; their check, and their text in a model file and a checkpoint.
 */
#include "model/model_file.h"
#include "train/train.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static nqm_train_options paper_options(void) {
    return (nqm_train_options){
        .recipe = "paper",
        .id = "paper",
        .layout = NQM_LAYOUT_REF_TEST,
        .difference_scale = 3,
        .scalar_scale = 1,
        .n_hidden = 3,
        .hidden = {1024, 716, 501},
        .target = NQM_TARGET_JOD,
        .min_delta_e = 0.05,
        .whitening = NQM_WHITEN_CHANNEL,
        .scale_copy = NQM_SCALE_PAIR_REFLECTANCE,
        .split_by_pair = 1,
        .validation_fraction = 0.2,
        .balance = 1,
        .balance_sigma = 0.01,
        .dropout = 0.2,
        .lr_first = 1e-4,
        .lr_deeper = 1e-3,
        .weight_decay = 1e-4,
        .plateau_factor = 0.1,
        .plateau_patience = 5,
        .batch = 512,
        .epochs = 100,
        .seed = 1,
    };
}

static nqm_train_options notebook_options(void) {
    nqm_train_options o = paper_options();
    o.recipe = o.id = "notebook";
    o.whitening = NQM_WHITEN_SCALAR;
    o.scale_copy = NQM_SCALE_ELEMENT_TRANSFORMED;
    o.split_by_pair = 0;
    o.freeze_first_layernorm = 1;
    return o;
}

static nqm_train_options nqm_options(void) {
    nqm_train_options o = paper_options();
    o.recipe = o.id = "nqm";
    o.layout = NQM_LAYOUT_REF_DIFF_ABSDIFF;
    /* Scalars, schedule, dropout, decay, batch and epochs: chosen on validation materials, doc/training.md. */
    o.scalars = 1;
    o.scalar_scale = 8;
    o.target = NQM_TARGET_LOG_DELTA_E;
    o.split_by_pair = 0;
    o.balance = 0;
    o.schedule = NQM_SCHEDULE_COSINE;
    o.dropout = 0.1;
    o.weight_decay = 1e-5;
    o.batch = 128;
    o.epochs = 40;
    return o;
}

nqm_status nqm_train_options_recipe(const char *recipe, nqm_train_options *options_ret, nqm_error *err) {
    if (strcmp(recipe, "paper") == 0)
        *options_ret = paper_options();
    else if (strcmp(recipe, "notebook") == 0)
        *options_ret = notebook_options();
    else if (strcmp(recipe, "nqm") == 0)
        *options_ret = nqm_options();
    else
        return nqm_fail(err, NQM_ERR_ARG, -1, "there is no recipe '%.40s'; there are paper, notebook and nqm", recipe);
    return NQM_OK;
}

/* ---- check ------------------------------------------------------------------------------------------------------- */

static nqm_status check_range(const char *what, double value, double min, double max, nqm_error *err) {
    if (value >= min && value <= max)
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s is %g; it must be from %g to %g", what, value, min, max);
}

nqm_status nqm_train_options_check(const nqm_train_options *o, nqm_error *err) {
    enum { MAX_WIDTH = 16384, MAX_BATCH = 65536, MAX_EPOCHS = 1000000 };
    const struct {
        const char *what;
        double value, min, max;
    } ranges[] = {
        {"the layout", o->layout, NQM_LAYOUT_REF_TEST, NQM_LAYOUT_REF_DIFF_ABSDIFF},
        {"the target", o->target, NQM_TARGET_JOD, NQM_TARGET_LOG_DELTA_E},
        {"the schedule", o->schedule, NQM_SCHEDULE_PLATEAU, NQM_SCHEDULE_COSINE},
        {"the whitening", o->whitening, NQM_WHITEN_CHANNEL, NQM_WHITEN_SCALAR},
        {"the scale copy", o->scale_copy, NQM_SCALE_PAIR_REFLECTANCE, NQM_SCALE_NONE},
        {"the difference scale", o->difference_scale, 1e-6, 1e6},
        {"the scale of the scalar features", o->scalar_scale, 1e-6, 1e6},
        {"the number of hidden layers", (double)o->n_hidden, 1, NQM_TRAIN_MAX_HIDDEN},
        {"the smallest Delta-E", o->min_delta_e, 1e-6, 10},
        {"the validation fraction", o->validation_fraction, 0.001, 0.9},
        {"the noise of balancing", o->balance_sigma, 0, 10},
        {"the dropout", o->dropout, 0, 0.9},
        {"the learning rate of the first layer", o->lr_first, 0, 1},
        {"the learning rate", o->lr_deeper, 0, 1},
        {"the weight decay", o->weight_decay, 0, 1},
        {"the plateau factor", o->plateau_factor, 0.001, 1},
        {"the batch", (double)o->batch, 1, MAX_BATCH},
        {"the precision", o->precision, NQM_PRECISION_F32, NQM_PRECISION_BF16},
        {"the number of epochs", (double)o->epochs, 1, MAX_EPOCHS},
    };
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < sizeof ranges / sizeof ranges[0]; ++i)
        status = check_range(ranges[i].what, ranges[i].value, ranges[i].min, ranges[i].max, err);
    for (size_t i = 0; status == NQM_OK && i < o->n_hidden; ++i)
        status = check_range("the width of a hidden layer", (double)o->hidden[i], 1, MAX_WIDTH, err);
    if (status == NQM_OK && (!o->recipe || !o->id))
        status = nqm_fail(err, NQM_ERR_ARG, -1, "the options name no recipe or no model id");
    if (status == NQM_OK && o->resume && !o->checkpoint)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "resuming needs a checkpoint");
    return status;
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

static const char *const schedule_names[] = {"plateau", "cosine"};
static const char *const whitening_names[] = {"channel", "scalar"};
static const char *const scale_copy_names[] = {"pair_reflectance", "element_transformed", "none"};

json_t *nqm_train_options_json(const nqm_train_options *o) {
    json_t *hidden = json_array();
    for (size_t i = 0; i < o->n_hidden; ++i)
        json_array_append_new(hidden, json_integer((json_int_t)o->hidden[i]));
    char seed[32]; /* a JSON integer holds 63 bits only */
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)o->seed);
    json_t *json = json_pack(
        "{s:s, s:s, s:f, s:b, s:f, s:o, s:s, s:f, s:s, s:s, s:b, s:f, s:b, s:f, s:b, s:f, s:f, s:f, s:f, s:s, s:f, "
        "s:I, "
        "s:I, s:s}",
        "recipe", o->recipe, "layout", nqm_layout_names[o->layout], "difference_scale", o->difference_scale, "scalars",
        o->scalars != 0, "scalar_scale", o->scalar_scale, "hidden", hidden, "target", nqm_target_names[o->target],
        "min_delta_e", o->min_delta_e, "whitening", whitening_names[o->whitening], "scale_copy",
        scale_copy_names[o->scale_copy], "split_by_pair", o->split_by_pair != 0, "validation_fraction",
        o->validation_fraction, "balance", o->balance != 0, "balance_sigma", o->balance_sigma, "freeze_first_layernorm",
        o->freeze_first_layernorm != 0, "dropout", o->dropout, "lr_first", o->lr_first, "lr_deeper", o->lr_deeper,
        "weight_decay", o->weight_decay, "schedule", schedule_names[o->schedule], "plateau_factor", o->plateau_factor,
        "plateau_patience", (json_int_t)o->plateau_patience, "batch", (json_int_t)o->batch, "seed", seed);
    if (o->precision != NQM_PRECISION_F32) /* left out where it is float: older files do not name it */
        json_object_set_new(json, "precision", json_string(nqm_precision_name(o->precision)));
    if (o->schedule == NQM_SCHEDULE_COSINE) /* every epoch's rate depends on it */
        json_object_set_new(json, "epochs", json_integer((json_int_t)o->epochs));
    return json;
}

char *nqm_train_options_text(const nqm_train_options *options) {
    json_t *json = nqm_train_options_json(options);
    char *dump = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    char *text = dump ? nqm_strdup(dump) : NULL;
    free(dump);
    json_decref(json);
    return text;
}
