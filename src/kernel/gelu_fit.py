# SPDX-License-Identifier: MIT
"""The polynomials of gelu.h: /usr/bin/python3 src/kernel/gelu_fit.py prints their coefficients, constant term first, and the
largest weighted error. Least squares whose weights grow where the error is large become the least largest error (Lawson 1961)."""
import numpy as np
from numpy.polynomial import Chebyshev, Polynomial, chebyshev
from scipy.special import log_ndtr, ndtr


def fit(name, function, weight, low, high, degree):
    x = (low + high) / 2 + (high - low) / 2 * np.cos((np.arange(4000) + 0.5) * np.pi / 4000)
    basis = chebyshev.chebvander((2 * x - low - high) / (high - low), degree) * weight(x)[:, None]
    target, lawson, best = function(x) * weight(x), np.ones_like(x), (np.inf, None)
    for _ in range(200):
        c = np.linalg.lstsq(basis * np.sqrt(lawson)[:, None], target * np.sqrt(lawson), rcond=None)[0]
        error = abs(basis @ c - target)
        best = min(best, (error.max(), tuple(c)))
        lawson *= error / error.mean() + 1e-9
        lawson /= lawson.mean()
    powers = Chebyshev(best[1], domain=[low, high]).convert(kind=Polynomial).coef
    print(f"{name}, {best[0]:.1e}:", ", ".join(f"{p:.9e}f" for p in powers))


def mills_slope(a):
    return 1 - a * np.exp(-a * a / 2) / np.sqrt(2 * np.pi) / ndtr(-a)


# The last two have 1 as their constant term: the rest is fitted.
fit("log2_tail", lambda a: log_ndtr(-a) / np.log(2), lambda a: ndtr(-a) * np.log(2), 0, 13, 8)
fit("power_of_2", lambda r: (2**r - 1) / r, lambda r: abs(r) * 2**-r, -0.5, 0.5, 4)
fit("slope_of_tail", lambda a: (mills_slope(a) - 1) / a, lambda a: a * ndtr(-a), 0, 6, 7)
