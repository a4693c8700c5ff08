/* SPDX-License-Identifier: MIT
 *
 * The implementation of template.h.
 */
#include "nqm/template.h"
#include "nqm/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct filling {
    FILE *out;
    template_escape *escape;
    template_element *element;
    const void *user;
} filling;

/* What names are looked for in. */
typedef struct scope {
    const json_t *data;
    const struct scope *outer;
} scope;

/* The innermost scope that has the first key of a path decides. */
static const json_t *find(const scope *s, const char *path) {
    char key[40];
    const size_t n = strcspn(path, ".");
    snprintf(key, sizeof key, "%.*s", (int)n, path);
    if (n == 0)
        return s->data;
    const json_t *found = NULL;
    for (; s && !found; s = s->outer)
        found = json_object_get(s->data, key);
    return value_at(found, path + n + (path[n] == '.'));
}

static void put_mark(const filling *f, const scope *s, char *name) {
    char *digits = strchr(name, ':');
    if (digits)
        *digits++ = '\0';
    const json_t *value = find(s, name + (*name == '&'));
    json_t *number = digits ? number_text(json_is_number(value) ? json_number_value(value) : (double)NAN, atoi(digits),
                                          digits[strlen(digits) - 1])
                            : NULL;
    const char *text = json_string_value(number ? number : value);
    if (text && *name == '&')
        fputs(text, f->out);
    else if (text)
        f->escape(f->out, text);
    else if (json_is_integer(value))
        fprintf(f->out, "%lld", (long long)json_integer_value(value));
    json_decref(number);
}

static const char *fill_section(const filling *f, const char *p, const scope *s, const json_t *value, bool is_inverse);

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
        if (*name == '#' || *name == '^')
            p = fill_section(f, p, s, s ? find(s, name + 1) : NULL, *name == '^');
        else if (s)
            put_mark(f, s, name);
    }
    fputs(s ? p : "", f->out);
    return p + strlen(p);
}

static const char *fill_section(const filling *f, const char *p, const scope *s, const json_t *value, bool is_inverse) {
    const bool is_list = json_is_array(value), is_number = json_is_integer(value);
    const bool is_there =
        json_is_object(value) || json_is_true(value) || json_is_real(value) || json_string_length(value) > 0;
    size_t n = is_list ? json_array_size(value) : is_number ? (size_t)json_integer_value(value) : is_there;
    if (is_inverse)
        n = s && n == 0;
    const char *end = NULL;
    for (size_t i = 0; i < n; ++i) {
        json_t *made = is_number ? f->element(f->user, i) : NULL;
        const scope inner = {is_list ? json_array_get(value, i) : is_number ? made : value, s};
        end = fill(f, p, &inner);
        json_decref(made);
    }
    return end ? end : fill(f, p, NULL);
}

void fill_template(FILE *out, const char *text, template_escape *escape, json_t *data, template_element *element,
                   const void *user) {
    fill(&(filling){out, escape, element, user}, text, &(scope){data, NULL});
    json_decref(data);
}

json_t *number_text(double value, int n_digits, char conversion) {
    const char *format = conversion == 'g' ? "%.*g" : conversion == '#' ? "%#.*g" : "%.*f";
    value *= conversion == 'p' ? 100 : 1;
    return isfinite(value) ? json_sprintf(format, n_digits, value) : json_string("\xe2\x80\x93"); /* a dash */
}

/* XML does not allow most control characters, not even escaped. */
void escape_xml(FILE *out, const char *text) {
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
