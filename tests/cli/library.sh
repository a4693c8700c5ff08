#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm dedup and nqm nearest: hidden near-duplicates are found, none is replaced below the JOD, and the nearest are those of exact scores.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
cd "$dir"

# 20 materials that look different, and 4 copies of some that hardly do.
awk 'function put(name, r, g, b, metal, rough) {
        printf "%s{\"name\": \"%s\", \"pbrMetallicRoughness\": {\"baseColorFactor\": [%.4f, %.4f, %.4f, 1], ", n++ ? ",\n" : "", name, r, g, b
        printf "\"metallicFactor\": %d, \"roughnessFactor\": %.4f}}", metal, rough}
    BEGIN {printf "{\"asset\": {\"version\": \"2.0\"}, \"materials\": [\n"
        for (i = 0; i < 20; ++i) {
            r = 0.1 + 0.2 * (i % 5); g = 0.1 + 0.25 * int(i / 5 % 4); b = 0.2 + 0.1 * (i % 3); m = i % 2; a = 0.2 + 0.15 * (i % 4)
            put("m" i, r, g, b, m, a)
            if (i % 5 == 3) put("copy" i, r * 1.004, g * 0.997, b, m, a * 1.002)}
        printf "]}\n"}' >lib.gltf

run 0 dedup lib.gltf --map map.csv
grep -q '^24 materials, of which ' out || fail "text: $(cat out)"
n=$(($(wc -l <map.csv) - 1))
[ "$(grep -c '^ *[0-9.]* .*lib.gltf:' out)" = "$n" ] && [ "$(sed 1d map.csv | cut -d, -f2 | sort -u | wc -l)" = "$(grep -c '^kept ' out)" ] ||
    fail "$n rows: $(cat out)"
for i in 3 8 13 18; do # whichever of the two is kept
    grep -qE "^lib.gltf:(copy)?m?$i,lib.gltf:(copy)?m?$i," map.csv || fail "copy $i is not found: $(cat map.csv)"
done

# No exact score is below the JOD, and what remains does not look the same: each order of all pairs, by batch.
"$tool" info lib.gltf | sed -n 's/^\([a-z0-9]*\)  glTF .*/\1/p' >names
awk 'BEGIN {print "reference,test"} {n[NR] = $1} END {for (i = 1; i <= NR; ++i) for (j = 1; j <= NR; ++j) if (i != j)
    printf "lib.gltf:%s,lib.gltf:%s\n", n[i], n[j]}' names >pairs.csv
"$tool" batch pairs.csv -o exact.csv
awk -F, 'FNR == NR {jod[$1 "," $2] = $3; next}
    FNR > 1 {gone[$1] = 1; if (jod[$1 "," $2] < 9.5) {print "replaced at " jod[$1 "," $2]; exit 1}}
    END {for (p in jod) {split(p, m, ","); if (!(m[1] in gone) && !(m[2] in gone) && jod[p] >= 9.5 && jod[m[2] "," m[1]] >= 9.5) {
        print "kept both of " p; exit 1}}}' exact.csv map.csv >why || fail "$(cat why)"
run 0 dedup lib.gltf --json --map map.json --jod 9.9
grep -q '"n_materials": 24' out && grep -q '"old": "lib.gltf:' out || fail "JSON: $(cat out)"
grep -q '"lib.gltf:[a-z0-9]*": "lib.gltf:[a-z0-9]*"' map.json || fail "map: $(cat map.json)"
head -n 1 map.csv | grep -qx 'old,new,jod' || fail "CSV"

# Nearest: the same as the ranking of all, alike without and with an index, and after a change of the library.
mkdir folder
cp lib.gltf folder/
run 0 nearest lib.gltf:m7 --among lib.gltf -n 5 -q
cp out nearest
awk -F, '$1 == "lib.gltf:m7" {print $3, $2}' exact.csv | sort -rn | head -n 4 | cut -d' ' -f2 >want
sed 1d nearest | diff want - || fail "nearest"
[ "$(head -n 1 nearest)" = lib.gltf:m7 ] || fail "itself is the nearest"
run 0 nearest lib.gltf:m7 --among folder -n 5 -q --index f.index
sed 's|folder/||' out | diff nearest - || fail "folder"
run 0 nearest lib.gltf:m7 --among folder -n 5 -q --index f.index
sed 's|folder/||' out | diff nearest - || fail "index"
sed 's/"m7"/"other"/' lib.gltf >folder/lib.gltf
run 0 nearest lib.gltf:m7 --among folder -n 1 -q --index f.index
grep -qx folder/lib.gltf:other out || fail "an old index is used: $(cat out)"
run 0 nearest lib.gltf:m7 --among folder lib.gltf -n 2 -q # two places: a material is named by its whole path
sort out | tr '\n' ' ' | grep -qx 'folder/lib.gltf:other lib.gltf:m7 ' || fail "several places: $(cat out)"
run 0 dedup folder lib.gltf lib.gltf # a file that is given twice is read once
grep -q '^48 materials, of which ' out || fail "several places: $(cat out)"
printf broken >no.index
refuses 2 'no.index: is no index' nearest lib.gltf:m7 --among folder -n 1 -q --index no.index
[ "$(cat no.index)" = broken ] || fail "a file that is no index is replaced"
run 0 nearest lib.gltf:m7 --among folder -n 1 -q --index f.index
run 0 nearest lib.gltf:m7 --among lib.gltf -n 3 --apart --json
grep -q '"similarity_jod"' out || fail "apart: $(cat out)"
OMP_NUM_THREADS=1 "$tool" nearest lib.gltf:m7 --among lib.gltf -n 24 --csv >one
OMP_NUM_THREADS=2 "$tool" nearest lib.gltf:m7 --among lib.gltf -n 24 --csv | cmp - one || fail "threads"

# Refused, textured and faulty members are left out and said.
cat >mixed.gltf <<'END'
{"asset": {"version": "2.0"}, "materials": [{"name": "a"}, {"name": "b"},
{"name": "glass", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}]}
END
run 9 dedup mixed.gltf
grep -q '1 of 3 materials have no values' err || fail "faulty: $(cat err)"
run 0 dedup mixed.gltf --ignore transmission

# Textured ones: equal pixels are found, near scores decide, in an index too, until a map changes.
python3 "$NQM_SOURCE/examples/maps.py" maps 8
cat >maps.gltf <<'END'
{"asset": {"version": "2.0"}, "images": [{"uri": "maps/steel/steel_Color.png"}, {"uri": "copy.png"}, {"uri": "maps/half/steel_Color.png"}],
 "textures": [{"source": 0}, {"source": 1}, {"source": 2}], "materials": [{"name": "plain", "pbrMetallicRoughness": {"roughnessFactor": 0.2}},
 {"name": "a", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, {"name": "b", "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}},
 {"name": "c", "pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}}]}
END
cp maps/steel/steel_Color.png copy.png
run 0 dedup maps.gltf --map maps.csv
sed 1d maps.csv | grep -v '^maps.gltf:b,maps.gltf:a,10.0000$' && fail "dedup: $(cat maps.csv)"
[ "$(wc -l <maps.csv)" = 2 ] || fail "dedup finds no copy: $(cat maps.csv)"
run 0 nearest maps.gltf:b --among maps.gltf -n 2 -q --index m.index
[ "$(sort out | tr '\n' ' ')" = 'maps.gltf:a maps.gltf:b ' ] || fail "nearest: $(cat out)"
cp m.index before.index
run 0 nearest maps.gltf:b --among maps.gltf -n 2 -q --index m.index
cmp -s m.index before.index || fail 'an index that fits was written again'
cp maps/half/steel_Color.png copy.png
touch -d 2001-01-01 copy.png
run 0 nearest maps.gltf:c --among maps.gltf -n 2 -q --index m.index
[ "$(sort out | tr '\n' ' ')" = 'maps.gltf:b maps.gltf:c ' ] || fail "a map that changed: $(cat out)"
