/* SPDX-License-Identifier: MIT
 *
 * html.h - writing a page that is HTML and well-formed XML at once, and leans on no other file: escaped texts, pictures
 * as data: addresses, data as JSON.
 */
#ifndef NQM_TOOL_HTML_H
#define NQM_TOOL_HTML_H

#include "nqm/tool.h"

/** Write markup, in which each %s stands for a text that is escaped, and %% for a percent sign; no other conversion is
 *  allowed. Attributes stand in single quotes. */
__attribute__((format(printf, 2, 3))) void html(FILE *out, const char *markup, ...);

/** What an <img> needs beside its bytes. */
typedef struct html_picture {
    const char *path; /* PNG file */
    const char *alt;
    size_t width, height; /* CSS pixels */
} html_picture;

/** An <img> that holds the file's bytes. EXIT_OK, or the fault is reported and its exit code returned. */
int html_image(const char *verb, FILE *out, const html_picture *picture);

/** A block of data, which no browser runs: <script type='application/json' id='...'>. Releases the value. EXIT_OK, or the
 *  fault is reported and its exit code returned. */
int html_json(const char *verb, FILE *out, const char *id, json_t *value);

/** A number as text, to be passed to html() as `.text`; a dash when it is not finite. */
typedef struct html_number {
    char text[40];
} html_number;
html_number html_fixed(double value, int decimals);
html_number html_digits(double value, int significant);
/** The same with all its digits: "0.0250". */
html_number html_all_digits(double value, int significant);
html_number html_count(size_t count);
/** A share of people: "71 %", "> 99 %". */
html_number html_share(double share);

#endif
