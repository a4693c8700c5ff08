/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the tables that `nqm plot` draws: logs of trainings, predictions of pairs, and labels with the curve that
 * `nqm regress` fits to them. A table that is refused must get a message; the coefficients of an accepted one must be finite.
 */
#include "figures/plot_shared.h"
#include "fuzz.h"

#include <math.h>
#include <unistd.h>

static void plot_curve(const char *path) {
    enum { MIN_ROWS = 4, MAX_ROWS = 64 }; /* the curve has three coefficients; the time of a fit grows with the rows */
    nqm_points scores;
    nqm_regress_report fit;
    nqm_error err = {0};
    if (nqm_points_load(path, "DeltaE", "JOD", "", &scores, NULL) != NQM_OK)
        return;
    if (scores.n >= MIN_ROWS && scores.n <= MAX_ROWS) {
        if (nqm_regress(scores.n, scores.x, scores.y, &fit, &err) == NQM_OK) {
            must(isfinite(fit.curve.b1) && isfinite(fit.curve.b2) && isfinite(fit.curve.b3));
            must(nqm_plot_curve(fuzz_drawing(), path, &fit, NULL, &err) == NQM_OK || err.message[0]);
        } else {
            must(err.message[0]);
        }
    }
    nqm_points_free(&scores);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    char path[FUZZ_PATH];
    nqm_error err = {0};
    const int fd = fuzz_file(data, n_bytes, path);
    const char *const logs[] = {path, path};
    must(nqm_plot_losses(fuzz_drawing(), 2, logs, NULL, &err) == NQM_OK || err.message[0]);
    err = (nqm_error){0};
    must(nqm_plot_predictions(fuzz_drawing(), path, NULL, NULL, &err) == NQM_OK || err.message[0]);
    plot_curve(path);
    close(fd);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "epoch,train_loss,validation_loss,lr_first,jod,default,family,DeltaE,JOD,model\n"
                               "1,.5,.6,1e-3,9,8.5,noise,5,9.4,ward\n2,.25,.4,1e-3,7,7.5,gloss,20,7.3,ggx\n"
                               "3,.125,.3,5e-4,2,3,noise,60,4.1,ward\n4,.1,.31,5e-4,5,4.5,tint,100,2.9,ggx\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
