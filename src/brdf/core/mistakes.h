/* SPDX-License-Identifier: MIT
 *
 * mistakes.h - frequent mistakes of shaders, which `nqm conform` finds by comparing values with those of mistaken models.
 *
 * Formulas are written once: the building blocks of models/ ask MISTAKEN(NAME) where people go wrong. The constant 0 in
 * the models of the library, which compile to the same code as without it. models/shading_*.c are compiled a second
 * time with NQM_WITH_MISTAKES, where it reads a set of mistakes. Wrong values of parameters need no such place: callers
 * change the parameters.
 */
#ifndef NQM_SRC_BRDF_MISTAKES_H
#define NQM_SRC_BRDF_MISTAKES_H

#include "material/material.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/** X(NAME, what the shader does). Those from COSINE_INCLUDED on change values of any model (brdf/mistakes.c). */
#define NQM_MISTAKES(X)                                                                                                \
    X(HALF_NOT_NORMALISED, "the half vector is not normalised")                                                        \
    X(HALF_AVERAGED, "the half vector is (light + viewer) / 2, not normalised")                                        \
    X(HALF_IN_COMPONENTS, "the half vector is not normalised, in a distribution of its components")                    \
    X(HALF_AVERAGED_IN_COMPONENTS, "the half vector is (light + viewer) / 2, in a distribution of its components")     \
    X(FRESNEL_LEFT_OUT, "the Fresnel factor is left out (1)")                                                          \
    X(FRESNEL_CONSTANT, "the Fresnel factor is that of normal incidence at every angle")                               \
    X(FRESNEL_AT_VIEWER, "the Fresnel factor has the angle of normal and viewer, not of half vector and viewer")       \
    X(FRESNEL_AT_LIGHT, "the Fresnel factor has the angle of normal and light, not of half vector and light")          \
    X(FRESNEL_AT_HALF, "the Fresnel factor has the angle of normal and half vector, not of half vector and viewer")    \
    X(FRESNEL_TWICE, "the Fresnel factor is applied twice")                                                            \
    X(FRESNEL_SCHLICK, "the Fresnel factor is Schlick's, not the exact one")                                           \
    X(SCHLICK_EXPONENT, "the exponent of Schlick's factor is not 5 but")                                               \
    X(F90_ONE, "F90, the reflectance at grazing incidence, is 1")                                                      \
    X(DISTRIBUTION_WITHOUT_PI, "the distribution D lacks 1 / pi")                                                      \
    X(DISTRIBUTION_NOT_SQUARED, "the denominator of the distribution D is not squared")                                \
    X(DISTRIBUTION_BECKMANN, "the distribution D is Beckmann's, not GGX")                                              \
    X(DISTRIBUTION_GGX, "the distribution D is GGX, not Beckmann's")                                                   \
    X(SHADOWING_LEFT_OUT, "the shadowing G is left out (1)")                                                           \
    X(SHADOWING_SEPARABLE, "the shadowing G is separable, not height-correlated")                                      \
    X(SHADOWING_CORRELATED, "the shadowing G is height-correlated, not separable")                                     \
    X(SHADOWING_ALPHA, "the shadowing G has alpha where alpha^2 belongs")                                              \
    X(SHADOWING_SCHLICK, "the shadowing G is Schlick's approximation with k = alpha / 2")                              \
    X(SHADOWING_POINT_LIGHTS, "the shadowing G is Schlick's approximation with k = (roughness + 1)^2 / 8")             \
    X(SHADOWING_ISOTROPIC, "the shadowing G of an anisotropic lobe is that of its mean width")                         \
    X(FOUR_COSINES_LEFT_OUT, "1 / (4 cos cos) is left out")                                                            \
    X(FOUR_COSINES_TWICE, "1 / (4 cos cos) is applied twice")                                                          \
    X(FOUR_LEFT_OUT, "the 4 of 1 / (4 cos cos) is left out")                                                           \
    X(FOUR_IS_PI, "1 / (4 cos cos) is 1 / (pi cos cos)")                                                               \
    X(AXES_EXCHANGED, "tangent and bitangent are exchanged")                                                           \
    X(COMPENSATION_LEFT_OUT, "the energy compensation of rough lobes is left out")                                     \
    X(DIFFUSE_WITHOUT_PI, "the diffuse part lacks 1 / pi")                                                             \
    X(DIFFUSE_NOT_REDUCED, "the diffuse part is not multiplied by what the specular part lets through (1 - F)")        \
    X(DIFFUSE_BY_CHANNEL, "the diffuse part is multiplied by 1 - F of each channel, not of the largest one")           \
    X(DIFFUSE_LAMBERT, "the diffuse part is Lambert's, not Burley's")                                                  \
    X(DIFFUSE_OF_METAL, "the dielectric or diffuse part is not multiplied by 1 - metallic")                            \
    X(INTERNAL_REFLECTION, "the internal reflection of the base is left out")                                          \
    X(ETA_SQUARED, "1 / eta^2 of the diffuse part is left out")                                                        \
    X(SHEEN_ALPHA, "alpha of the sheen is its roughness, not squared")                                                 \
    X(SHEEN_NOT_SCALED, "the layers below the sheen or fuzz are not scaled by its albedo")                             \
    X(SHEEN_VISIBILITY, "the shadowing of the sheen is 1 / (4 (cos + cos - cos cos))")                                 \
    X(COAT_NOT_REDUCING, "the layers below the clear coat are not multiplied by what it lets through (1 - F)")         \
    X(COAT_FRESNEL_AT_HALF, "the Fresnel factor of the clear coat has the angle of half vector and viewer")            \
    X(COAT_F0_FIXED, "F0 of the clear coat is 0.04")                                                                   \
    X(COAT_F0_OF_INDEX, "F0 of the clear coat is that of the base's index of refraction")                              \
    X(COAT_F0_OF_BASE, "F0 of the clear coat is that of the base, with its weight and colour")                         \
    X(COSINE_INCLUDED, "the values include the cosine of the light")                                                   \
    X(COSINE_OF_VIEWER, "the values include the cosine of the viewer")                                                 \
    X(TIMES_PI, "the values are pi times too large")                                                                   \
    X(DIVIDED_BY_PI, "the values are divided by pi")                                                                   \
    X(EXCHANGED, "light and viewer are exchanged")                                                                     \
    X(ENCODED, "the values are encoded as sRGB")                                                                       \
    X(CLAMPED, "the values are clamped at")

enum {
#define NQM_MISTAKE_INDEX(NAME, WORDS) NQM_MISTAKE_##NAME,
    NQM_MISTAKES(NQM_MISTAKE_INDEX) NQM_N_MISTAKES
};
/** A set of mistakes. */
typedef struct nqm_mistakes {
    uint64_t made; /**< the bits 1 << NQM_MISTAKE_... */
    double amount; /**< of SCHLICK_EXPONENT, CLAMPED or `channels` */
    const char
        *channels; /**< "rrb": what red, green and blue are; "gr": green has red times `amount` added to it; or NULL */
} nqm_mistakes;

/* ---- wrong values of properties ---------------------------------------------------------------------------------- */

/** What may have been done with the value of a property, or with those of its map: "roughness" and the text name it. */
typedef struct nqm_property_mistake {
    const char *text;
    double (*apply)(double x); /**< NULL: no function of the value */
} nqm_property_mistake;

/** The number of a channel, 'r', 'g' or 'b'. */
static inline size_t nqm_channel_of(char name) {
    return name == 'r' ? 0 : name == 'g' ? 1 : 2;
}
static inline double nqm_square(double x) {
    return x * x;
}
static inline double nqm_invert(double x) {
    return 1 - x;
}
static inline double nqm_negate(double x) {
    return -x;
}

#define NQM_PROPERTY_MISTAKES                                                                                          \
    {.text = " is squared", .apply = nqm_square}, {.text = " is the square root", .apply = sqrt},                      \
        {.text = " is decoded from sRGB", .apply = nqm_srgb_to_linear},                                                \
        {.text = " is not decoded from sRGB", .apply = nqm_linear_to_srgb},                                            \
        {.text = " is inverted", .apply = nqm_invert}, {                                                               \
        .text = " is flipped", .apply = nqm_negate                                                                     \
    }

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

struct nqm_values;
/** What a mistake does, for people; its amount follows. mistake < NQM_N_MISTAKES. */
const char *nqm_mistake_words(size_t mistake);
/** Evaluate a shading model with mistakes: rgb (n, 3) receives f_r in 1/sr as float32, at least 0, and 0 for values that are not
 *  finite. wi, wo: (n, 3) above the horizon. values: of a shading model; any thread. */
void nqm_mistaken_eval(const struct nqm_values *values, const nqm_mistakes *mistakes, size_t n, const double *wi,
                       const double *wo, float *rgb);

/** What this thread's evaluation of a mistaken model does wrong; nqm_mistaken_eval() sets it. */
extern _Thread_local nqm_mistakes nqm_mistakes_made;

#ifdef NQM_WITH_MISTAKES
#define MISTAKEN(NAME)               (nqm_mistakes_made.made >> NQM_MISTAKE_##NAME & 1)
#define IF_MISTAKEN(...)             __VA_ARGS__
#define TIMES_MISTAKE(VALUE, FACTOR) ((VALUE) * (FACTOR))
#else
#define MISTAKEN(NAME) 0
#define IF_MISTAKEN(...)
#define TIMES_MISTAKE(VALUE, FACTOR) (VALUE)
#endif

#endif
