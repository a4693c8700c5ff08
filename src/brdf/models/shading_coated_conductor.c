/* SPDX-License-Identifier: MIT
 *
 * `pbrt-coated-conductor` is pbrt-v4's `coatedconductor` (Pharr, Jakob and Humphreys, Physically Based Rendering, 4th
 * edition, 14.3): a conductor under a dielectric interface with an absorbing gap; either can be smooth. The value is
 * the mean of pbrt's random walks (LayeredBxDF::f), estimated from N_WALKS pairs of walks, one from the viewer and one
 * from the light, on the points of a lattice, which are the same for all directions. All vertices of a pair are
 * connected, and equally long paths are weighted by the balance heuristic (Veach 1997, chapter 10). Paths with up to
 * N_ORDERS reflections by the conductor are summed, longer ones extrapolated. doc/materials.md has the errors. Mirrors are lobes of
 * the smallest roughness, 1e-6.
 */
#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"

enum { NQM_COATED_CONDUCTOR_KEYS(NQM_KEY_INDEX) };

enum {
    N_WALKS = 61,  /* a prime, for the lattice */
    GENERATOR = 6, /* of the lattice; has the smallest error for 16 materials */
    N_ORDERS = 3,  /* reflections by the conductor */
    MAX_VERTEX = 2 * N_ORDERS,
    N_REFLECTANCES = 128
};
#define SMOOTH 1e-6 /* pbrt's EffectivelySmooth(): alpha < 0.001 */

typedef enum layer { INTERFACE, CONDUCTOR } layer;

typedef struct coated {
    nqm_spec_state spec;
    double alpha[2], alpha2[2]; /* of the layers */
    bool is_smooth[2];
    double eta, gap, n_orders;
    double disk[N_WALKS][3];               /* a spiral that covers the unit disk */
    double reflectance[N_REFLECTANCES][3]; /* of the conductor in the coat, at cosines (j / (N_REFLECTANCES - 1))^2 */
} coated;

/* A walk: vertex 0 is outside, each next one follows an event, transmission first, then reflections by the conductor
 * and the interface. */
typedef struct vertex {
    double d[3];          /* away from the event before, or towards the next; z > 0 */
    double lambda[2];     /* Smith's Lambda for the distributions of the layers */
    double throughput[3]; /* product of value * cosine / density */
    double forward, back; /* density of d given the vertex before, and inversely */
    double others;        /* densities of the other ways to sample the path so far: for the balance heuristic */
} vertex;

/* Fresnel factors inside the coat. */
static void fresnel_inside(const coated *self, layer at, double cosine, double *f) {
    const double x = sqrt(cosine) * (N_REFLECTANCES - 1);
    const size_t i = x < N_REFLECTANCES - 2 ? (size_t)x : N_REFLECTANCES - 2;
    const double interface = at == INTERFACE ? fresnel_dielectric(1 / self->eta, cosine) : 0;
    for (size_t c = 0; c < 3; ++c)
        f[c] = at == INTERFACE ? interface : mix(self->reflectance[i][c], self->reflectance[i + 1][c], x - (double)i);
}

static void set_direction(const coated *self, double x, double y, double z, vertex *v) {
    v->d[0] = x;
    v->d[1] = y;
    v->d[2] = z;
    v->lambda[INTERFACE] = smith_lambda(self->alpha2[INTERFACE], z);
    v->lambda[CONDUCTOR] = smith_lambda(self->alpha2[CONDUCTOR], z);
}

/* D(h). */
static double distribution(double alpha2, double h_z) {
    const double z2 = h_z * h_z, spread = 1 - z2 + alpha2 * z2;
    return alpha2 / (NQM_PI * spread * spread);
}

/* The densities of a transmission and the product that both have, from D and the cosines with the normal, outside and inside. */
static double transmission(const coated *self, double d, const double *cosines, const vertex *outside, vertex *inside) {
    const double jacobian = cosines[0] / self->eta - cosines[1];
    const double common = d * cosines[0] * cosines[1] / (jacobian * jacobian);
    inside->forward = common / (outside->d[2] * (1 + outside->lambda[INTERFACE]));
    inside->back = common / (inside->d[2] * (1 + inside->lambda[INTERFACE]) * self->eta * self->eta);
    return common;
}

/* Let v[1] be what is transmitted of v[0]. */
static bool enter(const coated *self, const double *point, vertex *v) {
    const bool is_smooth = self->is_smooth[INTERFACE];
    const double alpha2 = self->alpha2[INTERFACE], *w = v[0].d, eta = self->eta, ratio = 1 / eta;
    double h[3] = {0, 0, 1};
    if (!is_smooth)
        ggx_visible_normal(self->alpha[INTERFACE], w, point, h);
    const double c = nqm_dot3(w, h), refracted = sqrt(1 - (1 - c * c) * ratio * ratio);
    const double k = c * ratio - refracted, z = w[2] * ratio - k * h[2];
    if (c <= 0 || z <= 1e-9)
        return false;
    set_direction(self, w[0] * ratio - k * h[0], w[1] * ratio - k * h[1], z, &v[1]);
    double weight = (1 - fresnel_dielectric(eta, c)) * exp(-self->gap / z);
    v[1].forward = v[1].back = v[1].others = 0;
    if (!is_smooth) {
        const double seen = 1 + v[0].lambda[INTERFACE];
        transmission(self, distribution(alpha2, h[2]), (const double[]){c, refracted}, &v[0], &v[1]);
        weight *= seen / (seen + v[1].lambda[INTERFACE]);
        v[1].others = 1 / v[1].forward;
    }
    v[1].throughput[0] = v[1].throughput[1] = v[1].throughput[2] = weight;
    return true;
}

/* Let v[1] be what a layer reflects of v[0]. */
static bool reflect(const coated *self, layer at, const double *point, vertex *v) {
    const double *w = v[0].d;
    double h[3] = {0, 0, 1}, f[3];
    if (!self->is_smooth[at])
        ggx_visible_normal(self->alpha[at], w, point, h);
    const double c = nqm_dot3(w, h), z = 2 * c * h[2] - w[2];
    if (c <= 0 || z <= 1e-9)
        return false;
    set_direction(self, 2 * c * h[0] - w[0], 2 * c * h[1] - w[1], z, &v[1]);
    double weight = exp(-self->gap / z);
    v[1].forward = v[1].back = 0;
    v[1].others = v[0].others;
    if (!self->is_smooth[at]) {
        const double seen[2] = {1 + v[0].lambda[at], 1 + v[1].lambda[at]}, d = distribution(self->alpha2[at], h[2]) / 4;
        weight *= seen[0] / (seen[0] + v[1].lambda[at]);
        v[1].forward = d / (seen[0] * w[2]);
        v[1].back = d / (seen[1] * z);
        v[1].others = (1 + v[1].back * v[0].others) / v[1].forward;
    }
    fresnel_inside(self, at, c, f);
    for (size_t i = 0; i < 3; ++i)
        v[1].throughput[i] = v[0].throughput[i] * weight * f[i];
    return true;
}

/* Walk from a direction outside; returns the number of vertices after it. first: the multiple of the walk's number of
 * which the points are. */
static size_t walk(const coated *self, const double *w, size_t number, size_t first, vertex *v) {
    size_t n = 0, at = number * first % N_WALKS;
    v[0] = (vertex){.throughput = {1, 1, 1}};
    set_direction(self, w[0], w[1], w[2], v);
    while (n < MAX_VERTEX &&
           (n ? reflect(self, n % 2 ? CONDUCTOR : INTERFACE, self->disk[at], v + n) : enter(self, self->disk[at], v))) {
        ++n;
        at = at * (GENERATOR * GENERATOR) % N_WALKS;
    }
    return n;
}

/* The sum of the weights of pbrt's strategies for the last reflection by the conductor. inside: of the densities of a transmission;
 * conductor: density of the reflection. */
static double weights(const coated *self, const vertex *inside, double conductor) {
    if (self->is_smooth[INTERFACE] || self->is_smooth[CONDUCTOR])
        return 1;
    const double i2 = inside->forward * inside->forward, c2 = conductor * conductor, o2 = inside->back * inside->back;
    return i2 / (i2 + c2) + c2 / (c2 + o2);
}

/* Add the path that a transmission between these vertices connects. first: of the light's walk; NULL: `outside` is the light. */
static void connect_outside(const coated *self, const vertex *outside, const vertex *walk, const vertex *first,
                            double *sum) {
    vertex inside = *walk;
    double h[3];
    for (size_t i = 0; i < 3; ++i)
        h[i] = self->eta * walk->d[i] - outside->d[i];
    const double length = copysign(sqrt(nqm_dot3(h, h)), h[2]);
    const double cosines[] = {nqm_dot3(outside->d, h) / length, nqm_dot3(walk->d, h) / length};
    if (cosines[0] <= 0 || cosines[1] <= 0)
        return;
    const double d = distribution(self->alpha2[INTERFACE], h[2] / length);
    const double common = transmission(self, d, cosines, outside, &inside);
    double weight = common * (1 - fresnel_dielectric(self->eta, cosines[0])) /
                    ((1 + outside->lambda[INTERFACE] + walk->lambda[INTERFACE]) * outside->d[2] * walk->d[2]);
    weight /= 1 + inside.forward * walk->others;
    weight *= first ? weights(self, first, first[1].back) : weights(self, &inside, walk->forward);
    for (size_t c = 0; c < 3; ++c)
        sum[c] += weight * walk->throughput[c];
}

/* Add the path that a reflection between these vertices connects. first: of the light's walk. */
static void connect_inside(const coated *self, layer at, const vertex *o, const vertex *i, const vertex *first,
                           double *sum) {
    const half_angles h = half_angles_of(i->d, o->d);
    const double d = ggx_distribution(h.tan2_h, self->alpha2[at]) / 4, to = o->lambda[at], ti = i->lambda[at];
    const double forward = d / ((1 + to) * o->d[2]), back = d / ((1 + ti) * i->d[2]);
    double weight = d / ((1 + to + ti) * o->d[2] * i->d[2]) / (1 + back * o->others + forward * i->others), f[3];
    weight *= weights(self, first, i == first ? forward : first[1].back);
    fresnel_inside(self, at, h.cos_d, f);
    for (size_t c = 0; c < 3; ++c)
        sum[c] += weight * f[c] * o->throughput[c] * i->throughput[c];
}

/* The walks from the viewer. */
typedef struct walks {
    vertex v[N_WALKS][MAX_VERTEX + 1];
    size_t n[N_WALKS]; /* vertices after the first */
} walks;

/* Sums over all walks by the number of reflections by the conductor. */
static void sum_orders(const coated *self, const walks *viewer, const double *wi, double sums[N_ORDERS][3]) {
    vertex i[MAX_VERTEX + 1];
    memset(sums, 0, N_ORDERS * sizeof *sums);
    for (size_t number = 0; number < N_WALKS; ++number) {
        const vertex *o = viewer->v[number];
        const size_t n_i = walk(self, wi, number, GENERATOR, i);
        for (size_t n = 0; n <= viewer->n[number]; ++n)
            for (size_t m = n % 2; m <= n_i && n + m <= MAX_VERTEX; m += 2) {
                const layer at = n % 2 ? CONDUCTOR : INTERFACE;
                if (n + m == 0 || self->is_smooth[at])
                    continue;
                double *sum = sums[(n + m) / 2 - 1];
                if (n && m)
                    connect_inside(self, at, &o[n], &i[m], &i[1], sum);
                else
                    connect_outside(self, n ? i : o, n ? &o[n] : &i[m], n ? NULL : &i[1], sum);
            }
    }
}

/* What the coat and the conductor below reflect as one mirror; pbrt follows `maxdepth` events, of which the last leaves
 * the coat. */
static void mirror(const coated *self, double max_depth, double cosine, double *rgb) {
    const double top = fresnel_dielectric(self->eta, cosine), n = floor(max_depth / 2);
    const double refracted = sqrt(1 - (1 - cosine * cosine) / (self->eta * self->eta));
    fresnel_inside(self, CONDUCTOR, refracted, rgb);
    for (size_t c = 0; c < 3; ++c) {
        const double down = rgb[c] * exp(-2 * self->gap / refracted);
        rgb[c] = top + (1 - top) * (1 - top) * down * (1 - pow(top * down, n)) / (1 - top * down);
    }
}

/* What leaves the coat: the sum of the orders that were estimated, and a geometric series. */
static double series(const coated *self, const double sums[N_ORDERS][3], size_t c) {
    double sum = 0;
    for (size_t k = 0; k < N_ORDERS && (double)k < self->n_orders; ++k)
        sum += sums[k][c];
    const double last = sums[N_ORDERS - 1][c], before = sums[N_ORDERS - 2][c], n = self->n_orders - N_ORDERS;
    const double ratio = last > 0 ? fmin(last / before, 0.95) : 0;
    if (n > 0)
        sum += last * ratio * (1 - pow(ratio, n)) / (1 - ratio);
    return sum / (N_WALKS * self->eta * self->eta);
}

static void coated_prepare(const nqm_values *values, void *state) {
    coated *self = state;
    const double(*v)[3] = values->v;
    const size_t keys[] = {INTERFACE_ROUGHNESS, CONDUCTOR_ROUGHNESS};
    for (size_t i = 0; i < 2; ++i) {
        self->is_smooth[i] = v[keys[i]][0] < SMOOTH;
        self->alpha2[i] = fmax(v[keys[i]][0], SMOOTH);
        self->alpha[i] = sqrt(self->alpha2[i]);
    }
    self->eta = v[INTERFACE_ETA][0];
    self->gap = v[THICKNESS][0];
    self->n_orders = floor((v[MAX_DEPTH][0] + 1) / 2);
    for (size_t j = 0; j < N_REFLECTANCES; ++j) {
        const double x = (double)j / (N_REFLECTANCES - 1), cosine = fmin(fmax(x * x, 1e-9), 1 - 1e-12); /* no 0 / 0 */
        for (size_t c = 0; c < 3; ++c)
            self->reflectance[j][c] =
                fmax(0, fresnel_conductor(v[CONDUCTOR_ETA][c] / self->eta, v[CONDUCTOR_K][c] / self->eta, cosine));
    }
    for (size_t j = 0; j < N_WALKS; ++j) {
        const double r = sqrt(((double)j + 0.5) / N_WALKS), turn = NQM_PI * (sqrt(5) - 1) * (double)j; /* golden */
        self->disk[j][0] = r * cos(turn);
        self->disk[j][1] = r * sin(turn);
        self->disk[j][2] = sqrt(1 - self->disk[j][0] * self->disk[j][0]);
    }
}

/* The light where the viewer is in the plane y = 0, and the light at y >= 0: isotropic, and without a handedness. */
static void turn_light(const double *wi, const double *wo, double *turned) {
    const double *w = hypot(wo[0], wo[1]) > 1e-9 ? wo : wi, length = hypot(w[0], w[1]);
    const double x = length > 0 ? w[0] / length : 1, y = length > 0 ? w[1] / length : 0;
    turned[0] = wi[0] * x + wi[1] * y;
    turned[1] = fabs(wi[1] * x - wi[0] * y);
    turned[2] = wi[2];
}

static void coated_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const coated *self = state;
    const bool is_mirror = self->is_smooth[INTERFACE] && self->is_smooth[CONDUCTOR];
    walks viewer;
    double turned[3], sums[N_ORDERS][3];
    for (size_t k = 0; k < n; ++k, wi += 3, wo += 3, rgb += 3) {
        const half_angles h = half_angles_of(wi, wo);
        const double lobe = correlated_ggx(h.tan2_h, wi[2], wo[2], equal_widths(self->alpha2[INTERFACE]));
        if (!is_mirror && (k == 0 || wo[2] != wo[-1])) /* renderers evaluate many lights for one viewer */
            for (size_t j = 0; j < N_WALKS; ++j)
                viewer.n[j] =
                    walk(self, (const double[]){sqrt(fmax(0, 1 - wo[2] * wo[2])), 0, wo[2]}, j, 1, viewer.v[j]);
        if (is_mirror) {
            mirror(self, self->spec.values.v[MAX_DEPTH][0], h.cos_d, rgb);
        } else {
            turn_light(wi, wo, turned);
            sum_orders(self, &viewer, turned, sums);
        }
        for (size_t c = 0; c < 3; ++c)
            rgb[c] = is_mirror ? lobe * rgb[c] : lobe * fresnel_dielectric(self->eta, h.cos_d) + series(self, sums, c);
    }
}

NQM_SHADING_MODEL(coated_conductor, "pbrt-coated-conductor", coated, coated_prepare, coated_eval, 0);
