/* SPDX-License-Identifier: MIT
 *
 * What a file is that a reader does not accept, from its first bytes, for messages.
 */
#include "io/io.h"

#include <string.h>

/* Files that begin with these bytes. */
static const struct {
    size_t n;
    const char *bytes, *kind;
} signatures[] = {
    {8, "SCATFUN\x01", "a Fourier BSDF of pbrt or Mitsuba"},
    {16, "NVIDIA ARC MBSDF", "a measured BSDF of NVIDIA MDL"},
    {11, "tensor_file", "an RGL tensor file"},
    {6, "\x93NUMPY", "an array of NumPy"},
    {4, "\x76\x2f\x31\x01", "an OpenEXR picture"},
    {10, "#?RADIANCE", "a Radiance HDR picture"},
    {6, "#?RGBE", "a Radiance HDR picture"},
    {4, "\x89PNG", "a PNG picture"},
    {3, "\xff\xd8\xff", "a JPEG picture"},
    {4, "II*\0", "a TIFF picture"},
    {4, "MM\0*", "a TIFF picture"},
    {12, "\xabKTX 20\xbb\r\n\x1a\n", "a KTX2 picture"},
    {12, "\xabKTX 11\xbb\r\n\x1a\n", "a KTX picture"},
    {8, "DDS |\0\0\0", "a DDS picture"},
    {4, "GIF8", "a GIF picture"},
    {4, "sB\x13\0", "a Basis Universal picture"},
    {4, "8BPS", "a Photoshop picture"},
    {8, "\0\0\0\x0cjP  ", "a JPEG 2000 picture"},
    {4, "ply\n", "a PLY mesh"},
    {5, "ply\r\n", "a PLY mesh"},
    {4, "glTF", "a binary glTF file"},
    {4, "PK\x03\x04", "a zip archive"},
    {2, "\x1f\x8b", "a gzip file: unpack it first"},
    {3, "BZh", "a bzip2 file: unpack it first"},
    {6, "\xfd\x37zXZ\0", "an xz file: unpack it first"},
    {8, "\x89HDF\r\n\x1a\n", "an HDF5 file"},
    {10, "MATLAB 5.0", "a MATLAB file"},
    {10, "MATLAB 7.3", "a MATLAB 7.3 file: save it with '-v7'"},
    {5, "%PDF-", "a PDF document"},
    {4, "\x7f\x45LF", "a program"},
    {2, "\x80\x04", "a Python pickle"},
    {4, "\x80\x02\x8a\n", "a PyTorch file: save the weights as .npy files"},
    {24, "version https://git-lfs.", "a pointer of Git LFS in place of the file: git lfs pull"},
};

/* Pictures in containers that also have other content, whose kind is at byte 8. */
static const char *kind_in_container(const unsigned char *data, size_t n) {
    if (n >= 12 && memcmp(data, "RIFF", 4) == 0 && memcmp(data + 8, "WEBP", 4) == 0)
        return "a WebP picture";
    if (n >= 12 && memcmp(data + 4, "ftypavif", 8) == 0)
        return "an AVIF picture";
    return n >= 12 && memcmp(data + 4, "ftyphei", 7) == 0 ? "an HEIC picture" : NULL;
}

enum { HEAD = 2048 };

/* The first word of a line of `text` is one of these, which end with NULL. Comments are skipped; `any`: in any line, otherwise
 * in the first one. */
static bool line_begins(const char *text, const char *const *words, bool any) {
    while (*text) {
        text += strspn(text, " \t\r\n");
        const size_t n_line = strcspn(text, "\n"), n_word = strcspn(text, " \t\r\n");
        const bool skipped = *text == '#';
        for (size_t i = 0; !skipped && words[i]; ++i)
            if (strlen(words[i]) == n_word && memcmp(text, words[i], n_word) == 0)
                return true;
        if (!skipped && !any)
            return false;
        text += n_line;
    }
    return false;
}

/* Separators of columns in the first n characters; a comma before a space is taken for prose. */
static size_t count_separators(const char *text, size_t n) {
    size_t count = 0;
    for (size_t i = 0; i < n; ++i)
        count += ((text[i] == ',' || text[i] == ';') && text[i + 1] != ' ' && text[i + 1] != '\n') || text[i] == '\t';
    return count;
}

/* The first two lines after comments have the same number of separators, at least one. */
static bool has_columns(const char *text) {
    while (*text == '#' || *text == '\n' || *text == '\r') {
        text += strcspn(text, "\n");
        text += *text == '\n';
    }
    const size_t n_first = strcspn(text, "\n"), count = count_separators(text, n_first);
    const char *second = text + n_first + (text[n_first] == '\n');
    return count && (!*second || count_separators(second, strcspn(second, "\n")) == count);
}

/* `text`: the beginning of a file that contains no control character. */
static const char *kind_of_text(const char *text) {
    static const char *const scatter[] = {"Symmetry", "SpectralContent", "ScatterType", NULL};
    static const char *const obj[] = {"v", "vn", "vt", "f", "o", "g", "mtllib", "usemtl", NULL};
    static const char *const html[] = {"<!DOCTYPE", "<!doctype", "<html>", "<html", NULL};
    text += strspn(text, " \t\r\n");
    if (line_begins(text, scatter, true))
        return "a BSDF table of Zemax or LightTools";
    if (line_begins(text, obj, false))
        return "an OBJ mesh";
    if (line_begins(text, html, false))
        return "an HTML page, perhaps of a failed download";
    if (strstr(text, "<WindowElement"))
        return "a window BSDF (XML): write f_r as CSV, for example with Radiance's bsdfquery";
    if (*text == '<')
        return "an XML document";
    if (*text == '{' || *text == '[')
        return "JSON";
    return has_columns(text) ? "CSV" : "text";
}

const char *nqm_file_kind(const unsigned char *data, size_t n_bytes) {
    char text[HEAD];
    size_t n = nqm_smaller(n_bytes, HEAD - 1);
    for (size_t i = 0; i < sizeof signatures / sizeof *signatures; ++i)
        if (n >= signatures[i].n && memcmp(data, signatures[i].bytes, signatures[i].n) == 0)
            return signatures[i].kind;
    if (kind_in_container(data, n))
        return kind_in_container(data, n);
    if (n > 9 && data[8] == '{' && nqm_load_u64(data) < ((uint64_t)1 << 40))
        return "a safetensors file";
    for (size_t i = 0; i < n; ++i)
        if ((data[i] < ' ' && !(data[i] >= '\t' && data[i] <= '\r')) || data[i] == 0x7f)
            return memcmp(data, "BM", nqm_smaller(n, 2)) == 0 ? "a BMP picture" : NULL;
    if (n == 0)
        return NULL;
    memcpy(text, data, n);
    text[n] = '\0';
    return kind_of_text(memcmp(text, "\xef\xbb\xbf", nqm_smaller(n, 3)) == 0 ? text + nqm_smaller(n, 3) : text);
}
