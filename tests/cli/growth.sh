#!/bin/sh
# SPDX-License-Identifier: MIT
# Files of twice the size take about twice the work, counted in instructions: materials that are looked up by name or composed, and equal
# directions. A file of zeros is refused without reading it.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
if truncate -s 40G "$dir/zeros" 2>/dev/null; then
    for arguments in "info $dir/zeros" "score $dir/zeros sgd:nickel" "batch $dir/zeros" "score $dir/zeros:x sgd:nickel"; do
        code=0
        # shellcheck disable=SC2086
        timeout 1800 "$tool" $arguments >"$dir/out" 2>"$dir/err" || code=$?
        { [ "$code" = 4 ] || [ "$code" = 7 ]; } || fail "a file of zeros: exit code $code: $arguments"
    done
fi
# A program with sanitizers does not run under valgrind.
[ -z "${NQM_SANITIZE:-}" ] && command -v valgrind >/dev/null && command -v python3 >/dev/null || exit 77

cat >"$dir/make.py" <<'END'
import sys

kind, n = sys.argv[1], int(sys.argv[2])
rows = range(n)
if kind == "gltf":
    text = '{"asset":{"version":"2.0"},"materials":[' + ",".join('{"name":"m%d"}' % i for i in rows) + '],"extensionsRequired":["X_y"]}'
elif kind == "members":
    text = '{"asset":{"version":"2.0"},"materials":[' + ",".join(
        '{"name":"m%d","pbrMetallicRoughness":{"roughnessFactor":%g}}' % (i, .3 + 1e-4 * i) for i in rows) + ']}'
elif kind == "surfaces":
    text = '<materialx version="1.39">' + "".join('<zz name="s%d"/>' % i for i in rows) + "".join(
        '<surfacematerial name="m%d"><input name="surfaceshader" nodename="s%d"/></surfacematerial>' % (i, i) for i in rows) + "</materialx>"
elif kind == "dots":
    text = '<materialx version="1.39">' + "".join(
        '<dot name="d%d"><input name="in" nodename="d%d"/></dot>' % (i, i + 1) for i in rows)
    text += '<constant name="d%d"><input name="value" value="0.5"/></constant><standard_surface name="s">' % n
    text += "".join('<input name="%s" nodename="d%d"/>' % (key, n - 20) for key in ("base", "metalness", "specular", "sheen"))
    text += "</standard_surface>" + "".join(
        '<surfacematerial name="m%d"><input name="surfaceshader" nodename="s"/></surfacematerial>' % i for i in rows) + "</materialx>"
elif kind == "usda":
    text = '#usda 1.0\nclass Material "c" { token outputs:surface.connect = </c/s.outputs:s>\n'
    text += 'def Shader "s" { uniform token info:id = "UsdPreviewSurface" } }\n' + "".join(
        'def Material "m%d" (inherits = </c>) { over "s" { float inputs:roughness = 0.%d } }\n' % (i, i + 1) for i in rows)
elif kind == "pbrt":
    text = "".join('Texture "t%d" "spectrum" "constant"\n' % i for i in rows) + "".join(
        'Material "diffuse" "texture reflectance" "t%d"\n' % (n - 1 - i) for i in rows)
elif kind == "twosided":
    text = '<scene version="3.0.0"><bsdf type="twosided" id="t">' + '<ref id="no"/>' * n + "</bsdf></scene>"
elif kind == "directions":
    text = "theta_h,theta_d,phi_d,r,g,b\n" + "0,45,0,1,1,1\n" * n
sys.stdout.write(text)
END

# work KIND N: the instructions of reading a file of this kind; a refused material is no fault.
work() {
    python3 "$dir/make.py" "$1" "$2" >"$dir/file"
    OMP_NUM_THREADS=1 valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null "$tool" check "$dir/file" \
        >"$dir/out" 2>"$dir/err" || true
    sed -n 's/,//g; s/.*I *refs: *//p' "$dir/err"
}

# Quadratic work quadruples from one difference to the next, linear work doubles.
for kind in gltf surfaces dots usda pbrt twosided directions; do
    a=$(work $kind 1000) b=$(work $kind 2000) c=$(work $kind 4000)
    { [ -n "$a" ] && [ -n "$b" ] && [ -n "$c" ]; } || fail "no count of instructions: $kind"
    [ $((c - b)) -lt $((3 * (b - a))) ] || fail "$kind: $a, $b, $c instructions for 1000, 2000 and 4000"
    # check evaluates thousands of directions: none of them may pass over all rows
    [ $kind != directions ] || [ $((c - b)) -lt $((2000 * 20000)) ] || fail "$kind: $(((c - b) / 2000)) instructions for a row"
done

# A list with two files of materials means all pairs of them; each file is read once. Materials that are refused are looked at again.
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 20
printf 'reference,test\na.gltf,b.gltf\n' >"$dir/list.csv"
batch() {
    python3 "$dir/make.py" "$1" "$2" >"$dir/a.gltf"
    python3 "$dir/make.py" "$1" "$2" | sed 's/:0\.3/:0.4/g' >"$dir/b.gltf"
    OMP_NUM_THREADS=1 valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null "$tool" batch "$dir/list.csv" -m "$dir/model.safetensors" \
        >"$dir/out" 2>"$dir/err" || true
    [ "$(wc -l <"$dir/out")" = $(($2 + 1)) ] || fail "$1: not $2 rows"
    sed -n 's/,//g; s/.*I *refs: *//p' "$dir/err"
}
for kind in members gltf; do
    a=$(batch $kind 100) b=$(batch $kind 200) c=$(batch $kind 400)
    { [ -n "$a" ] && [ -n "$b" ] && [ -n "$c" ]; } || fail "no count of instructions: batch, $kind"
    [ $((c - b)) -lt $((3 * (b - a))) ] || fail "batch, $kind: $a, $b, $c instructions for 100, 200 and 400"
done
