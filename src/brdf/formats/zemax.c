/* SPDX-License-Identifier: MIT
 *
 * Tabular BSDF files of Zemax ("BSDF Data Interchange File Format Specification", Radiant Imaging 2008; doc/files.md): a grid about
 * the specular direction, or a list of directions.
 */
#include "brdf/formats/grid.h"
#include "brdf/formats/listed.h"

#include "io/io.h"
#include <math.h>

static const double degree = NQM_PI / 180;
static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

enum { ROTATION, INCIDENCE, AZIMUTH, RADIAL, N_AXES, WORD_BYTES = 40 };
static const struct {
    const char *word;
    double high; /* degrees */
} axes[N_AXES] = {{"SampleRotation", 360}, {"AngleOfIncidence", 90}, {"ScatterAzimuth", 360}, {"ScatterRadial", 180}};

/* A file, and the position in it. */
typedef struct table {
    const nqm_map *map;
    size_t at, begin; /* after the last word, and its first byte */
    char word[WORD_BYTES];
    bool is_symmetrical;
    size_t n[N_AXES];
    double *angle[N_AXES]; /* radians */
    size_t n_values;       /* product of n */
    float *rgb;            /* (product of n, 3) */
    unsigned channels;     /* bit k: value k has been read */
    char remark[NQM_REMARK_SIZE];
} table;

static nqm_status fail(const table *t, const char *fault, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)t->begin,
                    "%s: '%s' at byte %zu: %s, in what begins like a BSDF table of Zemax or LightTools", t->map->path,
                    t->word, t->begin, fault);
}

/* Move to the next word; "" at the end. Lines that begin with '#' are comments. */
static const char *next_word(table *t) {
    const char *text = (const char *)t->map->data;
    size_t n = 0;
    while (t->at < t->map->n_bytes && (strchr(" \t\r\n", text[t->at]) || text[t->at] == '#')) {
        const bool is_comment = text[t->at++] == '#';
        while (is_comment && t->at < t->map->n_bytes && text[t->at] != '\n')
            ++t->at;
    }
    for (t->begin = t->at; t->at < t->map->n_bytes && !strchr(" \t\r\n", text[t->at]); ++t->at)
        if (n + 1 < WORD_BYTES)
            t->word[n++] = text[t->at];
    t->word[n] = '\0';
    return t->word;
}

static nqm_status read_number(table *t, double low, double high, double *value, nqm_error *err) {
    const char *end = next_word(t);
    return nqm_parse_double(end, &end, value) && !*end && *value >= low && *value <= high
               ? NQM_OK
               : fail(t, *t->word ? "not a number of its range" : "a number is missing", err);
}

/* One of two words, of which the second may be followed by anything. */
static nqm_status read_choice(table *t, const char *first, const char *second, bool *is_first, nqm_error *err) {
    next_word(t);
    *is_first = nqm_equal_any_case(t->word, first, SIZE_MAX);
    return *is_first || (*second && nqm_equal_any_case(t->word, second, strlen(second)))
               ? NQM_OK
               : fail(t, "this kind of table is not read", err);
}

static nqm_status read_axis(table *t, size_t k, nqm_error *err) {
    double n;
    nqm_status status = read_number(t, 1, (double)(t->map->n_bytes - t->at) / 2, &n, err);
    if (status == NQM_OK && (t->angle[k] || n != floor(n)))
        status = fail(t, "a number of angles is given twice, or is none", err);
    if (status != NQM_OK)
        return status;
    t->n[k] = (size_t)n;
    t->angle[k] = nqm_alloc(t->n[k], sizeof *t->angle[k]);
    if (!t->angle[k])
        return nqm_fail_nomem(err, t->n[k] * sizeof *t->angle[k]);
    for (size_t i = 0; i < t->n[k] && status == NQM_OK; ++i) {
        double *angle = &t->angle[k][i];
        status = read_number(t, k == ROTATION ? -360 : 0, axes[k].high, angle, err);
        *angle *= degree;
        if (status == NQM_OK && i && !(angle[0] > angle[-1]))
            status = fail(t, "angles do not rise", err);
    }
    return status;
}

/* The values of one channel, which count with these weights for RGB. */
static nqm_status read_values(table *t, const double *weights, nqm_error *err) {
    t->n_values = 1;
    for (size_t k = 0; k < N_AXES; ++k)
        if (!t->angle[k] || !nqm_mul_size(t->n_values, t->n[k], &t->n_values) || t->n_values > t->map->n_bytes / 2)
            return fail(t, "the angles are missing, or are more than the file has values", err);
    if (!t->rgb && !(t->rgb = nqm_alloc(t->n_values, 3 * sizeof *t->rgb)))
        return nqm_fail_nomem(err, t->n_values * 3 * sizeof *t->rgb);
    for (size_t i = 0; i < t->n_values; ++i) {
        double value;
        const size_t at = t->at;
        if (strcmp(next_word(t), "TIS") == 0) { /* the total, and the values of an angle of incidence */
            nqm_remark_add(t->remark, sizeof t->remark, "TIS is not used");
            next_word(t);
        } else
            t->at = at;
        nqm_status status = read_number(t, -1e30, 1e30, &value, err);
        if (status != NQM_OK)
            return status;
        for (size_t c = 0; c < 3; ++c)
            t->rgb[3 * i + c] += (float)(weights[c] * value);
    }
    return nqm_equal_any_case(next_word(t), "DataEnd", SIZE_MAX)
               ? NQM_OK
               : fail(t, "the values do not end here with DataEnd", err);
}

static nqm_status read_table(table *t, nqm_error *err) {
    static const char *const channels[] = {"TristimulusX", "TristimulusY", "TristimulusZ", "Monochrome"};
    static const double grey[3] = {1, 1, 1};
    nqm_status status = NQM_OK;
    size_t channel = 4;
    bool is_mono = true, is_brdf;
    while (status == NQM_OK && *next_word(t)) {
        size_t k = 0, c = 0;
        while (k < N_AXES && !nqm_equal_any_case(t->word, axes[k].word, SIZE_MAX))
            ++k;
        while (c < 4 && !nqm_equal_any_case(t->word, channels[c], SIZE_MAX))
            ++c;
        if (k < N_AXES)
            status = read_axis(t, k, err);
        else if (c < 4)
            channel = c;
        else if (nqm_equal_any_case(t->word, "Source", SIZE_MAX))
            nqm_remark_add(t->remark, sizeof t->remark, "Source %s is not used", next_word(t));
        else if (nqm_equal_any_case(t->word, "Symmetry", SIZE_MAX))
            status = read_choice(t, "PlaneSymmetrical", "ASymmetrical", &t->is_symmetrical, err);
        else if (nqm_equal_any_case(t->word, "SpectralContent", SIZE_MAX))
            status = read_choice(t, "Monochrome", "XYZ", &is_mono, err);
        else if (nqm_equal_any_case(t->word, "ScatterType", SIZE_MAX))
            status = read_choice(t, "BRDF", "", &is_brdf, err);
        else if (nqm_equal_any_case(t->word, "DataBegin", SIZE_MAX) && channel < 4 && !(t->channels >> channel & 1)) {
            t->channels |= 1u << channel;
            status = read_values(t, channel < 3 ? nqm_xyz_weights + 3 * channel : grey, err);
        } else
            status = fail(t, "not a word of a table of Zemax (LightTools' are not read)", err);
    }
    if (status == NQM_OK && t->channels != (is_mono ? 8u : 7u))
        status = fail(t, "the file ends without its values", err);
    return status;
}

/* Light at this polar angle and azimuth 0, and the direction at the angles about its mirror direction. */
static void direction(double incidence, double azimuth, double radial, double *wo) {
    double about[3];
    nqm_spherical(radial, azimuth, about);
    wo[0] = about[0] * cos(incidence) - about[2] * sin(incidence);
    wo[1] = about[1];
    wo[2] = about[0] * sin(incidence) + about[2] * cos(incidence);
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

/* Of a symmetrical table each row counts at both sides of the plane of incidence. */
static nqm_status make_list(const table *t, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    const size_t n_sides = t->is_symmetrical ? 2 : 1, n_most = n_sides * t->n_values;
    nqm_list l = {.path = t->map->path, .has_pairs = true, .has_unit = true};
    if (n_most > nqm_listed_most(t->map->n_bytes))
        return nqm_fail(err, NQM_ERR_LIMIT, 0,
                        "%s: %zu directions (from byte 0 on) that are no grid; %zu are the limit", l.path, n_most,
                        nqm_listed_most(t->map->n_bytes));
    memcpy(l.remark, t->remark, sizeof l.remark);
    l.rows = nqm_alloc(n_most, sizeof *l.rows);
    if (!l.rows)
        return nqm_fail_nomem(err, n_most * sizeof *l.rows);
    for (size_t i = 0; i < n_most; ++i) {
        const size_t at = i / n_sides, line = at / t->n[RADIAL], block = line / t->n[AZIMUTH];
        const double side = i % n_sides ? -1 : 1, incidence = t->angle[INCIDENCE][block % t->n[INCIDENCE]];
        const double azimuth = t->angle[AZIMUTH][line % t->n[AZIMUTH]], radial = t->angle[RADIAL][at % t->n[RADIAL]];
        double wo[3];
        direction(incidence, side * azimuth, radial, wo);
        const float *rgb = t->rgb + 3 * at, *first = rgb - 3 * (line % t->n[AZIMUTH]) * t->n[RADIAL];
        const bool is_again = radial <= 0 && rgb != first && memcmp(rgb, first, 3 * sizeof *rgb) == 0;
        if ((side < 0 && fabs(sin(azimuth)) < 1e-9) || is_again)
            continue; /* the same direction as another row, and the same value */
        nqm_listed *row = &l.rows[l.n++];
        row->at[0] = incidence;
        row->at[1] = atan2(hypot(wo[0], wo[1]), wo[2]);
        row->at[2] = atan2(wo[1], wo[0]);
        row->phi_i = t->angle[ROTATION][block / t->n[INCIDENCE]];
        memcpy(row->rgb, rgb, sizeof row->rgb);
    }
    nqm_status status = nqm_listed_create(&l, t->map->n_bytes, argument, brdf_ret, err);
    nqm_free(l.rows);
    return status;
}

/* ---- grids ------------------------------------------------------------------------------------------------------- */

static void eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    for (size_t i = 0; i < n; ++i, wi += 3, wo += 3, rgb += 3) {
        const double sine = hypot(wi[0], wi[1]), x = sine > 0 ? wi[0] / sine : 1, y = sine > 0 ? wi[1] / sine : 0;
        const double along = x * wo[0] + y * wo[1], across = x * wo[1] - y * wo[0];
        const double toward = along * wi[2] + wo[2] * sine, mirror = wo[2] * wi[2] - along * sine;
        double at[3] = {atan2(sine, wi[2]), atan2(hypot(toward, across), mirror), atan2(across, toward)};
        nqm_grid_eval_folded(self, at, rgb);
    }
}

static const nqm_brdf_class zemax_class = {.format = "grid", .eval = eval, .free = nqm_free};

static nqm_status make_grid(const table *t, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    static const size_t order[3] = {INCIDENCE, RADIAL, AZIMUTH};
    double *node[3];
    unsigned char *value;
    nqm_grid *g;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&g, 1, sizeof *g}, {node, t->n[order[0]], sizeof(double)},
                                                    {node + 1, t->n[order[1]], sizeof(double)},
                                                    {node + 2, t->n[order[2]], sizeof(double)},
                                                    {&value, t->n_values, 3 * sizeof(float)}),
                                         err);
    if (status != NQM_OK)
        return status;
    *g = (nqm_grid){
        .period = 2 * NQM_PI, .value = value, .n_channels = 3, .channel_stride = sizeof(float), .weights = identity};
    for (size_t k = 0; k < 3; ++k) {
        g->n[k] = t->n[order[k]];
        g->node[k] = memcpy(node[k], t->angle[order[k]], g->n[k] * sizeof(double));
    }
    g->stride[1] = 3 * sizeof(float);
    g->stride[2] = g->n[1] * g->stride[1];
    g->stride[0] = g->n[2] * g->stride[2];
    if (t->is_symmetrical)
        g->period = node[2][g->n[2] - 1] - node[2][0];
    if (nqm_grid_gap(g, 2) > NQM_GRID_WIDEST) {
        nqm_free(g);
        return make_list(t, argument, brdf_ret, err);
    }
    for (size_t i = 0; i < t->n_values; ++i) {
        double wo[3];
        direction(node[0][i / g->n[1] / g->n[2]], node[2][i / g->n[1] % g->n[2]], node[1][i % g->n[1]], wo);
        for (size_t c = 0; c < 3; ++c)
            nqm_store_f32(value + (3 * i + c) * sizeof(float), wo[2] > 1e-9 ? t->rgb[3 * i + c] : NAN);
    }
    char layout[160];
    snprintf(layout, sizeof layout,
             "%zu angles of incidence x %zu azimuths x %zu radial angles about the mirror direction", g->n[0], g->n[2],
             g->n[1]);
    const nqm_brdf_info info = {
        .name = argument->name, .layout = layout, .remark = t->remark, .n_values = 3 * t->n_values, .isotropic = 1};
    return nqm_brdf_wrap(&zemax_class, g, &info, brdf_ret, err);
}

static bool probe(const nqm_map *map) {
    const char *kind = nqm_file_kind(map->data, map->n_bytes);
    return kind && strncmp(kind, "a BSDF table", 12) == 0;
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    table t = {.map = map};
    nqm_map_expect(map, true);
    nqm_status status = read_table(&t, err);
    if (status == NQM_OK && t.n[ROTATION] == 1 && t.n[INCIDENCE] > 1 && t.n[RADIAL] > 1 && !argument->member)
        status = make_grid(&t, argument, brdf_ret, err);
    else if (status == NQM_OK)
        status = make_list(&t, argument, brdf_ret, err);
    for (size_t k = 0; k < N_AXES; ++k)
        nqm_free(t.angle[k]);
    nqm_free(t.rgb);
    return status;
}

const nqm_brdf_format nqm_zemax_format = {
    .files = "BSDF table of Zemax", .takes_members = true, .probe = probe, .open = open_file};
