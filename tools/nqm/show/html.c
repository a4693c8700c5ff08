/* SPDX-License-Identifier: MIT
 *
 * The implementation of html.h.
 */
#include "nqm/show/html.h"

#include <errno.h>
#include <math.h>
#include <openssl/evp.h>
#include <stdlib.h>
#include <string.h>

/* XML does not allow most control characters, not even escaped. */
static void put_text(FILE *out, const char *text) {
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

/* ---- templates --------------------------------------------------------------------------------------------------- */

typedef struct filling {
    FILE *out;
    html_element *element;
    const void *user;
} filling;

/* What names are looked for in. */
typedef struct scope {
    const json_t *data;
    const struct scope *outer;
} scope;

static const json_t *find(const scope *s, const char *name) {
    if (strcmp(name, ".") == 0)
        return s->data;
    const json_t *found = NULL;
    for (; s && !found; s = s->outer)
        found = json_object_get(s->data, name);
    return found;
}

static void put_value(FILE *out, const json_t *value, bool is_markup) {
    if (json_is_integer(value))
        fprintf(out, "%lld", (long long)json_integer_value(value));
    else if (json_is_string(value))
        is_markup ? (void)fputs(json_string_value(value), out) : put_text(out, json_string_value(value));
}

static const char *fill_section(const filling *f, const char *p, const scope *s, const json_t *value);

/* Write from p to the end of the section, or of the template; s NULL: only find it. Returns what follows. */
static const char *fill(const filling *f, const char *p, const scope *s) {
    for (const char *mark; (mark = strstr(p, "{{"));) {
        char name[40];
        const size_t n = strcspn(mark, "}");
        snprintf(name, sizeof name, "%.*s", (int)n - 2, mark + 2);
        if (s)
            fwrite(p, 1, (size_t)(mark - p), f->out);
        p = mark + n + 2;
        if (*name == '/')
            return p;
        if (*name == '#')
            p = fill_section(f, p, s, s ? find(s, name + 1) : NULL);
        else if (s)
            put_value(f->out, find(s, name + (*name == '&')), *name == '&');
    }
    fputs(s ? p : "", f->out);
    return p + strlen(p);
}

static const char *fill_section(const filling *f, const char *p, const scope *s, const json_t *value) {
    const bool is_list = json_is_array(value), is_number = json_is_integer(value);
    const bool is_there = json_is_object(value) || json_is_true(value) || json_string_length(value) > 0;
    const size_t n = is_list ? json_array_size(value) : is_number ? (size_t)json_integer_value(value) : is_there;
    const char *end = NULL;
    for (size_t i = 0; i < n; ++i) {
        json_t *made = is_number ? f->element(f->user, i) : NULL;
        const scope inner = {is_list ? json_array_get(value, i) : is_number ? made : value, s};
        end = fill(f, p, &inner);
        json_decref(made);
    }
    return end ? end : fill(f, p, NULL);
}

void html_fill(FILE *out, const char *page, json_t *data, html_element *element, const void *user) {
    fill(&(filling){out, element, user}, page, &(scope){data, NULL});
    json_decref(data);
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

json_t *html_number(double value, int n_digits, char conversion) {
    const char *format = conversion == 'f' ? "%.*f" : conversion == 'g' ? "%.*g" : "%#.*g";
    return isfinite(value) ? json_sprintf(format, n_digits, value) : json_string("\xe2\x80\x93"); /* a dash */
}

json_t *html_image(const char *path, const char *alt, size_t width, size_t height) {
    unsigned char bytes[3 * 1024], base64[4 * 1024 + 1];
    char *text;
    size_t n;
    FILE *in = fopen(path, "rb"), *out = open_text(&text, &n);
    if (!in)
        stop(EXIT_OPEN, "%s: cannot read: %s", path, strerror(errno));
    fprintf(out, "<img width='%zu' height='%zu' alt='", width, height);
    put_text(out, alt);
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
