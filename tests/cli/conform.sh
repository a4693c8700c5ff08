#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm conform: kits, values as CSV and from a command, the mistake of a C and of a NumPy shader, reports, and faults of values.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
examples=$NQM_SOURCE/examples/conform
keys=base_color,metallic,roughness
cd "$dir"

# ---- the kit proves itself
run 0 conform pbrt-conductor --self --json
grep -q '"passes": true' out || fail "the kit does not prove itself"
[ "$(number mistakes 1)" -ge 25 ] || fail "only $(number mistakes 1) mistakes"
[ "$(number mistakes 1)" = "$(number named_first 1)" ] || fail "a mistake is not named first"

# ---- the shader in C: roughness is squared twice
run 0 conform gltf --keys $keys --shader kit.h
${CC:-cc} -std=c11 -Wall -Werror -I. "$examples/shader.c" -lm -o shader || fail "the shader does not compile"
./shader >values.csv
run 1 conform gltf values.csv --keys $keys --fail-under 9.9 --worst 2 --junit j.xml --markdown m.md
grep -q '^Likely mistake: roughness is squared twice (with it: lowest JOD 10.00' out || fail "another mistake: $(cat out)"
grep -q 'very different *FAIL *set' out || fail "the worst set is not shown first"
grep -q '^  ... 34 more sets' out && [ "$(grep -c ' FAIL  *set' out)" = 2 ] || fail "--worst does not count"
grep -q "<testsuites name='nqm conform' tests='36'" j.xml || fail "JUnit: $(head -3 j.xml)"
grep -q '^Likely mistake: roughness is squared twice' m.md || fail "Markdown without the mistake"
grep -q '^| FAIL | ' m.md || fail "Markdown without the sets"
run 1 conform gltf - --keys $keys -q <values.csv
[ "$(cat out)" = "roughness is squared twice" ] || fail "--quiet: $(cat out)"

# ---- the same without the mistake passes; -nan is no value
sed 's/alpha = r \* r;/alpha = r;/' "$examples/shader.c" >right.c
${CC:-cc} -I. right.c -lm -o right
./right | sed '2s/.*/-nan,nan,1/' >right.csv
run 0 conform gltf right.csv --keys $keys --json
grep -q '"mistakes": \[\]' out || fail "a mistake is named in a right shader"
grep -q '"facts": {}' out || fail "something separates sets that all pass"
grep -q '1 values are not finite' err || fail "NaN is not told"
[ "$(grep -c '"delta_e_itp"' out)" = 36 ] || fail "JSON without the sets"
# Each spec has the values of its set, and those that are not named are the defaults.
"$tool" conform gltf --keys $keys --directions rows.csv
python3 - >why 2>&1 <<'END' || fail "specs of sets: $(cat why)"
import csv, json
rows = {row["set"]: row for row in csv.DictReader(open("rows.csv"))}
default = {"base_color": (1, 1, 1), "metallic": (1,), "roughness": (1,)}
for result in json.load(open("out"))["results"]:
    row = rows[result["name"].split()[-1]]
    given = {k: tuple(map(float, v.split(","))) for k, v in (pair.split("=") for pair in result["reference"].split(":", 1)[1].split(";") if pair)}
    for key, values in default.items():
        wanted = tuple(float(row[c]) for c in ([key + "_" + c for c in "rgb"] if len(values) == 3 else [key]))
        has = given.get(key, values)
        has = has * (len(wanted) // len(has))
        assert all(abs(a - b) < 1e-6 for a, b in zip(has, wanted)), (result["name"], key, has, wanted)
        assert key not in given or has != values, (result["name"], key, "is the default")
END
# The factor is none that people forget, and the only one that there is.
sed 's/base \/ pi +/base * 0.6f \/ pi +/' right.c >unknown.c
${CC:-cc} -I. unknown.c -lm -o unknown
./unknown >unknown.csv
run 1 conform gltf unknown.csv --keys $keys --markdown m.md
run 0 conform gltf unknown.csv --keys $keys --fail-under 0
grep -q '^No mistake of the list explains' out || fail "a mistake is named that is none: $(cat out)"
# What separates failing from passing sets, and by how much they fail.
separated='^All 32 sets that fail have metallic < 1; so have 0 of the 4 that pass\.$'
grep -q "$separated" out || fail "nothing separates the sets: $(cat out)"
grep -q "$separated" m.md || fail "Markdown without what separates the sets"
grep -q '^Largest difference: [a-z]* of set [0-9]* is 0.6 times the right value' out || fail "largest difference: $(cat out)"
run 1 conform gltf unknown.csv --keys $keys --json
grep -q '"ratio": 0.60000' out || fail "JSON: ratio $(number ratio 1)"
# At which angles; no key separates sets where all fail.
sed 's/(metal \* d \* v - plain) \* m->metallic;/& rgb[c] *= v_h < 0.5f ? 2 : 1;/' right.c >steep.c
${CC:-cc} -I. steep.c -lm -o steep
./steep >steep.csv
run 1 conform gltf steep.csv --keys $keys
grep -q '^100 % of their difference is where theta_d > 60 degrees: 43 % of the directions\.$' out || fail "angles: $(cat out)"
! grep -q 'sets that fail have' out || fail "a key separates no sets: $(cat out)"

sed '3s/.*/-1,1,1/;4s/.*/1,1,-1/' right.csv >negative.csv
run 0 conform gltf negative.csv --keys $keys --fail-under 0
grep -q '^nqm conform: 2 values have a negative channel' err || fail "negative values: $(cat err)"

# ---- mistakes with an amount, and of channels; those that only resemble one are not named
while IFS='|' read -r edit words; do
    sed "$edit" right.c >wrong.c
    ${CC:-cc} -I. wrong.c -lm -o wrong || fail "a shader does not compile: $edit"
    ./wrong >wrong.csv
    run 1 conform gltf wrong.csv --keys $keys -q
    [ "$(cat out)" = "$words" ] || fail "$words: $(cat out)"
done <<'END'
s/rgb.c. = \(.*\);/rgb[c] = \1; rgb[c] \/= 1 + rgb[c];/|unknown
s/alpha = r;/alpha = 0.04f + 0.96f * r;/|unknown
s/powf(1 - v_h, 5)/powf(1 - v_h, 4)/|the exponent of Schlick's factor is not 5 but 4
s/alpha = r;/alpha = fmaxf(r, 0.04f);/|roughness is raised to at least 0.2
s/rgb.c. = \(.*\);/rgb[c] = fminf(\1, 8);/|the values are clamped at 8
s/m->base_color.c./m->base_color[0]/|the values are read as .rrr; or base_color is read as .rrr
s/rgb.c. = \(.*\);/rgb[2 - c] = \1;/|the values are read as .bgr; or base_color is read as .bgr
s/    float h.3. = .*/&\n    rgb[0] = rgb[1] = rgb[2] = 0;/;s/rgb.c. = \(.*\);/rgb[c] += \1; if (c == 0) rgb[1] += 0.1f * rgb[0];/|the values: .r is added to .g, times 0.1
END

# ---- files of all languages and models
run 0 conform open-pbr --shader kit.glsl --directions kit.csv
grep -q '^const vec3 nqm_light\[1872\] = vec3\[1872\](' kit.glsl || fail "no array of GLSL"
[ "$(head -1 kit.csv | tr , '\n' | tail -1)" = viewer_z ] || fail "columns: $(head -1 kit.csv)"
awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "base_color_r") c = i } NR > 1 && !($c >= 0 && $c <= 1) { exit 1 }' kit.csv || fail "a colour is above 1"
run 0 conform rough-conductor --shader kit.hlsl
grep -q '^static const float3 nqm_light\[1872\] = {' kit.hlsl || fail "no array of HLSL"

# ---- faults
refuses 5 'has 67392 values, and the kit has' conform gltf values.csv
sed '5s/.*/1,x,1/' values.csv >bad.csv
refuses 4 'bad.csv.*line 5' conform gltf bad.csv --keys $keys

# ---- Ctrl-C ends the command, too
"$tool" conform gltf --command 'sleep 60 & echo $! >pid; wait' 2>err &
until_written pid
ctrl_c
sleep 0.5
! grep -q '^State:.*[RSD] ' "/proc/$(cat pid)/status" 2>/dev/null || fail "the command runs on"
# ... also one that does not care; and one that prints without end is ended.
rm pid
"$tool" conform gltf --command 'trap "" TERM; echo $$ >pid; while :; do sleep .1; done' 2>err &
until_written pid
ctrl_c
! kill -0 "$(cat pid)" 2>/dev/null || fail "a command that ignores its end runs on"
refuses 7 "printed more than" conform gltf --command yes --keys roughness
