/* SPDX-License-Identifier: MIT
 *
 * Golden values of the self-test. Made by tests/vectors/selftest.py (numpy 1.24.2): do not edit.
 */
#ifndef NQM_SRC_METRIC_SELFTEST_GOLDEN_H
#define NQM_SRC_METRIC_SELFTEST_GOLDEN_H
/* clang-format off */

/* f_r of presets; theta_h, theta_d, phi_d in degrees. */
static const struct {
    const char *spec;
    double hd_deg[3], rgb[3];
} golden_brdfs[] = {
    {"sgd:nickel", {0.5, 10, 20}, {5.21585437086709, 3.52414531235331, 2.93840699757025}},
    {"sgd:nickel", {8, 40, 100}, {0.141709895018216, 0.188570684230296, 0.190412356752202}},
    {"sgd:nickel", {30, 25, 60}, {0.00458394883994415, 0.00367135439625522, 0.00314821846450989}},
    {"sgd:blue-rubber", {2, 5, 170}, {0.0191312688559079, 0.0323839048236727, 0.0577255179973279}},
    {"sgd:blue-rubber", {45, 20, 90}, {0.0118838644052652, 0.0234738490107686, 0.0481997081432485}},
    {"ward:nickel", {0.5, 10, 20}, {8.48702757011531, 7.36831357994267, 6.53341935177286}},
    {"ward:nickel", {8, 40, 100}, {0.00732511373904976, 0.00676796707877098, 0.00587741579490665}},
    {"ward:nickel", {30, 25, 60}, {0.00703464848466177, 0.00651580337018219, 0.00565382019839649}},
    {"ward:blue-rubber", {2, 5, 170}, {0.0474670345445453, 0.0592021184522527, 0.0841849293441003}},
    {"ward:blue-rubber", {45, 20, 90}, {0.00983613662071265, 0.02200034480299, 0.047080298113037}},
};

/* The published curve: Delta-E ITP, JOD. */
static const double golden_jod[][2] = {
    {0.1, 9.99999928760737},
    {1, 9.99405934797479},
    {3, 9.88587036370212},
    {10, 8.72327551475414},
    {30, 5.28153022370546},
    {100, 1.92149432805161},
    {300, 0.731523901647547},
};

#endif
