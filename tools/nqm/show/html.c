/* SPDX-License-Identifier: MIT
 *
 * The implementation of html.h.
 */
#include "nqm/show/html.h"

#include <errno.h>
#include <openssl/evp.h>
#include <stdlib.h>
#include <string.h>

/* XML does not allow most control characters, not even escaped. */
void html_escape(FILE *out, const char *text) {
    static const char special[] = "&<>\"'";
    static const char *const escaped[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
    for (const char *p = text; *p; ++p) {
        const char *found = strchr(special, *p);
        bool is_control = (unsigned char)*p < ' ' && *p != '\n' && *p != '\t';
        if (found)
            fputs(escaped[found - special], out);
        else
            fputc(is_control ? '?' : *p, out);
    }
}

json_t *html_image(const char *path, const char *alt, size_t width, size_t height) {
    unsigned char bytes[3 * 1024], base64[4 * 1024 + 1];
    char *text;
    size_t n;
    FILE *in = fopen(path, "rb"), *out = open_text(&text, &n);
    if (!in)
        stop(EXIT_OPEN, "%s: cannot read: %s", path, strerror(errno));
    fprintf(out, "<img width='%zu' height='%zu' alt='", width, height);
    html_escape(out, alt);
    fputs("' src='data:image/png;base64,", out);
    while ((n = fread(bytes, 1, sizeof bytes, in)) > 0)
        fwrite(base64, 1, (size_t)EVP_EncodeBlock(base64, bytes, (int)n), out);
    if (ferror(in))
        stop(EXIT_OPEN, "%s: cannot read", path);
    fclose(in);
    fputs("'/>\n", out);
    return html_text(out, &text);
}

/* < > & occur in strings only, where JSON can escape them. */
json_t *html_json(json_t *value, size_t n_digits) {
    char *text = must_have(json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(n_digits))), *escaped;
    size_t n;
    FILE *out = open_text(&escaped, &n);
    json_decref(value);
    for (const char *p = text; *p; ++p)
        fprintf(out, *p == '<' || *p == '>' || *p == '&' ? "\\u%04x" : "%c", (unsigned)*p);
    free(text);
    return html_text(out, &escaped);
}

json_t *html_text(FILE *stream, char **text) {
    if (fclose(stream) != 0)
        stop(EXIT_LIMIT, "out of memory");
    json_t *string = json_string(*text);
    free(*text);
    return string;
}

json_t *html_people(double fraction) {
    return json_sprintf("%.0f\xc2\xa0%%", 100 * fraction);
}
