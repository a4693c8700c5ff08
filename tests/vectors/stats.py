# SPDX-License-Identifier: MIT
"""Correlations, ranks and quantiles by SciPy and NumPy: stats_data.csv (the points of each case) and stats_expected.csv."""
import warnings

import numpy
import scipy
import scipy.stats

SEED = 20250
rng = numpy.random.default_rng(SEED)
cases = {}
x = rng.normal(size=50)
cases["normal"] = (x, 0.5 * x + rng.normal(size=50))
cases["ties"] = (rng.integers(0, 6, 200).astype(float), rng.integers(0, 4, 200).astype(float))
cases["ties_in_x"] = (rng.integers(0, 3, 101).astype(float), rng.normal(size=101))
x = rng.integers(0, 5, 150).astype(float)
cases["ties_in_both"] = (x, x + rng.integers(0, 2, 150))
cases["two"] = (numpy.array([1.0, 2.0]), numpy.array([5.0, 3.0]))
cases["reversed"] = (numpy.arange(31.0), -numpy.arange(31.0) ** 3)
cases["offset"] = (1e9 + rng.normal(size=40), 1e-9 * rng.normal(size=40))
cases["large"] = (numpy.round(rng.normal(size=1500), 2), numpy.round(rng.normal(size=1500), 1))
cases["constant"] = (numpy.full(7, 0.1), rng.normal(size=7))
cases["one"] = (numpy.array([1.0]), numpy.array([2.0]))

head = f"# made by stats.py: numpy {numpy.__version__}, scipy {scipy.__version__}, seed {SEED}\n"
with open("stats_data.csv", "w") as data, open("stats_expected.csv", "w") as expected:
    data.write(head + "case,x,y,rank_x\n")
    expected.write(head + "case,pearson,spearman,kendall,mean_x,q025_x,q500_x,q900_x\n")
    for name, (x, y) in cases.items():
        ranks = scipy.stats.rankdata(x)
        for row in zip(x, y, ranks):
            data.write(name + "," + ",".join(repr(float(v)) for v in row) + "\n")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # without variance the expected value is NaN
            if len(x) > 1:
                r = [scipy.stats.pearsonr(x, y)[0], scipy.stats.spearmanr(x, y)[0], scipy.stats.kendalltau(x, y)[0]]
            else:
                r = [numpy.nan] * 3  # SciPy refuses a single point
        r += [numpy.mean(x)] + [numpy.quantile(x, q) for q in (0.025, 0.5, 0.9)]
        expected.write(name + "," + ",".join("" if numpy.isnan(v) else repr(float(v)) for v in r) + "\n")
