# SPDX-License-Identifier: MIT
"""Agreement of two predictors with labels of pairs in groups, by SciPy: train_agreement.csv (the pairs, sorted by group) and
train_agreement_expected.csv (correlations over all pairs, the mean Spearman over groups of at least three pairs, and
the fraction of label pairs within a group, differing by more than MARGIN, that the predictor orders correctly)."""
import itertools

import numpy
import scipy
import scipy.stats

SEED = 7
MARGIN = 0.25
rng = numpy.random.default_rng(SEED)
group = numpy.sort(rng.integers(0, 12, 120))
group[group == 5] = 6  # an empty group
group = numpy.concatenate([group, [12, 12, 13]])  # two groups with too few pairs
label = numpy.round(10 - rng.gamma(2, 1, len(group)), 1).clip(0, 10)
first = numpy.round(label + rng.normal(0, 0.8, len(group)), 2)
second = -numpy.round(numpy.exp(2 - 0.4 * label + rng.normal(0, 0.7, len(group))), 3)



def order(p):
    right = []
    for i, k in itertools.combinations(range(len(label)), 2):
        if group[i] == group[k] and abs(label[i] - label[k]) > MARGIN:
            right.append(0.5 * (1 + numpy.sign(p[i] - p[k]) * numpy.sign(label[i] - label[k])))
    return len(right), numpy.mean(right)


head = f"# made by train_agreement.py: numpy {numpy.__version__}, scipy {scipy.__version__}, seed {SEED}\n"
with open("train_agreement.csv", "w") as data:
    data.write(head + "group,label,first,second\n")
    for row in zip(group, label, first, second):
        data.write(",".join(repr(v.item()) for v in row) + "\n")
with open("train_agreement_expected.csv", "w") as expected:
    expected.write(head + "predictor,spearman,spearman_mean_by_material,pearson,kendall,mae,rmse,r2,n_ordered,order\n")
    for name, p in [("first", first), ("second", second)]:
        inside = [scipy.stats.spearmanr(p[group == g], label[group == g])[0] for g in set(group) if (group == g).sum() >= 3]
        r2 = 1 - ((p - label) ** 2).sum() / ((label - label.mean()) ** 2).sum()
        values = [
            scipy.stats.spearmanr(p, label)[0], numpy.mean(inside), scipy.stats.pearsonr(p, label)[0],
            scipy.stats.kendalltau(p, label)[0], abs(p - label).mean(), numpy.sqrt(((p - label) ** 2).mean()), r2, *order(p),
        ]
        expected.write(name + "," + ",".join(repr(float(v)) for v in values) + "\n")
