#!/bin/sh
# SPDX-License-Identifier: MIT
# --ignore: materials that do more than reflect are scored by what reflects, and every output says so.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
cd "$dir"

# material FILE PROPERTIES TRANSMISSION EXTRA
material() {
    cat >"$1" <<END
{"asset": {"version": "2.0"}, "materials": [{"name": "glass", $4 "pbrMetallicRoughness": {"metallicFactor": 0, $2},
"extensions": {"KHR_materials_transmission": {"transmissionFactor": $3}}}]}
END
}
material half.gltf '"roughnessFactor": 0.5' 0.5 ''
material glow.gltf '"roughnessFactor": 0.4' 1 '"emissiveFactor": [1, 0, 0],'
all=transmission,subsurface,emission,opacity,displacement,bump

run 0 info half.gltf --ignore transmission
grep -q 'base_color=0.5' out || fail "the diffuse reflection keeps half: $(cat out)"
grep -q 'only what reflects is taken: transmission ignored' err || fail "info says what is ignored"

# Every output says so; only the words that a material needs are named.
run 0 score half.gltf glow.gltf --ignore $all
grep -q 'ignore:transmission,emission:glow.gltf' out || fail "text: $(cat out)"
grep -q 'only what reflects is taken' err || fail "remark"
run 0 score half.gltf NAMED=glow.gltf lambert:kd=.5 --ignore $all --json
grep -q '"test": "ignore:transmission,emission:glow.gltf"' out || fail "JSON: $(cat out)"
grep -q '"reference: only what reflects is taken: transmission ignored"' out || fail "JSON: warning"
grep -q '"test": "lambert:kd=.5"' out || fail "JSON: other BRDFs remain"
run 0 rank half.gltf glow.gltf --ignore $all --csv
grep -q '^"*ignore:transmission:half.gltf' out || fail "rank: $(cat out)"
printf 'reference,test\nhalf.gltf,glow.gltf\n' >list.csv
run 0 batch list.csv --ignore $all --junit j.xml --markdown m.md
for file in out j.xml m.md; do
    grep -q 'only what reflects is taken: transmission,emission ignored' $file || fail "$file: $(cat $file)"
done
run 0 check half.gltf --ignore transmission
run 0 sample half.gltf --ignore transmission
"$tool" sample ignore:transmission:half.gltf | cmp - out || fail "the argument and the option differ"

# Files of several materials.
sed 's/}}}]}/}}}, {"name": "chalk", "pbrMetallicRoughness": {"metallicFactor": 0}}]}/' half.gltf >two.gltf
run 0 info two.gltf
grep -q 'glass .*refused: .*; accepted with --ignore transmission$' out || fail "info: $(cat out)"
run 0 info two.gltf --ignore transmission
grep -q '^accepted  *2$' out || fail "info: $(cat out)"
run 0 score two.gltf two.gltf --ignore $all --csv
[ "$(grep -c ",identical,0," out)" = 2 ] && [ "$(grep -c "^ignore:transmission:two.gltf:glass," out)" = 1 ] || fail "several: $(cat out)"
run 0 translate two.gltf --to open-pbr --loss log --ignore $all --json
grep -q ignore:transmission:two.gltf:glass out || fail "translate: $(cat out)"

# Textures: the map of the base color keeps half.
if [ -n "$(command -v python3)" ] && python3 -c 'import numpy' 2>/dev/null; then
    python3 - <<'END'
import struct, zlib
def chunk(k, d): return struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d))
rows = b"".join(b"\0" + bytes([200, 40 * x, 40] * 1) * 2 for x in range(2))
open("a.png", "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)) +
                          chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
END
    cat >map.gltf <<END
{"asset": {"version": "2.0"}, "images": [{"uri": "a.png"}], "textures": [{"source": 0}],
"materials": [{"name": "pane", "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorTexture": {"index": 0}},
"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}}},
{"name": "wall", "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorTexture": {"index": 0},
"baseColorFactor": [0.5, 0.5, 0.5, 1]}}]}
END
    run 4 score map.gltf:pane map.gltf:wall
    run 0 score map.gltf:pane map.gltf:wall --ignore transmission --csv
    grep -q ',identical,' out || fail "the map keeps half: $(cat out)"
fi

# The materials of physicallybased.info as three shading models (shared data): of 132 pairs at least 128 have a score.
data=${NQM_DATA:-$NQM_SOURCE/../shared/data}/materials/physicallybased
[ -d "$data" ] || skip_rest ignore_physicallybased
for file in "$data"/PB_OPBR_*.mtlx; do
    name=${file##*PB_OPBR_}
    printf '%s\n' "PB_OPBR_$name,PB_GLTF_$name" "PB_OPBR_$name,PB_SS_$name"
done | sed '1i reference,test' >physical.csv
"$tool" batch physical.csv --root "$data" --keep-going --ignore $all -o scores.csv 2>err || true
n=$(awk -F, 'NR > 1 && $3 != ""' scores.csv | wc -l)
[ "$n" -ge 128 ] || fail "$n of 132 pairs have a score"
