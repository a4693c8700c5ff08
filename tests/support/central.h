/* SPDX-License-Identifier: MIT
 *
 * central.h - derivatives by central differences.
 */
#ifndef NQM_TESTS_CENTRAL_H
#define NQM_TESTS_CENTRAL_H

/** Set `result` to the derivative of an expression by a variable (doubles), by differences of order 4 with steps of h. The variable keeps
 *  its value. */
#define CENTRAL_DIFFERENCE(result, variable, h, expression)                                                            \
    do {                                                                                                               \
        static const double steps[4] = {-2, -1, 1, 2}, factors[4] = {1, -8, 8, -1};                                    \
        const double centre = (variable), step = (h);                                                                  \
        double sum = 0;                                                                                                \
        for (int i_ = 0; i_ < 4; ++i_) {                                                                               \
            (variable) = centre + steps[i_] * step;                                                                    \
            sum += factors[i_] * (expression);                                                                         \
        }                                                                                                              \
        (variable) = centre;                                                                                           \
        (result) = sum / (12 * step);                                                                                  \
    } while (0)

#endif
