/* SPDX-License-Identifier: MIT
 *
 * The model card: the data on which a model was trained and evaluated, and the results. It is generated from the
 * dataset, the options and the report, so that it cannot differ from them. Text added by a person follows the generated
 * part.
 */
#include "base/os.h"
#include "train/train.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A number with a limited number of decimals, formatted the same in any locale. */
typedef struct number_text {
    char text[32];
} number_text;

static number_text number(double value, int decimals) {
    number_text t;
    double unit = pow(10, decimals);
    nqm_format_double(t.text, sizeof t.text, round(value * unit) / unit);
    return t;
}

static void write_network(FILE *out, const nqm_train_options *o, const struct nqm_model *m) {
    fprintf(out, "Predicts how good a BRDF approximation looks compared with its reference, in JOD (10: no visible "
                 "difference),\n");
    fprintf(out, "from %zu directions. A multi-layer perceptron ", m->directions->n);
    for (size_t l = 0; l <= m->params.shape.n_layers; ++l)
        fprintf(out, "%s%zu", l ? "-" : "", m->params.shape.sizes[l]);
    fprintf(out, " with %zu parameters; recipe `%s`.\n", m->params.n, o->recipe);
    if (o->input.layout == NQM_LAYOUT_REF_TEST)
        fprintf(out, "Input: reference and test. ");
    else
        fprintf(out, "Input: reference, difference and absolute difference (times %s). ",
                number(o->input.difference_scale, 6).text);
    if (o->input.scalars)
        fprintf(out, "Behind them %d scalar features of the pair. ", NQM_SCALAR_COUNT);
    fprintf(out, "It learnt %s.\n",
            o->labels.target == NQM_TARGET_JOD ? "JOD"
                                               : "the logarithm of Delta-E ITP, which a fixed curve maps to JOD");
}

static void write_data(FILE *out, const nqm_dataset *d) {
    static const char *const split_names[3] = {"training", "validation", "test"};
    size_t n_groups[3] = {0}, n_pairs[3] = {0};
    for (size_t g = 0; g < d->n_groups; ++g)
        ++n_groups[d->group_split[g]];
    for (size_t i = 0; i < d->n_pairs; ++i)
        ++n_pairs[nqm_dataset_pair_split(d, i)];
    fprintf(out, "\n## Trained on\n\nDataset with SHA-256 `%s`:\n%zu references of %zu materials, %zu pairs.\n\n",
            d->sha256, d->n_refs, d->n_groups, d->n_pairs);
    fprintf(out, "| split | materials | pairs |\n|---|---|---|\n");
    for (size_t s = 0; s < 3; ++s)
        fprintf(out, "| %s | %zu | %zu |\n", split_names[s], n_groups[s], n_pairs[s]);
    fprintf(out, "\n| kind of distortion | training pairs | validation pairs | test pairs |\n|---|---|---|---|\n");
    for (size_t kind = 0; kind < d->n_kinds; ++kind) {
        size_t n[3] = {0};
        for (size_t i = 0; i < d->n_pairs; ++i)
            n[nqm_dataset_pair_split(d, i)] += d->pair_kind[i] == kind;
        fprintf(out, "| %s | %zu | %zu | %zu |\n", nqm_name(&d->kind_names, kind), n[0], n[1], n[2]);
    }
    fprintf(out, "\nA material is in one split only, with all its reconstructions. The test split was not used.\n");
    if (n_groups[NQM_SPLIT_VALIDATION] == 0)
        fprintf(out, "Validation examples were drawn from the training split.\n");
}

static void write_training(FILE *out, const nqm_train_options *o, const nqm_dataset *d, const nqm_train_report *r) {
    fprintf(out, "\n## Training\n\n%zu epochs of %zu examples in batches of %zu (%zu steps), seed %llu.\n", r->epochs,
            r->n_train, o->optimiser.batch, r->n_steps, (unsigned long long)o->optimiser.seed);
    if (o->input.transport && d->transport)
        fprintf(out, "The network corrects the label that light transport of the labels' scene estimates.\n");
    if (o->augmentation.balance)
        fprintf(out, "Label bins were balanced by noisy copies (sigma %s).\n",
                number(o->augmentation.balance_sigma, 6).text);
    if (o->augmentation.scale_copy != NQM_SCALE_NONE)
        fprintf(out, "Every example has a copy scaled by 0.95 to 1.05.\n");
    if (o->augmentation.swap)
        fprintf(out, "The second copy exchanges reference and test.\n");
    fprintf(out, "Loss (log-cosh of normalised labels): %s in training, %s on %zu validation examples.\n",
            number(r->train_loss, 4).text, number(r->validation_loss, 4).text, r->n_validation);
    if (isfinite(r->validation_spearman))
        fprintf(out, "Spearman with the labels there, without noisy copies: %s.\n",
                number(r->validation_spearman, 3).text);
    if (o->split.by_pair)
        fprintf(out,
                "Validation examples were drawn over pairs, as in the paper: their materials also occur in training,\n"
                "so that these validation figures flatter the model.\n");
    fprintf(out, "Results on the test split: `nqm eval --model FILE --split test DATASET`.\n");
}

static void write_limits(FILE *out, const nqm_train_options *o, const nqm_dataset *d) {
    fprintf(out,
            "\n## Not good for\n\n"
            "- Isotropic BRDFs only, at the directions stored in the model: what happens elsewhere (grazing angles,\n"
            "  lobes that fall between the directions) is not seen.\n"
            "- The labels stand for one kind of scene and viewing condition. Other light, shapes, exposure or\n"
            "  observers may rank pairs differently.\n");
    fprintf(out, "- Distortions unlike the %zu kinds above were not learnt.\n", d->n_kinds);
    if (o->labels.target == NQM_TARGET_JOD)
        fprintf(out, "- Scores stay inside the range of the training labels: a perfect copy need not reach 10.\n");
    fprintf(out,
            "- Not a loss for fitting: as the paper's authors found, a good score does not make a good gradient.\n");
}

/* Writes to the memory stream fail only when memory runs out; the stream's error flag reports it. */
char *nqm_model_card(const nqm_dataset *d, const nqm_train_options *o, const nqm_train_report *report,
                     const struct nqm_model *m) {
    char *text = NULL, *card = NULL;
    size_t n_bytes = 0;
    FILE *out = nqm_os_memory_stream(&text, &n_bytes);
    if (!out)
        return NULL;
    fprintf(out, "# Model `%s`\n\n", m->id);
    write_network(out, o, m);
    write_data(out, d);
    write_training(out, o, d, report);
    write_limits(out, o, d);
    if (o->card)
        fprintf(out, "\n%s", o->card);
    if (nqm_os_close_memory(out, &text, &n_bytes))
        card = nqm_strdup(text);
    free(text);
    return card;
}
