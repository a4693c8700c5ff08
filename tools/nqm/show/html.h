/* SPDX-License-Identifier: MIT
 *
 * html.h - what templates of pages and reports need that are well-formed XML (a page is HTML, too): escaped texts, pictures as data:
 * URLs, data as JSON.
 */
#ifndef NQM_TOOL_HTML_H
#define NQM_TOOL_HTML_H

#include "nqm/template.h"

/** A text of such a page; attributes are in single quotes. */
template_escape html_escape;

/** Markup: an <img> of width x height CSS pixels that contains the bytes of a PNG file. On failure, report the error and exit. */
json_t *html_image(const char *path, const char *alt, size_t width, size_t height);
/** Markup: a value, which is released, as JSON for a <script type='application/json'>. n_digits: of numbers. */
json_t *html_json(json_t *value, size_t n_digits);

/** The text of a stream of open_text(), which is closed and freed. */
json_t *html_text(FILE *stream, char **text);

/** A fraction of people as text: "71 %", as nqm score prints it. */
json_t *html_people(double fraction);

#endif
