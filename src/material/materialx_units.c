/* SPDX-License-Identifier: MIT
 *
 * Units that values of MaterialX name (MaterialX Specification, "Units").
 */
#include "io/xml.h"
#include "material/materialx.h"

/* Units, in degrees and nanometres. */
static const struct unit {
    const char *name;
    bool is_angle;
    double size;
} units[] = {{"degree", true, 1},        {"radian", true, 57.29577951308232},
             {"nanometer", false, 1},    {"micron", false, 1e3},
             {"micrometer", false, 1e3}, {"millimeter", false, 1e6},
             {"centimeter", false, 1e7}, {"inch", false, 25.4e6},
             {"foot", false, 304.8e6},   {"yard", false, 914.4e6},
             {"meter", false, 1e9},      {"kilometer", false, 1e12},
             {"mile", false, 1609.344e9}};

bool nqm_mtlx_convert_unit(nqm_mtlx_graph *g, const nqm_xml_element *e, size_t n, double *v) {
    const char *name = nqm_xml_get(e, "name"), *unit = nqm_xml_get(e, "unit");
    const struct unit *u = units, *end = units + sizeof units / sizeof *units;
    if (!unit)
        return true;
    while (u < end && strcmp(u->name, unit) != 0)
        ++u;
    const bool is_film = name && strstr(name, "thickness"), is_size = name && strncmp(name, "realworld", 9) == 0;
    if (u == end || (!u->is_angle && !is_film && !is_size))
        return nqm_refuse(g->reading, g->input, "%s: the unit '%.40s' of '%.60s' is not known here", g->name, unit,
                          name ? name : e->name);
    const double to = is_film && nqm_texts_equal(e->parent->name, "open_pbr_surface") ? 1e3 : 1;
    for (size_t c = 0; c < n; ++c)
        v[c] *= u->size / to;
    return true;
}
