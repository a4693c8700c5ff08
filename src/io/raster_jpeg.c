/* SPDX-License-Identifier: MIT
 *
 * JPEG pictures with libjpeg-turbo: grey or RGB, 8 bits. Damaged data are refused, which libjpeg would replace by grey.
 */
#include "io/raster.h"

#include <jpeglib.h>

#include <jerror.h>
#include <setjmp.h>

/* A block of 8 x 8 values takes at least one bit with Huffman codes; arithmetic codes have no such bound. */
static const double max_pixels_per_byte = 8 * 64;

/* libjpeg goes through all coefficients once in every scan. Encoders write 10; each of 3 components has 64
 * coefficients, most of which share a scan. */
enum { MAX_SCANS = 100 };

typedef struct jpeg_input {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_progress_mgr progress;
    jmp_buf failed;
    char message[JMSG_LENGTH_MAX];
    const nqm_map *map;
    bool header_only;
    nqm_raster *raster;
    nqm_status status;
    nqm_error *err;
} jpeg_input;

static void on_error(j_common_ptr jpeg) {
    jpeg_input *input = jpeg->client_data;
    jpeg->err->format_message(jpeg, input->message);
    longjmp(input->failed, 1);
}

/* Called for traces and warnings, which are not printed. These warnings mean that pixels are lost. */
static void on_message(j_common_ptr jpeg, int level) {
    static const int damage[] = {JWRN_JPEG_EOF, JWRN_HIT_MARKER, JWRN_HUFF_BAD_CODE, JWRN_NOT_SEQUENTIAL,
                                 JWRN_MUST_RESYNC};
    for (size_t i = 0; level < 0 && i < sizeof damage / sizeof *damage; ++i)
        if (jpeg->err->msg_code == damage[i])
            on_error(jpeg);
}

static void on_print(j_common_ptr jpeg) {
    (void)jpeg;
}

static void on_progress(j_common_ptr jpeg) {
    jpeg_input *input = jpeg->client_data;
    if (input->jpeg.input_scan_number <= MAX_SCANS)
        return;
    snprintf(input->message, sizeof input->message, "more than %d scans; save it again", MAX_SCANS);
    longjmp(input->failed, 1);
}

static nqm_status fail_jpeg(const jpeg_input *input, const char *what) {
    const struct jpeg_source_mgr *source = input->jpeg.src;
    const size_t byte = input->map->n_bytes - (source ? source->bytes_in_buffer : 0);
    return nqm_fail(input->err, NQM_ERR_FORMAT, (int64_t)byte, "%s: JPEG at byte %zu: %s", input->map->path, byte,
                    what);
}

static nqm_status read_header(jpeg_input *input) {
    struct jpeg_decompress_struct *jpeg = &input->jpeg;
    nqm_raster *raster = input->raster;
    (void)jpeg_read_header(jpeg, TRUE);
    if (jpeg->arith_code)
        return fail_jpeg(input, "arithmetic coding is not read: save it with Huffman coding");
    if (jpeg->num_components != 1 && jpeg->num_components != 3)
        return fail_jpeg(input, jpeg->num_components == 4 ? "CMYK colours are not read: convert it to RGB"
                                                          : "it is neither grey nor RGB: convert it to RGB");
    *raster = (nqm_raster){.width = jpeg->image_width,
                           .height = jpeg->image_height,
                           .channels = (size_t)jpeg->num_components,
                           .type = NQM_RASTER_U8};
    return nqm_raster_begin(input->map, max_pixels_per_byte, input->header_only, raster, input->err);
}

/* All calls that libjpeg may leave by longjmp(). Values that are needed after the jump are members of `input`. */
static void read_jpeg(jpeg_input *input) {
    struct jpeg_decompress_struct *jpeg = &input->jpeg;
    const nqm_raster *raster = input->raster;
    if (setjmp(input->failed)) {
        input->status = fail_jpeg(input, input->message);
        return;
    }
    jpeg_create_decompress(jpeg);
    jpeg->progress = &input->progress;
    jpeg_mem_src(jpeg, input->map->data, input->map->n_bytes);
    input->status = read_header(input);
    if (input->status != NQM_OK || input->header_only)
        return;
    jpeg->out_color_space = raster->channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    (void)jpeg_start_decompress(jpeg);
    while (jpeg->output_scanline < jpeg->output_height) {
        JSAMPROW row = (JSAMPROW)raster->data + jpeg->output_scanline * raster->width * raster->channels;
        (void)jpeg_read_scanlines(jpeg, &row, 1);
    }
    (void)jpeg_finish_decompress(jpeg);
}

nqm_status nqm_raster_decode_jpeg(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    jpeg_input input = {.map = map, .header_only = header_only, .raster = raster, .err = err};
    input.jpeg.err = jpeg_std_error(&input.errors);
    input.jpeg.client_data = &input;
    input.errors.error_exit = on_error;
    input.errors.emit_message = on_message;
    input.errors.output_message = on_print;
    input.progress.progress_monitor = on_progress;
    read_jpeg(&input);
    jpeg_destroy_decompress(&input.jpeg);
    return input.status;
}
