/* SPDX-License-Identifier: MIT
 *
 * OpenEXR pictures with OpenEXRCore. Reading: the first part; scanlines, or tiles of the finest level; channels R, G and B,
 * or Y, each with A or without; half or float. The picture is the data window. Deep pictures and subsampled channels are refused.
 * Writing: one part of scanlines; R, G and B as float; ZIP compression.
 */
#include "io/io.h"
#include "io/raster.h"

#include <openexr.h>
#include <stdlib.h>
#include <string.h>

/* A pixel has at least two bytes. */
static const double max_pixels_per_byte = NQM_DEFLATE_MAX / 2;

enum { MAX_ALLOCATION = 256 << 20 };

/* A file that is read, or written. */
typedef struct exr_file {
    const char *path;
    const nqm_map *map;
    nqm_outfile out;
    exr_context_t context;
    size_t row;        /* row that is being read, from 1; 0: none */
    char message[200]; /* last error message of OpenEXRCore */
    nqm_error *err;
} exr_file;

static nqm_status fail_exr(exr_file *file, nqm_status status, const char *what) {
    char row[40] = "";
    if (file->row)
        snprintf(row, sizeof row, "row %zu: ", file->row);
    return nqm_fail(file->err, status, -1, "%s: OpenEXR: %s%s%s%s", file->path, row, what, file->message[0] ? ": " : "",
                    file->message);
}

static nqm_status refuse(exr_file *file, const char *what) {
    return fail_exr(file, NQM_ERR_FORMAT, what);
}

static bool good(exr_result_t result) {
    return result == EXR_ERR_SUCCESS;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *message) {
    void *user = NULL;
    (void)code;
    if (!context || !good(exr_get_user_data(context, &user)) || !user)
        return;
    /* OpenEXRCore puts the path at the start of its messages, and fail_exr() adds it too: remove one. */
    exr_file *file = user;
    size_t n = strlen(file->path);
    if (strncmp(message, file->path, n) == 0)
        message += n + strspn(message + n, "': ");
    snprintf(file->message, sizeof file->message, "%s", message);
}

/* Where a picture with `channels` channels stores the channel of this name; SIZE_MAX: nowhere. Four channels are
 * decoded in an order that OpenEXRCore leaves to its general loop, and restore_order() follows: its fast loops for four
 * channels of half, in the order of the file and in the reverse, store them the wrong way round (3.1.5). */
static size_t find_channel(const char *name, size_t channels) {
    static const char *const names[] = {"", "Y", "YA", "RGB", "GRBA"};
    const char *place = strlen(name) == 1 ? strchr(names[channels], *name) : NULL;
    return place ? (size_t)(place - names[channels]) : SIZE_MAX;
}

/* Describe channel k of the pixel at `first` and those after it to a pipeline. */
static void set_channel(exr_coding_channel_info_t *channel, const nqm_raster *raster, size_t first, size_t k) {
    const size_t n = raster->channels;
    channel->decode_to_ptr =
        (uint8_t *)((float *)raster->data + n * first + k); /* shares a union with encode_from_ptr */
    channel->user_bytes_per_element = sizeof(float);
    channel->user_data_type = EXR_PIXEL_FLOAT;
    channel->user_pixel_stride = (int32_t)(n * sizeof(float));
    channel->user_line_stride = (int32_t)(n * sizeof(float) * raster->width);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* Returns fewer than n bytes at the end of the file, as pread() does, because OpenEXRCore reads ahead. */
static int64_t on_read(exr_const_context_t context, void *user, void *buffer, uint64_t n, uint64_t offset,
                       exr_stream_error_func_ptr_t error_fn) {
    (void)context;
    (void)error_fn;
    const nqm_map *map = ((exr_file *)user)->map;
    if (offset >= map->n_bytes)
        return 0;
    if (n > map->n_bytes - offset)
        n = map->n_bytes - offset;
    memcpy(buffer, map->data + offset, (size_t)n);
    return (int64_t)n;
}

static int64_t on_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((exr_file *)user)->map->n_bytes;
}

/* OpenEXRCore accepts a compressed chunk that ends early and leaves the rest of its buffer as it was. Filled with NaN,
 * missing pixels are refused as not finite instead of being whatever the memory held. */
static void *limited_malloc(size_t n) {
    void *block = n <= MAX_ALLOCATION ? malloc(n) : NULL;
    return block ? memset(block, 0xff, n) : NULL;
}

/* Set the number of channels that are read: 1 Y, 2 with A, 3 R, G and B, 4 with A. */
static nqm_status choose_channels(exr_file *file, nqm_raster *raster) {
    const exr_attr_chlist_t *list;
    if (!good(exr_get_channels(file->context, 0, &list)))
        return refuse(file, "the header is damaged");
    unsigned found = 0;
    for (int i = 0; i < list->num_channels; ++i) {
        const exr_attr_chlist_entry_t *channel = &list->entries[i];
        const char *place = channel->name.length == 1 ? strchr("RGBAY", channel->name.str[0]) : NULL;
        if (!place)
            continue;
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            return refuse(file, "subsampled channels are not read");
        if (channel->pixel_type == EXR_PIXEL_UINT)
            return refuse(file, "channels of integers are not read");
        found |= 1u << (place - "RGBAY");
    }
    const bool has_alpha = found & 8;
    raster->channels = has_alpha + ((found & 7) == 7 ? 3u : 1u);
    raster->type = NQM_RASTER_F32;
    return (found & 7) == 7 || found >> 4 ? NQM_OK : refuse(file, "the channels are neither R, G, B nor Y");
}

static nqm_status decode_chunk(exr_file *file, exr_chunk_info_t *chunk, const exr_attr_box2i_t *window,
                               const nqm_raster *raster) {
    int64_t x = (int64_t)chunk->start_x, y = (int64_t)chunk->start_y;
    if (chunk->type == EXR_STORAGE_SCANLINE) { /* absolute position; tiles: relative to the data window */
        x -= window->min.x;
        y -= window->min.y;
    }
    bool inside = x >= 0 && y >= 0 && chunk->width >= 0 && chunk->height >= 0 &&
                  x + chunk->width <= (int64_t)raster->width && y + chunk->height <= (int64_t)raster->height;
    if (!inside)
        return refuse(file, "a chunk extends beyond the data window");
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    if (!good(exr_decoding_initialize(file->context, 0, chunk, &pipeline)))
        return refuse(file, "a chunk cannot be read");
    for (int i = 0; i < pipeline.channel_count; ++i) {
        const size_t k = find_channel(pipeline.channels[i].channel_name, raster->channels);
        if (k != SIZE_MAX)
            set_channel(&pipeline.channels[i], raster, (size_t)y * raster->width + (size_t)x, k);
    }
    nqm_status status = NQM_OK;
    if (!good(exr_decoding_choose_default_routines(file->context, 0, &pipeline)) ||
        !good(exr_decoding_run(file->context, 0, &pipeline)))
        status = refuse(file, "a chunk is damaged");
    exr_decoding_destroy(file->context, &pipeline);
    return status;
}

static nqm_status read_scanlines(exr_file *file, const exr_attr_box2i_t *window, const nqm_raster *raster) {
    int32_t n_lines;
    nqm_status status = NQM_OK;
    if (!good(exr_get_scanlines_per_chunk(file->context, 0, &n_lines)) || n_lines < 1)
        return refuse(file, "the chunks have no height");
    for (int64_t y = window->min.y; status == NQM_OK && y <= window->max.y; y += n_lines) {
        exr_chunk_info_t chunk;
        file->row = (size_t)(y - window->min.y) + 1;
        if (!good(exr_read_scanline_chunk_info(file->context, 0, (int)y, &chunk)))
            return refuse(file, "a chunk is missing or damaged");
        status = decode_chunk(file, &chunk, window, raster);
    }
    return status;
}

static nqm_status read_tiles(exr_file *file, const exr_attr_box2i_t *window, const nqm_raster *raster) {
    uint32_t tile_width, tile_height;
    exr_tile_level_mode_t level;
    exr_tile_round_mode_t round;
    if (!good(exr_get_tile_descriptor(file->context, 0, &tile_width, &tile_height, &level, &round)) || tile_width < 1 ||
        tile_height < 1)
        return refuse(file, "the tiles have no size");
    nqm_status status = NQM_OK;
    for (size_t y = 0; status == NQM_OK && y * tile_height < raster->height; ++y)
        for (size_t x = 0; status == NQM_OK && x * tile_width < raster->width; ++x) {
            exr_chunk_info_t chunk;
            file->row = y * tile_height + 1;
            if (!good(exr_read_tile_chunk_info(file->context, 0, (int)x, (int)y, 0, 0, &chunk)))
                return refuse(file, "a tile is missing or damaged");
            chunk.start_x = (int32_t)(x * tile_width);
            chunk.start_y = (int32_t)(y * tile_height);
            status = decode_chunk(file, &chunk, window, raster);
        }
    return status;
}

/* G, R, B, A to R, G, B, A. */
static void restore_order(nqm_raster *raster) {
    float *pixel = raster->data;
    for (size_t i = 0; i < raster->width * raster->height; ++i, pixel += 4) {
        const float green = pixel[0];
        pixel[0] = pixel[1];
        pixel[1] = green;
    }
}

static nqm_status read_picture(exr_file *file, bool header_only, nqm_raster *raster) {
    exr_storage_t storage;
    exr_attr_box2i_t window;
    if (!good(exr_get_storage(file->context, 0, &storage)) || !good(exr_get_data_window(file->context, 0, &window)))
        return refuse(file, "the header is damaged");
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return refuse(file, "deep pictures are not read");
    int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    if (width < 1 || height < 1)
        return refuse(file, "the data window is empty");
    raster->width = (size_t)width;
    raster->height = (size_t)height;
    nqm_status status = choose_channels(file, raster);
    if (status == NQM_OK)
        status = nqm_raster_begin(file->map, max_pixels_per_byte, header_only, raster, file->err);
    if (status != NQM_OK || header_only)
        return status;
    status =
        storage == EXR_STORAGE_SCANLINE ? read_scanlines(file, &window, raster) : read_tiles(file, &window, raster);
    if (raster->channels == 4)
        restore_order(raster);
    return status;
}

nqm_status nqm_raster_decode_exr(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    exr_file file = {.path = map->path, .map = map, .err = err};
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = on_error;
    start.alloc_fn = limited_malloc;
    start.free_fn = free;
    start.user_data = &file;
    start.read_fn = on_read;
    start.size_fn = on_size;
    start.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    if (!good(exr_start_read(&file.context, map->path, &start)))
        return refuse(&file, "the header is damaged");
    nqm_status status = read_picture(&file, header_only, raster);
    exr_finish(&file.context);
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static int64_t on_write(exr_const_context_t context, void *user, const void *buffer, uint64_t n, uint64_t offset,
                        exr_stream_error_func_ptr_t error_fn) {
    (void)context;
    (void)error_fn;
    FILE *stream = ((exr_file *)user)->out.stream;
    if (fseek(stream, (long)offset, SEEK_SET) != 0 || fwrite(buffer, 1, n, stream) != n)
        return -1;
    return (int64_t)n;
}

static bool write_header(exr_file *o, const nqm_raster *raster) {
    static const char *const names[] = {"B", "G", "R"};
    int part;
    /* whiteLuminance is a standard attribute: the luminance of the colour (1, 1, 1) in cd/m2. */
    bool ok = good(exr_add_part(o->context, NULL, EXR_STORAGE_SCANLINE, &part)) &&
              good(exr_initialize_required_attr_simple(o->context, part, (int32_t)raster->width,
                                                       (int32_t)raster->height, EXR_COMPRESSION_ZIP)) &&
              good(exr_attr_set_float(o->context, part, "whiteLuminance", 1.0f));
    for (int k = 0; ok && k < 3; ++k)
        ok = good(exr_add_channel(o->context, part, names[k], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    return ok && good(exr_write_header(o->context));
}

static bool write_chunks(exr_file *o, const nqm_raster *raster) {
    int32_t n_lines = 0;
    bool ok = good(exr_get_scanlines_per_chunk(o->context, 0, &n_lines)) && n_lines > 0;
    for (int32_t y = 0; ok && y < (int32_t)raster->height; y += n_lines) {
        exr_chunk_info_t chunk;
        exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
        if (!good(exr_write_scanline_chunk_info(o->context, 0, y, &chunk)) ||
            !good(exr_encoding_initialize(o->context, 0, &chunk, &pipeline)))
            return false;
        for (int i = 0; i < pipeline.channel_count; ++i) {
            exr_coding_channel_info_t *channel = &pipeline.channels[i];
            set_channel(channel, raster, (size_t)y * raster->width, find_channel(channel->channel_name, 3));
        }
        ok = good(exr_encoding_choose_default_routines(o->context, 0, &pipeline)) &&
             good(exr_encoding_run(o->context, 0, &pipeline));
        ok = good(exr_encoding_destroy(o->context, &pipeline)) && ok;
    }
    return ok;
}

nqm_status nqm_image_write_exr(const char *path, const nqm_image *image, nqm_error *err) {
    exr_file o = {.path = path, .err = err};
    const nqm_raster raster = {
        .width = image->width, .height = image->height, .channels = 3, .type = NQM_RASTER_F32, .data = image->rgb};
    nqm_status status = nqm_outfile_open(path, &o.out, err);
    if (status != NQM_OK)
        return status;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = on_error;
    start.user_data = &o;
    start.write_fn = on_write;
    bool ok = good(exr_start_write(&o.context, path, EXR_WRITE_FILE_DIRECTLY, &start));
    ok = ok && write_header(&o, &raster) && write_chunks(&o, &raster);
    if (o.context)
        ok = good(exr_finish(&o.context)) && ok;
    if (ok)
        return nqm_outfile_commit(&o.out, err);
    nqm_outfile_abort(&o.out);
    return fail_exr(&o, NQM_ERR_IO, "cannot write");
}
