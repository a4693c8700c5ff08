/* SPDX-License-Identifier: MIT
 *
 * html.h - writes a self-contained page that is both HTML and well-formed XML: escaped texts, numbers, pictures as data:
 * URLs, data as JSON.
 */
#ifndef NQM_TOOL_HTML_H
#define NQM_TOOL_HTML_H

#include "nqm/tool.h"

/** Write markup. As in printf(): %s is a text, which is escaped; %zu a size_t; %.2f, %.3g and %#.4g a double, written as a
 *  dash if it is not finite; %% a percent sign. Attributes are in single quotes. */
__attribute__((format(printf, 2, 3))) void html(FILE *out, const char *markup, ...);

/** An <img> of width x height CSS pixels that contains the bytes of a PNG file. On failure, report the error and exit. */
void html_image(FILE *out, const char *path, const char *alt, size_t width, size_t height);

/** A data block, <script type='application/json' id='...'>, which browsers do not run. Releases the value. On failure,
 *  report the error and exit. n_digits: of numbers. */
void html_json(FILE *out, const char *id, json_t *value, size_t n_digits);

/** A fraction of people as text for html(): "71 %", as nqm score prints it. */
typedef struct html_percent {
    char text[16];
} html_percent;
html_percent html_people(double fraction);

#endif
