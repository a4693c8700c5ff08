/* SPDX-License-Identifier: MIT
 *
 * The directional albedo of a BRDF by quadrature.
 *
 * The albedo is a multiple importance sampling estimate over several sets of viewer directions: one distributed like
 * the cosine, and one for each of eight widths of a half-vector lobe (the GGX density of normals, Walter et al. 2007,
 * DOI 10.2312/EGWR/EGSR07/195-206). Every value is divided by the combined density of all sets (balance heuristic,
 * Veach and Guibas 1995, DOI 10.1145/218380.218498). The sets cover lobe widths from 0.006 to 40 degrees.
 */
#include "brdf/brdf.h"

#include <math.h>

enum { N_WIDTHS = 8, BLOCK = 128 };
/* Points of a set and the step between them: neighbouring Fibonacci numbers, whose lattices cover the square evenly. Anisotropic
 * lobes are narrow in azimuth, too. */
typedef struct lattice {
    size_t n, step;
} lattice;
static const lattice cosine_lattice = {987, 610}, lobe_lattice = {377, 233}, anisotropic_lobe_lattice = {2584, 1597};
static const double widths[N_WIDTHS] = {1e-4, 3.5e-4, 1.2e-3, 4.2e-3, 0.015, 0.05, 0.18, 0.65};

/* Expected number of samples per unit solid angle at wo: the sum of n p over all sets. A lobe's set has the GGX density
 * of normals times the cosine of the normal; the Jacobian of the reflection is 4 cos theta_d = 2 |wi + wo|. */
static double mixture_density(const lattice *lobe, const double *wi, const double *wo) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
    double xy = x * x + y * y, length2 = xy + z * z;
    double sum = 0;
    for (int k = 0; k < N_WIDTHS; ++k) {
        double w2 = widths[k] * widths[k];
        double spread = (w2 * z * z + xy) / length2; /* cos^2 theta_h (alpha^2 + tan^2 theta_h) */
        sum += w2 / (spread * spread);
    }
    return (double)lobe->n * sum * z / (NQM_PI * 2 * length2) + (double)cosine_lattice.n * wo[2] / NQM_PI;
}

/* Map a point (u, v) of the unit square to a viewer direction; false when it is below the horizon. set 0: cosine
 * distribution; set k > 0: lobe of widths[k - 1]. */
static bool place_viewer(int set, const double *wi, double u, double v, double *wo) {
    double phi = 2 * NQM_PI * v;
    if (set == 0) {
        double r = sqrt(u);
        wo[0] = r * cos(phi);
        wo[1] = r * sin(phi);
        wo[2] = sqrt(1 - u);
        return wo[2] > 0;
    }
    double tan_h = widths[set - 1] * sqrt(u / (1 - u)), cos_h = 1 / sqrt(1 + tan_h * tan_h);
    double h[3] = {tan_h * cos_h * cos(phi), tan_h * cos_h * sin(phi), cos_h};
    double d = 2 * nqm_dot3(wi, h);
    for (int a = 0; a < 3; ++a)
        wo[a] = d * h[a] - wi[a];
    return wo[2] > 0 && d > 0;
}

/* Directions collected for one call of the BRDF. */
typedef struct batch {
    const nqm_brdf *brdf;
    const lattice *lobe;
    size_t n;
    double wi[3 * BLOCK], wo[3 * BLOCK], rgb[3 * BLOCK];
    double sum[3];
    double lambert;   /* the same sum for a Lambert BRDF of albedo 1; its deviation from 1 is the error */
    double lowest[3]; /* smallest f_r evaluated: the Lambertian part */
} batch;

static void flush(batch *b) {
    nqm_brdf_eval(b->brdf, b->n, b->wi, b->wo, b->rgb, NULL);
    for (size_t i = 0; i < b->n; ++i) {
        double weight = b->wo[3 * i + 2] / mixture_density(b->lobe, b->wi + 3 * i, b->wo + 3 * i);
        b->lambert += weight / NQM_PI;
        for (size_t c = 0; c < 3; ++c) {
            b->sum[c] += weight * b->rgb[3 * i + c];
            b->lowest[c] = fmin(b->lowest[c], b->rgb[3 * i + c]);
        }
    }
    b->n = 0;
}

void nqm_brdf_albedo(const nqm_brdf *brdf, double theta_i_rad, uint64_t seed, double *rgb) {
    assert(brdf && rgb);
    batch b = {.brdf = brdf,
               .lobe = brdf->info.isotropic ? &lobe_lattice : &anisotropic_lobe_lattice,
               .lowest = {INFINITY, INFINITY, INFINITY}};
    double wi[3];
    nqm_spherical(theta_i_rad, 0, wi);
    for (int set = 0; set <= N_WIDTHS; ++set) {
        nqm_rng rng = nqm_rng_make(seed, (uint64_t)set);
        double turn = nqm_rng_uniform(&rng);
        const lattice *l = set ? b.lobe : &cosine_lattice;
        for (size_t i = 0; i < l->n; ++i) {
            double u = ((double)i + 0.5) / (double)l->n, v = (double)(i * l->step % l->n) / (double)l->n + turn;
            if (!place_viewer(set, wi, u, v, b.wo + 3 * b.n))
                continue;
            for (size_t a = 0; a < 3; ++a)
                b.wi[3 * b.n + a] = wi[a];
            if (++b.n == BLOCK)
                flush(&b);
        }
    }
    flush(&b);
    for (int c = 0; c < 3; ++c) /* control variate: the exact albedo of the Lambertian part is known */
        rgb[c] = b.sum[c] + NQM_PI * b.lowest[c] * (1 - b.lambert);
}
