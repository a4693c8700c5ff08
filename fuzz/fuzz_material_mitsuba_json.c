/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: Mitsuba dictionaries in JSON.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_material(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "{\"type\": \"scene\", \"gold\": {\"type\": \"twosided\", \"inner\": {\"type\": \"roughconductor\", "
        "\"alpha\": 0.1, \"eta\": {\"type\": \"rgb\", \"value\": [0.1, 0.4, 1.4]}, \"k\": {\"type\": "
        "\"spectrum\", \"value\": 3}}}, \"s\": {\"type\": \"sphere\", \"b\": {\"type\": \"principled\", "
        "\"roughness\": 0.3, \"base_color\": [1, 0.5, 0]}}, \"d\": {\"type\": \"diffuse\", \"reflectance\": {\"type\": "
        "\"bitmap\", \"filename\": \"a\", \"to_uv\": [1, 0, 0]}}}";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
