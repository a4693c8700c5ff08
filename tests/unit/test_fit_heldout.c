/* SPDX-License-Identifier: MIT
 *
 * No embedded encoder was learned from the 20 materials of the human study (Kavoosighafi et al. 2025): each file lists
 * its references, and none of them is one of those materials in any form.
 */
#include "encode/encode.h"
#include "support/check.h"
#include "support/rows.h"

#include <jansson.h>

/* Whether the material NAME of "DIR/NAME.bsdf", "ARCHIVE:NAME" or "MODEL:NAME" is held out. */
static bool is_held_out(const char *brdf) {
    const char *slash = strrchr(brdf, '/'), *colon = strrchr(brdf, ':');
    const char *name = slash ? slash + 1 : brdf;
    name = colon && colon >= name ? colon + 1 : name;
    size_t n = strcspn(name, ".");
    EVERY_ROW(row, "materials held out") {
        if (strlen(row[0]) == n && memcmp(row[0], name, n) == 0)
            return true;
    }
    return false;
}

TEST(every_form_of_a_name_is_known) {
    size_t n;
    table_rows("materials held out", &n);
    assert_int_equal(n, 20);
    assert_true(is_held_out("rgl/ilm_solo_m_68_rgb.bsdf"));
    assert_true(is_held_out("nbrdf/merl_nbrdf.zip:aluminium"));
    assert_true(is_held_out("nbrdf/merl_nbrdf.zip:blue-fabric.h5"));
    assert_true(is_held_out("nps/nps_decoder_f32le.bin:cardboard"));
    assert_true(is_held_out("sgd:violet-acrylic"));
    assert_true(is_held_out("notebook"));
    assert_false(is_held_out("sgd:violet-rubber"));
    assert_false(is_held_out("rgl/ilm_solo_m_68_rgb_2.bsdf"));
}

TEST(no_encoder_has_seen_one) {
    size_t n_bytes;
    assert_non_null(nqm_encoder_bytes("sparse", &n_bytes));
    assert_non_null(nqm_encoder_bytes("hyper", &n_bytes));
    for (const nqm_embedded_file *file = nqm_embedded_encoders; file->name; ++file) {
        nqm_safetensors *st;
        const unsigned char *bytes = nqm_encoder_bytes(file->name, &n_bytes);
        assert_int_equal(nqm_encoder_parse(bytes, n_bytes, file->name, file->name, &st, NULL), NQM_OK);
        json_t *references = json_loads(nqm_safetensors_meta(st, "references"), 0, NULL);
        assert_true(json_array_size(references) > 100);
        for (size_t i = 0; i < json_array_size(references); ++i) {
            const char *reference = json_string_value(json_array_get(references, i));
            if (is_held_out(reference))
                fail_msg("%s has seen %s", file->name, reference);
        }
        json_decref(references);
        nqm_safetensors_free(st);
    }
}
