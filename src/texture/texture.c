/* SPDX-License-Identifier: MIT
 *
 * Textured materials with their decoded maps: opened from files or made of arrays, their size in texels, and the material of one
 * position.
 */
#include "texture/texture.h"

#include <math.h>

void nqm_texture_free(nqm_texture *t) {
    if (!t)
        return;
    for (size_t i = 0; t->images && i < t->maps->n_images; ++i) {
        nqm_raster_clear(&t->images[i].raster);
        nqm_free(t->images[i].table);
    }
    nqm_free(t->images);
    nqm_free(t->constants);
    nqm_argument_file_release(t->file);
    nqm_textured_free(t->owned);
    nqm_free(t->name);
    nqm_free(t->argument);
    nqm_free(t);
}

static nqm_texture *make(const char *name) {
    nqm_texture *t = nqm_alloc(1, sizeof *t);
    if (!t || !(t->name = nqm_strdup(name))) {
        nqm_free(t);
        return NULL;
    }
    t->normal = NQM_NO_NODE;
    return t;
}

/* The end of what makes a texture. */
static nqm_status keep(nqm_texture *t, nqm_status status, nqm_texture **texture_ret) {
    if (status == NQM_OK)
        *texture_ret = t;
    else
        nqm_texture_free(t);
    return status;
}

/* ---- what varies ------------------------------------------------------------------------------------------------- */

/* Operands are earlier nodes. */
static void find_varying(nqm_texture *t) {
    for (size_t k = 0; k < t->maps->n_nodes; ++k) {
        const nqm_map_node *node = &t->maps->nodes[k];
        t->rows[k] = NQM_NO_ROW;
        t->varies[k] = node->op == NQM_MAP_IMAGE || node->op == NQM_MAP_TEXCOORD;
        for (size_t i = 0; i < nqm_graph_operands(node->op, node->n); ++i)
            t->varies[k] = t->varies[k] || t->varies[node->in[i]];
        if (!t->varies[k])
            nqm_graph_node_value(node, (const double(*)[4])t->constants, t->constants[k]);
    }
}

/* Give rows to nodes that outputs need, which have one already, and to those that these need. */
static void lay_out(nqm_texture *t) {
    for (size_t k = t->maps->n_nodes; k-- > 0;) {
        const nqm_map_node *node = &t->maps->nodes[k];
        if (t->rows[k] == NQM_NO_ROW)
            continue;
        t->rows[k] = t->n_rows;
        t->n_rows = (uint16_t)(t->n_rows + node->n);
        for (size_t i = 0; t->varies[k] && i < nqm_graph_operands(node->op, node->n); ++i)
            t->rows[node->in[i]] = 0;
    }
    for (size_t k = 0; k < t->n_properties; ++k) {
        nqm_texture_property *p = &t->properties[k];
        for (size_t c = 0; p->node != NQM_NO_NODE && c < 3; ++c)
            p->row[c] = (uint16_t)(t->rows[p->node] + nqm_smaller(c, (size_t)t->maps->nodes[p->node].n - 1));
    }
}

static void add_output(nqm_texture *t, const char *name, uint16_t node) {
    const size_t used = strlen(t->words);
    snprintf(t->words + used, sizeof t->words - used, "%s%s", used ? " " : "", name);
    t->rows[node] = 0;
}

/* The properties of the model, with constant values. */
static void set_model(nqm_texture *t, const nqm_values *values) {
    t->values = *values;
    t->model = values->schema->model;
    t->keys = values->schema->keys;
    t->n_properties = values->schema->n_keys;
    for (size_t k = 0; k < t->n_properties; ++k) {
        t->properties[k] = (nqm_texture_property){.key = &t->keys[k], .node = NQM_NO_NODE};
        memcpy(t->properties[k].v, values->v[k], sizeof t->properties[k].v);
    }
}

static nqm_status set_output(nqm_texture *t, const nqm_map_output *output, nqm_error *err) {
    const size_t k = nqm_schema_key_named(t->values.schema, output->key, strlen(output->key));
    if (k == t->n_properties)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the model '%s' has no property '%s' that a map can change", t->name,
                        t->model, output->key);
    nqm_texture_property *p = &t->properties[k];
    if (t->varies[output->node]) {
        p->node = output->node;
        add_output(t, output->key, output->node);
        return NQM_OK;
    }
    nqm_values_set(&t->values, p->key->name, nqm_smaller(p->key->n, t->maps->nodes[output->node].n),
                   t->constants[output->node]);
    memcpy(p->v, t->values.v[k], sizeof p->v);
    return NQM_OK;
}

nqm_status nqm_texture_prepare(nqm_texture *t, nqm_error *err) {
    const size_t n = t->maps->n_nodes;
    set_model(t, &t->maps->values);
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&t->constants, n, sizeof *t->constants},
                                                    {&t->varies, n, sizeof *t->varies}, {&t->rows, n, sizeof *t->rows}),
                                         err);
    if (status != NQM_OK)
        return status;
    find_varying(t);
    for (size_t i = 0; status == NQM_OK && i < t->maps->n_outputs; ++i)
        status = set_output(t, &t->maps->outputs[i], err);
    t->normal = t->maps->normal;
    if (t->normal != NQM_NO_NODE && !t->varies[t->normal])
        t->normal = NQM_NO_NODE;
    if (t->normal != NQM_NO_NODE)
        add_output(t, "normal", t->normal);
    lay_out(t);
    return status;
}

/* ---- maps of files ----------------------------------------------------------------------------------------------- */

typedef struct decode_job {
    nqm_texture *t;
    nqm_error errors[NQM_MAX_MAP_IMAGES];
} decode_job;

static nqm_status decode_map(const nqm_map_image *image, nqm_texels *texels, nqm_error *err) {
    nqm_map map;
    const unsigned char *data;
    size_t n;
    nqm_status status = nqm_textured_open_image(image, &map, &data, &n, err);
    if (status == NQM_OK)
        status = nqm_raster_decode(data, n, image->name, &texels->raster, err);
    nqm_map_close(&map);
    if (status != NQM_OK)
        return status;
    const char *lacks = image->needs_alpha && texels->raster.channels % 2   ? "no alpha"
                        : image->needs_color && texels->raster.channels < 3 ? "one channel, which stands for all keys"
                                                                            : NULL;
    if (lacks)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s has %s: name another channel, or none", image->name, lacks);
    /* "auto" of USD: colours of 8 bits are sRGB; greys, 16 bits and floats are values as they are. */
    const bool is_auto = strcmp(image->space, NQM_SPACE_AUTO) == 0,
               is_srgb = texels->raster.type == NQM_RASTER_U8 && texels->raster.channels >= 3;
    return nqm_texels_decode(texels, !is_auto ? image->space : is_srgb ? "srgb_texture" : "", err);
}

static void decode_one(void *user, size_t image) {
    decode_job *job = user;
    const nqm_texture *t = job->t;
    bool is_needed = false;
    for (size_t k = 0; k < t->maps->n_nodes; ++k) {
        const nqm_map_node *node = &t->maps->nodes[k];
        is_needed = is_needed || (node->op == NQM_MAP_IMAGE && node->image == image && t->rows[k] != NQM_NO_ROW);
    }
    if (is_needed)
        job->errors[image].status = decode_map(&t->maps->images[image], &t->images[image], &job->errors[image]);
}

static nqm_status decode_all(nqm_texture *t, nqm_ticker *ticker, nqm_error *err) {
    decode_job *job = nqm_alloc(1, sizeof *job);
    nqm_status status = NQM_OK;
    t->images = nqm_alloc(t->maps->n_images, sizeof *t->images);
    if (!job || !t->images) {
        nqm_free(job);
        return nqm_fail_nomem(err, sizeof *job + t->maps->n_images * sizeof *t->images);
    }
    job->t = t;
    if (nqm_parallel_ticking(ticker, "maps", t->maps->n_images, decode_one, job))
        status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    for (size_t i = 0; status == NQM_OK && i < t->maps->n_images; ++i)
        if ((status = job->errors[i].status) != NQM_OK)
            nqm_fail(err, status, job->errors[i].byte_offset, "the map '%s' of the material %s: %s",
                     t->maps->images[i].name, t->name, job->errors[i].message);
    nqm_free(job);
    return status;
}

/* With its maps; decoded ones are there already. Whether the material of a texel opens tells whether that of all does. */
static nqm_status complete(nqm_texture *t, nqm_ticker *ticker, nqm_error *err) {
    nqm_brdf *brdf = NULL;
    double normal[3];
    nqm_status status = nqm_texture_prepare(t, err);
    if (status == NQM_OK && !t->images)
        status = decode_all(t, ticker, err);
    if (status == NQM_OK)
        status = nqm_texture_at(t, 0.5, 0.5, &brdf, normal, err);
    nqm_brdf_free(brdf);
    snprintf(t->remark, sizeof t->remark, "%s", t->maps->remark);
    return status == NQM_OK ? nqm_texture_inspect(t, err) : status;
}

/* ---- size in texels ---------------------------------------------------------------------------------------------- */

static size_t common_divisor(size_t a, size_t b) {
    return b ? common_divisor(b, a % b) : a;
}

/* Tiles of an image that is repeated a whole number of times and not turned. */
static size_t count_tiles(const nqm_map_node *node, size_t axis) {
    const double times = fabs(node->uv[axis][axis]), nearest = nearbyint(times);
    const bool is_turned = node->uv[0][1] != 0 || node->uv[1][0] != 0;
    return node->wrap[axis] == NQM_MAP_REPEAT && !is_turned && nearest >= 1 && nearest < 1e6 &&
                   fabs(times - nearest) < 1e-6
               ? (size_t)nearest
               : 1;
}

size_t nqm_texture_tiles(const nqm_texture *ref, const nqm_texture *test, size_t axis, size_t *n_texels_ret) {
    enum { MAX_SIDE = 8192 };
    const nqm_texture *const each[2] = {ref, test};
    size_t n_tiles = 0; /* equal ones into which all maps divide the surface; 0: any number */
    double n = 0;
    for (size_t s = 0; s < 2; ++s)
        for (size_t k = 0; each[s]->maps && k < each[s]->maps->n_nodes; ++k) {
            const nqm_map_node *node = &each[s]->maps->nodes[k];
            const bool is_image = node->op == NQM_MAP_IMAGE;
            if (each[s]->rows[k] == NQM_NO_ROW || (!is_image && node->op != NQM_MAP_TEXCOORD))
                continue;
            n_tiles = common_divisor(n_tiles, is_image ? count_tiles(node, axis) : 1);
            const nqm_raster *r = is_image ? &each[s]->images[node->image].raster : NULL;
            if (r)
                n = fmax(n,
                         fmax((double)r->width * fabs(node->uv[0][axis]), (double)r->height * fabs(node->uv[1][axis])));
        }
    n_tiles = nqm_larger(n_tiles, 1);
    *n_texels_ret = (size_t)fmin(fmax(ceil(n / (double)n_tiles - 1e-6), 1), MAX_SIDE);
    return n_tiles;
}

nqm_texture_info nqm_texture_get_info(const nqm_texture *t, const nqm_texture *beside) {
    assert(t);
    static const size_t n_each[] = {[NQM_RASTER_U8] = 1, [NQM_RASTER_U16] = 2, [NQM_RASTER_F32] = 4};
    nqm_texture_info info = {.name = t->name, .model = t->model, .varying = t->words, .remark = t->remark};
    (void)nqm_texture_tiles(t, beside ? beside : t, 0, &info.width);
    (void)nqm_texture_tiles(t, beside ? beside : t, 1, &info.height);
    for (size_t i = 0; t->images && i < t->maps->n_images; ++i) {
        const nqm_raster *r = &t->images[i].raster;
        info.n_images += r->data != NULL;
        info.n_bytes += r->width * r->height * r->channels * n_each[r->type];
    }
    return info;
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* A BRDF that does not vary. */
static nqm_status open_constant(nqm_texture *t, nqm_argument *argument, nqm_error *err) {
    nqm_brdf *brdf = NULL;
    nqm_status status = nqm_argument_open(argument, &brdf, err);
    if (status != NQM_OK)
        return status;
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    nqm_values values;
    if (info.spec && nqm_values_parse_spec(info.spec, &values, NULL) == NQM_OK) {
        set_model(t, &values);
    } else {
        t->model = info.format;
        t->argument = nqm_strdup(t->name);
        status = t->argument ? NQM_OK : nqm_fail_nomem(err, strlen(t->name) + 1);
    }
    nqm_brdf_free(brdf);
    return status;
}

nqm_status nqm_texture_open_argument(nqm_argument *argument, nqm_progress_fn progress, void *progress_user,
                                     nqm_texture **texture_ret, nqm_error *err) {
    nqm_ticker ticker = {.fn = progress, .user = progress_user};
    nqm_texture *t = make(argument->text);
    *texture_ret = NULL;
    if (!t)
        return nqm_fail_nomem(err, sizeof *t);
    nqm_status status = nqm_argument_maps(argument, &t->maps, &t->owned, err);
    t->file = nqm_argument_file_hold(argument->file);
    if (status == NQM_OK)
        status = t->maps ? complete(t, &ticker, err) : open_constant(t, argument, err);
    return keep(t, status, texture_ret);
}

nqm_status nqm_texture_open(const char *argument, nqm_progress_fn progress, void *progress_user,
                            nqm_texture **texture_ret, nqm_error *err) {
    NQM_MAKE(err, texture_ret, argument);
    nqm_argument *a = nqm_argument_parse(argument, NULL);
    nqm_status status = a ? nqm_texture_open_argument(a, progress, progress_user, texture_ret, err)
                          : nqm_fail_nomem(err, strlen(argument) + 1);
    nqm_argument_free(a);
    return status;
}

/* ---- from arrays ------------------------------------------------------------------------------------------------- */

static nqm_status check_map(const nqm_texture *t, const nqm_texture_map *map, nqm_error *err) {
    const size_t k = nqm_schema_key_named(t->values.schema, map->key, strlen(map->key)),
                 n_of_key = k < t->n_properties ? t->keys[k].n : 0;
    const size_t n = strcmp(map->key, "normal") == 0 ? 3 : n_of_key;
    if (n == 0)
        return nqm_fail(err, NQM_ERR_ARG, -1, "the model '%s' has no property '%s' that a map can change", t->model,
                        map->key);
    if (n != map->channels || map->height == 0 || map->width == 0)
        return nqm_fail(err, NQM_ERR_ARG, -1, "the map '%s' has the shape (%zu, %zu, %zu): the last is %zu, none is 0",
                        map->key, map->height, map->width, map->channels, n);
    if (map->height > NQM_RASTER_MAX_SIDE || map->width > NQM_RASTER_MAX_SIDE)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "the map '%s' has %zu x %zu texels; a side has at most %d", map->key,
                        map->width, map->height, (int)NQM_RASTER_MAX_SIDE);
    for (size_t i = 0; i < map->height * map->width * n; ++i)
        if (!isfinite(map->values[i]))
            return nqm_fail(err, NQM_ERR_ARG, -1, "the map '%s' is not finite at texel (%zu, %zu)", map->key,
                            i / n / map->width, i / n % map->width);
    return NQM_OK;
}

static nqm_status add_map(nqm_texture *t, const nqm_texture_map *map, nqm_error *err) {
    static const double uv[2][3] = {{1, 0, 0}, {0, 1, 0}};
    static const uint8_t repeat[2] = {NQM_MAP_REPEAT, NQM_MAP_REPEAT};
    const size_t n = map->height * map->width * map->channels;
    const nqm_map_image named = {.data = nqm_alloc(1, 1), .name = nqm_strdup(map->key)};
    size_t image = 0;
    uint16_t node = NQM_NO_NODE;
    float *values = nqm_alloc(n, sizeof *values);
    if (nqm_graph_add_image(t->owned, named, &image) && values)
        node = nqm_graph_image_at(t->owned, image, map->channels, uv, repeat);
    if (node == NQM_NO_NODE) {
        nqm_free(values);
        return nqm_fail_nomem(err, n * sizeof *values);
    }
    memcpy(values, map->values, n * sizeof *values);
    t->images[image].raster = (nqm_raster){
        .width = map->width, .height = map->height, .channels = map->channels, .type = NQM_RASTER_F32, .data = values};
    if (strcmp(map->key, "normal") == 0)
        t->owned->normal = node;
    else
        nqm_graph_output_set(t->owned, map->key, node);
    return NQM_OK;
}

static nqm_status make_of_arrays(nqm_texture *t, size_t n_maps, const nqm_texture_map *maps, nqm_error *err) {
    t->maps = t->owned = nqm_textured_create();
    t->images = nqm_alloc(nqm_smaller(n_maps, NQM_MAX_MAP_IMAGES), sizeof *t->images);
    if (!t->owned || !t->images)
        return nqm_fail_nomem(err, sizeof *t->owned);
    nqm_status status = nqm_values_parse_spec(t->name, &t->owned->values, err);
    if (status == NQM_OK && n_maps > NQM_MAX_MAP_IMAGES)
        status = nqm_fail(err, NQM_ERR_LIMIT, -1, "%zu maps; there may be %d", n_maps, NQM_MAX_MAP_IMAGES);
    if (status == NQM_OK)
        set_model(t, &t->owned->values);
    for (size_t i = 0; status == NQM_OK && i < n_maps; ++i) {
        status = check_map(t, &maps[i], err);
        if (status == NQM_OK)
            status = add_map(t, &maps[i], err);
    }
    return status == NQM_OK ? complete(t, NULL, err) : status;
}

nqm_status nqm_texture_create(const char *base, size_t n_maps, const nqm_texture_map *maps, nqm_texture **texture_ret,
                              nqm_error *err) {
    NQM_MAKE(err, texture_ret, base);
    NQM_REQUIRE_IF(n_maps, err, maps);
    for (size_t i = 0; i < n_maps; ++i)
        NQM_REQUIRE(err, maps[i].key, maps[i].values);
    nqm_texture *t = make(base);
    return keep(t, t ? make_of_arrays(t, n_maps, maps, err) : nqm_fail_nomem(err, sizeof *t), texture_ret);
}

/* ---- one position ------------------------------------------------------------------------------------------------ */

nqm_values nqm_texture_values(const nqm_texture *t, const float *rows, size_t i) {
    nqm_values values = t->values;
    for (size_t k = 0; k < t->n_properties; ++k)
        for (size_t c = 0; c < 3 && t->properties[k].node != NQM_NO_NODE; ++c) {
            values.v[k][c] = nqm_texture_value(t, k, nqm_smaller(c, t->keys[k].n - 1), rows, i);
            values.given |= UINT64_C(1) << k;
        }
    return values;
}

nqm_subject nqm_texture_subject(const nqm_texture *t, const float *rows, size_t i, nqm_values *values) {
    if (t->argument)
        return (nqm_subject){.name = t->argument};
    *values = nqm_texture_values(t, rows, i);
    return (nqm_subject){.values = values};
}

nqm_status nqm_texture_at(const nqm_texture *t, double u, double v, nqm_brdf **brdf_ret, double normal[3],
                          nqm_error *err) {
    const double at[2] = {u - floor(u), v - floor(v)};
    const size_t n = (size_t)t->n_rows * NQM_TEXEL_BLOCK;
    float *rows = nqm_alloc(n, sizeof *rows);
    *brdf_ret = NULL;
    if (!rows)
        return nqm_fail_nomem(err, n * sizeof *rows);
    nqm_texture_evaluate(t, 1, &at[0], &at[1], rows);
    nqm_texture_normal(t, rows, 0, normal);
    nqm_values values;
    const nqm_subject subject = nqm_texture_subject(t, rows, 0, &values);
    nqm_free(rows);
    nqm_status status = subject.name ? NQM_OK : nqm_values_check(&values, err);
    return status == NQM_OK ? nqm_subject_open(&subject, NULL, brdf_ret, err) : status;
}
