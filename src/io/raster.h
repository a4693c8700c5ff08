/* SPDX-License-Identifier: MIT
 *
 * raster.h - pictures as they are stored, for maps of materials: PNG, JPEG, WebP and OpenEXR, with the values of the file and no colour
 * conversion. Light maps and other pictures of radiance are nqm_image (io.h).
 */
#ifndef NQM_SRC_IO_RASTER_H
#define NQM_SRC_IO_RASTER_H

#include "base/base.h"

typedef enum nqm_raster_type { NQM_RASTER_U8, NQM_RASTER_U16, NQM_RASTER_F32 } nqm_raster_type;

/** A picture. Free with nqm_raster_clear(). */
typedef struct nqm_raster {
    size_t width, height;
    size_t channels; /**< 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha */
    nqm_raster_type type;
    size_t n_counted; /**< bytes of `data` that count for NQM_RASTER_MAX_BYTES */
    void *data; /**< (height, width, channels), first row on top; integers stand for value / 255 or value / 65535 */
} nqm_raster;

enum { NQM_RASTER_MAX_SIDE = 16384 };
/** All decoded pictures that a process holds at a time: 3 GiB, of 32 bits 1 GiB. Small files may say that they are large pictures. */
#define NQM_RASTER_MAX_BYTES ((uint64_t)(SIZE_MAX > UINT32_MAX ? 3 : 1) << 30)

/** Decode a picture of any of these formats, which is recognised by its first bytes; palettes become RGB, grey pictures
 *  of fewer than 8 bits 8 bits. `name` is for messages. Other formats of pictures (KTX2, DDS, ...) are named in
 *  the message. NQM_ERR_FORMAT, NQM_ERR_LIMIT (a side above NQM_RASTER_MAX_SIDE, or all above
 *  NQM_RASTER_MAX_BYTES), NQM_ERR_NOMEM; raster_ret is empty then. */
NQM_MUST_CHECK nqm_status nqm_raster_decode(const unsigned char *data, size_t n_bytes, const char *name,
                                            nqm_raster *raster_ret, nqm_error *err);
/** Width and height from the header, without decoding. */
NQM_MUST_CHECK nqm_status nqm_raster_size(const unsigned char *data, size_t n_bytes, const char *name,
                                          size_t *width_ret, size_t *height_ret, nqm_error *err);
/** Write 8-bit RGB, or RGB and alpha, as PNG; is_srgb: the file says that the colours are sRGB. The file is complete at
 *  once (set NULL), or when the set is committed. */
NQM_MUST_CHECK nqm_status nqm_raster_write_png(const char *path, const nqm_raster *raster, bool is_srgb,
                                               nqm_outset *set, nqm_error *err);
/** A value from 0 to 1 as a byte. */
static inline unsigned char nqm_unit_byte(double v) {
    return (unsigned char)((v > 0 ? v < 1 ? v : 1 : 0) * 255 + 0.5);
}
/** Free the pixels; a zeroed raster is allowed. */
void nqm_raster_clear(nqm_raster *raster);

/* ---- decoders of the formats ------------------------------------------------------------------------------------- */

/** Deflate expands one byte to at most this many. */
enum { NQM_DEFLATE_MAX = 1032 };

/** Decode one format; header_only: everything but the pixels. The caller clears a zeroed `raster` after a failure. Thread-safe. */
typedef nqm_status nqm_raster_decoder(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err);
nqm_raster_decoder nqm_raster_decode_png, nqm_raster_decode_jpeg, nqm_raster_decode_webp, nqm_raster_decode_exr;

/** Check the size of a picture whose other members are set, and, unless header_only, allocate its pixels. per_byte: the
 *  pixels that a byte of the file can store at most. */
NQM_MUST_CHECK nqm_status nqm_raster_begin(const nqm_map *map, double per_byte, bool header_only, nqm_raster *raster,
                                           nqm_error *err);

#endif
