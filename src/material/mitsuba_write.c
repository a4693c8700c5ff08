/* SPDX-License-Identifier: MIT
 *
 * Materials as BSDFs of Mitsuba 3, in XML or as a JSON dictionary for load_dict(). Every value is written with the digits that
 * read back to the same bits.
 */
#include "material/mitsuba.h"

#include <strings.h>

/* How a key is named and typed; keys that are not listed are numbers or colours of the same name. */
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

/* A property with its text, which is one word or numbers separated by ", "; tag: of the XML element. */
static void write_value(FILE *stream, bool is_json, const char *tag, const char *name, const char *text) {
    const bool is_color = strcmp(tag, "rgb") == 0, is_string = strcmp(tag, "string") == 0;
    if (is_json)
        fprintf(stream, ",\n    \"%s\": %s%s%s", name,
                is_color    ? "{\"type\": \"rgb\", \"value\": ["
                : is_string ? "\""
                            : "",
                text,
                is_color    ? "]}"
                : is_string ? "\""
                            : "");
    else
        fprintf(stream, "        <%s name=\"%s\" value=\"%s\"/>\n", tag, name, text);
}

/* Two numbers are those along u and v. */
static void write_property(FILE *stream, bool is_json, const nqm_values *values, size_t k) {
    const nqm_schema_key *key = &values->schema->keys[k];
    const double *v = values->v[k];
    const bool is_pair = key->n == 2 && v[0] != v[1];
    const size_t n = key->n == 3 ? 3 : 1;
    const char *name = key->name, *word = NULL;
    char text[100], name_of_one[50];
    for (size_t i = 0; i < N_RENAMED; ++i)
        if (strcmp(renamed[i].model, values->schema->model) == 0 && strcmp(renamed[i].key, key->name) == 0) {
            name = renamed[i].name;
            word = renamed[i].words[v[0] != 0];
        }
    const bool is_flag = word && nqm_contains_word("false true", word, false);
    if (strcmp(name, "int_ior") == 0)
        write_value(stream, is_json, "float", "ext_ior", is_json ? "1.0" : "1");
    for (size_t c = 0; c < (is_pair ? 2 : 1); ++c) {
        snprintf(name_of_one, sizeof name_of_one, "%s%s", name, !is_pair ? "" : c ? "_v" : "_u");
        nqm_format_doubles(text, sizeof text, n, v + c, ", ");
        write_value(stream, is_json,
                    is_flag  ? "boolean"
                    : word   ? "string"
                    : n == 3 ? "rgb"
                             : "float",
                    name_of_one, word ? word : text);
    }
}

nqm_status nqm_mitsuba_write(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                             nqm_error *err) {
    const char *dot = strrchr(path, '.');
    const bool is_json = dot && strcasecmp(dot, ".json") == 0;
    fputs(is_json ? "{\n  \"type\": \"scene\"" : "<scene version=\"3.0.0\">\n", stream);
    (void)err;
    for (size_t i = 0; i < n; ++i) {
        const nqm_values *values = &materials[i].values;
        const char *type = nqm_mitsuba_type_of(values->schema->model), *name = materials[i].name;
        if (is_json)
            fprintf(stream, ",\n  \"%s\": {\n    \"type\": \"%s\"", name, type);
        else
            fprintf(stream, "    <bsdf type=\"%s\" id=\"%s\">\n", type, name);
        for (size_t k = 0; k < values->schema->n_keys; ++k)
            if (values->given >> k & 1)
                write_property(stream, is_json, values, k);
        fputs(is_json ? "\n  }" : "    </bsdf>\n", stream);
    }
    fputs(is_json ? "\n}\n" : "</scene>\n", stream);
    return NQM_OK;
}
