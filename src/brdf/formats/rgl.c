/* SPDX-License-Identifier: MIT
 *
 * RGL measured materials, RGB or spectral (Dupuy and Jakob 2018, DOI 10.1145/3272127.3275059; doc/files.md): f_r cos(theta_o) D^-1
 * 4 sigma on a grid that is warped, per direction of incidence, by the distribution of visible normals. Evaluation inverts the warp
 * (section 4): the half vector's coordinates go through the marginal and conditional integrals of the visible-normal density, and
 * the result is looked up bilinearly. Spectra become RGB when the file is opened: evaluation is linear in the stored values.
 *
 * The file's omega_i is the viewer and its omega_o the light, whose stored cosine is divided out.
 */
#include "brdf/formats/format.h"

#include "io/io.h"
#include <float.h>
#include <math.h>

/* Tolerance of the ranges of phi_i, radians. */
#define PHI_SLACK 1e-3

/** A table over the unit square, first coordinate along a row; (height, width) or several such slices. */
typedef struct grid {
    size_t width, height;
    const float *value;
} grid;

/* Allocated as one block; copies and integrals follow the struct. A slice is that of one phi_i and theta_i. */
typedef struct rgl {
    grid theta, phi; /* theta_i (at least two), phi_i: rising, radians; width: their number */
    grid ndf, sigma; /* microfacet density over half vectors; projected area over incidence: (height, width) */
    grid vndf;       /* visible-normal density, not normalised: (phi.width, theta.width, height, width) */
    double *
        conditional; /* (phi.width, theta.width, vndf.height, vndf.width): integral of a row up to a column, in cells */
    double *marginal; /* (phi.width, theta.width, vndf.height): integral of the rows up to a row, in cells */
    grid rgb;         /* (phi.width, theta.width, 3, height, width) */
    bool jacobian;    /* values are divided by D / (4 sigma) */
    size_t n_images;  /* symmetric images of a pair of directions, one of which has its phi_i in the range of phi */
} rgl;

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

/** A point between four neighbours of a grid: the lower corner's index, its row, and the weights of the upper ones. */
typedef struct spot {
    size_t corner, row;
    double x, y;
} spot;

static size_t cell_of(double *position, size_t n) {
    double scaled = *position > 0 ? *position * (double)(n - 1) : 0;
    size_t cell = scaled < (double)(n - 2) ? (size_t)scaled : n - 2;
    *position = fmin(scaled - (double)cell, 1);
    return cell;
}

/* u, v are clamped to [0, 1]. */
static inline spot locate(const grid *g, double u, double v) {
    size_t column = cell_of(&u, g->width), row = cell_of(&v, g->height);
    return (spot){.corner = row * g->width + column, .row = row, .x = u, .y = v};
}

static double mix(double a, double b, double t) {
    return (1 - t) * a + t * b;
}

/* The value in a slice of a grid. */
static double look_up_at(const grid *g, const float *slice, const spot *s) {
    const float *p = slice + s->corner, *q = p + g->width;
    return mix(mix((double)p[0], (double)p[1], s->x), mix((double)q[0], (double)q[1], s->x), s->y);
}

static double look_up(const grid *g, double u, double v) {
    const spot s = locate(g, u, v);
    return look_up_at(g, g->value, &s);
}

/** Terms of the inverse of the warp at a spot. All are linear in the density, so that interpolating them interpolates
 * between two angles of incidence. */
typedef struct warp_terms {
    double left, right; /* density at the cell's left and right edge */
    double before;      /* integral of the row up to the left edge */
    double row0, row1;  /* integrals of the whole rows below and above */
    double below;       /* integral of all rows up to the lower one */
} warp_terms;

static warp_terms terms_at(const rgl *m, size_t k, const spot *s) {
    size_t width = m->vndf.width, height = m->vndf.height;
    const float *d = m->vndf.value + k * width * height + s->corner;
    const double *c = m->conditional + k * width * height + s->corner;
    const double *row_end = m->conditional + (k * height + s->row + 1) * width - 1;
    return (warp_terms){.left = mix((double)d[0], (double)d[width], s->y),
                        .right = mix((double)d[1], (double)d[width + 1], s->y),
                        .before = mix(c[0], c[width], s->y),
                        .row0 = row_end[0],
                        .row1 = row_end[width],
                        .below = m->marginal[k * height + s->row]};
}

static warp_terms mix_terms(const warp_terms *a, double wa, const warp_terms *b, double wb) {
    return (warp_terms){.left = wa * a->left + wb * b->left,
                        .right = wa * a->right + wb * b->right,
                        .before = wa * a->before + wb * b->before,
                        .row0 = wa * a->row0 + wb * b->row0,
                        .row1 = wa * a->row1 + wb * b->row1,
                        .below = wa * a->below + wb * b->below};
}

/* Between slices k and k + 1 with weight t. */
static warp_terms terms_between(const rgl *m, size_t k, double t, const spot *s) {
    const warp_terms a = terms_at(m, k, s), b = terms_at(m, k + 1, s);
    const double *total = m->marginal + (k + 1) * m->vndf.height - 1; /* the density is normalised here */
    return mix_terms(&a, (1 - t) / total[0], &b, t / total[m->vndf.height]);
}

/** A pair on the grids of the file. */
typedef struct place {
    double u_i, v_i;   /* direction of incidence */
    double u, v;       /* half vector */
    size_t slice;      /* of the lower theta_i and phi_i */
    double theta, phi; /* weights of the upper ones */
} place;

/* Replace the half vector by the point of the value grid that the warp maps to it. */
static void invert_warp(const rgl *m, place *p) {
    const spot s = locate(&m->vndf, p->u, p->v);
    warp_terms a = terms_between(m, p->slice, p->theta, &s);
    if (m->phi.width > 1) {
        const warp_terms b = terms_between(m, p->slice + m->theta.width, p->theta, &s);
        a = mix_terms(&a, 1 - p->phi, &b, p->phi);
    }
    double row = mix(a.row0, a.row1, s.y);
    if (row > 0) /* else no half vector of this row is visible: leave u */
        p->u = (a.before + s.x * (a.left + 0.5 * s.x * (a.right - a.left))) / row;
    p->v = a.below + s.y * (a.row0 + 0.5 * s.y * (a.row1 - a.row0));
}

static double theta_to_unit(double theta) {
    return sqrt(theta * (2 / NQM_PI));
}

static double polar_angle(const double *w) {
    return atan2(sqrt(w[0] * w[0] + w[1] * w[1]), w[2]);
}

/* An azimuth from that of the direction w, as a fraction of a turn in [0, 1) with 0.5 at w. */
static double azimuth_to_unit(const double *w, const double *h) {
    bool normal = w[0] == 0 && w[1] == 0;
    double cos_i = normal ? 1 : w[0], sin_i = w[1]; /* atan2() does not need a unit vector */
    double phi = atan2(cos_i * h[1] - sin_i * h[0], cos_i * h[0] + sin_i * h[1]);
    double v = (phi + NQM_PI) / (2 * NQM_PI);
    return v < 1 ? v : 0;
}

/* Index of the last of n angles, without the very last, that is not above x, and the weight of the next one. */
static size_t find_angle(const grid *angles, double x, double *weight) {
    const float *angle = angles->value;
    size_t k = 0;
    while (k + 2 < angles->width && x >= (double)angle[k + 1])
        ++k;
    double before = (double)angle[k], after = (double)angle[k + 1];
    *weight = fmin(fmax((x - before) / (after - before), 0), 1);
    return k;
}

/* Replace omega_i and h by the symmetric image of the pair whose phi_i is in the range of the file; returns that phi_i. */
static double reduce_azimuth(const rgl *m, double *omega_i, double *h) {
    static const double images[4][2] = {{1, 1}, {-1, -1}, {1, -1}, {-1, 1}};
    const double first = (double)m->phi.value[0], last = (double)m->phi.value[m->phi.width - 1];
    double phi = first;
    size_t k = 0;
    for (; k < m->n_images; ++k) {
        phi = fmod(atan2(images[k][1] * omega_i[1], images[k][0] * omega_i[0]) - first, 2 * NQM_PI);
        phi = phi < 0 ? phi + first + 2 * NQM_PI : phi + first;
        if (phi <= last + PHI_SLACK)
            break;
    }
    for (size_t a = 0; k < m->n_images && a < 2; ++a) {
        omega_i[a] *= images[k][a];
        h[a] *= images[k][a];
    }
    return phi;
}

/* Complete the place of a pair in a file with several phi_i. h: the half vector, of any length. */
static void place_azimuths(const rgl *m, const double *omega_i, const double *h, place *p) {
    static const double tangent[2] = {1, 0};
    double i[2] = {omega_i[0], omega_i[1]}, half[2] = {h[0], h[1]};
    p->slice += m->theta.width * find_angle(&m->phi, reduce_azimuth(m, i, half), &p->phi);
    p->v_i = azimuth_to_unit(tangent, i);
    p->v = azimuth_to_unit(m->phi.width > 2 ? tangent : i, half);
}

static place find_place(const rgl *m, const double *omega_i, const double *omega_o) {
    const double h[3] = {omega_i[0] + omega_o[0], omega_i[1] + omega_o[1], omega_i[2] + omega_o[2]};
    const double theta_i = polar_angle(omega_i);
    place p = {.u_i = theta_to_unit(theta_i), .v_i = 0.5, .u = theta_to_unit(polar_angle(h))};
    p.v = azimuth_to_unit(omega_i, h);
    p.slice = find_angle(&m->theta, theta_i, &p.theta);
    if (m->phi.width > 1)
        place_azimuths(m, omega_i, h, &p);
    return p;
}

static void eval_pair(const rgl *m, const double *omega_i, const double *omega_o, double *rgb) {
    place p = find_place(m, omega_i, omega_o);
    double scale = 1 / omega_o[2];
    if (m->jacobian)
        scale *= look_up(&m->ndf, p.u, p.v) / (4 * look_up(&m->sigma, p.u_i, p.v_i));
    invert_warp(m, &p);
    const spot s = locate(&m->rgb, p.u, p.v);
    const size_t n_slice = m->rgb.width * m->rgb.height, n_phi = m->phi.width > 1 ? 2 : 1;
    const float *lower = m->rgb.value + 3 * p.slice * n_slice;
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (size_t j = 0; j < n_phi; ++j, lower += 3 * m->theta.width * n_slice) {
        const double weight = scale * (j ? p.phi : 1 - p.phi);
        for (size_t c = 0; c < 3; ++c) {
            rgb[c] += (1 - p.theta) * weight * look_up_at(&m->rgb, lower + c * n_slice, &s);
            rgb[c] += p.theta * weight * look_up_at(&m->rgb, lower + (3 + c) * n_slice, &s);
        }
    }
}

static void rgl_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    for (size_t i = 0; i < n; ++i)
        eval_pair(self, wo + 3 * i, wi + 3 * i, rgb + 3 * i);
}

static const nqm_brdf_class rgl_class = {.format = "rgl", .anisotropic = true, .eval = rgl_eval, .free = nqm_free};

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/** The required tensors of the file. */
typedef struct contents {
    const char *path;
    const nqm_tensor *phi_i, *theta_i, *ndf, *sigma, *vndf;
    const nqm_tensor *values;      /* `rgb` or `spectra` */
    const nqm_tensor *wavelengths; /* wavelengths of spectra, nm; NULL for rgb */
    nqm_illuminant illuminant;
} contents;

static nqm_status find_tensor(const nqm_tensor_file *file, const contents *c, const char *name, size_t n_dims,
                              const nqm_tensor **t_ret, nqm_error *err) {
    *t_ret = nqm_tensor_file_find(file, name);
    if (!*t_ret)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no tensor '%s' (byte 0)", c->path, name);
    if ((*t_ret)->dtype != NQM_F32 || (*t_ret)->n_dims != n_dims)
        return nqm_brdf_fail_tensor(c->path, *t_ret, "has a type or shape that is not that of an RGL material", err);
    return NQM_OK;
}

static nqm_status find_tensors(const nqm_tensor_file *file, contents *c, nqm_error *err) {
    const bool spectral = nqm_tensor_file_find(file, "spectra") && !nqm_tensor_file_find(file, "rgb");
    const struct {
        const char *name;
        size_t n_dims;
        const nqm_tensor **t;
    } tensors[] = {{"phi_i", 1, &c->phi_i}, {"theta_i", 1, &c->theta_i}, {"ndf", 2, &c->ndf},
                   {"sigma", 2, &c->sigma}, {"vndf", 4, &c->vndf},       {spectral ? "spectra" : "rgb", 5, &c->values}};
    nqm_status status = spectral ? find_tensor(file, c, "wavelengths", 1, &c->wavelengths, err) : NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < sizeof tensors / sizeof *tensors; ++i)
        status = find_tensor(file, c, tensors[i].name, tensors[i].n_dims, tensors[i].t, err);
    return status;
}

/* Check that the shapes agree and that every grid has at least one cell. */
static nqm_status check_shapes(const contents *c, nqm_error *err) {
    const nqm_tensor *grids[] = {c->ndf, c->sigma, c->vndf, c->values};
    for (size_t i = 0; i < 4; ++i)
        if (grids[i]->dims[grids[i]->n_dims - 1] < 2 || grids[i]->dims[grids[i]->n_dims - 2] < 2)
            return nqm_brdf_fail_tensor(c->path, grids[i], "has fewer than 2 x 2 values", err);
    const size_t n_phi = c->phi_i->dims[0], n_theta = c->theta_i->dims[0];
    if (n_phi < 1 || (c->wavelengths && c->wavelengths->dims[0] < 1))
        return nqm_brdf_fail_tensor(c->path, n_phi < 1 ? c->phi_i : c->wavelengths, "is empty", err);
    if (n_theta < 2)
        return nqm_brdf_fail_tensor(c->path, c->theta_i, "has fewer than two angles", err);
    if (c->vndf->dims[0] != n_phi || c->vndf->dims[1] != n_theta)
        return nqm_brdf_fail_tensor(c->path, c->vndf, "does not have one slice for each phi_i and theta_i", err);
    const size_t *dims = c->values->dims;
    if (dims[0] != n_phi || dims[1] != n_theta || dims[2] != (c->wavelengths ? c->wavelengths->dims[0] : 3))
        return nqm_brdf_fail_tensor(c->path, c->values,
                                    c->wavelengths
                                        ? "does not have one value for each of `wavelengths`, phi_i and theta_i"
                                        : "does not have three channels for each phi_i and theta_i",
                                    err);
    return NQM_OK;
}

/* Refuse values that are below `least` or not finite. */
static nqm_status check_values(const contents *c, const nqm_tensor *t, float least, nqm_error *err) {
    const unsigned char *data = t->data, *end = data + t->n_bytes;
    while (data < end && nqm_load_f32(data) >= least && isfinite(nqm_load_f32(data)))
        data += sizeof(float);
    if (data == end)
        return NQM_OK;
    long long at = t->byte_offset + (data - (const unsigned char *)t->data);
    return nqm_fail(err, NQM_ERR_FORMAT, at, "%s: '%s' contains %g at byte %lld", c->path, t->name,
                    (double)nqm_load_f32(data), at);
}

static grid grid_of(const nqm_tensor *t, const float *value) {
    return (grid){
        .width = t->dims[t->n_dims - 1], .height = t->n_dims > 1 ? t->dims[t->n_dims - 2] : 1, .value = value};
}

static nqm_status copy_floats(const contents *c, const nqm_tensor *t, float least, float *copy, grid *g,
                              nqm_error *err) {
    nqm_copy_little_endian(nqm_tensor_count(t), sizeof *copy, t->data, copy);
    *g = grid_of(t, copy);
    return check_values(c, t, least, err);
}

/* RGB of spectra. weights: (n, 3), n = dims[2]; rgb: (n_phi, n_theta, 3, height, width). */
static void convert_spectra(const nqm_tensor *t, const double *weights, float *rgb) {
    const size_t n = t->dims[2], n_slice = t->dims[3] * t->dims[4], n_plane = n_slice * sizeof(float);
    for (size_t k = 0; k < t->dims[0] * t->dims[1]; ++k, rgb += 3 * n_slice)
        for (size_t i = 0; i < n_slice; ++i) {
            const unsigned char *value = (const unsigned char *)t->data + k * n * n_plane + i * sizeof(float);
            double sum[3] = {0};
            for (size_t w = 0; w < n; ++w, value += n_plane)
                for (size_t c = 0; c < 3; ++c)
                    sum[c] += weights[3 * w + c] * (double)nqm_load_f32(value);
            for (size_t c = 0; c < 3; ++c)
                rgb[c * n_slice + i] = (float)fmin(fmax(sum[c], (double)-FLT_MAX), (double)FLT_MAX);
        }
}

static nqm_status read_spectra(const contents *c, float *rgb, nqm_error *err) {
    const size_t n = c->wavelengths->dims[0];
    double *weights = nqm_alloc(3 * n, sizeof *weights);
    nqm_status status = weights ? nqm_brdf_tensor_weights(c->path, c->wavelengths, c->illuminant, weights, err)
                                : nqm_fail_nomem(err, 3 * n * sizeof *weights);
    if (status == NQM_OK)
        status = check_values(c, c->values, -FLT_MAX, err);
    if (status == NQM_OK)
        convert_spectra(c->values, weights, rgb);
    nqm_free(weights);
    return status;
}

/* Fill the integrals of slice k by the trapezoidal rule, which is exact for bilinear densities; returns that over the
 * whole slice. */
static double integrate_slice(rgl *m, size_t k) {
    const size_t width = m->vndf.width, height = m->vndf.height;
    const float *density = m->vndf.value + k * height * width;
    double *conditional = m->conditional + k * height * width, *marginal = m->marginal + k * height;
    for (size_t y = 0; y < height; ++y)
        for (size_t i = y * width + 1; i < (y + 1) * width; ++i)
            conditional[i] = conditional[i - 1] + 0.5 * ((double)density[i - 1] + (double)density[i]);
    for (size_t y = 1; y < height; ++y)
        marginal[y] = marginal[y - 1] + 0.5 * (conditional[y * width - 1] + conditional[(y + 1) * width - 1]);
    return marginal[height - 1];
}

static nqm_status read_angles(const contents *c, const nqm_tensor *t, float least, float *angle, grid *g,
                              nqm_error *err) {
    nqm_status status = copy_floats(c, t, least, angle, g, err);
    for (size_t k = 1; status == NQM_OK && k < g->width; ++k)
        if (!(angle[k] > angle[k - 1]))
            status = nqm_brdf_fail_tensor(c->path, t, "does not rise", err);
    return status;
}

/* The symmetric images that the range of phi_i needs: a turn, half a turn or a quarter. */
static nqm_status find_images(const contents *c, rgl *m, nqm_error *err) {
    const double range = (double)m->phi.value[m->phi.width - 1] - (double)m->phi.value[0];
    for (m->n_images = 1; m->n_images <= 4; m->n_images *= 2)
        if (fabs((double)m->n_images * range - 2 * NQM_PI) < PHI_SLACK)
            return NQM_OK;
    return nqm_brdf_fail_tensor(c->path, c->phi_i, "does not cover 360, 180 or 90 degrees", err);
}

/* `found` has the path and the illuminant; the tensors are added. */
static nqm_status read_material(const nqm_tensor_file *file, contents *found, rgl **m_ret, nqm_error *err) {
    nqm_status status = find_tensors(file, found, err);
    if (status == NQM_OK)
        status = check_shapes(found, err);
    if (status != NQM_OK)
        return status;
    const contents c = *found;
    const size_t n_slices = c.values->dims[0] * c.values->dims[1];
    const size_t n_rgb = 3 * n_slices * c.values->dims[3] * c.values->dims[4], n_warp = nqm_tensor_count(c.vndf);
    float *theta, *phi, *ndf, *sigma, *vndf, *rgb;
    double *conditional, *marginal;
    status = nqm_alloc_arrays(
        NQM_ARRAYS({m_ret, 1, sizeof(rgl)}, {&theta, nqm_tensor_count(c.theta_i), sizeof(float)},
                   {&phi, nqm_tensor_count(c.phi_i), sizeof(float)}, {&ndf, nqm_tensor_count(c.ndf), sizeof(float)},
                   {&sigma, nqm_tensor_count(c.sigma), sizeof(float)}, {&vndf, n_warp, sizeof(float)},
                   {&rgb, n_rgb, sizeof(float)}, {&conditional, n_warp, sizeof(double)},
                   {&marginal, n_slices * c.vndf->dims[2], sizeof(double)}),
        err);
    if (status != NQM_OK)
        return status;
    rgl *m = *m_ret;
    m->conditional = conditional;
    m->marginal = marginal;
    status = read_angles(&c, c.theta_i, 0, theta, &m->theta, err);
    if (status == NQM_OK)
        status = read_angles(&c, c.phi_i, -FLT_MAX, phi, &m->phi, err);
    if (status == NQM_OK && m->phi.width > 1)
        status = find_images(&c, m, err);
    if (status == NQM_OK)
        status = copy_floats(&c, c.ndf, 0, ndf, &m->ndf, err);
    if (status == NQM_OK)
        status = copy_floats(&c, c.sigma, FLT_MIN, sigma, &m->sigma, err);
    if (status == NQM_OK) {
        status = c.wavelengths ? read_spectra(&c, rgb, err) : copy_floats(&c, c.values, -FLT_MAX, rgb, &m->rgb, err);
        m->rgb = grid_of(c.values, rgb);
    }
    if (status == NQM_OK)
        status = copy_floats(&c, c.vndf, 0, vndf, &m->vndf, err);
    for (size_t k = 0; status == NQM_OK && k < n_slices; ++k)
        if (!(integrate_slice(m, k) >= FLT_MIN)) /* its inverse must be finite */
            status = nqm_brdf_fail_tensor(c.path, c.vndf, "has a slice without any density", err);
    const nqm_tensor *jacobian = nqm_tensor_file_find(file, "jacobian");
    m->jacobian = !jacobian || jacobian->n_bytes != 1 || *(const unsigned char *)jacobian->data != 0;
    return status;
}

static bool probe(const nqm_map *map) {
    static const char magic[12] = "tensor_file";
    size_t n = map->n_bytes < sizeof magic ? map->n_bytes : sizeof magic;
    return n >= 4 && memcmp(map->data, magic, n) == 0;
}

/* Describe the BRDF in a line, for its information. */
static void describe(const rgl *m, const contents *c, char *text, size_t n_text) {
    int used = m->phi.width > 1 ? snprintf(text, n_text, "%zu azimuths x ", m->phi.width) : 0;
    used += snprintf(text + used, n_text - (size_t)used, "%zu angles of incidence x %zu x %zu samples, warp %zu x %zu",
                     m->theta.width, m->rgb.height, m->rgb.width, m->vndf.height, m->vndf.width);
    const unsigned char *nm = c->wavelengths ? c->wavelengths->data : NULL;
    if (nm)
        snprintf(text + used, n_text - (size_t)used, ", %zu wavelengths %g to %g nm under illuminant %s",
                 c->wavelengths->dims[0], (double)nqm_load_f32(nm),
                 (double)nqm_load_f32(nm + c->wavelengths->n_bytes - sizeof(float)),
                 nqm_illuminant_name(c->illuminant));
}

static nqm_status open_rgl(nqm_map *map, const nqm_tensor_file *file, nqm_illuminant illuminant, const char *name,
                           nqm_brdf **brdf_ret, nqm_error *err) {
    contents c = {.path = map->path, .illuminant = illuminant};
    rgl *m = NULL;
    nqm_status status = read_material(file, &c, &m, err);
    if (status != NQM_OK) {
        nqm_free(m);
        return status;
    }
    char layout[200];
    describe(m, &c, layout, sizeof layout);
    const nqm_brdf_info info = {.name = name,
                                .source_doi = "10.1145/3272127.3275059",
                                .layout = layout,
                                .n_values = nqm_tensor_count(c.values) + nqm_tensor_count(c.vndf) +
                                            nqm_tensor_count(c.ndf) + nqm_tensor_count(c.sigma),
                                .isotropic = m->phi.width == 1};
    return nqm_brdf_wrap(&rgl_class, m, &info, brdf_ret, err);
}

/* The member is the illuminant for spectra. */
static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    const char *illuminant_name = argument->member;
    nqm_tensor_file *file = NULL;
    nqm_illuminant illuminant = NQM_ILLUMINANT_E;
    if (illuminant_name && !nqm_illuminant_find(illuminant_name, &illuminant))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: '%s' is not an illuminant for its spectra: E or D65", map->path,
                        illuminant_name);
    nqm_status status = nqm_tensor_file_parse(map->data, map->n_bytes, map->path, &file, err);
    if (status == NQM_OK && nqm_tensor_file_find(file, "M")) {
        status = nqm_pbsdf_open(map, file, illuminant, argument->name, brdf_ret, err);
        nqm_free(file);
        return status;
    }
    nqm_map_expect(map, true);
    if (status == NQM_OK && illuminant_name && !nqm_tensor_file_find(file, "spectra"))
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: contains RGB, not spectra: open it without ':%s'", map->path,
                          illuminant_name);
    if (status == NQM_OK)
        status = open_rgl(map, file, illuminant, argument->name, brdf_ret, err);
    nqm_free(file);
    return status;
}

const nqm_brdf_format nqm_rgl_format = {
    .files = "RGL .bsdf, .pbsdf", .takes_members = true, .probe = probe, .open = open_file};
