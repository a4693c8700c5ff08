/* SPDX-License-Identifier: MIT
 *
 * Saving a model: with golden scores of its own, and with notes behind its card.
 */
#include "metric/metric.h"
#include "train/train.h"

#include <string.h>

/* Models are immutable: card, checksum and golden scores of the new file are those of a copy. */
static nqm_status save_copy(const nqm_model *model, char *card, const char *path, nqm_error *err) {
    struct nqm_model copy = *model;
    copy.card = card;
    nqm_status status = nqm_golden_make(model, &copy.golden, err);
    if (status == NQM_OK) {
        status = nqm_model_write(&copy, path, err);
        nqm_free(copy.golden);
    }
    return status;
}

nqm_status nqm_model_save(const nqm_model *model, const char *path, nqm_error *err) {
    return save_copy(model, model->card, path, err);
}

nqm_status nqm_model_save_annotated(const nqm_model *model, const char *markdown, const char *path, nqm_error *err) {
    const char *before = model->card ? model->card : "";
    size_t n = strlen(before) + strlen(markdown) + 2;
    char *card = nqm_alloc(n, 1);
    if (!card)
        return nqm_fail_nomem(err, n);
    snprintf(card, n, "%s%s%s", before, *before ? "\n" : "", markdown);
    nqm_status status = save_copy(model, card, path, err);
    nqm_free(card);
    return status;
}
