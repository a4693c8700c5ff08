#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Write glyphs.h: the outlines of the characters that figures are lettered with, from a TrueType font.

    python3 glyphs.py /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf > glyphs.h

Outlines in the library make figures the same on every machine, whatever fonts it has.
"""
import struct
import sys

CHARACTERS = [chr(c) for c in range(0x20, 0x7F)] + list("\u00b0\u00b2\u00b7\u00d7\u0394\u03b8\u03c6\u2013\u2212\u2264\u2265")

font = open(sys.argv[1], "rb").read()
tables = {}
for i in range(struct.unpack(">H", font[4:6])[0]):
    tag, _, offset, length = struct.unpack(">4sIII", font[12 + 16 * i : 28 + 16 * i])
    tables[tag.decode()] = font[offset : offset + length]
units, = struct.unpack(">H", tables["head"][18:20])
long_loca, = struct.unpack(">h", tables["head"][50:52])
n_metrics, = struct.unpack(">H", tables["hhea"][34:36])
assert long_loca == 1
loca = struct.unpack(f">{len(tables['loca']) // 4}I", tables["loca"])


def character_map():
    """Code point to glyph, from the format 4 subtable of Windows Unicode."""
    cmap = tables["cmap"]
    for i in range(struct.unpack(">H", cmap[2:4])[0]):
        platform, encoding, offset = struct.unpack(">HHI", cmap[4 + 8 * i : 12 + 8 * i])
        if (platform, encoding) == (3, 1):
            sub = cmap[offset:]
    assert struct.unpack(">H", sub[:2])[0] == 4
    n = struct.unpack(">H", sub[6:8])[0] // 2
    column = lambda k, f: struct.unpack(f">{n}{f}", sub[k : k + 2 * n])
    ends, starts = column(14, "H"), column(16 + 2 * n, "H")
    deltas, offsets = column(16 + 4 * n, "h"), column(16 + 6 * n, "H")
    result = {}
    for i in range(n):
        for code in range(starts[i], ends[i] + 1):
            glyph = code
            if offsets[i]:
                at = 16 + 6 * n + 2 * i + offsets[i] + 2 * (code - starts[i])
                if at + 2 > len(sub):
                    continue
                glyph, = struct.unpack(">H", sub[at : at + 2])
            result[code] = (glyph + deltas[i]) & 0xFFFF
    return result


def outline(glyph):
    """Contours as lists of (x, y, on_curve)."""
    data = tables["glyf"][loca[glyph] : loca[glyph + 1]]
    if not data:
        return []
    n_contours, = struct.unpack(">h", data[:2])
    return composite(data) if n_contours < 0 else simple(data, n_contours)


def composite(data):
    at, contours, more = 10, [], True
    while more:
        flags, part = struct.unpack(">HH", data[at : at + 4])
        assert flags & 2 and not flags & 0xC8, "only plain shifts occur"
        dx, dy = struct.unpack(">hh" if flags & 1 else ">bb", data[at + 4 : at + (8 if flags & 1 else 6)])
        contours += [[(x + dx, y + dy, on) for x, y, on in c] for c in outline(part)]
        at += 8 if flags & 1 else 6
        more = flags & 0x20
    return contours


def simple(data, n_contours):
    ends = struct.unpack(f">{n_contours}H", data[10 : 10 + 2 * n_contours])
    at = 10 + 2 * n_contours
    at += 2 + struct.unpack(">H", data[at : at + 2])[0]
    flags = []
    while len(flags) <= ends[-1]:
        flag, repeat = data[at], 1
        at += 1
        if flag & 8:
            repeat += data[at]
            at += 1
        flags += [flag] * repeat
    axes = []
    for short, same in ((2, 16), (4, 32)):
        value, values = 0, []
        for flag in flags:
            if flag & short:
                value += data[at] if flag & same else -data[at]
                at += 1
            elif not flag & same:
                value += struct.unpack(">h", data[at : at + 2])[0]
                at += 2
            values.append(value)
        axes.append(values)
    points = [(x, y, f & 1) for x, y, f in zip(*axes, flags)]
    return [points[a:b] for a, b in zip([0] + [e + 1 for e in ends], [e + 1 for e in ends])]


mapping, numbers, rows = character_map(), [], []
for character in CHARACTERS:
    glyph = mapping[ord(character)]
    advance, = struct.unpack(">H", tables["hmtx"][4 * min(glyph, n_metrics - 1) :][:2])
    contours = outline(glyph)
    rows.append((ord(character), advance, len(numbers), len(contours)))
    for contour in contours:
        first = next(i for i, point in enumerate(contour) if point[2])
        contour = contour[first:] + contour[:first]
        numbers.append(len(contour))
        for x, y, on in contour:
            numbers += [2 * x + on, y]

print(f"""/* SPDX-License-Identifier: MIT AND Bitstream-Vera
 *
 * glyphs.h - outlines of {len(rows)} characters of DejaVu Sans, made by glyphs.py. DejaVu's changes to Bitstream Vera are
 * in the public domain. Copyright (c) 2003 by Bitstream, Inc. All Rights Reserved. Bitstream Vera is a trademark of
 * Bitstream, Inc. The licence of the outlines:
 *
 * Permission is hereby granted, free of charge, to any person obtaining a copy of the fonts accompanying this license
 * ("Fonts") and associated documentation files (the "Font Software"), to reproduce and distribute the Font Software,
 * including without limitation the rights to use, copy, merge, publish, distribute, and/or sell copies of the Font
 * Software, and to permit persons to whom the Font Software is furnished to do so, subject to the following
 * conditions:
 *
 * The above copyright and trademark notices and this permission notice shall be included in all copies of one or more
 * of the Font Software typefaces.
 *
 * The Font Software may be modified, altered, or added to, and in particular the designs of glyphs or characters in
 * the Fonts may be modified and additional glyphs or characters may be added to the Fonts, only if the fonts are
 * renamed to names not containing either the words "Bitstream" or the word "Vera".
 *
 * This License becomes null and void to the extent applicable to Fonts or Font Software that has been modified and is
 * distributed under the "Bitstream Vera" names.
 *
 * The Font Software may be sold as part of a larger software package but no copy of one or more of the Font Software
 * typefaces may be sold by itself.
 *
 * THE FONT SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED
 * TO ANY WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT OF COPYRIGHT, PATENT,
 * TRADEMARK, OR OTHER RIGHT. IN NO EVENT SHALL BITSTREAM OR THE GNOME FOUNDATION BE LIABLE FOR ANY CLAIM, DAMAGES OR
 * OTHER LIABILITY, INCLUDING ANY GENERAL, SPECIAL, INDIRECT, INCIDENTAL, OR CONSEQUENTIAL DAMAGES, WHETHER IN AN
 * ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF THE USE OR INABILITY TO USE THE FONT SOFTWARE OR FROM
 * OTHER DEALINGS IN THE FONT SOFTWARE.
 *
 * Except as contained in this notice, the names of Gnome, the Gnome Foundation, and Bitstream Inc., shall not be used
 * in advertising or otherwise to promote the sale, use or other dealings in this Font Software without prior written
 * authorization from the Gnome Foundation or Bitstream Inc., respectively. For further information, contact: fonts at
 * gnome dot org.
 */
#ifndef NQM_SRC_PLOT_GLYPHS_H
#define NQM_SRC_PLOT_GLYPHS_H

#include <stdint.h>

enum {{ GLYPH_UNITS = {units}, GLYPH_COUNT = {len(rows)} }};

/* Contours: the number of points, then x and y of each in 1/GLYPH_UNITS em, y up; x is doubled, plus 1 when the point lies on
 * the curve. Between two points off the curve lies one on it, half-way (TrueType). The first
 * point lies on the curve. */
static const int16_t glyph_outlines[] = {{
{", ".join(map(str, numbers))}}};

static const struct glyph {{
    uint32_t character; /* Unicode, rising */
    int16_t advance, first, n_contours;
}} glyphs[GLYPH_COUNT] = {{
{", ".join("{%d, %d, %d, %d}" % row for row in rows)}}};

#endif""")
