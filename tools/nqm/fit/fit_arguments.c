/* SPDX-License-Identifier: MIT
 *
 * The models and bounds of `nqm fit` from the command line.
 */
#include "nqm/fit/fit_tool.h"

#include <string.h>

static _Noreturn void stop_unknown(const char *name, size_t n_name) {
    char names[600] = "";
    size_t used = 0;
    for (size_t i = 0; nqm_fit_model(i) && used < sizeof names; ++i)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", nqm_fit_model(i));
    stop(EXIT_USAGE, "cannot fit a model '%.*s'; there are all, encodings, %s", n_name < 40 ? (int)n_name : 40, name,
         names);
}

static void add_model(fit_request *request, const char *name) {
    for (size_t i = 0; i < request->n_models; ++i)
        if (request->models[i] == name)
            return;
    if (request->n_models < FIT_MAX_MODELS)
        request->models[request->n_models++] = name;
}

void choose_models(const char *text, fit_request *request) {
    size_t n = strcmp(text, "all") == 0 ? FIT_MAX_MODELS : strcmp(text, "encodings") == 0 ? NQM_FIT_N_ENCODINGS : 0;
    for (size_t i = 0; i < n && nqm_fit_model(i); ++i)
        add_model(request, nqm_fit_model(i));
    for (size_t n_name = 0; n == 0; text += n_name + 1) {
        size_t i = 0;
        n_name = strcspn(text, ",");
        while (nqm_fit_model(i) && !(strncmp(nqm_fit_model(i), text, n_name) == 0 && nqm_fit_model(i)[n_name] == 0))
            ++i;
        if (!nqm_fit_model(i))
            stop_unknown(text, n_name);
        add_model(request, nqm_fit_model(i));
        if (!text[n_name])
            break;
    }
}

void choose_bounds(const char *text, fit_request *request) {
    for (int n = 0; text && *text; text += n) {
        if (request->n_bounds == FIT_MAX_BOUNDS)
            stop(EXIT_USAGE, "at most %d bounds", FIT_MAX_BOUNDS);
        nqm_fit_bound *bound = &request->bounds[request->n_bounds];
        char *key = request->bound_keys[request->n_bounds++];
        n = 0; /* numbers in the "C" locale: the tool never calls setlocale() */
        if (sscanf(text, "%15[^=,]=%lf:%lf%n", key, &bound->low, &bound->high, &n) != 3 || (text[n] && text[n] != ','))
            stop(EXIT_USAGE, "--bounds takes KEY=LOW:HIGH,..., not '%.80s'", text);
        n += text[n] == ',';
        bound->key = key;
        bool known = false;
        for (size_t m = 0; m < request->n_models; ++m)
            known |= nqm_fit_model_has(request->models[m], key) != 0;
        if (!known)
            stop(EXIT_USAGE, "none of the models has a lobe parameter '%s'", key);
    }
}
