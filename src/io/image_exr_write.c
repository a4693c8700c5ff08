/* SPDX-License-Identifier: MIT
 *
 * Writes OpenEXR images with OpenEXRCore: one part of scanlines; R, G and B as float; ZIP compression.
 */
#include "io/io.h"

#include <openexr.h>
#include <string.h>

typedef struct exr_output {
    nqm_outfile out;
    const nqm_image *image;
    exr_context_t context;
    char message[200]; /* last error message of OpenEXRCore */
} exr_output;

static void on_error(exr_const_context_t context, exr_result_t code, const char *message) {
    void *user = NULL;
    (void)code;
    if (context && exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user)
        snprintf(((exr_output *)user)->message, sizeof((exr_output *)user)->message, "%s", message);
}

static int64_t on_write(exr_const_context_t context, void *user, const void *buffer, uint64_t n, uint64_t offset,
                        exr_stream_error_func_ptr_t error_fn) {
    (void)context;
    (void)error_fn;
    FILE *stream = ((exr_output *)user)->out.stream;
    if (fseek(stream, (long)offset, SEEK_SET) != 0 || fwrite(buffer, 1, n, stream) != n)
        return -1;
    return (int64_t)n;
}

static bool good(exr_result_t result) {
    return result == EXR_ERR_SUCCESS;
}

static bool write_header(exr_output *o) {
    int part;
    /* whiteLuminance is a standard attribute: the luminance of the colour (1, 1, 1) in cd/m2. */
    bool ok = good(exr_add_part(o->context, NULL, EXR_STORAGE_SCANLINE, &part)) &&
              good(exr_initialize_required_attr_simple(o->context, part, (int32_t)o->image->width,
                                                       (int32_t)o->image->height, EXR_COMPRESSION_ZIP)) &&
              good(exr_attr_set_float(o->context, part, "whiteLuminance", 1.0f));
    for (int k = 0; ok && k < 3; ++k)
        ok = good(exr_add_channel(o->context, part,
                                  k == 0   ? "B"
                                  : k == 1 ? "G"
                                           : "R",
                                  EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    return ok && good(exr_write_header(o->context));
}

static bool write_chunk(exr_output *o, exr_chunk_info_t *chunk, int32_t y) {
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    if (!good(exr_encoding_initialize(o->context, 0, chunk, &pipeline)))
        return false;
    for (int i = 0; i < pipeline.channel_count; ++i) {
        exr_coding_channel_info_t *channel = &pipeline.channels[i];
        size_t k = (size_t)(strchr("RGB", channel->channel_name[0]) - "RGB");
        channel->encode_from_ptr = (const uint8_t *)(o->image->rgb + 3 * (size_t)y * o->image->width + k);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 3 * sizeof(float);
        channel->user_line_stride = (int32_t)(3 * sizeof(float) * o->image->width);
    }
    bool ok = good(exr_encoding_choose_default_routines(o->context, 0, &pipeline)) &&
              good(exr_encoding_run(o->context, 0, &pipeline));
    return good(exr_encoding_destroy(o->context, &pipeline)) && ok;
}

static bool write_chunks(exr_output *o) {
    int32_t n_lines = 0;
    bool ok = good(exr_get_scanlines_per_chunk(o->context, 0, &n_lines)) && n_lines > 0;
    for (int32_t y = 0; ok && y < (int32_t)o->image->height; y += n_lines) {
        exr_chunk_info_t chunk;
        ok = good(exr_write_scanline_chunk_info(o->context, 0, y, &chunk)) && write_chunk(o, &chunk, y);
    }
    return ok;
}

nqm_status nqm_image_write_exr(const char *path, const nqm_image *image, nqm_error *err) {
    exr_output o = {.image = image};
    nqm_status status = nqm_outfile_open(path, &o.out, err);
    if (status != NQM_OK)
        return status;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = on_error;
    start.user_data = &o;
    start.write_fn = on_write;
    bool ok = good(exr_start_write(&o.context, path, EXR_WRITE_FILE_DIRECTLY, &start));
    ok = ok && write_header(&o) && write_chunks(&o);
    if (o.context)
        ok = good(exr_finish(&o.context)) && ok;
    if (ok)
        return nqm_outfile_commit(&o.out, err);
    nqm_outfile_abort(&o.out);
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write OpenEXR%s%s", path, o.message[0] ? ": " : "", o.message);
}
