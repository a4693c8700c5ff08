/* SPDX-License-Identifier: MIT
 *
 * The files of a kit: rows for programs, as CSV; arrays for shaders, as GLSL, HLSL or C, with the loop over them.
 */
#include "conform/conform.h"

#include "math/math.h"

static void write_rows(const nqm_conform_kit *kit, FILE *out) {
    fprintf(out, "set,%s,light_x,light_y,light_z,viewer_x,viewer_y,viewer_z\n", kit->names);
    for (size_t s = 0; s < kit->n_sets; ++s) {
        const nqm_conform_info set = nqm_conform_kit_get_info(kit, s);
        char head[2048];
        nqm_format_doubles(head, sizeof head, kit->n_columns, set.values, ",");
        for (size_t i = 0; i < kit->n_directions; ++i) {
            const double *wi = set.light + 3 * i, *wo = set.viewer + 3 * i;
            fprintf(out, "%zu,%s,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", s + 1, head, wi[0], wi[1], wi[2], wo[0], wo[1],
                    wo[2]);
        }
    }
}

typedef struct language {
    const char *name, *vector; /* "vec": vec2, vec3 */
    const char *constant, *head, *loop;
    bool is_glsl; /* constructors instead of braces */
} language;

static const language languages[] = {
    {"glsl", "vec", "const ",
     "// GLSL 3.00 ES or 3.30 and later: put `#version` and `precision highp float;` before this file.\n",
     "// Define this function after this file: f_r in 1/sr of linear red, green and blue, without the cosine.\n"
     "vec3 nqm_brdf(nqm_set m, vec3 light, vec3 viewer);\n\n"
     "vec3 nqm_turned(vec3 d, vec2 turn) {\n"
     "    return vec3(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y, d.z);\n}\n"
     "vec3 nqm_value(int set, int direction) {\n"
     "    nqm_set m = nqm_sets[set];\n"
     "    return nqm_brdf(m, nqm_turned(nqm_light[direction], m.turn), nqm_turned(nqm_viewer[direction], "
     "m.turn));\n}\n\n"
     "// Fragment shader: draw into nqm_n_directions x nqm_n_sets texels of 32-bit floats and read them back, the "
     "first row first.\n"
     "out vec4 nqm_color;\n"
     "void main() {\n"
     "    nqm_color = vec4(nqm_value(int(gl_FragCoord.y), int(gl_FragCoord.x)), 1.0);\n}\n",
     true},
    {"hlsl", "float", "static const ", "",
     "// Define this function: f_r in 1/sr of linear red, green and blue, without the cosine.\n"
     "float3 nqm_brdf(nqm_set m, float3 light, float3 viewer);\n\n"
     "float3 nqm_turned(float3 d, float2 turn) {\n"
     "    return float3(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y, d.z);\n}\n\n"
     "// Compute shader: dispatch nqm_n_sets * nqm_n_directions / 64 groups, rounded up, and read the buffer back.\n"
     "RWStructuredBuffer<float3> nqm_values : register(u0);\n"
     "[numthreads(64, 1, 1)] void nqm_main(uint3 id : SV_DispatchThreadID) {\n"
     "    if (id.x >= nqm_n_sets * nqm_n_directions)\n        return;\n"
     "    nqm_set m = nqm_sets[id.x / nqm_n_directions];\n"
     "    uint d = id.x % nqm_n_directions;\n"
     "    nqm_values[id.x] = nqm_brdf(m, nqm_turned(nqm_light[d], m.turn), nqm_turned(nqm_viewer[d], m.turn));\n}\n",
     false},
    {"h", "nqm_float", "static const ",
     "#include <stdio.h>\n\ntypedef struct nqm_set nqm_set;\n"
     "typedef float nqm_float2[2], nqm_float3[3];\n\n",
     "/* f_r in 1/sr of linear red, green and blue, without the cosine. */\n"
     "typedef void nqm_brdf(const nqm_set *m, const float light[3], const float viewer[3], float rgb[3]);\n\n"
     "static inline void nqm_turn(const float d[3], const float turn[2], float to[3]) {\n"
     "    to[0] = turn[0] * d[0] - turn[1] * d[1];\n    to[1] = turn[1] * d[0] + turn[0] * d[1];\n    to[2] = "
     "d[2];\n}\n\n"
     "/* Print the values of all sets and directions. */\n"
     "static inline void nqm_print_values(FILE *out, nqm_brdf *brdf) {\n"
     "    fputs(\"r,g,b\\n\", out);\n"
     "    for (int s = 0; s < nqm_n_sets; ++s)\n"
     "        for (int d = 0; d < nqm_n_directions; ++d) {\n"
     "            float light[3], viewer[3], rgb[3];\n"
     "            nqm_turn(nqm_light[d], nqm_sets[s].turn, light);\n"
     "            nqm_turn(nqm_viewer[d], nqm_sets[s].turn, viewer);\n"
     "            brdf(&nqm_sets[s], light, viewer, rgb);\n"
     "            fprintf(out, \"%.9g,%.9g,%.9g\\n\", (double)rgb[0], (double)rgb[1], (double)rgb[2]);\n"
     "        }\n}\n",
     false},
};

static void put_vector(const language *l, FILE *out, size_t n, const double *v) {
    if (n > 1 && l->is_glsl)
        fprintf(out, "%s%zu(", l->vector, n);
    else if (n > 1)
        fputc('{', out);
    for (size_t c = 0; c < n; ++c) {
        char text[32];
        snprintf(text, sizeof text, "%.9g", v[c]);
        fprintf(out, "%s%s%sf", c ? ", " : "", text, strpbrk(text, ".e") ? "" : ".0");
    }
    fputs(n == 1 ? "" : l->is_glsl ? ")" : "}", out);
}

/* "const vec3 name[9] = vec3[9](", or with braces. */
static void begin_array(const language *l, FILE *out, const char *type, const char *name, size_t n) {
    fprintf(out, "%s%s %s[%zu] = ", l->constant, type, name, n);
    if (l->is_glsl)
        fprintf(out, "%s[%zu](\n", type, n);
    else
        fputs("{\n", out);
}

static void put_directions(const language *l, FILE *out, const char *name, size_t n, const double *d) {
    char type[16];
    snprintf(type, sizeof type, "%s3", l->vector);
    begin_array(l, out, type, name, n);
    for (size_t i = 0; i < n; ++i) {
        fputs(i ? ",\n    " : "    ", out);
        put_vector(l, out, 3, d + 3 * i);
    }
    fputs(l->is_glsl ? ");\n\n" : "};\n\n", out);
}

static void put_sets(const language *l, FILE *out, const nqm_conform_kit *kit) {
    const nqm_schema *schema = kit->schema;
    fputs("struct nqm_set {\n", out);
    fprintf(out, "    %s2 turn;\n", l->vector);
    for (const nqm_schema_key *key = schema->keys; key < schema->keys + schema->n_keys; ++key)
        if (key->n == 1)
            fprintf(out, "    float %s;\n", key->name);
        else
            fprintf(out, "    %s%zu %s;\n", l->vector, key->n, key->name);
    fputs("};\n", out);
    begin_array(l, out, "nqm_set", "nqm_sets", kit->n_sets);
    for (size_t s = 0; s < kit->n_sets; ++s) {
        const double angle = nqm_conform_azimuths_deg[kit->sets[s].azimuth] * NQM_PI / 180;
        fputs(l->is_glsl ? "    nqm_set(" : "    {", out);
        put_vector(l, out, 2, (double[]){cos(angle), sin(angle)});
        for (size_t k = 0; k < schema->n_keys; ++k) {
            fputs(", ", out);
            put_vector(l, out, schema->keys[k].n, kit->sets[s].values.v[k]);
        }
        fprintf(out, "%s%s // set %zu\n", l->is_glsl ? ")" : "}", s + 1 < kit->n_sets ? "," : "", s + 1);
    }
    fputs(l->is_glsl ? ");\n\n" : "};\n\n", out);
}

static void write_shader(const language *l, const nqm_conform_kit *kit, FILE *out) {
    fprintf(out,
            "// Parameter sets and directions of `nqm conform %s`, nqm %s. Angles and turns are of the tangent frame:\n"
            "// z is the normal, x the tangent; unit vectors away from the surface. `turn` is a cosine and a sine.\n",
            kit->schema->model, nqm_version());
    fprintf(out, "%s%sint nqm_n_sets = %zu, nqm_n_directions = %zu;\n\n", l->head, l->constant, kit->n_sets,
            kit->n_directions);
    put_sets(l, out, kit);
    put_directions(l, out, "nqm_light", kit->n_directions, nqm_conform_directions(kit, 0, 0));
    put_directions(l, out, "nqm_viewer", kit->n_directions, nqm_conform_directions(kit, 0, 1));
    fputs(l->loop, out);
}

nqm_status nqm_conform_kit_write(const nqm_conform_kit *kit, const char *format, const char *path, nqm_error *err) {
    enum { N_LANGUAGES = sizeof languages / sizeof *languages };
    const char *dot = strrchr(path, '.');
    const char *name = format ? format : dot ? dot + 1 : "";
    const language *l = languages;
    nqm_outfile out;
    while (l < languages + N_LANGUAGES && !nqm_equal_any_case(name, l->name, SIZE_MAX))
        ++l;
    if (l == languages + N_LANGUAGES && !nqm_equal_any_case(name, "csv", SIZE_MAX))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: a kit is written as csv, glsl, hlsl or h, not as '%.20s'", path,
                        name);
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    if (l < languages + N_LANGUAGES)
        write_shader(l, kit, out.stream);
    else
        write_rows(kit, out.stream);
    return nqm_outfile_commit(&out, err);
}
