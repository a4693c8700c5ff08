#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm sample -o: SciPy reads the same values from the MAT file as from the CSV (skipped without python3-scipy); refusals
# leave no file.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"$tool" directions -n 30 -o "$dir/d.csv" 2>/dev/null

printf 'theta_h,theta_d,phi_d\n10,20,30\n89,80,0\n' >"$dir/horizon.csv"
"$tool" sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv" --invalid zero -o "$dir/zero.mat" 2>/dev/null
"$tool" sample sgd:nickel -d "$dir/d.csv" >"$dir/nickel.csv"
"$tool" sample sgd:nickel -d "$dir/d.csv" -o "$dir/nickel.mat" >"$dir/out"
[ ! -s "$dir/out" ] || fail "something was printed"
"$tool" sample sgd:nickel -d "$dir/d.csv" -o "$dir/again.mat"
cmp "$dir/nickel.mat" "$dir/again.mat" || fail "equal samples, different files"

python=/usr/bin/python3
"$python" -c 'import scipy.io' 2>/dev/null || exit 77
"$python" - "$dir" <<'PYTHON' || fail "SciPy reads something else"
import csv, sys
import numpy, scipy.io
folder = sys.argv[1]
rows = numpy.array([[float(x) for x in row] for row in list(csv.reader(open(folder + "/nickel.csv")))[1:]])
mat = scipy.io.loadmat(folder + "/nickel.mat")
assert sorted(k for k in mat if not k.startswith("__")) == ["b", "g", "r", "random_locations"]
assert mat["random_locations"].shape == (30, 3) and numpy.allclose(mat["random_locations"], rows[:, :3], 1e-8, 0)
for k, name in enumerate("rgb"):
    assert mat[name].shape == (30, 1) and mat[name].dtype == numpy.float64
    assert numpy.allclose(mat[name][:, 0], rows[:, 3 + k], 1e-8, 0)
PYTHON
