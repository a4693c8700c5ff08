/* SPDX-License-Identifier: MIT
 *
 * BSDF tables of Zemax: values of functions of the directions, which are found where the axes of the file say, and faults.
 */
#include "base/base.h"
#include "math/math.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/damage.h"

#include <nqm/brdf.h>

static const double degree = 3.14159265358979323846 / 180;

typedef struct kind {
    const char *symmetry, *content;
    size_t n_rotations, n_incidences;
    int step, last; /* of azimuths */
} kind;

/* Linear in the angles of the table; of a mirrored table even in the azimuth. */
static double value_of(double incidence, double azimuth, double radial) {
    return 1 + 0.01 * incidence + 0.02 * radial + 0.001 * (azimuth > 180 ? 360 - azimuth : azimuth);
}

static const char *save(const kind *k) {
    static const double rotations[] = {0, 90}, incidences[] = {0, 20, 60}, radials[] = {0, 5, 15, 40};
    static const char *const channels[] = {"TristimulusX", "TristimulusY", "TristimulusZ", "Monochrome"};
    static const double white[] = {0.95047, 1, 1.08883, 1};
    static char text[32768];
    const bool is_mono = strcmp(k->content, "Monochrome") == 0;
    size_t n =
        (size_t)snprintf(text, sizeof text,
                         "# an instrument\nSource  Measured\nSymmetry  %s\nSpectralContent  %s\nScatterType  BRDF\n"
                         "SampleRotation  %zu\n",
                         k->symmetry, k->content, k->n_rotations);
#define ADD(...) n += (size_t)snprintf(text + n, sizeof text - n, __VA_ARGS__)
    for (size_t r = 0; r < k->n_rotations; ++r)
        ADD("%g ", rotations[r]);
    ADD("\nAngleOfIncidence  %zu\n", k->n_incidences);
    for (size_t i = 0; i < k->n_incidences; ++i)
        ADD("%g\t", incidences[i + (k->n_incidences == 1)]);
    ADD("\nScatterAzimuth %d\n", k->last / k->step + 1);
    for (int a = 0; a <= k->last; a += k->step)
        ADD("%d ", a);
    ADD("\nScatterRadial 4\n0 5 15 40\n\n");
    for (size_t c = is_mono ? 3 : 0; c < (is_mono ? 4u : 3u); ++c) {
        ADD("%s\nDataBegin\n", channels[c]);
        for (size_t b = 0; b < k->n_rotations * k->n_incidences; ++b) {
            ADD("TIS 0.5\n");
            for (int a = 0; a <= k->last; a += k->step)
                for (size_t r = 0; r < 4; ++r)
                    ADD("%.8g%s",
                        white[c] * (1 + 0.5 * (double)(b / k->n_incidences)) *
                            value_of(incidences[b % k->n_incidences + (k->n_incidences == 1)], a, radials[r]),
                        r == 3 ? "\n" : " ");
        }
        ADD("DataEnd%s", c < 2 ? "\n" : "");
    }
#undef ADD
    const char *path = scratch_path("table.bsdf");
    blob_save(&(blob){(unsigned char *)text, n}, path);
    return path;
}

/* f_r with the light at this azimuth, in the direction that is `radial` from the mirror direction; azimuth 0 is towards the normal. */
static double eval(const nqm_brdf *brdf, double turn, double incidence, double azimuth, double radial) {
    double wi[3], wo[3], rgb[3], mirror[3], toward[3], across[3];
    uint8_t flag;
    nqm_spherical(incidence * degree, turn, wi);
    nqm_spherical(incidence * degree, turn + NQM_PI, mirror);
    nqm_spherical((90 - incidence) * degree, turn, toward);
    nqm_spherical(90 * degree, turn + NQM_PI / 2, across);
    for (int k = 0; k < 3; ++k)
        wo[k] = mirror[k] * cos(radial * degree) + toward[k] * sin(radial * degree) * cos(azimuth * degree) +
                across[k] * sin(radial * degree) * sin(azimuth * degree);
    nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
    assert_near(rgb[1], rgb[0], 1e-5);
    assert_near(rgb[2], rgb[0], 1e-5);
    return nqm_has_value(flag) ? rgb[0] : flag == NQM_VALUE_HORIZON ? -2 : -1;
}

TEST(tables_are_interpolated) {
    static const kind kinds[] = {{"PlaneSymmetrical", "Monochrome", 1, 3, 20, 180},
                                 {"ASymmetrical", "Monochrome", 1, 3, 20, 340},
                                 {"Asymmetrical4D", "Monochrome", 1, 3, 20, 360},
                                 {"PlaneSymmetrical", "XYZ", 1, 3, 20, 180}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        nqm_brdf *brdf = must_open(save(&kinds[i]));
        const nqm_brdf_info info = nqm_brdf_get_info(brdf);
        assert_string_equal(info.format, "grid");
        assert_int_equal(info.isotropic, 1);
        assert_non_null(strstr(info.layout, "3 angles of incidence x "));
        for (int turn = 0; turn < 360; turn += 70)
            for (int azimuth = 0; azimuth < 360; azimuth += 30) {
                assert_near(eval(brdf, turn, 33, azimuth, 12), value_of(33, azimuth, 12), 1e-5);
                assert_near(eval(brdf, turn, 20, azimuth, 0.0001), value_of(20, 0, 0), 0.2); /* no azimuth */
                assert_true(eval(brdf, turn, 20, azimuth, 41) < 0 && eval(brdf, turn, 61, azimuth, 12) < 0);
            }
        assert_true(eval(brdf, 0, 60, 180, 35) == -2 && eval(brdf, 0, 60, 0, 35) > 0);
        nqm_brdf_free(brdf);
    }
}

/* One angle of incidence, few azimuths, a tolerance, or several rotations of the sample: a list of directions. */
TEST(other_tables_are_lists) {
    nqm_brdf *brdf = must_open(save(&(kind){"PlaneSymmetrical", "Monochrome", 1, 1, 20, 180}));
    assert_string_equal(nqm_brdf_get_info(brdf).format, "samples");
    assert_string_equal(
        nqm_brdf_get_info(brdf).remark,
        "Source Measured is not used; TIS is not used; rows that give a direction again: 17 (their mean counts)");
    for (int azimuth = 20; azimuth < 360; azimuth += 20)
        assert_near(eval(brdf, 1, 20, azimuth, 15), value_of(20, azimuth, 15), 1e-5);
    assert_near(eval(brdf, 1, 20, 0, 0), value_of(20, 90, 0), 1e-5); /* the mean over all azimuths */
    assert_true(eval(brdf, 1, 20, 30, 15) == -1);
    nqm_brdf_free(brdf);
    brdf = must_open(save(&(kind){"PlaneSymmetrical", "Monochrome", 1, 3, 180, 180}));
    assert_string_equal(nqm_brdf_get_info(brdf).format, "samples");
    nqm_brdf_free(brdf);
    char argument[400];
    snprintf(argument, sizeof argument, "%s:2", save(&(kind){"PlaneSymmetrical", "Monochrome", 1, 3, 20, 180}));
    brdf = must_open(argument);
    assert_string_equal(nqm_brdf_get_info(brdf).format, "samples");
    nqm_brdf_free(brdf);
    brdf = must_open(save(&(kind){"Asymmetrical4D", "Monochrome", 2, 3, 40, 320}));
    assert_int_equal(nqm_brdf_get_info(brdf).isotropic, 0);
    assert_near(eval(brdf, 0, 20, 40, 15), value_of(20, 40, 15), 1e-5);
    assert_near(eval(brdf, NQM_PI / 2, 20, 40, 15), 1.5 * value_of(20, 40, 15), 1e-5);
    assert_true(eval(brdf, 1, 20, 40, 15) == -1);
    nqm_brdf_free(brdf);
}

TEST(refuses_unfit_tables) {
    static const struct {
        const char *from, *to, *words;
    } faults[] = {{"BRDF", "BTDF", "this kind of table is not read, in what begins"},
                  {"PlaneSymmetrical", "Asymmetric      ", "'Asymmetric' at byte "},
                  {"PlaneSymmetrical", "AxiallySymmetric", "'AxiallySymmetric' at byte "},
                  {"SampleRotation", "AOI 0 POI 0   ", "not a word of a table of Zemax (LightTools'"},
                  {"0 5 15 40", "0 15 5 40", "angles do not rise"},
                  {"0 5 15 40", "0 5 15 nan", "'nan' at byte"},
                  {"TIS 0.5\n1 ", "TIS 0.5\nx ", "not a number of its range"},
                  {"DataEnd", "1.25   ", "'1.25'"},
                  {"ScatterRadial 4", "ScatterRadial 9", "not a number of its range"}};
    const char *path = save(&(kind){"PlaneSymmetrical", "Monochrome", 1, 3, 20, 180});
    blob whole = blob_load(path);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        char text[32768];
        memcpy(text, whole.data, whole.n_bytes);
        text[whole.n_bytes] = '\0';
        char *at = strstr(text, faults[i].from);
        assert_non_null(at);
        memcpy(at, faults[i].to, strlen(faults[i].to));
        blob_save(&(blob){(unsigned char *)text, whole.n_bytes}, path);
        must_refuse(path, NQM_ERR_FORMAT, faults[i].words);
    }
    refuse_cuts(path, whole, 7, read_brdf);
    blob_put(whole, path);
    assert_true(check_brdf_allocations(path) >= 6);
    assert_true(check_brdf_allocations(save(&(kind){"PlaneSymmetrical", "XYZ", 1, 1, 20, 180})) >= 6);
}
