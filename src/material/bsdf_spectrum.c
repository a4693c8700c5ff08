/* SPDX-License-Identifier: MIT
 *
 * Spectra by wavelength as RGB: pairs of a wavelength in nm and a value, inline ("400:0.1, 500:0.2") or in a file (.spd: a pair a line,
 * '#' begins a comment). They are integrated under D65, so that 1 at all wavelengths is (1, 1, 1), and are 0 beyond their ends, as in
 * Mitsuba's RGB variants and in pbrt. Colours are clamped to 0 to 1, indices of refraction to 0.
 */
#include "material/bsdf.h"
#include "math/math.h"

#include <math.h>

enum { MAX_BYTES = 1 << 16 };
static const char separators[] = " ,:;\t\r\n";

/* The text of the file in the folder of the scene that the property names; NULL: refused, or memory is short. nqm_free() */
static char *read_file(nqm_bsdf_reading *r, const nqm_bsdf_node *node) {
    nqm_map map = {0};
    nqm_error err = {0};
    const bool is_inside = nqm_include_is_inside(node->value);
    char *path = nqm_path_beside(r->path, node->value), *text = NULL;
    const bool is_open = path && is_inside && nqm_map_open(path, &map, &err) == NQM_OK && map.n_bytes < MAX_BYTES;
    if (is_open && (text = nqm_alloc(map.n_bytes + 1, 1)))
        memcpy(text, map.data, map.n_bytes);
    if (path && !is_open)
        nqm_refuse(&r->reading, node,
                   "%s: the spectrum '%.60s' is neither known nor a file of less than 64 kB in the folder of the scene",
                   node->name, node->value);
    nqm_map_close(&map);
    nqm_free(path);
    return text;
}

/* v: (strlen(text) / 2 + 1). Returns the count, 0 when anything else is there. */
static size_t parse_numbers(const char *text, double *v) {
    size_t n = 0;
    while (*(text += strspn(text, separators))) {
        if (*text == '#') {
            text += strcspn(text, "\n");
            continue;
        }
        if (!nqm_parse_double(text, &text, &v[n]) || !isfinite(v[n]) ||
            (*text && *text != '#' && !strchr(separators, *text)))
            return 0;
        ++n;
    }
    return n;
}

/* nm: (n / 2 + 2), weights: (3, of that) for n numbers v. false: they are no spectrum. */
static bool integrate(size_t n, const double *v, float *nm, double *weights, double rgb[3]) {
    const size_t n_pairs = n / 2;
    for (size_t i = 0; i < n_pairs; ++i)
        nm[i + 1] = (float)v[2 * i];
    if (n % 2 || !nqm_spectrum_is_visible(n_pairs, nm + 1))
        return false;
    nm[0] = nm[1] - 1e-3F; /* two pairs with the value 0 */
    nm[n_pairs + 1] = nm[n_pairs] + 1e-3F;
    nqm_spectrum_weights(NQM_ILLUMINANT_D65, n_pairs + 2, nm, weights);
    for (size_t c = 0; c < 3; ++c) {
        rgb[c] = 0;
        for (size_t i = 0; i < n_pairs; ++i)
            rgb[c] += weights[3 * (i + 1) + c] * v[2 * i + 1];
    }
    return true;
}

bool nqm_bsdf_spectrum(nqm_bsdf_reading *r, const nqm_bsdf_node *node, double rgb[3]) {
    const char *dot = strrchr(node->name, '.'), *end = node->value + strspn(node->value, separators);
    const bool is_index = nqm_contains_word("eta k", dot ? dot + 1 : node->name, false);
    double first;
    const bool is_inline = nqm_parse_double(end, &end, &first) && (!*end || strchr(separators, *end));
    char *text = is_inline ? nqm_strdup(node->value) : read_file(r, node);
    const size_t room = text ? strlen(text) / 2 + 3 : 0;
    double *v = NULL, *weights = NULL;
    float *nm = NULL;
    const bool has_memory =
        text && nqm_alloc_arrays(
                    NQM_ARRAYS({&v, room, sizeof *v}, {&weights, 3 * room, sizeof *weights}, {&nm, room, sizeof *nm}),
                    NULL) == NQM_OK;
    const bool is_read = has_memory && integrate(parse_numbers(text, v), v, nm, weights, rgb);
    if (!has_memory)
        nqm_refuse(&r->reading, node, "%s: memory is short", node->name);
    else if (!is_read)
        nqm_refuse(&r->reading, node,
                   "%s needs pairs of a wavelength in nm and a value; the wavelengths rise and cover 500 to 600 nm",
                   node->name);
    for (size_t c = 0; is_read && c < 3; ++c)
        rgb[c] = fmin(fmax(rgb[c], 0), is_index ? INFINITY : 1);
    nqm_free(v);
    nqm_free(text);
    return is_read;
}
