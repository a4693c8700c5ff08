/* SPDX-License-Identifier: MIT
 *
 * Saving a model with notes at the end of its card.
 */
#include "train/train.h"

#include <string.h>

nqm_status nqm_model_save_annotated(const nqm_model *model, const char *markdown, const char *path, nqm_error *err) {
    const char *before = model->card ? model->card : "";
    size_t n = strlen(before) + strlen(markdown) + 2;
    char *card = nqm_alloc(n, 1);
    if (!card)
        return nqm_fail_nomem(err, n);
    snprintf(card, n, "%s%s%s", before, *before ? "\n" : "", markdown);
    nqm_model *copy;
    nqm_status status = nqm_model_copy(model, &copy, err);
    if (status == NQM_OK) {
        nqm_free(copy->card);
        copy->card = card;
        status = nqm_model_save(copy, path, err);
        nqm_model_free(copy);
        return status;
    }
    nqm_free(card);
    return status;
}
