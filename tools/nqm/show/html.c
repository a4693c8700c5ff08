/* SPDX-License-Identifier: MIT
 *
 * The writer of html.h.
 */
#include "nqm/show/html.h"

#include <errno.h>
#include <math.h>
#include <openssl/evp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* XML does not allow most control characters, not even escaped. */
static void put_text(FILE *out, const char *text) {
    static const char special[] = "&<>\"'";
    static const char *const escaped[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
    json_t *utf8 = json_name(text);
    for (const char *p = utf8 ? json_string_value(utf8) : ""; *p; ++p) {
        const char *found = strchr(special, *p);
        bool is_control = (unsigned char)*p < ' ' && *p != '\n' && *p != '\t';
        if (found)
            fputs(escaped[found - special], out);
        else
            fputc(is_control ? '?' : *p, out);
    }
    json_decref(utf8);
}

static void put_number(FILE *out, bool keeps_zeros, int n_digits, char conversion, double value) {
    if (!isfinite(value))
        fputs("\xe2\x80\x93", out); /* a dash */
    else
        fprintf(out, conversion == 'f' ? "%.*f" : keeps_zeros ? "%#.*g" : "%.*g", n_digits, value);
}

void html(FILE *out, const char *markup, ...) {
    va_list values;
    va_start(values, markup);
    for (const char *p = markup; *p; ++p) {
        if (*p != '%') {
            fputc(*p, out);
            continue;
        }
        bool keeps_zeros = *++p == '#';
        p += keeps_zeros;
        int n_digits = *p == '.' ? p[1] - '0' : 0;
        p += *p == '.' ? 2 : 0;
        if (*p == 's')
            put_text(out, va_arg(values, const char *));
        else if (*p == 'z')
            fprintf(out, "%zu", va_arg(values, size_t));
        else if (*p == '%')
            fputc('%', out);
        else
            put_number(out, keeps_zeros, n_digits, *p, va_arg(values, double));
        p += *p == 'z'; /* the u */
    }
    va_end(values);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static bool put_base64(FILE *out, FILE *in) {
    unsigned char bytes[3 * 1024], text[4 * 1024 + 1];
    size_t n;
    while ((n = fread(bytes, 1, sizeof bytes, in)) > 0)
        fwrite(text, 1, (size_t)EVP_EncodeBlock(text, bytes, (int)n), out);
    return !ferror(in);
}

void html_image(FILE *out, const char *path, const char *alt, size_t width, size_t height) {
    FILE *in = fopen(path, "rb");
    if (!in)
        stop(EXIT_OPEN, "%s: cannot read: %s", path, strerror(errno));
    html(out, "<img width='%zu' height='%zu' alt='%s' src='data:image/png;base64,", width, height, alt);
    if (!put_base64(out, in))
        stop(EXIT_OPEN, "%s: cannot read", path);
    fclose(in);
    html(out, "'/>\n");
}

/* ---- data -------------------------------------------------------------------------------------------------------- */

/* < > & occur in strings only, where JSON can escape them. */
void html_json(FILE *out, const char *id, json_t *value, size_t n_digits) {
    char *text = value ? json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(n_digits)) : NULL;
    json_decref(value);
    if (!text)
        stop(EXIT_LIMIT, "cannot write JSON: out of memory");
    html(out, "<script type='application/json' id='%s'>", id);
    for (const char *p = text; *p; ++p) {
        if (*p == '<' || *p == '>' || *p == '&')
            fprintf(out, "\\u%04x", (unsigned)*p);
        else
            fputc(*p, out);
    }
    html(out, "</script>\n");
    free(text);
}

/* ---- people ------------------------------------------------------------------------------------------------------ */

html_percent html_people(double fraction) {
    html_percent p;
    snprintf(p.text, sizeof p.text, "%.0f\xc2\xa0%%", 100 * fraction);
    return p;
}
