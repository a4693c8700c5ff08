/* SPDX-License-Identifier: MIT
 *
 * The free parameters of a shading model: bounds, the scale of the search, generic starts, and specs. What a key means is read
 * from its name, because the models take their names from file formats that agree on them (roughness, metallic, base_color,
 * clearcoat, sheen, ...).
 */
#include "fit/shading.h"

#include <ctype.h>
#include <math.h>
#include <stddef.h>

/* ---- what keys mean ----------------------------------------------------------------------------------------------- */

/* Names without '_' in lower case: some formats write coat_roughness, others coatRoughness. */
typedef struct plain_name {
    char text[64];
} plain_name;

static plain_name plain(const char *name) {
    plain_name p = {""};
    for (size_t n = 0; *name && n < sizeof p.text - 1; ++name)
        if (*name != '_')
            p.text[n++] = (char)tolower((unsigned char)*name);
    return p;
}

static bool contains(const char *name, const char *word) {
    return strstr(plain(name).text, word) != NULL;
}

static bool is_index_of_refraction(const nqm_spec_key *key) {
    return contains(key->name, "ior") || (key->low >= 1 && contains(key->name, "eta"));
}

/* Layers over the base: coat, clearcoat, sheen, fuzz. */
static bool is_of_layer(const char *name) {
    return contains(name, "coat") || contains(name, "sheen") || contains(name, "fuzz");
}

static bool is_width(const char *name) {
    return contains(name, "rough") || strcmp(name, "alpha") == 0;
}

bool nqm_shading_is_layer(const nqm_spec_key *key) {
    static const char *const names[] = {"clearcoat", "coat",       "coatweight", "sheen",
                                        "fuzz",      "fuzzweight", "sheencolor", "sheenweight"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (strcmp(plain(key->name).text, names[i]) == 0)
            return key->fallback == 0 && !key->whole && !key->required;
    return false;
}

/* The first key that `is_it` accepts; n_keys: none. */
static size_t find_key(const nqm_spec_schema *schema, bool (*is_it)(const nqm_spec_key *key)) {
    size_t k = 0;
    while (k < schema->n_keys && !is_it(&schema->keys[k]))
        ++k;
    return k;
}

static bool is_base_width(const nqm_spec_key *key) {
    return key->n == 1 && is_width(key->name) && !is_of_layer(key->name) && !contains(key->name, "diffuse");
}

static bool is_base_color(const nqm_spec_key *key) {
    return key->n == 3 && (contains(key->name, "basecolor") || contains(key->name, "diffusecolor") ||
                           contains(key->name, "diffusereflectance"));
}

static bool is_metal(const nqm_spec_key *key) {
    return key->n == 1 && contains(key->name, "metal");
}

size_t nqm_shading_key(const nqm_spec_schema *schema, const char *name) {
    size_t k = 0;
    while (k < schema->n_keys && strcmp(schema->keys[k].name, name) != 0)
        ++k;
    return k;
}

/* ---- making the space --------------------------------------------------------------------------------------------- */

/* A unit of every coordinate changes f_r by about the factor e: widths count by the square, as alpha = roughness^2. */
static nqm_shading_parameter describe(const nqm_spec_key *key) {
    nqm_shading_parameter p = {.low = key->low, .high = key->high, .units = 1, .offset = 0.05};
    if (is_index_of_refraction(key)) {
        p.low = fmax(key->low, 1);
        p.high = fmin(key->high, 5);
        p.units = 4;
        p.offset = p.low;
    } else if (strcmp(key->name, "alpha") == 0) {
        p.offset = 4e-4;
    } else if (is_width(key->name)) {
        p.units = 2;
        p.offset = 0.02;
    } else if (contains(key->name, "gloss")) {
        p.units = 4;
        p.offset = 0;
    } else if (is_metal(key)) {
        p.units = 2;
        p.offset = 0;
    }
    /* Weights and colours that renderers and their editors take, although the formats allow more. */
    if (!is_index_of_refraction(key) && key->fallback <= 1)
        p.high = fmin(p.high, 1);
    return p;
}

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

/* Required keys have no default: that of other models. */
static double default_of(const nqm_spec_key *key) {
    double value = !key->required ? key->fallback : is_index_of_refraction(key) ? 1.5 : is_width(key->name) ? 0.3 : 0.5;
    return clamp(value, key->low, key->high);
}

/* The key of the amount of the layer that a key describes, as coat_weight for coat_ior; the key itself: none. */
static size_t layer_of(const nqm_spec_schema *schema, size_t key) {
    const plain_name name = plain(schema->keys[key].name);
    for (size_t k = 0; k < schema->n_keys && !nqm_shading_is_layer(&schema->keys[key]); ++k) {
        const plain_name weight = plain(schema->keys[k].name);
        const size_t n_weight = strlen(weight.text), n = n_weight - (contains(weight.text, "weight")  ? strlen("weight")
                                                                     : contains(weight.text, "color") ? strlen("color")
                                                                                                      : 0);
        if (nqm_shading_is_layer(&schema->keys[k]) && strncmp(name.text, weight.text, n) == 0)
            return k;
    }
    return key;
}

bool nqm_shading_is_idle(const nqm_shading_parameter *p, const nqm_spec_values *values) {
    const double *amount = values->v[p->layer];
    return p->layer != p->key && amount[0] == 0 && amount[1] == 0 && amount[2] == 0;
}

static void add_key(nqm_shading_space *space, size_t k) {
    const nqm_spec_key *key = &space->model->schema.keys[k];
    /* The outer index only scales the inner one. */
    if (key->whole || !(key->low < key->high) || contains(key->name, "extior"))
        return;
    for (size_t c = 0; c < key->n && space->n < NQM_SHADING_MAX_FREE; ++c) {
        nqm_shading_parameter p = describe(key);
        p.key = k;
        p.layer = layer_of(&space->model->schema, k);
        p.channel = c;
        space->parameters[space->n++] = p;
    }
}

void nqm_shading_fix(nqm_shading_space *space, size_t key) {
    size_t kept = 0;
    for (size_t i = 0; i < space->n; ++i)
        if (space->parameters[i].key != key)
            space->parameters[kept++] = space->parameters[i];
    space->n = kept;
}

static nqm_status apply_bound(nqm_shading_space *space, const nqm_fit_bound *bound, nqm_error *err) {
    const nqm_spec_schema *schema = &space->model->schema;
    const size_t k = nqm_shading_key(schema, bound->key);
    if (k == schema->n_keys)
        return nqm_fail(err, NQM_ERR_ARG, -1, "the %s fit has no bounds for '%.40s'", schema->model, bound->key);
    const nqm_spec_key *key = &schema->keys[k];
    if (!(bound->low >= key->low && bound->low <= bound->high && bound->high <= key->high))
        return nqm_fail(err, NQM_ERR_ARG, -1, "the bounds of %s in a %s fit must be increasing and between %g and %g",
                        key->name, schema->model, key->low, key->high);
    for (size_t c = 0; c < 3; ++c)
        space->defaults.v[k][c] = clamp(space->defaults.v[k][c], bound->low, bound->high);
    if (bound->low == bound->high)
        nqm_shading_fix(space, k);
    for (size_t i = 0; i < space->n; ++i)
        if (space->parameters[i].key == k) {
            space->parameters[i].low = bound->low;
            space->parameters[i].high = bound->high;
        }
    return NQM_OK;
}

static nqm_status parse(const nqm_analytic_model *model, const char *spec, nqm_spec_values *values, nqm_error *err) {
    const size_t n = strlen(model->schema.model);
    if (strncmp(spec, model->schema.model, n) != 0 || spec[n] != ':')
        return nqm_fail(err, NQM_ERR_ARG, -1, "a %s fit cannot start from '%.80s'", model->schema.model, spec);
    return nqm_spec_parse(&model->schema, spec + n + 1, values, err);
}

nqm_status nqm_shading_space_make(const nqm_analytic_model *model, const nqm_fit_options *options,
                                  nqm_shading_space *space, nqm_error *err) {
    const nqm_spec_schema *schema = &model->schema;
    nqm_spec_values start;
    *space = (nqm_shading_space){.model = model, .defaults = {.given = UINT64_MAX}};
    nqm_status status = options->start ? parse(model, options->start, &start, err) : NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < schema->n_keys; ++k) {
        for (size_t c = 0; c < 3; ++c)
            space->defaults.v[k][c] =
                options->start && schema->keys[k].whole ? start.v[k][c] : default_of(&schema->keys[k]);
        add_key(space, k);
    }
    for (size_t b = 0; status == NQM_OK && b < options->n_bounds; ++b)
        status = apply_bound(space, &options->bounds[b], err);
    return status;
}

/* ---- coordinates -------------------------------------------------------------------------------------------------- */

static double to_coordinate(const nqm_shading_parameter *p, double value) {
    value = clamp(value, p->low, p->high) - p->low;
    return p->units * (p->offset > 0 ? log(value + p->offset) : value);
}

static double to_value(const nqm_shading_parameter *p, double x) {
    x /= p->units;
    const double value = p->offset > 0 ? exp(x) - p->offset : x;
    return clamp(p->low + (value < 1e-6 ? 0 : value), p->low, p->high); /* rounding makes 0 a trace */
}

void nqm_shading_coordinates(const nqm_shading_space *space, const nqm_spec_values *values, double *x) {
    for (size_t i = 0; i < space->n; ++i)
        x[i] = to_coordinate(&space->parameters[i], values->v[space->parameters[i].key][space->parameters[i].channel]);
}

void nqm_shading_bounds(const nqm_shading_space *space, double *low, double *high) {
    for (size_t i = 0; i < space->n; ++i) {
        low[i] = to_coordinate(&space->parameters[i], space->parameters[i].low);
        high[i] = to_coordinate(&space->parameters[i], space->parameters[i].high);
    }
}

static void set_value(const nqm_shading_space *space, nqm_spec_values *values, size_t key, size_t channel, double v) {
    for (size_t c = 0; c < 3; ++c)
        if (c == channel || space->model->schema.keys[key].n == 1)
            values->v[key][c] = v;
}

void nqm_shading_values(const nqm_shading_space *space, const double *x, nqm_spec_values *values) {
    for (size_t i = 0; i < space->n; ++i) {
        const nqm_shading_parameter *p = &space->parameters[i];
        set_value(space, values, p->key, p->channel, to_value(p, x[i]));
    }
}

/* ---- starts ------------------------------------------------------------------------------------------------------- */

/* Set the value of a free key within its bounds; a key that is fixed or not there (n_keys) is left alone. */
static void start_at(const nqm_shading_space *space, nqm_spec_values *values, size_t key, const double v[3]) {
    for (size_t i = 0; i < space->n; ++i) {
        const nqm_shading_parameter *p = &space->parameters[i];
        if (p->key == key)
            set_value(space, values, key, p->channel, clamp(v[p->channel], p->low, p->high));
    }
}

/* The key STEM + `end` of a layer with the weight `name`; n_keys: none. */
static size_t key_of_layer(const nqm_spec_schema *schema, const char *name, const char *end) {
    static const char *const endings[] = {"weight", "color"};
    char key[sizeof(plain_name) + 16];
    const plain_name stem = plain(name);
    size_t n = strlen(stem.text), k = 0;
    for (size_t i = 0; i < 2; ++i)
        if (n > strlen(endings[i]) && strcmp(stem.text + n - strlen(endings[i]), endings[i]) == 0)
            n -= strlen(endings[i]);
    snprintf(key, sizeof key, "%.*s%s", (int)n, stem.text, end);
    while (k < schema->n_keys && strcmp(plain(schema->keys[k].name).text, key) != 0)
        ++k;
    return k;
}

/* Widths at which layers start: a mirror, which is the default of some, would have no effect at most directions. */
static void start_layer(const nqm_shading_space *space, size_t key, nqm_spec_values *values) {
    const nqm_spec_schema *schema = &space->model->schema;
    const double r = contains(schema->keys[key].name, "coat") ? 0.1 : 0.4;
    start_at(space, values, key_of_layer(schema, schema->keys[key].name, "roughness"), (const double[3]){r, r, r});
    start_at(space, values, key_of_layer(schema, schema->keys[key].name, "gloss"), (const double[3]){0.8, 0.8, 0.8});
}

bool nqm_shading_start(const nqm_shading_space *space, size_t i, const double *diffuse, const double *albedo,
                       nqm_spec_values *values) {
    static const double widths[] = {0.1, 0.3, 0.6};
    enum { N_WIDTHS = sizeof widths / sizeof *widths };
    const nqm_spec_schema *schema = &space->model->schema;
    const size_t width = find_key(schema, is_base_width), metal = find_key(schema, is_metal);
    const bool is_metallic = i / N_WIDTHS == 1;
    if (i >= N_WIDTHS * (metal < schema->n_keys ? 2 : 1))
        return false;
    double r = widths[i % N_WIDTHS];
    if (width < schema->n_keys && strcmp(schema->keys[width].name, "alpha") == 0)
        r *= r;
    *values = space->defaults;
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (nqm_shading_is_layer(&schema->keys[k]))
            start_layer(space, k, values);
    start_at(space, values, width, (const double[3]){r, r, r});
    start_at(space, values, metal, (const double[3]){is_metallic, is_metallic, is_metallic});
    start_at(space, values, find_key(schema, is_base_color), is_metallic ? albedo : diffuse);
    return true;
}

bool nqm_shading_add_layer(const nqm_shading_space *space, size_t i, bool rough, nqm_spec_values *values) {
    const nqm_spec_schema *schema = &space->model->schema;
    const size_t base = find_key(schema, is_base_width);
    size_t k = 0;
    while (k < schema->n_keys && (!nqm_shading_is_layer(&schema->keys[k]) || i-- > 0))
        ++k;
    if (k == schema->n_keys)
        return false;
    const double wide = base < schema->n_keys ? fmin(3 * values->v[base][0], 0.8) : 0;
    if (rough)
        start_at(space, values, base, (const double[3]){wide, wide, wide});
    start_at(space, values, k, (const double[3]){0.3, 0.3, 0.3});
    start_layer(space, k, values);
    return true;
}

/* ---- specs -------------------------------------------------------------------------------------------------------- */

nqm_status nqm_shading_read_spec(const nqm_shading_space *space, const char *spec, nqm_spec_values *values,
                                 nqm_error *err) {
    nqm_spec_values parsed;
    nqm_status status = parse(space->model, spec, &parsed, err);
    if (status != NQM_OK)
        return status;
    *values = space->defaults;
    for (size_t k = 0; k < space->model->schema.n_keys; ++k)
        start_at(space, values, k, parsed.v[k]);
    return NQM_OK;
}

static bool is_default(const nqm_spec_key *key, const double v[3]) {
    return !key->required && v[0] == key->fallback && v[1] == key->fallback && v[2] == key->fallback;
}

nqm_status nqm_shading_write_spec(const nqm_shading_space *space, nqm_spec_values *values, char *spec, size_t n_spec,
                                  nqm_error *err) {
    const int n_digits = 5; /* more than pictures show */
    const nqm_spec_schema *schema = &space->model->schema;
    nqm_spec_values shown = *values;
    shown.given = 0;
    for (size_t i = 0; i < space->n; ++i) {
        const nqm_shading_parameter *p = &space->parameters[i];
        const double v = nqm_round_digits(values->v[p->key][p->channel], n_digits);
        set_value(space, &shown, p->key, p->channel, clamp(v, p->low, p->high));
    }
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (!is_default(&schema->keys[k], shown.v[k]))
            shown.given |= UINT64_C(1) << k;
    if (!shown.given)
        shown.given = 1; /* a spec has at least one key */
    char *text = nqm_spec_format(schema, &shown);
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

/* As nqm_brdf_eval() does it with values that a surface cannot have. */
static void settle(size_t n, double *rgb) {
    for (size_t i = 0; i < n; ++i)
        rgb[i] = rgb[i] > 0 && isfinite(rgb[i]) ? rgb[i] : 0;
}

void nqm_shading_eval(const nqm_analytic_model *model, const nqm_spec_values *values, size_t n, const double *wi,
                      const double *wo, double *rgb) {
    _Alignas(max_align_t) char state[NQM_SPEC_MAX_STATE];
    *(nqm_spec_state *)state = (nqm_spec_state){model, *values};
    model->prepare(values, state);
    for (size_t i = 0, end; i < n; i = end) {
        end = i;
        while (end < n && wi[3 * end + 2] > 0 && wo[3 * end + 2] > 0)
            ++end;
        if (end > i)
            model->class_.eval(state, end - i, wi + 3 * i, wo + 3 * i, rgb + 3 * i);
        else
            memset(rgb + 3 * end++, 0, 3 * sizeof *rgb);
    }
    settle(3 * n, rgb);
}
