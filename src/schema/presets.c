/* SPDX-License-Identifier: MIT
 *
 * Published parameters of measured materials by name, from the text of the tables of presets/.
 */
#include "schema/schema.h"

const char *nqm_preset_named(const char *material) {
    const char *found = NULL;
    for (size_t i = 0; i < nqm_preset_name_count; ++i) {
        const char *name = nqm_preset_names[i], *colon = strchr(name, ':');
        if (colon && strcmp(colon + 1, material) == 0 && (!found || strncmp(name, "sgd:", 4) == 0))
            found = name;
    }
    return found;
}

const char *nqm_preset_without_colon(const char *text) {
    for (size_t i = 0; i < nqm_preset_name_count; ++i) {
        const char *name = nqm_preset_names[i];
        const size_t n = strcspn(name, ":");
        if (strlen(text) == strlen(name) && strchr("-_. ", text[n]) && strncmp(text, name, n) == 0 &&
            strcmp(text + n + 1, name + n + 1) == 0)
            return name;
    }
    return NULL;
}

void nqm_preset_nearest(nqm_nearest *nearest) {
    for (size_t i = 0; i < nqm_preset_name_count; ++i) {
        const char *colon = strchr(nqm_preset_names[i], ':');
        if (colon)
            nqm_nearest_add(nearest, colon + 1);
    }
}

const nqm_preset_table *nqm_preset_table_find(const char *name, size_t n_name) {
    for (const nqm_preset_table *t = nqm_preset_tables; t->name; ++t)
        if (strncmp(t->name, name, n_name) == 0 && t->name[n_name] == 0)
            return t;
    return NULL;
}

/* The text of a row after "NAME,", of the header with the name "name"; NULL: there is no such row. */
static const char *row_of(const char *table, const char *name) {
    const size_t n = strlen(name);
    for (const char *line = table; line; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (n && strncmp(line, name, n) == 0 && line[n] == ',')
            return line + n + 1;
    }
    return NULL;
}

static char lower(char c) {
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c == '_' || c == ' ' ? '-' : c;
}

/* Dice's coefficient of the letter pairs: robust against misspelling and word order ("acrylic-blue"). */
static double likeness(const char *a, const char *b) {
    size_t n_a = strlen(a), n_b = strlen(b), common = 0;
    for (size_t i = 0; i + 1 < n_a; ++i)
        for (size_t j = 0; j + 1 < n_b; ++j)
            if (lower(a[i]) == lower(b[j]) && lower(a[i + 1]) == lower(b[j + 1])) {
                ++common;
                break;
            }
    return n_a + n_b > 2 ? 2 * (double)common / (double)(n_a + n_b - 2) : 0;
}

/* The preset of `table` with the largest likeness to `material` that is below `below`; NULL when no likeness exceeds
 * 0.3. */
static const char *most_alike(const char *table, const char *material, double below, double *likeness_ret) {
    const char *best = NULL;
    double best_likeness = 0.3;
    size_t n_table = strlen(table);
    for (size_t i = 0; i < nqm_preset_name_count; ++i) {
        const char *name = nqm_preset_names[i];
        if (strncmp(name, table, n_table) != 0 || name[n_table] != ':')
            continue;
        double l = likeness(material, name + n_table + 1);
        if (l > best_likeness && l < below) {
            best_likeness = l;
            best = name;
        }
    }
    *likeness_ret = best_likeness;
    return best;
}

static nqm_status fail_unknown(const char *table, const char *material, nqm_error *err) {
    char near_names[160] = "";
    size_t used = 0;
    double below = 2;
    for (int i = 0; i < 3; ++i) {
        const char *name = most_alike(table, material, below, &below);
        if (!name)
            break;
        used += (size_t)snprintf(near_names + used, sizeof near_names - used, "%s%s", i ? ", " : "; near it: ", name);
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no preset '%.80s'%s (`nqm info list` names all)", table,
                    material, near_names);
}

/* "kd=.1,.2,.3;alpha=.05". Columns have the names of keys; those of a colour end in _r, _g and _b. */
static void write_settings(const char *header, const char *row, char *text, size_t n_text) {
    size_t used = 0;
    for (const char *separator = ""; used < n_text; separator = ";") {
        const size_t n_name = strcspn(header, ",\n"), n_value = strcspn(row, ",\n");
        const bool is_color = n_name > 2 && header[n_name - 2] == '_' && strchr("rgb", header[n_name - 1]);
        if (is_color && header[n_name - 1] != 'r')
            used += (size_t)snprintf(text + used, n_text - used, ",%.*s", (int)n_value, row);
        else
            used += (size_t)snprintf(text + used, n_text - used, "%s%.*s=%.*s", separator, (int)(n_name - 2 * is_color),
                                     header, (int)n_value, row);
        if (header[n_name] != ',')
            return;
        header += n_name + 1;
        row += n_value + (row[n_value] == ',');
    }
}

nqm_status nqm_preset_find(const nqm_preset_table *table, const nqm_schema *schema, const char *material,
                           nqm_values *values, nqm_error *err) {
    char settings[1024];
    const char *row = row_of(table->text, material), *header = row_of(table->text, "name");
    if (!row || row == header)
        return fail_unknown(table->name, material, err);
    write_settings(header, row, settings, sizeof settings);
    return nqm_values_parse(schema, settings, values, err);
}
