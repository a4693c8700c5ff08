/* SPDX-License-Identifier: MIT
 *
 * raster_decoders.h - what raster.c and the decoders of its formats share.
 */
#ifndef NQM_SRC_IO_RASTER_DECODERS_H
#define NQM_SRC_IO_RASTER_DECODERS_H

#include "io/io.h"
#include "io/raster.h"

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
