#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm dataset: a small standard corpus of analytic materials (models/plan.py) is the same for one and two threads and from its work
# files; test materials go to a separate file, and far pairs contain other materials of their own split only; any list of pairs is
# labelled; models/scan.py lists a data folder.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
cat >"$dir/materials.csv" <<'END'
name,group,brdf,source,split
m-sgd,brass,sgd:brass,sgd,train
n-ggx,n,ggx:kd=0.2;alpha=0.3,ggx,validation
o-ggx,o,ggx:kd=0.1;alpha=0.1,ggx,test
p-ggx,p,ggx:kd=0.4;alpha=0.5,ggx,train
q-sgd,q,sgd:nickel,sgd,train
r-sgd,r,sgd:chrome,sgd,validation
s-sgd,s,sgd:alumina-oxide,sgd,test
END
"$tool" directions -n 40 -o "$dir/directions.csv" 2>"$dir/err"
plan() {
    NQM_TOOL=$tool PYTHONDONTWRITEBYTECODE=1 python3 "$NQM_SOURCE/models/plan.py" "$dir/$1.csv" --perturbations 2 --far 12 --roundings 1 \
        --variants 2 --models ward
}
plan materials >"$dir/pairs.csv"
from() {
    list=$1
    shift
    "$tool" dataset "$dir/$list.csv" --directions "$dir/directions.csv" --keep far=12 --light studio --lights 64 --points 20 "$@" 2>"$dir/err"
}
make() { from pairs "$@"; }

OMP_NUM_THREADS=1 make -o "$dir/one.safetensors" --work "$dir/groups" >"$dir/out" || fail "$(cat "$dir/err")"
grep -q ' pairs of 5 references in 5 material groups (train [1-9][0-9]*, validation 36, test 0 pairs)' "$dir/out" || fail "summary: $(cat "$dir/out")"
OMP_NUM_THREADS=2 make -o "$dir/two.safetensors" >/dev/null
cmp "$dir/one.safetensors" "$dir/two.safetensors" || fail "two threads give another file"
make -o "$dir/again.safetensors" --work "$dir/groups" --json >"$dir/out"
cmp "$dir/one.safetensors" "$dir/again.safetensors" || fail "work files give another file"
grep -q '"manifest"' "$dir/out" || fail "--json"
grep -q '"brass"' "$dir/one.safetensors.json" || fail "the manifest does not name the material"
grep -q '"o-ggx"' "$dir/one.safetensors.json" && fail "a test material is in the training file"
if grep -qF "$dir" "$dir/one.safetensors.json"; then fail "the manifest names a folder"; fi
[ -z "$(find "$dir" -name '*.part')" ] || fail "left-over files"

# others MANIFEST SPLIT...: each split has far and rounded pairs, and its other materials are references of the same split.
others() {
    python3 - "$@" <<'END' || fail "other materials"
import json
import sys

with open(sys.argv[1]) as file:
    manifest = json.load(file)
splits = {reference["name"]: reference["split"] for reference in manifest["references"]}
others = manifest["other_materials"]
assert sorted(others) == sorted(sys.argv[2:]), others
for split in others:
    assert {splits[name] for name in others[split]} == {split}, (split, others[split])
families = manifest["families"]
assert families["far"] == 12 * len(splits) and families["rounding"] == len(splits), families
assert sum(kind["pairs"] for kind in manifest["kinds"].values() if kind["family"] == "far") == families["far"]
assert not manifest["failures"], manifest["failures"]
END
}
others "$dir/one.safetensors.json" train validation
make -o "$dir/test.safetensors" --only test >/dev/null
others "$dir/test.safetensors.json" test

# The standard plan: every family, the unseen kinds in the test split only, no other material of another split, the same list for the
# same seed, and one in N.
python3 - "$dir/materials.csv" "$tool" "$NQM_SOURCE/models/plan.py" <<'END' || fail "the plan"
import collections
import csv
import os
import subprocess
import sys

materials, tool, script = sys.argv[1:]


def plan(*arguments):
    environment = dict(os.environ, NQM_TOOL=tool, PYTHONDONTWRITEBYTECODE="1")
    text = subprocess.run([sys.executable, script, materials, *arguments], env=environment, check=True, capture_output=True,
                          text=True).stdout
    return text, list(csv.DictReader(text.splitlines()))


text, rows = plan()
assert text == plan()[0] and text != plan("--seed", "2")[0]
families = {"encoding", "published", "perturbation", "composed", "variant", "far", "rounding"}
splits = {row["name"]: row["split"] for row in rows}
for split in ("train", "validation", "test"):
    assert {row["family"] for row in rows if row["split"] == split} >= families - {"published"}, split
unseen = {"clamp", "ripple", "hue", "between-log", "white", "random-lafortune", "random-smooth"}
kinds = {split: {row["kind"] for row in rows if row["split"] == split} for split in ("train", "test")}
assert not kinds["train"] & unseen and kinds["test"] >= {"clamp", "hue", "between-log"}
assert {row["kind"] for row in rows if row["family"] == "variant"} == {"roughness", "key", "overfit", "translated", "folded"}
assert all(splits[row["other"]] == row["split"] for row in rows if row["other"])
assert any(row["other"] for row in rows)
for name in splits:
    own = [row for row in rows if row["name"] == name]
    counts = collections.Counter(row["family"] for row in own)
    assert counts["encoding"] == 22 and counts["far"] == 39 and counts["rounding"] == 3 and counts["variant"] == 8, (name, counts)
    assert counts["perturbation"] + counts["composed"] == 26
few = plan("--every", "4")[1]
assert 0.15 * len(rows) < len(few) < 0.35 * len(rows), (len(few), len(rows))
near = {(row["reference"], row["test"]) for row in few if row["family"] != "far"}
assert near < {(row["reference"], row["test"]) for row in rows}
assert {row["split"] for row in plan("--only", "test")[1]} == {"test"}
END

# The other material of a pair is part of the name of its work file: a change makes the unit again.
sed 's/alpha=0.5/alpha=0.6/' "$dir/materials.csv" >"$dir/list.csv"
plan list >"$dir/changed.csv"
before=$(find "$dir/groups" -name '*.safetensors' | wc -l)
from changed -o "$dir/changed.safetensors" --work "$dir/groups" >/dev/null
after=$(find "$dir/groups" -name '*.safetensors' | wc -l)
[ "$((after - before))" = 3 ] || fail "$before work files, $after after a change of a training material"

# So is the content of a file, and of the measured file that a material names: one of the same name and size makes the unit again, and
# only that. Tests that are files count too.
echo 'Material "measured" "string filename" "file.npy"' >"$dir/file.pbrt"
for file in file.npy file.pbrt; do
    printf 'reference,test\n%s,perturb:scale=2;of=%s\nggx:kd=.1;alpha=.1,ggx:kd=.2;alpha=.1\nggx:alpha=.2,perturb:scale=2;of=%s\n' \
        $file $file $file >"$dir/file.csv"
    "$tool" convert sgd:brass -o "$dir/file.npy" >/dev/null
    from file -o "$dir/first.safetensors" --work "$dir/contents-$file" >/dev/null
    "$tool" convert sgd:chrome -o "$dir/file.npy" >/dev/null
    from file -o "$dir/second.safetensors" --work "$dir/contents-$file" >/dev/null
    from file -o "$dir/expected.safetensors" >/dev/null
    cmp "$dir/second.safetensors" "$dir/expected.safetensors" || fail "work files of another content were used"
    ! cmp -s "$dir/first.safetensors" "$dir/second.safetensors" || fail "the changed file was not read"
    [ "$(find "$dir/contents-$file" -name '*.safetensors' | wc -l)" = 5 ] || fail "the unit without a change was made again"
done

# A damaged work file is computed again.
for file in "$dir"/groups/*.safetensors; do
    head -c 3000 "$file" >"$dir/cut"
    mv "$dir/cut" "$file"
done
make -o "$dir/mended.safetensors" --work "$dir/groups" >/dev/null
cmp "$dir/one.safetensors" "$dir/mended.safetensors" || fail "a damaged work file changed the result"

# Any list: two columns are enough, JSON Lines too; the label is that of `nqm label`, the fit that of `nqm fit`; a pair that fails is named.
ward=$("$tool" fit sgd:nickel --model ward --loss log -q)
cat >"$dir/any.csv" <<'END'
test,reference,material,subset,comment
fit:model=ward;of=sgd:nickel,sgd:nickel,m,ward,c
missing.bsdf,sgd:nickel,m,lost,c
END
"$tool" dataset "$dir/any.csv" --directions "$dir/directions.csv" --points 64 -o "$dir/any.safetensors" >"$dir/out" 2>"$dir/err"
grep -q '1 pairs of 1 references in 1 material groups (train 1,' "$dir/out" || fail "any list: $(cat "$dir/out")"
grep -q '1 pairs of kind lost have no label: .*missing.bsdf' "$dir/err" || fail "failures: $(cat "$dir/err")"
printf '{"reference":"sgd:nickel","test":"%s","name":"sgd:nickel","group":"m","kind":"ward","split":"train"}\n' "$ward" >"$dir/any.jsonl"
"$tool" dataset "$dir/any.jsonl" --directions "$dir/directions.csv" --points 64 -o "$dir/json.safetensors" >/dev/null 2>"$dir/err"
python3 - "$dir/any.safetensors" "$dir/json.safetensors" "$("$tool" label sgd:nickel "$ward" --points 64 --json)" <<'END' || fail "labels"
import json
import struct
import sys


def label(path):
    with open(path, "rb") as file:
        data = file.read()
    n = struct.unpack("<Q", data[:8])[0]
    begin, end = json.loads(data[8:8 + n])["delta_e"]["data_offsets"]
    return struct.unpack("<d", data[8 + n + begin:8 + n + end])[0]


def find(value):
    if isinstance(value, dict):
        return value.get("delta_e_itp") or next(filter(None, map(find, value.values())), None)
    return next(filter(None, map(find, value)), None) if isinstance(value, list) else None


assert label(sys.argv[1]) == label(sys.argv[2])
assert f"{label(sys.argv[1]):.8g}" == f"{find(json.loads(sys.argv[3])):.8g}", (label(sys.argv[1]), sys.argv[3])
END

# models/scan.py: names, groups and splits of a data folder.
scan() { python3 "$NQM_SOURCE/models/scan.py" "$@"; }
mkdir -p "$dir/data/labels" "$dir/data/rgl"
printf 'material,model,level,DeltaE,JOD,class\nbrass_1,ward,0,1,9,1\nfelt_rgb_12,ggx,0,1,9,1\n' >"$dir/data/labels/labels_real.csv"
: >"$dir/data/rgl/felt_rgb.bsdf"
: >"$dir/data/rgl/paper_rgb.bsdf"
scan "$dir/data/" >"$dir/list.csv"
grep -qx 'rgl-felt_rgb,felt_rgb,rgl/felt_rgb.bsdf,rgl,test' "$dir/list.csv" || fail "felt: $(cat "$dir/list.csv")"
grep -q '^rgl-paper_rgb,paper_rgb,rgl/paper_rgb.bsdf,rgl,[tv][^e]' "$dir/list.csv" || fail "paper"
printf 'material,mean0,mean1,mean2,mean3,mean4,mean5,mean6\n"felt, red",0,0,0,0,0,0,0\n"so ""called""",0,0,0,0,0,0,0\n' \
    >"$dir/latents"
mkdir -p "$dir/data/nps"
mv "$dir/latents" "$dir/data/nps/nps_latents.csv"
scan "$dir/data" >"$dir/quoted.csv"
grep -q '^"nps-felt, red","felt, red","nps/nps_decoder_f32le.bin:felt, red",nps,[tv]' "$dir/quoted.csv" ||
    fail "commas: $(grep nps "$dir/quoted.csv")"
grep -q '^"nps-so ""called""","so ""called""",' "$dir/quoted.csv" || fail "quotes: $(grep nps "$dir/quoted.csv")"
grep -qx 'sgd-brass,brass,sgd:brass,sgd,test' "$dir/list.csv" || fail "brass"
[ "$(grep -c '^sgd-' "$dir/list.csv")" = 100 ] || fail "100 presets"
[ "$(grep -Ec '^(renderer|mirror|analytic)-.*,(train|validation|test)$' "$dir/list.csv")" = 59 ] || fail "59 generated specs"
# Specs of the list open, and a material file is listed once for each material, a refused one not at all.
python3 -c 'import csv, sys
for row in csv.DictReader(open(sys.argv[1])):
    if row["source"] in ("renderer", "mirror", "analytic"):
        print(row["brdf"])' "$dir/list.csv" >"$dir/specs"
while read -r spec; do "$tool" info "$spec" >/dev/null || fail "$spec"; done <"$dir/specs"
mkdir -p "$dir/data/materials/some"
material() {
    printf '<materialx version="1.39"><open_pbr_surface name="m" type="surfaceshader">%s</open_pbr_surface></materialx>' "$2" \
        >"$dir/data/materials/some/$1.mtlx"
}
material open_pbr_gold ''
material PB_GLTF_Gold ''
material open_pbr_water '<input name="transmission_weight" type="float" value="1"/>'
scan "$dir/data" >"$dir/files.csv"
[ "$(grep -c '^renderer-gold,renderer-gold,materials/some/.*\.mtlx,renderer,' "$dir/files.csv")" = 1 ] || fail "gold"
if grep -q water "$dir/files.csv"; then fail "a refused material is listed"; fi
[ "$(grep -v '^renderer-gold' "$dir/files.csv")" = "$(cat "$dir/quoted.csv")" ] || fail "another material changes the list"

if scan "$dir" 2>"$dir/err"; then fail 'a folder without labels is accepted'; fi
grep -q labels_real.csv "$dir/err" || fail 'the missing file is not named'
