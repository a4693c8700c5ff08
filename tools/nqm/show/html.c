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

/* XML holds no control characters, not even as entities. */
static void put_text(FILE *out, const char *text) {
    json_t *utf8 = json_name(text);
    for (const char *p = utf8 ? json_string_value(utf8) : ""; *p; ++p) {
        bool control = (unsigned char)*p < ' ' && *p != '\n' && *p != '\t';
        switch (*p) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        case '\'':
            fputs("&#39;", out);
            break;
        default:
            fputc(control ? '?' : *p, out);
        }
    }
    json_decref(utf8);
}

void html(FILE *out, const char *markup, ...) {
    va_list texts;
    va_start(texts, markup);
    for (const char *p = markup; *p; ++p) {
        bool conversion = *p == '%';
        p += conversion;
        if (conversion && *p == 's')
            put_text(out, va_arg(texts, const char *));
        else
            fputc(*p, out);
    }
    va_end(texts);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static bool put_base64(FILE *out, FILE *in) {
    unsigned char bytes[3 * 1024], text[4 * 1024 + 1];
    size_t n;
    while ((n = fread(bytes, 1, sizeof bytes, in)) > 0)
        fwrite(text, 1, (size_t)EVP_EncodeBlock(text, bytes, (int)n), out);
    return !ferror(in);
}

int html_image(const char *verb, FILE *out, const html_picture *picture) {
    FILE *in = fopen(picture->path, "rb");
    if (!in)
        return report(verb, EXIT_OPEN, "%s: cannot read: %s", picture->path, strerror(errno));
    html(out, "<img width='%s' height='%s' alt='%s' src='data:image/png;base64,", html_count(picture->width).text,
         html_count(picture->height).text, picture->alt);
    bool good = put_base64(out, in);
    fclose(in);
    html(out, "'/>\n");
    return good ? EXIT_OK : report(verb, EXIT_OPEN, "%s: cannot read", picture->path);
}

/* ---- data -------------------------------------------------------------------------------------------------------- */

/* These three stand in strings only, where JSON has another way to write them. */
int html_json(const char *verb, FILE *out, const char *id, json_t *value) {
    char *text = value ? json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(value);
    if (!text)
        return report(verb, EXIT_LIMIT, "no JSON can be made: memory is short");
    html(out, "<script type='application/json' id='%s'>", id);
    for (const char *p = text; *p; ++p) {
        if (*p == '<' || *p == '>' || *p == '&')
            fprintf(out, "\\u%04x", (unsigned)*p);
        else
            fputc(*p, out);
    }
    html(out, "</script>\n");
    free(text);
    return EXIT_OK;
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static const char dash[] = "\xe2\x80\x93";

html_number html_fixed(double value, int decimals) {
    html_number n;
    snprintf(n.text, sizeof n.text, isfinite(value) ? "%.*f" : dash, decimals, value);
    return n;
}

html_number html_digits(double value, int significant) {
    html_number n;
    snprintf(n.text, sizeof n.text, isfinite(value) ? "%.*g" : dash, significant, value);
    return n;
}

html_number html_all_digits(double value, int significant) {
    html_number n;
    snprintf(n.text, sizeof n.text, isfinite(value) ? "%#.*g" : dash, significant, value);
    return n;
}

html_number html_count(size_t count) {
    html_number n;
    snprintf(n.text, sizeof n.text, "%zu", count);
    return n;
}

html_number html_share(double share) {
    html_number n;
    bool nearly_all = share >= 0.995, hardly_any = share < 0.005;
    snprintf(n.text, sizeof n.text, "%s%.0f\xc2\xa0%%",
             nearly_all   ? ">\xc2\xa0"
             : hardly_any ? "<\xc2\xa0"
                          : "",
             nearly_all   ? 99
             : hardly_any ? 1
                          : 100 * share);
    return n;
}
