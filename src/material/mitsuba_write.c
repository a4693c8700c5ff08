/* SPDX-License-Identifier: MIT
 *
 * Shadings as BSDFs of Mitsuba 3, in XML or as a JSON dictionary for load_dict(). Every value is written with the digits that
 * read back to the same bits.
 */
#include "material/mitsuba.h"

#include <strings.h>

/* How a key of a shading is named and typed; keys that are not listed are numbers or colours of the same name. */
static const struct {
    const char *model, *key, *name;
    const char *const words[2]; /* words for the values 0 and 1 of a whole number */
} renamed[] = {
    {"lambert", "kd", "reflectance", {NULL}},
    {"rough-conductor", "distribution", "distribution", {"beckmann", "ggx"}},
    {"rough-plastic", "distribution", "distribution", {"beckmann", "ggx"}},
    {"rough-plastic", "nonlinear", "nonlinear", {"false", "true"}},
    {"rough-plastic", "eta", "int_ior", {NULL}},
};
enum { N_RENAMED = sizeof renamed / sizeof *renamed };

/* One property as it is written. */
typedef struct written {
    const char *name;
    const char *word; /* NULL: the value is of numbers */
    bool is_boolean;
    size_t n;
    char text[100]; /* the numbers, separated by ", " */
} written;

static written describe(const nqm_shading *shading, const nqm_property *p) {
    written w = {.name = p->key, .n = p->n};
    for (size_t i = 0; i < N_RENAMED; ++i)
        if (strcmp(renamed[i].model, shading->model) == 0 && strcmp(renamed[i].key, p->key) == 0) {
            w.name = renamed[i].name;
            w.word = renamed[i].words[p->v[0] != 0];
            w.is_boolean = w.word && strcmp(renamed[i].words[0], "false") == 0;
        }
    nqm_format_doubles(w.text, sizeof w.text, p->n, p->v, ", ");
    return w;
}

/* The shading with alpha_u and alpha_v in place of an alpha of two numbers. */
static nqm_shading split(const nqm_shading *shading) {
    nqm_shading result = *shading;
    result.n = 0;
    for (size_t i = 0; i < shading->n; ++i) {
        const nqm_property *p = &shading->properties[i];
        char key[sizeof p->key];
        for (size_t c = 0; p->n == 2 && c < 2; ++c) {
            snprintf(key, sizeof key, "%.40s_%c", p->key, c ? 'v' : 'u');
            nqm_shading_set(&result, key, 1, &p->v[c]);
        }
        if (p->n != 2)
            nqm_shading_set(&result, p->key, p->n, p->v);
    }
    return result;
}

static void write_xml(const nqm_shading *shading, const char *name, FILE *stream) {
    fprintf(stream, "    <bsdf type=\"%s\" id=\"%s\">\n", nqm_mitsuba_type_of(shading->model), name);
    for (size_t i = 0; i < shading->n; ++i) {
        const written w = describe(shading, &shading->properties[i]);
        const char *tag = w.word ? w.is_boolean ? "boolean" : "string" : w.n == 3 ? "rgb" : "float";
        if (strcmp(w.name, "int_ior") == 0)
            fprintf(stream, "        <float name=\"ext_ior\" value=\"1\"/>\n");
        fprintf(stream, "        <%s name=\"%s\" value=\"%s\"/>\n", tag, w.name, w.word ? w.word : w.text);
    }
    fprintf(stream, "    </bsdf>\n");
}

static void write_json(const nqm_shading *shading, const char *name, FILE *stream) {
    fprintf(stream, ",\n  \"%s\": {\n    \"type\": \"%s\"", name, nqm_mitsuba_type_of(shading->model));
    for (size_t i = 0; i < shading->n; ++i) {
        const written w = describe(shading, &shading->properties[i]);
        const char *quote = w.word && !w.is_boolean ? "\"" : "";
        if (strcmp(w.name, "int_ior") == 0)
            fprintf(stream, ",\n    \"ext_ior\": 1.0");
        fprintf(stream, ",\n    \"%s\": ", w.name);
        if (!w.word && w.n == 3)
            fprintf(stream, "{\"type\": \"rgb\", \"value\": [%s]}", w.text);
        else
            fprintf(stream, "%s%s%s", quote, w.word ? w.word : w.text, quote);
    }
    fprintf(stream, "\n  }");
}

nqm_status nqm_mitsuba_write(size_t n, const nqm_named_shading *materials, const char *path, FILE *stream,
                             nqm_error *err) {
    const char *dot = strrchr(path, '.');
    const bool is_json = dot && strcasecmp(dot, ".json") == 0;
    fputs(is_json ? "{\n  \"type\": \"scene\"" : "<scene version=\"3.0.0\">\n", stream);
    (void)err;
    for (size_t i = 0; i < n; ++i) {
        const nqm_shading shading = split(&materials[i].shading);
        (is_json ? write_json : write_xml)(&shading, materials[i].name, stream);
    }
    fputs(is_json ? "\n}\n" : "</scene>\n", stream);
    return NQM_OK;
}
