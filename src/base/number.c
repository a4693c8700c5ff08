/* SPDX-License-Identifier: MIT
 *
 * Numbers in files. Text is converted in the "C" locale, which the calling thread uses during the conversion.
 */
#include "base/os.h"

#include <math.h>
#include <stdlib.h>

uint64_t nqm_load_integer(const unsigned char *p, size_t n_bytes, bool big_endian) {
    uint64_t bits = 0;
    for (size_t k = 0; k < n_bytes; ++k)
        bits = bits << 8 | p[big_endian ? k : n_bytes - 1 - k];
    return bits;
}

double nqm_load_number(const unsigned char *p, nqm_number_type type, bool big_endian) {
    const uint64_t bits = nqm_load_integer(p, type.n_bytes, big_endian);
    const int n_unused = 64 - 8 * type.n_bytes;
    unsigned char little[8];
    nqm_store_u64(little, bits);
    if (type.kind == 'f')
        return type.n_bytes == 8 ? nqm_load_f64(little) : (double)nqm_load_f32(little);
    return type.kind == 'i' ? (double)((int64_t)(bits << n_unused) >> n_unused) : (double)bits;
}

void nqm_write_values(FILE *stream, size_t n, size_t n_each, const void *values) {
    unsigned char little[8];
    if (!NQM_BIG_ENDIAN)
        fwrite(values, n_each, n, stream);
    for (size_t i = 0; NQM_BIG_ENDIAN && i < n; ++i) {
        nqm_copy_little_endian(1, n_each, (const unsigned char *)values + i * n_each, little);
        fwrite(little, 1, n_each, stream);
    }
}

void nqm_sha256_add_values(nqm_sha256 *sha, size_t n, size_t n_each, const void *values) {
    unsigned char little[8];
    if (!NQM_BIG_ENDIAN)
        nqm_sha256_add(sha, values, n * n_each);
    for (size_t i = 0; NQM_BIG_ENDIAN && i < n; ++i) {
        nqm_copy_little_endian(1, n_each, (const unsigned char *)values + i * n_each, little);
        nqm_sha256_add(sha, little, n_each);
    }
}

bool nqm_parse_double(const char *text, const char **end, double *value) {
    void *before = nqm_os_enter_c_locale();
    char *stop;
    double v = strtod(text, &stop);
    nqm_os_leave_locale(before);
    if (stop == text || !isfinite(v) || memchr(text, 'x', (size_t)(stop - text)) ||
        memchr(text, 'X', (size_t)(stop - text))) /* strtod() also reads hexadecimal numbers */
        return false;
    *end = stop;
    *value = v;
    return true;
}

char *nqm_format_double(char *buffer, size_t n_buffer, double value) {
    void *before = nqm_os_enter_c_locale();
    for (int digits = 6; digits <= 17; ++digits) {
        snprintf(buffer, n_buffer, "%.*g", digits, value);
        if (strtod(buffer, NULL) == value)
            break;
    }
    nqm_os_leave_locale(before);
    return buffer;
}

char *nqm_format_doubles(char *buffer, size_t n_buffer, size_t n, const double *values, const char *separator) {
    char number[32];
    *buffer = '\0';
    for (size_t i = 0, used = 0; i < n && used < n_buffer; ++i)
        used += (size_t)snprintf(buffer + used, n_buffer - used, "%s%s", i ? separator : "",
                                 nqm_format_double(number, sizeof number, values[i]));
    return buffer;
}

double nqm_round_digits(double value, int n_digits) {
    if (value == 0 || !isfinite(value))
        return value;
    int exponent = n_digits - 1 - (int)floor(log10(fabs(value)));
    double power = pow(10, abs(exponent)); /* exact up to 1e22 */
    return exponent >= 0 ? nearbyint(value * power) / power : nearbyint(value / power) * power;
}
