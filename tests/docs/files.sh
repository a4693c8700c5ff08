#!/bin/sh
# SPDX-License-Identifier: MIT
# Make the files that the commands in README.md and doc/ name, in the folder BUILD/docs-files; pages.py copies them to the scratch
# folder of each page. They are small: the models and corpora have the right form, but their numbers mean nothing.
set -eu
folder=${NQM_BUILD:?}/docs-files nqm=${NQM_TOOL:?}
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"

# BRDFs: a measurement (a MERL table), an approximation of it (a network file), a light map and a shape.
"$nqm" convert sgd:nickel -o measured.binary
"$nqm" fit sgd:nickel --model hyper-low -o approximation.safetensors -q
"$nqm" render lambert:kd=.8 -o probe.exr --size 64x32 --background light >/dev/null
cat >paints.mtlx <<END
<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709">
  <open_pbr_surface name="s1" type="surfaceshader">
    <input name="base_color" type="color3" value="0.6, 0.1, 0.05"/>
  </open_pbr_surface>
  <open_pbr_surface name="s2" type="surfaceshader">
    <input name="base_color" type="color3" value="0.6, 0.1, 0.05"/>
    <input name="coat_weight" type="float" value="1"/>
    <input name="coat_roughness" type="float" value="0.2"/>
  </open_pbr_surface>
  <surfacematerial name="plain" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s1"/>
  </surfacematerial>
  <surfacematerial name="coated" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s2"/>
  </surfacematerial>
</materialx>
END
cat >glass.gltf <<END
{"asset": {"version": "2.0"}, "materials": [
{"name": "bottle", "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.2, 0.5, 0.3, 1]},
 "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}}},
{"name": "window", "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [1, 1, 1, 0.1]}, "alphaMode": "BLEND",
 "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}]}
END
python3 "$NQM_SOURCE/examples/maps.py" .
cat >bunny.ply <<END
ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
element face 8
property list uchar int vertex_indices
end_header
1 0 0
-1 0 0
0 1 0
0 -1 0
0 0 1
0 0 -1
3 0 2 4
3 2 1 4
3 1 3 4
3 3 0 4
3 2 0 5
3 1 2 5
3 3 1 5
3 0 3 5
END

# A corpus, its test pairs, a model trained on it.
cat >materials.csv <<END
name,group,brdf,source,split
nickel,nickel,sgd:nickel,sgd,train
brass,brass,sgd:brass,sgd,train
blue-rubber,blue-rubber,sgd:blue-rubber,sgd,train
pink-felt,pink-felt,sgd:pink-felt,sgd,validation
gold-paint,gold-paint,sgd:gold-paint,sgd,validation
alum-bronze,alum-bronze,sgd:alum-bronze,sgd,test
red-plastic,red-plastic,sgd:red-plastic,sgd,test
END
"$nqm" directions show default -o directions.csv
NQM_TOOL=$nqm PYTHONDONTWRITEBYTECODE=1 python3 "$NQM_SOURCE/models/plan.py" materials.csv --models ward,ggx --perturbations 3 |
    awk 'NR % 4 == 1' >corpus.csv # enough of every kind
"$nqm" dataset corpus.csv --directions directions.csv --keep far=26 --points 100 --lights 64 -o train.safetensors
# The same pairs as test pairs: to make another dataset would take as long as all the rest.
python3 - <<END
import hashlib
import json
data = bytearray(open("train.safetensors", "rb").read())
n = 8 + int.from_bytes(data[:8], "little")
begin, end = json.loads(data[8:n])["group_split"]["data_offsets"]
data[n + begin:n + end] = b"\2" * (end - begin)
at = data.index(b'"sha256":"') + 10
data[at:at + 64] = b"0" * 64
data[at:at + 64] = hashlib.sha256(data).hexdigest().encode()
open("test.safetensors", "wb").write(data)
END
cp train.safetensors corpus.safetensors
"$nqm" train train.safetensors --hidden 32,16,8 --epochs 3 -o my.safetensors --log loss.csv

# A study in the authors' layout.
mkdir authors-data
"$NQM_BUILD/tests/authors_folder" authors-data
cp -r authors-data/. .

# A list of pairs, and scores that people might have given them.
cat >pairs.csv <<END
reference,test
sgd:nickel,ward:nickel
sgd:nickel,abc:nickel
sgd:brass,ward:brass
sgd:brass,abc:brass
END
cat >opinions.csv <<END
reference,test,score
sgd:nickel,ward:nickel,2.1
sgd:nickel,abc:nickel,3.4
sgd:brass,ward:brass,2.6
sgd:brass,abc:brass,3.9
END
