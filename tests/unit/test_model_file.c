/* SPDX-License-Identifier: MIT
 *
 * Model files: written data are read back and used in place; the message names every missing, extra, misshapen or
 * non-finite tensor, the checksum detects all damage; and the meaning of the raw output in JOD.
 */
#include "io/io.h"
#include "kernel/half.h"
#include "model/model.h"
#include "net/inference.h"
#include "percept/percept.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/damage.h"

#include <nqm/train.h>

enum { N_DIRECTIONS = 4, MAX_TENSORS = 40 };

/* What the models of these tests have; n_points: of the transport matrix. */
static bool with_network = true, with_scalars, with_transport;
enum { MAX_POINTS = 3 * NQM_TRANSPORT_POINTS };
static size_t n_points = NQM_TRANSPORT_POINTS;

/* Two scenes of as many points each. */
static void add_transport(struct nqm_model *model) {
    static float light[N_DIRECTIONS * 3 * MAX_POINTS];
    static double points[3 * MAX_POINTS];
    for (size_t i = 0; i < sizeof light / sizeof *light; ++i)
        light[i] = 0.25f * (float)(i % 1000);
    for (size_t i = 0; i < n_points; ++i) {
        points[3 * i] = 2 / (double)n_points;
        points[3 * i + 1] = (double)(i / (n_points / 2));
        points[3 * i + 2] = 1000;
    }
    const nqm_transport transport = {N_DIRECTIONS, light, {n_points, points}};
    assert_int_equal(nqm_model_set_transport(model, &transport, NULL), NQM_OK);
}

static struct nqm_model *make_model(void) {
    struct nqm_model *model = nqm_alloc(1, sizeof *model);
    const nqm_net_shape shape = {3, {6 * N_DIRECTIONS + (with_scalars ? NQM_SCALAR_COUNT : 0), 16, 5, 1}};
    if (with_network) {
        assert_int_equal(nqm_params_create(&shape, &model->params, NULL), NQM_OK);
        nqm_params_init(&model->params, 3);
    }
    double degrees[3 * N_DIRECTIONS];
    for (size_t i = 0; i < 3 * N_DIRECTIONS; ++i)
        degrees[i] = 1.5 * (double)i;
    assert_int_equal(nqm_directions_from_degrees(N_DIRECTIONS, degrees, &model->directions, NULL), NQM_OK);
    for (size_t i = 0; i < 3; ++i) {
        model->features.mean[i] = 0.1f * (float)i;
        model->features.std[i] = 1 + (float)i;
    }
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i) {
        model->scalars.mean[i] = 0.5f * (float)i;
        model->scalars.std[i] = 2 + (float)i;
    }
    model->scalars.scale = 1.5;
    model->scalar_names = with_scalars ? nqm_scalar_names() : NULL;
    if (with_scalars)
        assert_int_equal(nqm_scalars_select(NULL, &model->scalars, NULL), NQM_OK);
    model->features.layout = NQM_LAYOUT_REF_TEST;
    model->target = with_transport ? NQM_TARGET_LOG_DELTA_E : NQM_TARGET_JOD;
    if (with_transport)
        add_transport(model);
    model->features.difference_scale = 3;
    model->output.mean = 5, model->output.std = 2;
    model->output.lo = -2, model->output.hi = 1.5;
    for (size_t i = 0; i < NQM_LABEL_PARTS; ++i)
        model->parts[i] = (nqm_output_range){0.1 * (double)i, 1, -1, 1 + (double)i};
    model->curve = nqm_curve_published;
    model->id = nqm_strdup("test"), model->recipe = nqm_strdup("paper"), model->licence = nqm_strdup("MIT");
    model->card = nqm_strdup("# Card\n\"quoted\""), model->training = nqm_strdup("{\"epochs\":1}");
    model->manifest_sha256 = nqm_strdup("");
    return model;
}

/* The content of a file; free with nqm_free(). */
static unsigned char *read_file(const char *path, size_t *n_bytes) {
    nqm_map map;
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    unsigned char *copy = nqm_alloc(map.n_bytes, 1);
    memcpy(copy, map.data, map.n_bytes);
    *n_bytes = map.n_bytes;
    nqm_map_close(&map);
    unlink(path);
    return copy;
}

static unsigned char *model_file(size_t *n_bytes) {
    struct nqm_model *model = make_model();
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    nqm_model_free(model);
    return read_file(scratch_path("model"), n_bytes);
}

static float output_of(const struct nqm_model *model) {
    float x[6 * N_DIRECTIONS + NQM_SCALAR_COUNT], z;
    const nqm_inference_net *net;
    nqm_inference_work *work;
    for (size_t i = 0; i < model->params.shape.sizes[0]; ++i)
        x[i] = sinf((float)i);
    assert_int_equal(nqm_model_inference(model, &net, NULL), NQM_OK);
    assert_int_equal(nqm_inference_work_create(net, 1, &work, NULL), NQM_OK);
    nqm_inference_run(work, 1, x, model->params.shape.sizes[0], &z);
    nqm_inference_work_free(work);
    return z;
}

TEST(round_trip) {
    size_t n, n_again;
    struct nqm_model *made = make_model(), *model;
    assert_int_equal(nqm_model_save(made, scratch_path("model"), NULL), NQM_OK);
    unsigned char *file = read_file(scratch_path("model"), &n);
    assert_int_equal(nqm_model_parse(file, n, "f", true, &model, NULL), NQM_OK);
    assert_int_equal(model->params.n, made->params.n);
    assert_null(model->params.block); /* weights are used in place */
    assert_int_equal(nqm_model_has_network(model), with_network);
    if (with_network) {
        assert_true((const unsigned char *)model->params.layer[0].w > file);
        assert_int_equal((uintptr_t)model->params.layer[0].w % 64, 0);
        assert_true(output_of(model) == output_of(made));
    } else
        assert_memory_equal(model->parts, made->parts, sizeof made->parts);
    assert_int_equal(model->directions->n, N_DIRECTIONS);
    assert_memory_equal(model->directions->degrees, made->directions->degrees, 3 * N_DIRECTIONS * sizeof(double));
    assert_memory_equal(model->features.mean, made->features.mean, sizeof made->features.mean);
    assert_memory_equal(model->features.std, made->features.std, sizeof made->features.std);
    assert_int_equal(model->scalars.n, with_scalars ? NQM_SCALAR_COUNT : 0);
    if (with_scalars) {
        assert_memory_equal(model->scalars.mean, made->scalars.mean, sizeof made->scalars.mean);
        assert_memory_equal(model->scalars.std, made->scalars.std, sizeof made->scalars.std);
        assert_near(model->scalars.scale, 1.5, 0);
        assert_string_equal(model->scalar_names, made->scalar_names);
    }
    assert_int_equal(model->transport != NULL, with_transport);
    if (with_transport) {
        assert_int_equal(model->n_transport, N_DIRECTIONS);
        assert_int_equal(model->n_points, n_points);
        assert_memory_equal(model->transport, made->transport, N_DIRECTIONS * 3 * n_points * sizeof *made->transport);
        assert_memory_equal(model->transport_points, made->transport_points,
                            3 * n_points * sizeof *made->transport_points);
    }
    assert_int_equal(model->features.layout, made->features.layout);
    assert_int_equal(model->target, made->target);
    const double values[][2] = {{model->features.difference_scale, made->features.difference_scale},
                                {model->output.mean, made->output.mean},
                                {model->output.std, made->output.std},
                                {model->output.lo, made->output.lo},
                                {model->output.hi, made->output.hi},
                                {model->curve.b1, made->curve.b1},
                                {model->curve.b2, made->curve.b2},
                                {model->curve.b3, made->curve.b3}};
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i)
        assert_true(values[i][0] == values[i][1]);
    const char *const texts[][2] = {{model->id, made->id},
                                    {model->recipe, made->recipe},
                                    {model->card, made->card},
                                    {model->licence, made->licence},
                                    {model->training, made->training},
                                    {model->manifest_sha256, made->manifest_sha256}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        assert_string_equal(texts[i][0], texts[i][1]);
    assert_int_equal(strlen(model->sha256), 64);
    /* saving again must give the same bytes */
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    unsigned char *again = read_file(scratch_path("model"), &n_again);
    assert_int_equal(n_again, n);
    assert_memory_equal(again, file, n);
    nqm_model_free(model);
    nqm_model_free(made);
    nqm_free(again);
    nqm_free(file);
}

/* At an odd address floats cannot be used in place; the copy must have the same values. */
TEST(unaligned_bytes) {
    size_t n;
    unsigned char *file = model_file(&n), *shifted = nqm_alloc(n + 1, 1);
    memcpy(shifted + 1, file, n);
    struct nqm_model *model, *odd;
    assert_int_equal(nqm_model_parse(file, n, "f", true, &model, NULL), NQM_OK);
    assert_int_equal(nqm_model_parse(shifted + 1, n, "f", true, &odd, NULL), NQM_OK);
    assert_non_null(odd->memory);
    assert_true(output_of(odd) == output_of(model));
    nqm_model_free(model);
    nqm_model_free(odd);
    nqm_free(shifted);
    nqm_free(file);
}

/* Each of the 2^16 halves survives conversion to float and back; ties round to even. */
TEST(half_values) {
    for (uint32_t bits = 0; bits < 0x10000; ++bits) {
        uint16_t half = (uint16_t)bits, back;
        float x;
        if ((half & 0x7c00) == 0x7c00)
            continue;
        nqm_half_to_float(1, &half, &x);
        nqm_half_from_float(1, &x, &back);
        assert_int_equal(back, half);
    }
    static const struct {
        float x;
        uint16_t half;
    } known[] = {{1, 0x3c00},
                 {-2, 0xc000},
                 {65504, 0x7bff},
                 {65519, 0x7bff},
                 {65520, 0x7c00},
                 {0x1p-24f, 1},
                 {0x1.8p-24f, 2},
                 {0x1p-25f, 0},
                 {0x1.1p-25f, 1},
                 {0x1p-14f, 0x400},
                 {0x1.ff8p-15f, 0x3ff},
                 {0x1.ffcp-15f, 0x400},
                 {1 + 0x1p-11f, 0x3c00},
                 {1 + 0x3p-11f, 0x3c02},
                 {1 + 0x1.1p-11f, 0x3c01},
                 {-0.0f, 0x8000}};
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i) {
        uint16_t half;
        nqm_half_from_float(1, &known[i].x, &half);
        assert_int_equal(half, known[i].half);
    }
}

/* A file with 16-bit weights gives the rounded weights at any address and is saved with 16-bit weights again. */
TEST(weights_in_half) {
    size_t n_whole, n, n_again;
    struct nqm_model *made = make_model(), *copy, *model, *odd;
    assert_int_equal(nqm_model_copy(made, &copy, NULL), NQM_OK);
    assert_true(output_of(copy) == output_of(made));
    assert_int_equal(nqm_model_round_to_half(copy, NULL), NQM_OK);
    const size_t n_first = made->params.shape.sizes[0] * made->params.shape.sizes[1];
    for (size_t i = 0; i < n_first; ++i) {
        const float w = made->params.layer[0].w[i];
        assert_near(copy->params.layer[0].w[i], w, 0x1p-11f * fabsf(w) + 0x1p-25f);
    }
    assert_memory_equal(copy->params.layer[2].w, made->params.layer[2].w, made->params.shape.sizes[2] * sizeof(float));
    unsigned char *whole = model_file(&n_whole);
    assert_int_equal(nqm_model_save(copy, scratch_path("model"), NULL), NQM_OK);
    unsigned char *file = read_file(scratch_path("model"), &n), *shifted = nqm_alloc(n + 1, 1);
    assert_near((double)(n_whole - n), (double)(2 * (n_first + 16 * 5)), 64); /* the header's length may differ */
    memcpy(shifted + 1, file, n);
    assert_int_equal(nqm_model_parse(file, n, "f", true, &model, NULL), NQM_OK);
    assert_int_equal(nqm_model_parse(shifted + 1, n, "f", true, &odd, NULL), NQM_OK);
    nqm_params_free(&copy->params); /* the loaded model must not depend on it */
    nqm_model_free(copy);
    assert_int_equal(nqm_model_copy(odd, &copy, NULL), NQM_OK);
    assert_true(output_of(model) == output_of(odd) && output_of(copy) == output_of(odd));
    assert_int_equal(nqm_model_save(copy, scratch_path("model"), NULL), NQM_OK);
    unsigned char *again = read_file(scratch_path("model"), &n_again);
    assert_int_equal(n_again, n);
    assert_memory_equal(again, file, n);
    made->params.layer[1].w[7] = 65520;
    assert_int_equal(nqm_model_round_to_half(made, NULL), NQM_ERR_NUMERIC);
    struct nqm_model *models[] = {made, copy, model, odd};
    for (size_t i = 0; i < 4; ++i)
        nqm_model_free(models[i]);
    unsigned char *blocks[] = {whole, file, shifted, again};
    for (size_t i = 0; i < 4; ++i)
        nqm_free(blocks[i]);
}

static nqm_status read_model(const nqm_map *map, nqm_error *err) {
    struct nqm_model *model;
    const nqm_status status = nqm_model_parse(map->data, map->n_bytes, map->path, true, &model, err);
    assert_true((status == NQM_OK) == (model != NULL));
    nqm_model_free(model);
    return status;
}

TEST(damage) {
    size_t n;
    unsigned char *file = model_file(&n);
    struct nqm_model *model;
    nqm_error err = {0};
    file[n - 1] ^= 1;
    assert_int_equal(nqm_model_parse(file, n, "my.model", true, &model, &err), NQM_ERR_MODEL);
    assert_null(model);
    assert_non_null(strstr(err.message, "my.model: checksum"));
    assert_int_equal(nqm_model_parse(file, n, "f", false, &model, NULL), NQM_OK); /* without verification */
    nqm_model_free(model);
    file[n - 1] ^= 1;
    refuse_cuts("my.model", (blob){file, n}, 1, read_model);
    nqm_free(file);
}

/* ---- files with invalid content and a valid checksum ------------------------------------------------------------- */

/* The content of a valid file, which tests change and write again. */
typedef struct contents {
    unsigned char *file;
    nqm_safetensors *st;
    size_t n_tensors, n_meta;
    nqm_tensor tensors[MAX_TENSORS];
    nqm_meta meta[16];
} contents;

static contents open_contents(void) {
    static const char *const keys[] = {"format", "schema", "id",       "recipe",          "layout",
                                       "target", "card",   "training", "manifest_sha256", "licence"};
    contents c = {0};
    size_t n;
    c.file = model_file(&n);
    assert_int_equal(nqm_safetensors_parse(c.file, n, "f", &c.st, NULL), NQM_OK);
    c.n_tensors = nqm_safetensors_count(c.st);
    for (size_t i = 0; i < c.n_tensors; ++i)
        c.tensors[i] = *nqm_safetensors_at(c.st, i);
    c.n_meta = sizeof keys / sizeof *keys;
    for (size_t i = 0; i < c.n_meta; ++i)
        c.meta[i] = (nqm_meta){keys[i], nqm_safetensors_meta(c.st, keys[i])};
    if (with_scalars)
        c.meta[c.n_meta++] = (nqm_meta){"scalars", nqm_safetensors_meta(c.st, "scalars")};
    return c;
}

static void close_contents(contents *c) {
    nqm_safetensors_free(c->st);
    nqm_free(c->file);
}

/* Write and parse; the file must be refused with a message that contains `says`. */
static void must_be_refused(const contents *c, const char *says) {
    size_t n;
    struct nqm_model *model;
    nqm_error err = {0};
    assert_int_equal(
        nqm_safetensors_write(scratch_path("model"), c->n_tensors, c->tensors, c->n_meta, c->meta, NULL, NULL), NQM_OK);
    unsigned char *file = read_file(scratch_path("model"), &n);
    assert_int_equal(nqm_model_parse(file, n, "f", true, &model, &err), NQM_ERR_MODEL);
    assert_null(model);
    if (!strstr(err.message, says))
        print_error("'%s' does not say '%s'\n", err.message, says);
    assert_non_null(strstr(err.message, says));
    nqm_free(file);
}

TEST(each_tensor_is_checked) {
    contents c = open_contents();
    for (size_t i = 0; i < c.n_tensors; ++i) {
        nqm_tensor saved = c.tensors[i];
        const char *name = saved.name;
        unsigned char *values = nqm_alloc(saved.n_bytes + 8, 1);
        memcpy(values, saved.data, saved.n_bytes);
        /* the last value becomes NaN or infinite */
        c.tensors[i].data = values;
        if (saved.dtype == NQM_F64)
            memcpy(values + saved.n_bytes - 8, &(double){(double)NAN}, 8); /* in the byte order of the host */
        else
            memcpy(values + saved.n_bytes - 4, &(float){i % 2 ? INFINITY : NAN}, 4);
        must_be_refused(&c, name);
        /* one extra value */
        memcpy(values, saved.data, saved.n_bytes);
        c.tensors[i].n_dims = 1;
        c.tensors[i].dims[0] = saved.n_bytes / (saved.dtype == NQM_F64 ? 8 : 4) + 1;
        c.tensors[i].n_bytes += saved.dtype == NQM_F64 ? 8 : 4;
        must_be_refused(&c, name);
        /* missing: renamed, so that the renamed tensor is an extra one */
        c.tensors[i] = saved;
        c.tensors[i].name = "layers.7.weigth";
        must_be_refused(&c, name);
        c.tensors[i] = saved;
        nqm_free(values);
    }
    c.tensors[c.n_tensors] = (nqm_tensor){.name = "extra", .dtype = NQM_U8, .n_dims = 1, .data = c.file};
    c.n_tensors++;
    must_be_refused(&c, "'extra'");
    close_contents(&c);
}

TEST(each_text_is_checked) {
    contents c = open_contents();
    for (size_t i = 0; i < c.n_meta; ++i) {
        nqm_meta saved = c.meta[i];
        c.meta[i].key = "other";
        bool scalars = strcmp(saved.key, "scalars") == 0; /* without scalars the input is too wide */
        must_be_refused(&c, i == 0 ? "not an nqm model" : scalars ? "does not fit the layout" : saved.key);
        c.meta[i] = saved;
    }
    static const struct {
        size_t index;
        const char *value, *says;
    } bad[] = {{0, "nqm-dataset", "not an nqm model"},
               {1, "2", "schema 2"},
               {4, "three", "layout"},
               {5, "", "target"},
               {4, "ref_diff_absdiff", "does not fit the layout"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_meta saved = c.meta[bad[i].index];
        c.meta[bad[i].index].value = bad[i].value;
        must_be_refused(&c, bad[i].says);
        c.meta[bad[i].index] = saved;
    }
    close_contents(&c);
}

TEST(impossible_numbers) {
    const float no_std[3] = {1, 0, 1}, no_scalar_std[NQM_SCALAR_COUNT] = {1};
    const double flat[4] = {5, 2, 1, 1}, no_deviation[4] = {5, 0, -1, 1};
    const struct {
        const char *name;
        const void *data;
    } bad[] = {{"whitening.std", no_std}, {"target", flat}, {"target", no_deviation}, {"scalars.std", no_scalar_std}};
    for (size_t i = 0; i < 3u + with_scalars; ++i) {
        contents c = open_contents();
        for (size_t k = 0; k < c.n_tensors; ++k)
            if (strcmp(c.tensors[k].name, bad[i].name) == 0)
                c.tensors[k].data = bad[i].data;
        must_be_refused(&c, bad[i].name);
        close_contents(&c);
    }
}

/* A file in which the tensor `name` has other values must be refused with a message that contains `says`. */
static void refuse_values(const char *name, const void *data, const char *says) {
    contents c = open_contents();
    size_t found = 0;
    for (size_t k = 0; k < c.n_tensors; ++k)
        if (strcmp(c.tensors[k].name, name) == 0) {
            c.tensors[k].data = data;
            ++found;
        }
    assert_int_equal(found, 1);
    must_be_refused(&c, says);
    close_contents(&c);
}

static void impossible_transport(void **state) {
    (void)state;
    struct nqm_model *model = make_model();
    model->transport[100] = INFINITY;
    refuse_values("transport", model->transport, "is not finite");
    static const struct {
        size_t i, k;
        double value;
        const char *says;
    } bad[] = {{3, 0, -0.1, "a fraction outside 0 to 1"},
               {3, 0, 1.1, "a fraction outside 0 to 1"},
               {3, 0, 0.5, "do not sum to 1"},
               {NQM_TRANSPORT_POINTS - 1, 0, 0, "do not sum to 1"},
               {0, 1, 1, "number its scenes"},
               {5, 1, 1, "do not sum to 1"},
               {NQM_TRANSPORT_POINTS / 2, 1, 2, "number its scenes"},
               {NQM_TRANSPORT_POINTS - 1, 1, 0, "number its scenes"},
               {9, 1, 0.5, "number its scenes"},
               {70, 2, 0, "peak luminance"},
               {70, 2, -1000, "peak luminance"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        double points[3 * NQM_TRANSPORT_POINTS];
        memcpy(points, model->transport_points, sizeof points);
        points[3 * bad[i].i + bad[i].k] = bad[i].value;
        refuse_values("transport.points", points, bad[i].says);
    }
    nqm_model_free(model);
    contents c = open_contents();
    c.meta[5].value = "jod";
    must_be_refused(&c, "'transport' needs the target log_delta_e");
    c.meta[5].value = "log_delta_e";
    for (size_t k = 0; k < c.n_tensors; ++k)
        if (strcmp(c.tensors[k].name, "transport") == 0) {
            c.tensors[k].dims[0] -= 1;
            c.tensors[k].n_bytes -= 3 * NQM_TRANSPORT_POINTS * sizeof(float);
        }
    must_be_refused(&c, "'transport' does not have a row for each direction");
    close_contents(&c);
}

/* Files of models with a transport matrix that has other shapes than the model's directions and scenes. */
static void impossible_shapes(void **state) {
    (void)state;
    static const struct {
        size_t n_points, n_columns; /* rows of transport.points; columns of transport */
        const char *says;
    } bad[] = {{100, 300, "no multiple of 32 up to 4096"},
               {128, 256, "'transport' has the wrong type or shape"},
               {96, 384, "'transport' has the wrong type or shape"},
               {4128, 3 * 4128, "no multiple of 32 up to 4096"}};
    static const float light[N_DIRECTIONS * 3 * 4128];
    static double points[3 * 4128];
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        contents c = open_contents();
        for (size_t k = 0; k < c.n_tensors; ++k) {
            if (strcmp(c.tensors[k].name, "transport") == 0)
                c.tensors[k] = nqm_tensor_of("transport", NQM_F32, N_DIRECTIONS, bad[i].n_columns, light);
            if (strcmp(c.tensors[k].name, "transport.points") == 0)
                c.tensors[k] = nqm_tensor_of("transport.points", NQM_F64, bad[i].n_points, 3, points);
        }
        must_be_refused(&c, bad[i].says);
        close_contents(&c);
    }
}

/* A network has a hidden layer. */
TEST(one_layer) {
    static const float weights[6 * N_DIRECTIONS], bias[1];
    contents c = open_contents();
    for (size_t k = 0; k < c.n_tensors; ++k)
        if (strncmp(c.tensors[k].name, "layers.", strlen("layers.")) == 0)
            c.tensors[k--] = c.tensors[--c.n_tensors];
    c.tensors[c.n_tensors++] = nqm_tensor_of("layers.0.weight", NQM_F32, 1, 6 * N_DIRECTIONS, weights);
    c.tensors[c.n_tensors++] = nqm_tensor_of("layers.0.bias", NQM_F32, 0, 1, bias);
    must_be_refused(&c, "'layers.1.weight' is missing");
    close_contents(&c);
}

/* A file without layers needs a transport matrix, and has no part of a layer. */
static void neither_network_nor_transport(void **state) {
    (void)state;
    static const float bias[16];
    contents c = open_contents();
    c.tensors[c.n_tensors++] = nqm_tensor_of("layers.0.bias", NQM_F32, 0, 16, bias);
    must_be_refused(&c, "'layers.0.weight' is missing");
    c.tensors[c.n_tensors - 1].name = "layers.1.weight";
    must_be_refused(&c, "'layers.1.weight' does not belong in a model");
    --c.n_tensors;
    for (size_t k = 0; k < c.n_tensors; ++k)
        if (strncmp(c.tensors[k].name, "transport", strlen("transport")) == 0)
            c.tensors[k--] = c.tensors[--c.n_tensors];
    must_be_refused(&c, "'layers.0.weight' is missing");
    close_contents(&c);
}

TEST(out_of_memory) {
    size_t n;
    unsigned char *file = model_file(&n);
    nqm_status status = NQM_OK;
    long count = -1;
    EVERY_ALLOCATION(count, status, 0)
    status = read_model(&(nqm_map){.data = file, .n_bytes = n, .path = "f"}, NULL);
    assert_true(count > 7);
    nqm_free(file);
}

/* ---- the meaning of the output ----------------------------------------------------------------------------------- */

TEST(jod_of_an_output) {
    struct nqm_model *model = make_model();
    double delta_e;
    assert_near(nqm_model_jod(model, 0, NULL, &delta_e), 5 + 2 * (-2 + 3.5 / 2), 1e-12);
    assert_true(isnan(delta_e));
    assert_near(nqm_model_jod(model, 1e9, NULL, NULL), 5 + 2 * 1.5, 1e-12);
    assert_near(nqm_model_jod(model, -1e9, NULL, NULL), 5 - 2 * 2, 1e-12);
    model->target = NQM_TARGET_LOG_DELTA_E;
    model->output.mean = log(11.0372467041016), model->output.lo = -1,
    model->output.hi = 1; /* a row of the authors' labels */
    assert_near(nqm_model_jod(model, 0, NULL, &delta_e), 8.50837750985371, 1e-9);
    assert_relative(delta_e, 11.0372467041016, 1e-12);
    assert_true(nqm_model_jod(model, -1, NULL, NULL) > nqm_model_jod(model, 1, NULL, NULL));
    nqm_model_free(model);
    nqm_model_free(NULL);
}

/* The outputs are added to the targets of the estimated label, raised to the floor. */
static void correction_of_an_estimate(void **state) {
    (void)state;
    struct nqm_model *model = make_model();
    const nqm_label estimate = {.delta_e = 3, .shift = {1, -2, 0.5}, .contrast = 0.1, .structure = 2};
    const nqm_label equal = {.delta_e = 0};
    double delta_e, base[1 + NQM_LABEL_PARTS];
    model->output = (nqm_output_range){.mean = 0.25, .std = 0.5, .lo = -1, .hi = 1};
    assert_near(nqm_model_jod(model, 0, &estimate, &delta_e), nqm_curve_jod(&model->curve, 3 * exp(0.25)), 1e-12);
    assert_relative(delta_e, 3 * exp(0.25), 1e-14);
    (void)nqm_model_jod(model, 1e9, &estimate, &delta_e);
    assert_relative(delta_e, 3 * exp(0.25 + 0.5), 1e-14);
    (void)nqm_model_jod(model, 0, &equal, &delta_e);
    assert_relative(delta_e, 0.05 * exp(0.25), 1e-14);
    nqm_estimate_targets(&estimate, base);
    const double expected[] = {log(3), asinh(1), asinh(-2), asinh(0.5), asinh(3), log(2)};
    for (size_t i = 0; i < 1 + NQM_LABEL_PARTS; ++i)
        assert_near(base[i], expected[i], 1e-15);
    nqm_estimate_targets(NULL, base);
    for (size_t i = 0; i < 1 + NQM_LABEL_PARTS; ++i)
        assert_true(base[i] == 0);
    for (size_t i = 0; i < NQM_LABEL_PARTS; ++i)
        model->parts[i] = (nqm_output_range){.std = 1, .lo = -1, .hi = 1};
    const nqm_label same = nqm_model_label(model, (const float[1 + NQM_LABEL_PARTS]){0}, &estimate);
    assert_true(same.error == 0); /* a prediction */
    assert_relative(same.delta_e, 3 * exp(0.25), 1e-14);
    for (size_t i = 0; i < 3; ++i)
        assert_near(same.shift[i], estimate.shift[i], 1e-14);
    assert_near(same.contrast, 0.1, 1e-14);
    assert_near(same.structure, 2, 1e-14);
    nqm_model_free(model);
}

TEST(with_scalar_features) {
    with_scalars = true;
    round_trip(state);
    each_tensor_is_checked(state);
    each_text_is_checked(state);
    impossible_numbers(state);
}

TEST(with_scalar_features_and_transport) {
    with_scalars = with_transport = true;
    round_trip(state);
    unaligned_bytes(state);
    weights_in_half(state);
    each_tensor_is_checked(state);
    each_text_is_checked(state);
    impossible_numbers(state);
    impossible_transport(state);
    out_of_memory(state);
    correction_of_an_estimate(state);
}

TEST(transport_without_a_network) {
    with_transport = true;
    with_network = with_scalars = false;
    round_trip(state);
    damage(state);
    impossible_transport(state);
    each_tensor_is_checked(state);
    out_of_memory(state);
    neither_network_nor_transport(state);
}

TEST(numbers_of_points) {
    with_transport = true;
    with_network = with_scalars = false;
    for (n_points = 32; n_points <= MAX_POINTS; n_points *= 3) {
        round_trip(state);
        each_tensor_is_checked(state);
        impossible_shapes(state);
    }
}
