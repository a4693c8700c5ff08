/* SPDX-License-Identifier: MIT
 *
 * Labels of BRDFs: create the scene, render each BRDF, and compute its Delta-E ITP to its reference.
 */
#include "nqm/label/label.h"

#include <math.h>
#include <stdlib.h>

static nqm_status render_item(const label_run *run, label_item *item) {
    item->delta_e = item->jod = (double)NAN;
    item->rgb_cdm2 = allocate(3 * nqm_scene_count(run->scene), sizeof *item->rgb_cdm2);
    return render_brdf(run->scene, item->name, item->rgb_cdm2, &item->err);
}

/* Render item i and compare it with its reference. Errors of tests are stored in the item. */
static nqm_status label_item_at(label_run *run, size_t i) {
    label_item *item = &run->items[i], *reference = &run->items[item->reference];
    nqm_status status = render_item(run, item);
    if (item == reference)
        return status;
    if (status == NQM_OK) {
        const nqm_curve curve = nqm_curve_default();
        item->delta_e = nqm_scene_delta_e(run->scene, reference->rgb_cdm2, item->rgb_cdm2);
        item->jod = nqm_curve_jod(&curve, item->delta_e);
    }
    if (!run->keep_rgb) {
        free(item->rgb_cdm2);
        item->rgb_cdm2 = NULL;
    }
    return NQM_OK;
}

void make_labels(label_run *run) {
    nqm_error err = {0};
    must(nqm_scene_create(&run->scene_options, &run->scene, &err), &err);
    for (size_t i = 0; i < run->n_items; ++i) {
        if (show_progress(NULL, "label", (double)i, (double)run->n_items))
            stop(EXIT_INTERRUPTED, "interrupted");
        must(label_item_at(run, i), &run->items[i].err);
    }
    end_progress();
}

void free_labels(label_run *run) {
    for (size_t i = 0; i < run->n_items; ++i)
        free(run->items[i].rgb_cdm2);
    free(run->items);
    nqm_scene_free(run->scene);
}
