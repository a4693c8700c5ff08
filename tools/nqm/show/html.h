/* SPDX-License-Identifier: MIT
 *
 * html.h - fills templates of pages and reports that are well-formed XML (a page is HTML, too): escaped texts, numbers,
 * pictures as data: URLs, data as JSON.
 */
#ifndef NQM_TOOL_HTML_H
#define NQM_TOOL_HTML_H

#include "nqm/tool.h"

/** Data of element i of a list that is a number; released after the element is written. */
typedef json_t *html_element(const void *user, size_t i);

/**
 * Write a template, whose marks are names of members of `data`, which is released. {{name}} is a text, escaped, or a whole
 * number; {{&name}} is markup. What is between {{#name}} and {{/name}} is written for each element of a list; with a number n,
 * for n elements that `element` makes; otherwise once, unless the member is missing, null, false or "". Inside, names are
 * looked for in the element first, and {{.}} is the element itself. Attributes are in single quotes.
 */
void html_fill(FILE *out, const char *page, json_t *data, html_element *element, const void *user);

/** A number as a text: 'f' and 'g' as in printf(), '#' as %#g; a dash if it is not finite. */
json_t *html_number(double value, int n_digits, char conversion);
/** Markup: an <img> of width x height CSS pixels that contains the bytes of a PNG file. On failure, report the error and exit. */
json_t *html_image(const char *path, const char *alt, size_t width, size_t height);
/** Markup: a value, which is released, as JSON for a <script type='application/json'>. n_digits: of numbers. */
json_t *html_json(json_t *value, size_t n_digits);

/** The text of a stream of open_text(), which is closed and freed. */
json_t *html_text(FILE *stream, char **text);

/** A fraction of people as text: "71 %", as nqm score prints it. */
json_t *html_people(double fraction);

#endif
