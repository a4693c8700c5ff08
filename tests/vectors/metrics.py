# SPDX-License-Identifier: MIT
"""The nine scalar metrics and the network's input for one synthetic pair, by NumPy in double: metrics_pair.csv (directions,
samples, flags of the directions in use), metrics_expected.csv, features_expected.csv."""
import numpy

SEED = 11
N = 60
rng = numpy.random.default_rng(SEED)
degrees = numpy.column_stack([60 * rng.uniform(size=N) ** 2, 70 * rng.uniform(size=N), 180 * rng.uniform(size=N)])
degrees = numpy.round(degrees, 3)
ref = numpy.exp(rng.normal(-2, 2, size=(N, 3))).astype(numpy.float32)
test = (ref * numpy.exp(rng.normal(0, 0.5, size=(N, 3)))).astype(numpy.float32)
ref[3] = 0
test[5] = 0
test[7] = ref[7]
ref[9] = 250.0
used = rng.uniform(size=N) > 0.2


def unit(theta, phi):
    return numpy.array([numpy.sin(theta) * numpy.cos(phi), numpy.sin(theta) * numpy.sin(phi), numpy.cos(theta)])


def cosine_product(theta_h, theta_d, phi_d):
    """cos(theta_i) cos(theta_o) by definition: rotate the difference vector, then mirror it at the half vector."""
    d = unit(theta_d, phi_d)
    turn = numpy.array([[numpy.cos(theta_h), 0, numpy.sin(theta_h)], [0, 1, 0], [-numpy.sin(theta_h), 0, numpy.cos(theta_h)]])
    wi = turn @ d
    h = unit(theta_h, 0)
    wo = 2 * numpy.dot(h, wi) * h - wi
    return max(wi[2], 0) * max(wo[2], 0)


c = numpy.array([cosine_product(*numpy.radians(row)) for row in degrees])[:, None]
a, b = ref.astype(float), test.astype(float)


def values(keep):
    p, q, w = a[keep], b[keep], c[keep]

    def rms(f):
        return numpy.sqrt(numpy.mean((f(q) - f(p)) ** 2))

    def ma(f):
        return numpy.mean(numpy.abs(f(q) - f(p)))

    out = {}
    for kind, f in {"": lambda v: v, "_crwe": lambda v: numpy.cbrt(w * v), "_loge": lambda v: numpy.log(1 + v),
                    "_logwe": lambda v: numpy.log(1 + w * v)}.items():
        out["rms" + kind if kind else "rmse"] = rms(f)
        out["ma" + kind if kind else "mae"] = ma(f)
    out["log_diff"] = ma(lambda v: numpy.log(v + 0.003))
    return out


head = f"# made by metrics.py: numpy {numpy.__version__}, seed {SEED}\n"
with open("metrics_pair.csv", "w") as out:
    out.write(head + "theta_h,theta_d,phi_d,ref_r,ref_g,ref_b,test_r,test_g,test_b,used\n")
    for i in range(N):
        row = list(degrees[i]) + list(a[i]) + list(b[i]) + [int(used[i])]
        out.write(",".join(repr(v) if isinstance(v, int) else repr(float(v)) for v in row) + "\n")
with open("metrics_expected.csv", "w") as out:
    out.write(head + "metric,all,used\n")
    everything, kept = values(numpy.ones(N, bool)), values(used)
    for name in everything:
        out.write(f"{name},{float(everything[name])!r},{float(kept[name])!r}\n")

mean, std, scale = numpy.array([0.31, 0.42, 0.53]), numpy.array([0.2, 0.25, 0.3]), 3.0
mean, std = mean.astype(numpy.float32).astype(float), std.astype(numpy.float32).astype(float)
r = (numpy.log(numpy.cbrt(a) + 1) - mean) / std
t = (numpy.log(numpy.cbrt(b) + 1) - mean) / std
r[~used] = 0
t[~used] = 0
with open("features_expected.csv", "w") as out:
    out.write(head + "layout,value\n")
    for layout, parts in ((0, (r, t)), (1, (r, scale * (t - r), scale * numpy.abs(t - r)))):
        for v in numpy.concatenate([p.ravel() for p in parts]):
            out.write(f"{layout},{float(v)!r}\n")
