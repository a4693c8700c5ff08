/* SPDX-License-Identifier: MIT
 *
 * CSV files of directions and values, also in the layout of ASTM E1392 (doc/files.md): which columns have which angles, in which
 * unit, and how RGB is made of the values.
 */
#include "brdf/formats/listed.h"

#include "io/io.h"
#include <math.h>

/* ---- names ------------------------------------------------------------------------------------------------------- */

enum { NAME_BYTES = 48, MAX_ANGLES = 4, PREAMBLE_BYTES = 1 << 16 };

typedef enum angle_unit { NO_UNIT, DEGREES, RADIANS, OTHER_UNIT } angle_unit;

/* What is written for these in names. */
static const struct {
    const char *text, *letters;
} symbols[] = {
    {"\xc2\xb0", "deg"}, {"\xce\xb8", "theta"}, {"\xcf\x91", "theta"}, {"\xcf\x86", "phi"}, {"\xcf\x95", "phi"}};

/* Copy letters, small, digits and '%' up to an opening bracket; returns what follows it, or NULL. */
static const char *squeeze(const char *text, char name[NAME_BYTES]) {
    size_t n = 0;
    for (; *text && *text != '(' && *text != '['; ++text) {
        const char c = *text >= 'A' && *text <= 'Z' ? (char)(*text + 32) : *text;
        for (size_t i = 0; i < sizeof symbols / sizeof *symbols; ++i)
            if (strncmp(text, symbols[i].text, 2) == 0 && n + 6 < NAME_BYTES)
                n += (size_t)snprintf(name + n, NAME_BYTES - n, "%s", symbols[i].letters);
        if (((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '%') && n + 1 < NAME_BYTES)
            name[n++] = c;
    }
    name[n] = '\0';
    return *text ? text + 1 : NULL;
}

static bool ends_with(const char *text, const char *end) {
    const size_t n = strlen(text), n_end = strlen(end);
    return n >= n_end && strcmp(text + n - n_end, end) == 0;
}

/* The name and the unit of a column; the latter is also found at the end of the name of an angle. */
static angle_unit read_name(const char *header, char name[NAME_BYTES]) {
    static const char *const units[] = {"deg", "degree", "degrees", "rad", "radian", "radians"};
    char text[NAME_BYTES] = "";
    const char *rest = squeeze(header, name);
    if (rest)
        squeeze(rest, text);
    for (size_t i = 0; i < sizeof units / sizeof *units; ++i) {
        const bool is_suffix = !rest && (strncmp(name, "theta", 5) == 0 || strncmp(name, "phi", 3) == 0) &&
                               strpbrk(header, "_ .-") && ends_with(name, units[i]);
        if (is_suffix)
            name[strlen(name) - strlen(units[i])] = '\0';
        if (is_suffix || strcmp(text, units[i]) == 0)
            return i < 3 ? DEGREES : RADIANS;
    }
    return *text && !strstr(text, "sr") ? OTHER_UNIT : NO_UNIT;
}

/* The column with the first of the names "STEM NAME" that is there, but not `except`; -1: none. */
static int find_column(const nqm_csv *csv, const char *stem, const char *const *names, int except, angle_unit *unit) {
    char wanted[NAME_BYTES], name[NAME_BYTES];
    for (; *names; ++names) {
        snprintf(wanted, sizeof wanted, "%s%s", stem, *names);
        for (size_t i = 0; i < nqm_csv_columns(csv); ++i) {
            *unit = read_name(nqm_csv_header(csv, (int)i), name);
            if ((int)i != except && strcmp(name, wanted) == 0)
                return (int)i;
        }
    }
    return -1;
}

/* ---- columns ----------------------------------------------------------------------------------------------------- */

/* An 's' is the scattered light, or with another name of the viewer the source. */
static const char *const light_names[] = {"i", "in",    "inc",    "incident", "incidence", "incoming",
                                          "l", "light", "source", "s",        NULL};
static const char *const viewer_names[] = {"o",         "out",     "outgoing",  "r",      "ref", "refl",
                                           "reflected", "v",       "view",      "viewer", "e",   "obs",
                                           "detector",  "scatter", "scattered", "s",      NULL};
static const char *const half_names[] = {"h", "half", NULL}, *const difference_names[] = {"d", "diff", NULL};

typedef struct angle_column {
    const char *name, *stem;
    const char *const *names;
    double low, high; /* degrees */
} angle_column;

static const angle_column half_diff_columns[] = {{"theta_h", "theta", half_names, 0, 90},
                                                 {"theta_d", "theta", difference_names, 0, 90},
                                                 {"phi_d", "phi", difference_names, -180, 360}};
/* In the order in which they are found: that of the viewer decides what 's' means. */
static const angle_column pair_columns[] = {{"theta_o", "theta", viewer_names, -90, 90},
                                            {"phi_o", "phi", viewer_names, -360, 360},
                                            {"theta_i", "theta", light_names, -90, 90},
                                            {"phi_i", "phi", light_names, -360, 360}};

/* Columns of a file. */
typedef struct layout {
    const nqm_csv *csv;
    size_t header; /* its first byte */
    const angle_column *angles;
    size_t n_angles, n_values;
    int angle[MAX_ANGLES];
    bool in_radians[MAX_ANGLES];
    int *value;      /* (n_values) */
    double *weights; /* (n_values, 3): RGB is the sum over k of weights[3 k + c] times value k */
    float *nm;       /* (n_values) wavelengths of a spectrum */
} layout;

static nqm_status fail_column(const layout *l, const char *path, const char *name, nqm_error *err) {
    return nqm_fail(
        err, NQM_ERR_FORMAT, (int64_t)l->header,
        "%s: has no column '%s' (header at byte %zu); a CSV of a BRDF has theta_h, theta_d, phi_d, or "
        "theta_i, phi_i, theta_o, phi_o, and r, g, b, or one value, 'brdf' (doc/files.md has other names)%s",
        path, name, l->header, nqm_csv_columns(l->csv) > 1 ? "" : ", separated by commas");
}

static nqm_status fail_unit(const layout *l, const char *path, int column, const char *needed, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)l->header,
                    "%s: the unit of column '%s' (header at byte %zu) is not %s", path, nqm_csv_header(l->csv, column),
                    l->header, needed);
}

/* is_astm: angles without a unit are radians. */
static nqm_status find_angles(layout *l, bool is_astm, nqm_list *list, nqm_error *err) {
    angle_unit unit;
    const bool is_pair = find_column(l->csv, "theta", half_names, -1, &unit) < 0 &&
                         find_column(l->csv, "theta", light_names, -1, &unit) >= 0;
    l->angles = is_pair ? pair_columns : half_diff_columns;
    l->n_angles = is_pair ? 4 : 3;
    list->has_pairs = is_pair;
    list->has_unit = true;
    for (size_t k = 0; k < l->n_angles; ++k) {
        const angle_column *a = &l->angles[k];
        l->angle[k] = find_column(l->csv, a->stem, a->names, k >= 2 && is_pair ? l->angle[k - 2] : -1, &unit);
        if (l->angle[k] < 0)
            return fail_column(l, list->path, a->name, err);
        if (unit == OTHER_UNIT)
            return fail_unit(l, list->path, l->angle[k], "degrees (deg) or radians (rad)", err);
        l->in_radians[k] = unit == RADIANS || (unit == NO_UNIT && is_astm);
        list->has_unit = list->has_unit && (unit != NO_UNIT || is_astm);
    }
    return NQM_OK;
}

/* Three columns, whose weights are those given; returns how many are there. */
static size_t find_three(layout *l, const char *const names[3][3], const double *weights, bool *has_unit) {
    size_t n = 0;
    *has_unit = false;
    for (size_t c = 0; c < 3; ++c) {
        angle_unit unit;
        l->value[c] = find_column(l->csv, "", names[c], -1, &unit);
        n += l->value[c] >= 0;
        *has_unit |= l->value[c] >= 0 && unit != NO_UNIT;
    }
    l->n_values = 3;
    memcpy(l->weights, weights, 9 * sizeof *weights);
    return n;
}

static bool find_one(layout *l, bool *has_unit) {
    static const char *const names[] = {"r", "brdf",      "bsdf", "fr",   "f",    "value",
                                        "y", "luminance", "grey", "gray", "mono", NULL};
    angle_unit unit;
    l->value[0] = find_column(l->csv, "", names, -1, &unit);
    l->weights[0] = l->weights[1] = l->weights[2] = 1;
    l->n_values = 1;
    *has_unit = l->value[0] >= 0 && unit != NO_UNIT;
    return l->value[0] >= 0;
}

/* Columns that are named by their wavelengths, "550nm" or "550"; a single one is grey. Returns how many there are. */
static size_t find_spectrum(layout *l) {
    l->n_values = 0;
    for (size_t i = 0; i < nqm_csv_columns(l->csv); ++i) {
        const char *end = nqm_csv_header(l->csv, (int)i);
        double nm;
        if (!nqm_parse_double(end, &end, &nm) || !(nm >= 200 && nm <= 3000))
            continue;
        end += strspn(end, " [(_");
        if (*end && !nqm_equal_any_case(end, "nm", 2))
            continue;
        l->nm[l->n_values] = (float)nm;
        l->value[l->n_values++] = (int)i;
    }
    if (nqm_spectrum_is_visible(l->n_values, l->nm))
        nqm_spectrum_weights(NQM_ILLUMINANT_E, l->n_values, l->nm, l->weights);
    return l->n_values;
}

static nqm_status find_values(layout *l, const char *path, nqm_error *err) {
    static const char *const rgb[3][3] = {{"r", "red"}, {"g", "green"}, {"b", "blue"}};
    static const char *const xyz[3][3] = {{"x"}, {"y"}, {"z"}};
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    bool has_unit = false;
    const size_t n_rgb = find_three(l, rgb, identity, &has_unit);
    const int *value = l->value;
    if (n_rgb == 2 || (n_rgb == 1 && value[0] < 0)) /* r alone is the only value */
        return fail_column(l, path, *rgb[value[0] < 0 ? 0 : value[1] < 0 ? 1 : 2], err);
    if (n_rgb < 3 && (n_rgb || find_three(l, xyz, nqm_xyz_weights, &has_unit) < 3) && !find_one(l, &has_unit)) {
        if (find_spectrum(l) == 0)
            return fail_column(l, path, "r", err);
        if (l->n_values > 1 && !nqm_spectrum_is_visible(l->n_values, l->nm))
            return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)l->header,
                            "%s: the wavelengths of its %zu columns of values (header at byte %zu) do not rise from at "
                            "most 500 nm to at least 600 nm",
                            path, l->n_values, l->header);
    }
    return has_unit ? fail_unit(l, path, value[0], "1/sr", err) : NQM_OK;
}

static bool is_column_used(const layout *l, int column) {
    bool is = false;
    for (size_t k = 0; k < l->n_angles; ++k)
        is = is || l->angle[k] == column;
    for (size_t k = 0; k < l->n_values; ++k)
        is = is || l->value[k] == column;
    return is;
}

/* Columns that are not used are named; one with the name of a used one is a mistake. */
static nqm_status check_columns(const layout *l, nqm_list *list, nqm_error *err) {
    char name[NAME_BYTES], other[NAME_BYTES];
    for (int i = 0; i < (int)nqm_csv_columns(l->csv); ++i) {
        const char *header = nqm_csv_header(l->csv, i);
        if (is_column_used(l, i))
            continue;
        read_name(header, name);
        for (int j = 0; j < i && *name; ++j)
            if (is_column_used(l, j) && (read_name(nqm_csv_header(l->csv, j), other), strcmp(name, other) == 0))
                return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)l->header,
                                "%s: two columns are '%s' (header at byte %zu)", list->path, header, l->header);
        nqm_remark_add(list->remark, sizeof list->remark, "column '%.40s' is not used", header);
    }
    return NQM_OK;
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

/* A negative polar angle is on the other side of the normal: its positive one at the opposite azimuth. */
static void unsign(double *theta, double *phi) {
    *phi += *theta < 0 ? NQM_PI : 0;
    *theta = fabs(*theta);
}

static nqm_status read_angle(const layout *l, const char *path, size_t row, size_t k, double *angle, nqm_error *err) {
    static const double degree = NQM_PI / 180, rounding = 0.01;
    const angle_column *range = &l->angles[k];
    nqm_status status = nqm_csv_number(l->csv, row, l->angle[k], angle, err);
    double degrees = *angle / (l->in_radians[k] ? degree : 1);
    if (l->in_radians[k] && fabs(degrees) > range->high && fabs(degrees) < range->high + rounding)
        degrees = copysign(range->high, degrees); /* 1.5708 */
    if (status == NQM_OK && !(degrees >= range->low && degrees <= range->high)) {
        const size_t at = nqm_csv_byte(l->csv, row, l->angle[k]);
        status = nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at, "%s: %s %g%s at byte %zu is not within %g to %g degrees",
                          path, nqm_csv_header(l->csv, l->angle[k]), *angle, l->in_radians[k] ? " radians" : "", at,
                          range->low, range->high);
    }
    *angle = degrees * degree;
    return status;
}

static nqm_status read_angles(const layout *l, const char *path, size_t row, nqm_listed *to, nqm_error *err) {
    double angle[MAX_ANGLES];
    nqm_status status = NQM_OK;
    for (size_t k = 0; k < l->n_angles && status == NQM_OK; ++k)
        status = read_angle(l, path, row, k, angle + k, err);
    if (status != NQM_OK)
        return status;
    memcpy(to->at, angle, sizeof to->at);
    if (l->angles != pair_columns)
        return NQM_OK;
    unsign(angle, angle + 1);
    unsign(angle + 2, angle + 3);
    to->at[0] = angle[2];
    to->at[1] = angle[0];
    to->at[2] = angle[1] - angle[3];
    to->phi_i = angle[3];
    return NQM_OK;
}

/* Empty fields, or NaN in one: no value. */
static nqm_status read_value(const layout *l, size_t row, float *rgb, nqm_error *err) {
    bool is_none = false, is_empty = true;
    double sum[3] = {0};
    for (size_t k = 0; k < l->n_values; ++k) {
        const char *text = nqm_csv_text(l->csv, row, l->value[k]);
        is_empty = is_empty && !*text;
        is_none = is_none || nqm_equal_any_case(text, "nan", SIZE_MAX) || nqm_equal_any_case(text, "-nan", SIZE_MAX);
    }
    for (size_t k = 0; k < l->n_values && !is_none && !is_empty; ++k) {
        double value;
        nqm_status status = nqm_csv_number(l->csv, row, l->value[k], &value, err);
        if (status != NQM_OK)
            return status;
        for (size_t c = 0; c < 3; ++c)
            sum[c] += l->weights[3 * k + c] * value;
    }
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = is_none || is_empty ? NAN : (float)sum[c];
    return NQM_OK;
}

static nqm_status read_rows(const nqm_csv *csv, size_t header, bool is_astm, nqm_list *list, nqm_error *err) {
    layout l = {.csv = csv, .header = header};
    const size_t n_columns = nqm_csv_columns(csv) + 3;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&l.value, n_columns, sizeof *l.value}, {&l.nm, n_columns, sizeof *l.nm},
                                    {&l.weights, n_columns, 3 * sizeof *l.weights}),
                         err);
    if (status != NQM_OK)
        return status;
    status = find_angles(&l, is_astm, list, err);
    if (status == NQM_OK)
        status = find_values(&l, list->path, err);
    if (status == NQM_OK)
        status = check_columns(&l, list, err);
    list->is_reciprocal = status == NQM_OK && !list->has_pairs;
    for (size_t row = 0; row < list->n && status == NQM_OK; ++row) {
        const double *phi_d = list->rows[row].at + 2;
        status = read_angles(&l, list->path, row, &list->rows[row], err);
        if (status == NQM_OK)
            status = read_value(&l, row, list->rows[row].rgb, err);
        list->is_reciprocal = list->is_reciprocal && *phi_d >= 0 && *phi_d <= NQM_PI;
    }
    nqm_free(l.value);
    return status;
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* Whether a line names two polar angles. */
static bool names_angles(const char *line, size_t n) {
    int count = 0;
    for (size_t i = 0; i + 5 <= n; ++i)
        count += nqm_equal_any_case(line + i, "theta", 5) || memcmp(line + i, "\xce\xb8", 2) == 0;
    return count >= 2;
}

/* The header: the first line that is neither blank nor a comment, or in ASTM's layout the line that begins with VARS, whose other
 * words it is. n_bytes: none. */
static size_t find_header(const nqm_map *map, bool *is_astm) {
    const char *text = (const char *)map->data;
    const size_t n_bytes = nqm_smaller(map->n_bytes, PREAMBLE_BYTES);
    size_t n_lines = 0;
    for (size_t at = n_bytes >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0, n; at < n_bytes; at += n + 1) {
        const char *end = memchr(text + at, '\n', n_bytes - at);
        n = end ? (size_t)(end - text) - at : n_bytes - at;
        const char *line = text + at;
        size_t n_blank = 0;
        while (n_blank < n && strchr(" \t\r", line[n_blank]))
            ++n_blank;
        *is_astm = n > 5 && memcmp(line, "VARS", 4) == 0 && strchr(" \t", line[4]);
        if ((*is_astm || n_lines == 0) && names_angles(line, n))
            return at + (*is_astm ? 5 : 0);
        n_lines += n_blank < n && line[n_blank] != '#';
    }
    return map->n_bytes;
}

static bool probe(const nqm_map *map) {
    bool is_astm;
    return find_header(map, &is_astm) < map->n_bytes;
}

/* A copy of a file in ASTM's layout in which the lines before the header are comments: bytes and lines of messages are right. */
static nqm_status parse_astm(const nqm_map *map, size_t header, nqm_csv **csv, nqm_error *err) {
    char *text = nqm_alloc(map->n_bytes, 1);
    if (!text)
        return nqm_fail_nomem(err, map->n_bytes);
    memcpy(text, map->data, map->n_bytes);
    for (size_t i = 0; i < header; ++i)
        if (text[i] != '\n')
            text[i] = ' ';
    nqm_status status = nqm_csv_parse(text, map->n_bytes, map->path, csv, err);
    nqm_free(text);
    return status;
}

/* The member is the tolerance. */
static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_csv *csv = NULL;
    bool is_astm;
    nqm_map_expect(map, true);
    const size_t header = find_header(map, &is_astm);
    nqm_status status = is_astm ? parse_astm(map, header, &csv, err)
                                : nqm_csv_parse((const char *)map->data, map->n_bytes, map->path, &csv, err);
    if (status != NQM_OK)
        return status;
    nqm_list l = {.path = map->path, .n = nqm_csv_rows(csv)};
    l.rows = nqm_alloc(l.n, sizeof *l.rows);
    if (!l.rows)
        status = nqm_fail_nomem(err, l.n * sizeof *l.rows);
    else if (l.n == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, (int64_t)map->n_bytes, "%s: ends at byte %zu without a direction",
                          map->path, map->n_bytes);
    if (status == NQM_OK)
        status = read_rows(csv, header, is_astm, &l, err);
    nqm_csv_free(csv);
    if (status == NQM_OK)
        status = nqm_listed_create(&l, map->n_bytes, argument, brdf_ret, err);
    nqm_free(l.rows);
    return status;
}

const nqm_brdf_format nqm_listed_format = {.files = "CSV or ASTM text with theta_h, theta_d, phi_d or theta_i, phi_i, "
                                                    "theta_o, phi_o",
                                           .takes_members = true,
                                           .probe = probe,
                                           .open = open_file};
