/* SPDX-License-Identifier: MIT
 *
 * The models and bounds of `nqm fit` from the command line.
 */
#include "nqm/fit/fit_tool.h"

#include <stdlib.h>
#include <string.h>

static int fail_unknown(const char *name, size_t n_name) {
    char names[600] = "";
    size_t used = 0;
    for (size_t i = 0; nqm_fit_model(i) && used < sizeof names; ++i)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", nqm_fit_model(i));
    return report("fit", EXIT_USAGE, "cannot fit a model '%.*s'; there are all, encodings, %s",
                  n_name < 40 ? (int)n_name : 40, name, names);
}

static void add_model(fit_request *request, const char *name) {
    for (size_t i = 0; i < request->n_models; ++i)
        if (request->models[i] == name)
            return;
    if (request->n_models < FIT_MAX_MODELS)
        request->models[request->n_models++] = name;
}

int choose_models(const char *text, fit_request *request) {
    size_t n = strcmp(text, "all") == 0 ? FIT_MAX_MODELS : strcmp(text, "encodings") == 0 ? NQM_FIT_N_ENCODINGS : 0;
    for (size_t i = 0; i < n && nqm_fit_model(i); ++i)
        add_model(request, nqm_fit_model(i));
    while (n == 0) {
        size_t n_name = strcspn(text, ","), i = 0;
        while (nqm_fit_model(i) && !(strncmp(nqm_fit_model(i), text, n_name) == 0 && nqm_fit_model(i)[n_name] == 0))
            ++i;
        if (!nqm_fit_model(i))
            return fail_unknown(text, n_name);
        add_model(request, nqm_fit_model(i));
        if (!text[n_name])
            break;
        text += n_name + 1;
    }
    return EXIT_OK;
}

/* Parse a number; *end is set after it. */
static bool read_number(const char *text, char **end, double *value) {
    *value = strtod(text, end);
    return *end != text;
}

int choose_bounds(const char *text, fit_request *request) {
    while (text && *text) {
        size_t n_key = strcspn(text, "="), b = request->n_bounds;
        char *end = NULL;
        if (b == FIT_MAX_BOUNDS)
            return report("fit", EXIT_USAGE, "at most %d bounds", FIT_MAX_BOUNDS);
        nqm_fit_bound *bound = &request->bounds[b];
        if (n_key == 0 || n_key >= sizeof request->bound_keys[b] || text[n_key] != '=' ||
            !read_number(text + n_key + 1, &end, &bound->low) || *end != ':' ||
            !read_number(end + 1, &end, &bound->high) || (*end != ',' && *end != 0))
            return report("fit", EXIT_USAGE, "--bounds takes KEY=LOW:HIGH,..., not '%.80s'", text);
        memcpy(request->bound_keys[b], text, n_key);
        bound->key = request->bound_keys[b];
        bool known = false;
        for (size_t m = 0; m < request->n_models; ++m)
            known |= nqm_fit_model_has(request->models[m], bound->key) != 0;
        if (!known)
            return report("fit", EXIT_USAGE, "none of the models has a lobe parameter '%s'", bound->key);
        ++request->n_bounds;
        text = end + (*end == ',');
    }
    return EXIT_OK;
}
