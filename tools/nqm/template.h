/* SPDX-License-Identifier: MIT
 *
 * template.h - fills templates of pages, reports, man pages and completions with data in JSON.
 */
#ifndef NQM_TOOL_TEMPLATE_H
#define NQM_TOOL_TEMPLATE_H

#include "nqm/tool.h"

/** Writes a text so that nothing of it has a meaning in the format of the template. */
typedef void template_escape(FILE *out, const char *text);
/** Data of element i of a list that is a number; released after the element is written. */
typedef json_t *template_element(const void *user, size_t i);

/**
 * Write a template, whose marks are paths of members of `data` (rows.h), which is released. {{name}} is a text, escaped, or a whole
 * number; {{&name}} is a text as it is; {{name:2f}} is a number as of number_text(). What is between {{#name}} and {{/name}} is
 * written for each element of a list; with a number n, for n elements that `element` makes; otherwise once, unless the member is
 * missing, null, false or "", and only then between {{^name}} and {{/name}}. Inside, paths are looked for in the element first, and
 * {{.}} is the element itself.
 */
void fill_template(FILE *out, const char *text, template_escape *escape, json_t *data, template_element *element,
                   const void *user);

/** Of XML, and HTML that is well-formed XML: attributes are in single quotes. */
template_escape escape_xml;

/** A number as a text: 'f' and 'g' as in printf(), '#' as %#g, 'p' percent of a fraction; a dash if it is not finite. */
json_t *number_text(double value, int n_digits, char conversion);

#endif
