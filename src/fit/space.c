/* SPDX-License-Identifier: MIT
 *
 * The free parameters of a model: bounds, the scale of the search, specs; f_r and its derivatives at their values.
 */
#include "fit/fit.h"
#include "math/math.h"

#include <math.h>
#include <stddef.h>

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

/* ---- making the space --------------------------------------------------------------------------------------------- */

/* The units of a scale whose whole range is 8: one changes a lobe about as much as a unit of log(ks). */
static nqm_fit_parameter describe_shape(const nqm_fit_shape *shape, size_t key) {
    const double range = 8;
    nqm_fit_parameter p = {
        .key = key, .channel = NQM_FIT_ALL_CHANNELS, .layer = key, .low = shape->low, .high = shape->high};
    p.is_log = shape->scale != NQM_FIT_SCALE_LINEAR;
    p.zero = shape->scale == NQM_FIT_SCALE_LOG_REST ? 1 : 0;
    p.units =
        p.is_log ? range / log((shape->high - p.zero) / (shape->low - p.zero)) : range / (shape->high - shape->low);
    return p;
}

/* low = high: the key is not free. */
static nqm_fit_parameter describe(const nqm_fit_entry *entry, size_t k) {
    const nqm_schema_key *key = &entry->model->schema->keys[k];
    const nqm_fit_shape *shape = nqm_fit_find_shape(entry, key->name);
    if (!entry->n_shape)
        return nqm_fit_describe(entry->model->schema, k);
    if (shape)
        return describe_shape(shape, k);
    nqm_fit_parameter p = {.key = k, .layer = k, .low = key->low, .high = key->high, .units = 1, .is_log = true};
    p.zero = p.low - 0.05; /* smaller: fits stay at albedos of 0, where the loss hardly changes */
    if (key->n < 3)
        p.high = p.low;
    return p;
}

/* ratio: of the second value of a key with two to the first. */
static void add_key(nqm_fit_space *space, size_t k, double ratio) {
    const nqm_schema_key *key = &space->model->schema->keys[k];
    nqm_fit_parameter p = describe(space->entry, k);
    if (nqm_fit_is_kept(key) || !(p.low < p.high))
        return;
    if (key->n == 2)
        p.channel = NQM_FIT_ALL_CHANNELS; /* fits keep the anisotropy of their start */
    p.ratio = ratio;
    for (size_t c = 0; c < key->n && space->n < NQM_FIT_MAX_FREE; ++c) {
        p.channel = p.channel == NQM_FIT_ALL_CHANNELS ? p.channel : c;
        space->parameters[space->n++] = p;
        if (p.channel == NQM_FIT_ALL_CHANNELS)
            return;
    }
}

void nqm_fit_fix(nqm_fit_space *space, size_t key) {
    size_t kept = 0;
    for (size_t i = 0; i < space->n; ++i)
        if (space->parameters[i].key != key)
            space->parameters[kept++] = space->parameters[i];
    space->n = kept;
}

bool nqm_fit_split(nqm_fit_space *space) {
    bool is_split = false;
    for (size_t i = 0; i < space->n && space->n < NQM_FIT_MAX_FREE; ++i) {
        nqm_fit_parameter *p = &space->parameters[i];
        if (space->model->schema->keys[p->key].n != 2 || p->channel != NQM_FIT_ALL_CHANNELS)
            continue;
        p->ratio = 1;
        memmove(p + 1, p, (space->n++ - i) * sizeof *p);
        p[0].channel = 0;
        p[1].channel = 1;
        is_split = true;
    }
    return is_split;
}

static nqm_status apply_bound(nqm_fit_space *space, const nqm_fit_bound *bound, nqm_error *err) {
    const nqm_schema *schema = space->model->schema;
    const nqm_fit_shape *shape = nqm_fit_find_shape(space->entry, bound->key);
    const size_t k = nqm_schema_key_named(schema, bound->key, strlen(bound->key));
    if (k == schema->n_keys || (space->entry->n_shape && !shape))
        return nqm_fail(err, NQM_ERR_ARG, -1, "the %s fit has no bounds for '%.40s'", schema->model, bound->key);
    const double low = shape ? shape->low : schema->keys[k].low, high = shape ? shape->high : schema->keys[k].high;
    if (!(bound->low >= low && bound->low <= bound->high && bound->high <= high))
        return nqm_fail(err, NQM_ERR_ARG, -1, "the bounds of %s in a %s fit must be increasing and between %g and %g",
                        bound->key, schema->model, low, high);
    for (size_t c = 0; c < 3; ++c)
        space->defaults.v[k][c] = clamp(space->defaults.v[k][c], bound->low, bound->high);
    if (bound->low == bound->high)
        nqm_fit_fix(space, k);
    for (size_t i = 0; i < space->n; ++i)
        if (space->parameters[i].key == k) {
            space->parameters[i].low = bound->low;
            space->parameters[i].high = bound->high;
        }
    return NQM_OK;
}

static nqm_status parse(const nqm_analytic_model *model, const char *spec, nqm_values *values, nqm_error *err) {
    const size_t n = strlen(model->schema->model);
    if (strncmp(spec, model->schema->model, n) != 0 || spec[n] != ':')
        return nqm_fail(err, NQM_ERR_ARG, -1, "a %s fit cannot start from '%.80s'", model->schema->model, spec);
    return nqm_values_parse(model->schema, spec + n + 1, values, err);
}

nqm_status nqm_fit_space_make(const nqm_fit_entry *entry, const nqm_fit_options *options, nqm_fit_space *space,
                              nqm_error *err) {
    const nqm_schema *schema = entry->model->schema;
    nqm_values start;
    *space = (nqm_fit_space){.entry = entry, .model = entry->model, .turn = {0, 1}, .defaults = nqm_values_of(schema)};
    space->defaults.given = UINT64_MAX;
    nqm_status status = options->start ? parse(entry->model, options->start, &start, err) : NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < schema->n_keys; ++k) {
        for (size_t c = 0; c < 3; ++c)
            space->defaults.v[k][c] =
                options->start && nqm_fit_is_kept(&schema->keys[k]) ? start.v[k][c] : nqm_fit_default(&schema->keys[k]);
        add_key(space, k, options->start && schema->keys[k].n == 2 ? start.v[k][1] / start.v[k][0] : 1);
    }
    for (size_t b = 0; status == NQM_OK && b < options->n_bounds; ++b)
        status = apply_bound(space, &options->bounds[b], err);
    return status;
}

/* ---- coordinates -------------------------------------------------------------------------------------------------- */

static double to_coordinate(const nqm_fit_parameter *p, double value) {
    value = clamp(value, p->low, p->high);
    return p->units * (p->is_log ? log(fabs(value - p->zero)) : value);
}

static double to_value(const nqm_fit_parameter *p, double x) {
    x /= p->units;
    return !p->is_log ? x : p->zero < p->high ? p->zero + exp(x) : p->zero - exp(x);
}

static size_t channel_of(const nqm_fit_parameter *p) {
    return p->channel == NQM_FIT_ALL_CHANNELS ? 0 : p->channel;
}

/* The derivative of the value by its coordinate. */
static double slope_of(const nqm_fit_parameter *p, const nqm_values *values) {
    return (p->is_log ? values->v[p->key][channel_of(p)] - p->zero : 1) / p->units;
}

void nqm_fit_coordinates(const nqm_fit_space *space, const nqm_values *values, double *x) {
    for (size_t i = 0; i < space->n; ++i) {
        const nqm_fit_parameter *p = &space->parameters[i];
        x[i] = to_coordinate(p, values->v[p->key][channel_of(p)]);
    }
}

void nqm_fit_bounds(const nqm_fit_space *space, double *low, double *high) {
    for (size_t i = 0; i < space->n; ++i) {
        low[i] = to_coordinate(&space->parameters[i], space->parameters[i].low);
        high[i] = to_coordinate(&space->parameters[i], space->parameters[i].high);
    }
}

static void set_value(const nqm_fit_space *space, nqm_values *values, const nqm_fit_parameter *p, double v) {
    const bool all = p->channel == NQM_FIT_ALL_CHANNELS || space->model->schema->keys[p->key].n == 1;
    for (size_t c = 0; c < 3; ++c)
        if (all || c == p->channel)
            values->v[p->key][c] = c && p->ratio != 1 ? clamp(v * p->ratio, p->low, p->high) : v;
}

void nqm_fit_values(const nqm_fit_space *space, const double *x, nqm_values *values) {
    for (size_t i = 0; i < space->n; ++i) {
        const nqm_fit_parameter *p = &space->parameters[i];
        const double v = to_value(p, x[i]);
        set_value(space, values, p, v < p->low + 1e-6 ? p->low : fmin(v, p->high)); /* rounding makes 0 a trace */
    }
}

void nqm_fit_set(const nqm_fit_space *space, nqm_values *values, size_t key, const double v[3]) {
    for (size_t i = 0; i < space->n; ++i) {
        const nqm_fit_parameter *p = &space->parameters[i];
        if (p->key == key)
            set_value(space, values, p, clamp(v[channel_of(p)], p->low, p->high));
    }
}

/* ---- specs -------------------------------------------------------------------------------------------------------- */

nqm_status nqm_fit_read_spec(const nqm_fit_space *space, const char *spec, nqm_values *values, nqm_error *err) {
    nqm_values parsed;
    nqm_status status = parse(space->model, spec, &parsed, err);
    if (status != NQM_OK)
        return status;
    *values = space->defaults;
    for (size_t k = 0; k < space->model->schema->n_keys; ++k)
        nqm_fit_set(space, values, k, parsed.v[k]);
    return NQM_OK;
}

static bool is_default(const nqm_schema_key *key, const double v[3]) {
    return !key->required && v[0] == key->fallback && v[1] == key->fallback && v[2] == key->fallback;
}

/* More digits than data determine or pictures show. */
static double round_value(const nqm_fit_parameter *p, double v, int n_digits) {
    v = p->zero > p->high ? p->zero - nqm_round_digits(p->zero - v, n_digits) : nqm_round_digits(v, n_digits);
    return clamp(v, p->low, p->high);
}

nqm_status nqm_fit_write_spec(const nqm_fit_space *space, nqm_values *values, char *spec, size_t n_spec,
                              nqm_error *err) {
    const bool is_shading = space->entry->n_shape == 0;
    const nqm_schema *schema = space->model->schema;
    nqm_values shown = *values;
    shown.given = 0;
    for (size_t i = 0; i < space->n; ++i) {
        const nqm_fit_parameter *p = &space->parameters[i];
        const int n_digits = is_shading ? 5 : 6;
        double *v = shown.v[p->key];
        set_value(space, &shown, p, round_value(p, v[channel_of(p)], n_digits));
        if (p->ratio != 1)
            v[1] = v[2] = round_value(p, v[1], n_digits);
        if (!is_shading)
            shown.given |= UINT64_C(1) << p->key;
    }
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (!is_default(&schema->keys[k], shown.v[k]))
            shown.given |= UINT64_C(1) << k;
    if (!shown.given)
        shown.given = 1; /* a spec has at least one key */
    char *text = nqm_values_spec(&shown);
    if (!text)
        return nqm_fail_nomem(err, n_spec);
    const size_t n = strlen(text);
    if (n < n_spec)
        memcpy(spec, text, n + 1);
    nqm_free(text);
    *values = shown;
    values->given = UINT64_MAX;
    return n < n_spec ? NQM_OK : nqm_fail(err, NQM_ERR_LIMIT, -1, "the spec of the %s fit is too long", schema->model);
}

/* ---- evaluation --------------------------------------------------------------------------------------------------- */

/* Prepare the state of a model; it is read through max_align_t. */
static void prepare(const nqm_fit_space *space, const nqm_values *values, void *state) {
    *(nqm_spec_state *)state = (nqm_spec_state){space->model, *values}; /* models in closed form overwrite it */
    space->model->prepare(values, state);
}

enum { CHUNK = 64 };

/* The end of the run of at most CHUNK pairs above the horizon that begins at `i`; i: it is below. */
static size_t end_of_run(size_t i, size_t n, const double *wi, const double *wo) {
    const size_t most = nqm_smaller(n, i + CHUNK);
    while (i < most && wi[3 * i + 2] > 0 && wo[3 * i + 2] > 0)
        ++i;
    return i;
}

/* n directions in the axes of the model: themselves, or `turned`. */
static const double *in_axes(const nqm_fit_space *space, size_t n, const double *w, double *turned) {
    if (space->turn[0] == 0)
        return w;
    for (size_t i = 0; i < n; ++i)
        nqm_turn3(space->turn, w + 3 * i, turned + 3 * i);
    return turned;
}

void nqm_fit_eval(const nqm_fit_space *space, const nqm_values *values, size_t n, const double *wi, const double *wo,
                  double *rgb) {
    _Alignas(max_align_t) char state[NQM_SPEC_MAX_STATE];
    double turned[2][CHUNK * 3];
    prepare(space, values, state);
    for (size_t i = 0, end; i < n; i = end) {
        end = end_of_run(i, n, wi, wo);
        if (end > i)
            space->model->class_.eval(state, end - i, in_axes(space, end - i, wi + 3 * i, turned[0]),
                                      in_axes(space, end - i, wo + 3 * i, turned[1]), rgb + 3 * i);
        else
            memset(rgb + 3 * end++, 0, 3 * sizeof *rgb);
    }
    for (size_t i = 0; i < 3 * n; ++i) /* as nqm_brdf_eval() does it with values that a surface cannot have */
        rgb[i] = rgb[i] > 0 && isfinite(rgb[i]) ? rgb[i] : 0;
}

/* Whether a parameter is of a layer that is off: nqm_fit_add_layer() turns layers on, no step does. */
static bool is_idle(const nqm_fit_space *space, const nqm_fit_parameter *p, const nqm_values *values) {
    const double *amount = values->v[p->layer];
    return nqm_schema_is_layer(space->model->schema, p->layer) && amount[0] == 0 && amount[1] == 0 && amount[2] == 0;
}

/* The values with parameter k one step further, or one step back at its upper end. Returns the step; 0 for an idle parameter. */
static double step_values(const nqm_fit_space *space, size_t k, const nqm_values *values, nqm_values *near) {
    const nqm_fit_parameter *p = &space->parameters[k];
    const double step = 1e-5, x = to_coordinate(p, values->v[p->key][channel_of(p)]);
    const double h = x + step > to_coordinate(p, p->high) ? -step : step;
    *near = *values;
    if (is_idle(space, p, values))
        return 0;
    set_value(space, near, p, to_value(p, x + h));
    return h;
}

/* Index of the first value of each key among the columns of a Jacobian; returns their number. */
static size_t index_columns(const nqm_schema *schema, size_t *first) {
    size_t n = 0;
    for (size_t k = 0; k < schema->n_keys; ++k) {
        first[k] = n;
        n += schema->keys[k].n;
    }
    return n;
}

/* The columns of `count` pairs from pair `at` of n by their Jacobian (count, 3, n_columns). */
static void chain(const nqm_fit_space *space, const nqm_values *values, const double *jacobian, size_t at, size_t count,
                  size_t n, double *columns) {
    size_t first[NQM_SCHEMA_MAX_KEYS];
    const size_t n_columns = index_columns(space->model->schema, first);
    for (size_t k = 0; k < space->n; ++k) {
        const nqm_fit_parameter *p = &space->parameters[k];
        const size_t n_channels = p->channel == NQM_FIT_ALL_CHANNELS ? space->model->schema->keys[p->key].n : 1;
        const double slope = slope_of(p, values), *from = jacobian + first[p->key] + channel_of(p);
        double *column = columns + 3 * (k * n + at);
        for (size_t i = 0; i < 3 * count; ++i) {
            double sum = 0;
            for (size_t c = 0; c < n_channels; ++c)
                sum += (c ? p->ratio : 1) * from[i * n_columns + c];
            column[i] = isfinite(sum) ? sum * slope : 0;
        }
    }
}

/* The columns by differences, which need fewer evaluations than nqm_spec_jacobian(), and of idle parameters none. */
static void difference(const nqm_fit_space *space, const nqm_values *values, size_t n, const double *wi,
                       const double *wo, const double *rgb, double *columns) {
    for (size_t k = 0; k < space->n; ++k, columns += 3 * n) {
        nqm_values near;
        const double h = step_values(space, k, values, &near);
        if (h == 0) {
            memset(columns, 0, 3 * n * sizeof *columns);
            continue;
        }
        nqm_fit_eval(space, &near, n, wi, wo, columns);
        for (size_t i = 0; i < 3 * n; ++i)
            columns[i] = (columns[i] - rgb[i]) / h;
    }
}

void nqm_fit_slopes(const nqm_fit_space *space, const nqm_values *values, size_t n, const double *wi, const double *wo,
                    const double *rgb, double *columns) {
    enum { MAX_COLUMNS = 16 };
    if (space->model->class_.jacobian == nqm_spec_jacobian) {
        difference(space, values, n, wi, wo, rgb, columns);
        return;
    }
    _Alignas(max_align_t) char state[NQM_SPEC_MAX_STATE];
    double jacobian[CHUNK * 3 * MAX_COLUMNS], unused[CHUNK * 3], turned[2][CHUNK * 3];
    prepare(space, values, state);
    for (size_t i = 0, end; i < n; i = end) {
        end = end_of_run(i, n, wi, wo);
        memset(jacobian, 0, sizeof jacobian);
        if (end > i)
            space->model->class_.jacobian(state, end - i, in_axes(space, end - i, wi + 3 * i, turned[0]),
                                          in_axes(space, end - i, wo + 3 * i, turned[1]), unused, jacobian);
        chain(space, values, jacobian, i, nqm_larger(end - i, 1), n, columns);
        end = nqm_larger(end, i + 1);
    }
}
