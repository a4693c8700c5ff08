/* SPDX-License-Identifier: MIT
 *
 * No embedded encoder was learned from the 20 materials of the human study (Kavoosighafi et al. 2025): each file lists
 * its references, and none of them is one of those materials in any form.
 */
#include "encode/encode.h"
#include "support/check.h"

#include <jansson.h>

static const char *const held_out[] = {"acrylic_felt_green_rgb",
                                       "aluminium",
                                       "blue-fabric",
                                       "blue-metallic-paint",
                                       "bluebook",
                                       "cardboard",
                                       "cc_amber_citrine_rgb",
                                       "color-changing-paint1",
                                       "gold-metallic-paint2",
                                       "green-metallic-paint2",
                                       "ilm_l3_37_dark_green_rgb",
                                       "ilm_solo_m_68_rgb",
                                       "light-red-paint",
                                       "notebook",
                                       "red-metallic-paint",
                                       "silver-metallic-paint2",
                                       "specular-green-phenolic",
                                       "vch_dragon_eye_red_rgb",
                                       "vch_golden_yellow_rgb",
                                       "violet-acrylic"};

/* Whether the material NAME of "DIR/NAME.bsdf", "ARCHIVE:NAME" or "MODEL:NAME" is held out. */
static bool is_held_out(const char *brdf) {
    const char *slash = strrchr(brdf, '/'), *colon = strrchr(brdf, ':');
    const char *name = slash ? slash + 1 : brdf;
    name = colon && colon >= name ? colon + 1 : name;
    size_t n = strcspn(name, ".");
    for (size_t i = 0; i < sizeof held_out / sizeof *held_out; ++i)
        if (strlen(held_out[i]) == n && memcmp(held_out[i], name, n) == 0)
            return true;
    return false;
}

TEST(every_form_of_a_name_is_known) {
    assert_int_equal(sizeof held_out / sizeof *held_out, 20);
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
