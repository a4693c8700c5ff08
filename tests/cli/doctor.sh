#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm doctor: all works here; what does not work is named with what to do, and decides the exit code where it is needed.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

run 0 doctor
for name in build libraries Embree processor kernels threads self-test temporary folder Python; do
    grep -qE "^(ok|note) +$name " "$dir/out" || fail "no line of $name: $(cat "$dir/out")"
done
grep -q '^ok  *model  *default, .* sha256 [0-9a-f]\{16\}$' "$dir/out" || fail "no line of the model default"
grep -qE '^all that nqm needs works; (1 note|(0|[2-9]) notes)$' "$dir/out" || fail "no summary: $(cat "$dir/out")"
grep -q "; $(grep -c '^note' "$dir/out") note" "$dir/out" || fail "the number of notes: $(cat "$dir/out")"

grep -q '^ok  *self-test  *[0-9][0-9]* checks pass$' "$dir/out" || fail "the self-test: $(cat "$dir/out")"

# The Python of a wheel, which need not be the first of PATH.
printf '#!/bin/sh\necho 0.1.0 /of/the/wheel\n' >"$dir/python of a wheel"
chmod +x "$dir/python of a wheel"
NQM_PYTHON="$dir/python of a wheel" "$tool" doctor >"$dir/out"
grep -q '^ok  *Python  *nqm 0.1.0 /of/the/wheel$' "$dir/out" || fail "another Python is asked: $(cat "$dir/out")"

# Without a temporary folder, with one thread, slow kernels and a Python package of another version.
mkdir "$dir/bin"
printf '#!/bin/sh\necho 0.0.1 /nowhere/nqm/__init__.py\n' >"$dir/bin/python3"
chmod +x "$dir/bin/python3"
got=0
(cd "$dir" && PATH=$dir/bin:$PATH TMPDIR=$dir/nowhere OMP_NUM_THREADS=1 NQM_KERNELS=generic "$tool" doctor --json >"$dir/out") || got=$?
[ $got = 1 ] || fail "exit code $got"
[ "$(number problems 1)" = 2 ] || fail "two problems: $(cat "$dir/out")"
grep -q '"failed": 0,' "$dir/out" || fail "the self-test: $(cat "$dir/out")"
for advice in 'set TMPDIR to a folder' 'install the Python package of the same version' 'unset NQM_KERNELS'; do
    grep -q "\"advice\": \"$advice" "$dir/out" || fail "no advice: $advice"
done
