#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm conform with NumPy: the example reads rows and prints values; a float32 shader of all of glTF passes, and some of its planted
# mistakes are named (tests/vectors/conform_gltf.py has 71). Skipped without NumPy, and under sanitizers, where it takes a minute.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
[ -z "${NQM_SANITIZE:-}" ] || exit 77
for python in python3 /usr/bin/python3; do
    if "$python" -c 'import numpy' 2>/dev/null; then break; fi
    python=
done
[ -n "$python" ] || exit 77
export PYTHONDONTWRITEBYTECODE=1
run 1 conform gltf --keys base_color,metallic,roughness --command "$python $NQM_SOURCE/examples/conform/shader.py"
grep -q '^Likely mistake: the diffuse part is not multiplied by what' "$dir/out" || fail "another mistake: $(cat "$dir/out")"
"$python" "$NQM_SOURCE/tests/vectors/conform_gltf.py" "$tool" 0 22 31 50 60 61 69 >"$dir/out" 2>"$dir/err" || fail "$(cat "$dir/out")"
grep -q '^6 first' "$dir/out" || fail "$(cat "$dir/out")"
