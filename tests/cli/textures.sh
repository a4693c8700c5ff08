#!/bin/sh
# SPDX-License-Identifier: MIT
# Materials with image maps in score, batch, rank, info and report: mistakes by name, gates, heat maps, lists, messages.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
python3 "$NQM_SOURCE/examples/maps.py" "$dir" 8 # few texels: with normals each takes 6 ms, and much more in builds with checks
cd "$dir"

run 0 score steel export --map heat.png
for words in 'roughness is squared' 'green channel of the normal map is flipped' 'worst 5 %' 'from afar'; do
    grep -q "$words" out || fail "no '$words' in: $(cat out)"
done
[ "$(head -c 4 heat.png | tail -c 3)" = PNG ] || fail "no heat map"
run 0 score half 'maps:base_color=half/steel_Color.png;roughness=.4' --exact
run 0 score -q steel steel
[ "$(cat out)" = 10.0000 ] || fail "a texture differs from itself: $(cat out)"
run 0 score steel export half --json
jod=$(number jod 1)
for key in '"median_jod"' '"far_jod_low"' '"blame"' '"mistake": "roughness is squared"' '"property": "normal"'; do
    grep -q "$key" out || fail "no $key in the JSON"
done
run 0 score steel export --csv
head -1 out | grep -q 'median_jod,worst_jod,below_9,below_8,far_jod,.*blame,blame_jod,mistake' || fail "columns: $(head -1 out)"
run 0 score steel half --map heat.exr -q
[ -s heat.exr ] || fail "no heat map in OpenEXR"

# Gates, and verbs that take lists.
run 1 score steel export half --fail-under 9.5
run 1 score steel export --fail-under-worst 8
grep -q 'worst 5 % of texels below 8' err || fail "the gate is not named"
run 0 score steel half --fail-under-worst 2
printf 'reference,test\nsteel,export\nsgd:nickel,ward:nickel\n' >pairs.csv
run 0 batch pairs.csv -o scores.csv
awk -F, -v jod="$jod" 'NR == 2 { exit !($3 > jod - .001 && $3 < jod + .001) }' scores.csv || fail "batch: $(cat scores.csv)"
run 0 rank steel export half
grep -n half out | head -1 | grep -q '^[1-9]' || fail "rank: $(cat out)"
awk '/half/ { half = NR } /export/ { export_ = NR } END { exit !(half < export_) }' out || fail "the better one is not first"

# A texture beside a BRDF, maps one by one, and what info says.
run 0 score -q 'maps:base_color=steel/steel_Color.png;roughness=.4;metallic=1' 'gltf:base_color=.56,.55,.53;roughness=.4'
run 0 info steel --json
grep -q '"varying": "base_color roughness metallic normal"' out || fail "info: $(cat out)"

# A path of MaterialX that leads out of the folder is looked for without its "../".
cat >plate.mtlx <<END
<?xml version="1.0"?>
<materialx version="1.39">
  <image name="i" type="color3"><input name="file" type="filename" value="../../../gone/../steel/steel_Color.png" colorspace="srgb_texture"/></image>
  <image name="j" type="float"><input name="file" type="filename" value="../../../steel/steel_Roughness.png"/></image>
  <gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i"/><input name="roughness" type="float" nodename="j"/></gltf_pbr>
  <surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>
</materialx>
END
sed 's,gone/../steel,steel,' plate.mtlx >found.mtlx
run 0 score -q found.mtlx 'maps:base_color=steel/steel_Color.png;roughness=steel/steel_Roughness.png;metallic=1'
[ "$(cat out)" = 10.0000 ] || fail "MaterialX and a list of the same maps: $(cat out)"
refuses 3 'steel_Color.png.*No such file' score plate.mtlx steel

# Columns of batch, pixels of several texels, and checks.
run 0 batch pairs.csv --textures
head -1 out | grep -q 'median_jod,worst_jod,below_9,below_8,far_jod,far_jod_low,far_jod_high' || fail "columns: $(head -1 out)"
run 0 batch pairs.csv --textures --work pieces -o again.csv
run 0 batch pairs.csv --textures -o scores.csv
cmp again.csv scores.csv || fail "textures in pieces have other columns"
flat='maps:base_color=steel/steel_Color.png;roughness=steel/steel_Roughness.png;metallic=steel/steel_Metalness.png'
run 0 score "$flat" 'gltf:roughness=.5' --texels-per-pixel 2
grep -q 'pixels of 2 x 2 texels: median' out || fail "pixels: $(cat out)"
run 0 check export "$flat"
grep -q 'export: plausible; 0 of .* texels fail' out || fail "check: $(cat out)"
"$tool" check "maps:base_color=1.5,1.5,1.5;roughness=steel/steel_Roughness.png;metallic=0" --json >out 2>err || :
grep -q '"checked"' out || grep -q base_color err || fail "check as JSON: $(cat out err)"

# A report has the maps, the heat map and the scores of textures.
run 0 report "$flat" 'gltf:roughness=.5' -o page.html --size 16
for words in 'Over the texels' 'from afar' 'Map of Delta-E ITP of the texels' 'Maps of the reference' 'roughness alone' '8 × 8 texels, maps of'; do
    grep -q "$words" page.html || fail "no '$words' in the report"
done

# A translation is written with its maps, which are packed as glTF has them, and is scored.
surface='base_color=steel/steel_Color.png;metalness=steel/steel_Metalness.png;specular_roughness=steel/steel_Roughness.png'
run 0 translate "maps:$surface;normal=steel/steel_NormalGL.png;coat=.5;model=standard-surface" --to gltf -o new.gltf --loss log --samples 200
awk '/^JOD/ { exit !($2 > 9) }' out || fail "translation: $(cat out)"
for word in '"baseColorTexture": {"index": 0}' '"metallicRoughnessTexture": {"index": 1}' '"normalTexture": {"index": 2}' new_normal.png; do
    grep -q "$word" new.gltf || fail "no $word in $(cat new.gltf)"
done
run 0 score -q new.gltf new.gltf
run 0 translate steel --to gltf -o same.gltf --loss log --samples 200
awk '/^JOD/ { exit !($2 > 9.9) }' out || fail "the same model: $(cat out)"

# A material and its maps are written whole or not at all.
mkdir old old/new_normal.png
cp new.gltf new_baseColor.png old
cp half/steel_Color.png old/new_baseColor.png
run 3 translate "maps:$surface;normal=steel/steel_NormalGL.png;model=standard-surface" --to gltf -o old/new.gltf --loss log --samples 200
grep -q 'old/new_normal.png: cannot write' err || fail "the map is not named: $(cat err)"
cmp -s new.gltf old/new.gltf && cmp -s half/steel_Color.png old/new_baseColor.png || fail 'a part of the set was replaced'
[ "$(ls old | wc -l)" = 3 ] || fail "left over: $(ls old)"

# A channel that a picture has not.
for map in steel/steel_Color.png:a steel/steel_Roughness.png:b steel/steel_Roughness.png:a; do
    run 4 score steel "maps:base_color=steel/steel_Color.png;roughness=$map"
    grep -q "has no alpha: name another channel\|has one channel, which" err || fail "$map: $(cat err)"
done

# A service reads no file outside of its folder, by whatever path or link.
mkdir inside
cp -r steel half inside
ln -s ../../half/steel_Color.png inside/half/link.png
run 0 score -q inside/steel inside/half --within inside
for map in half/steel_Color.png inside/../half/steel_Color.png "$dir/half/steel_Color.png" inside/half/link.png; do
    run 3 score inside/steel "maps:base_color=$map" --within inside
    grep -q "is not read: no file inside of .*inside" err || fail "$map: $(cat err)"
done
run 3 score inside/steel inside/half --within gone

# Messages.
run 3 score steel 'maps:base_color=gone.png;model=gltf' half
grep -q "^ *[0-9.]* .*half" out || fail "a test that fails stops the others"
run 2 score steel export --model paper
grep -q "'paper' predicts no Delta-E" err || fail 'the model is not named'

# USD: a grey image is values as they are unless the file says sRGB, one of three channels of 8 bits is sRGB.
# usda NAME COLOUR_SPACE MAP INPUT OUTPUT
usda() {
    printf '#usda 1.0\ndef Material "M" {\n token outputs:surface.connect = </M/S.outputs:surface>
 def Shader "S" {\n uniform token info:id = "UsdPreviewSurface"\n %s.connect = </M/T.outputs:%s>\n token outputs:surface\n }
 def Shader "T" {\n uniform token info:id = "UsdUVTexture"\n asset inputs:file = @%s@\n %s\n float outputs:r float3 outputs:rgb\n }\n}\n' \
        "$4" "$5" "$3" "${2:+token inputs:sourceColorSpace = \"$2\"}" >"$1"
}
for space in raw auto sRGB ''; do
    usda "rough$space.usda" "$space" steel/steel_Roughness.png 'float inputs:roughness' r
    usda "color$space.usda" "$space" steel/steel_Color.png 'color3f inputs:diffuseColor' rgb
done
# same A B YES|NO
same() {
    run 0 score -q "$1" "$2"
    [ "$(cat out)" = 10.0000 ] && is=YES || is=NO
    [ $is = "$3" ] || fail "$1 and $2: $(cat out)"
}
same rough.usda roughraw.usda YES
same roughauto.usda roughraw.usda YES
same roughsRGB.usda roughraw.usda NO
same color.usda colorsRGB.usda YES
same colorauto.usda colorsRGB.usda YES
same colorraw.usda colorsRGB.usda NO

# What nothing gives is said, and is the same for a folder and a list.
mkdir plain
cp steel/steel_Color.png plain/x_COL_VAR1_2K.png
cp steel/steel_Roughness.png plain/x_AO_2K.png
run 0 score -q plain 'maps:base_color=steel/steel_Color.png'
[ "$(cat out)" = 10.0000 ] || fail "a folder and a list without metalness: $(cat out)"
grep -q 'plain: not used: x_AO_2K.png; metallic is 0, as nothing gives it' err || fail "remarks: $(cat err)"
grep -q 'maps:base_color=.*: metallic is 0' err || fail "remark of the list: $(cat err)"
run 0 info plain --json
grep -q '"remark": "not used: x_AO_2K.png' out || fail "info: $(cat out)"

# WebP wherever a map may be: a lossless picture is the PNG with the same pixels. The picture of glTF's extension comes before `source`.
mkdir web web/webp web/png
python3 - <<'END'
import base64
import struct
import zlib


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


pixels = [bytes((30 * i, 255 - 9 * i, 4 * i * i)) for i in range(8)]
for name, order in ("png/base_color", 1), ("other", -1):
    rows = b"".join(b"\0" + b"".join(pixels[::order][4 * y:4 * y + 4]) for y in range(2))
    with open("web/%s.png" % name, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 4, 2, 8, 2, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
with open("web/webp/base_color.webp", "wb") as f:
    f.write(base64.b64decode("UklGRjgAAABXRUJQVlA4TCsAAAAvA0AAAD/w+//xUNpIChy+TyKRSCSS+Y/QsNgcLo8PAgEytqBFixYR/Q9sAA=="))
END
for kind in png webp; do
    map=$kind/base_color.$kind
    usda web/$kind.usda '' $map 'color3f inputs:diffuseColor' rgb
    sed "s,../../../gone/../steel/steel_Color.png,$map,; /image name=.j/d; s,<input name=.roughness[^>]*>,," plate.mtlx >web/$kind.mtlx
    printf '{"type": "principled", "base_color": {"type": "bitmap", "filename": "%s"}}' $map >web/$kind.json
    printf '<scene version="3.0.0"><bsdf type="diffuse" id="m"><texture type="bitmap" name="reflectance"><string name="filename" value="%s"/></texture></bsdf></scene>' $map >web/$kind.xml
    printf 'Texture "t" "spectrum" "imagemap" "string filename" "%s" Material "diffuse" "texture reflectance" "t"' $map >web/$kind.pbrt
    printf '{"asset": {"version": "2.0"}, "images": [{"uri": "other.png"}, {"uri": "%s"}], "textures": [{"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}, {"source": 0}],
  "materials": [{"name": "M", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, {"name": "N", "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}]}' $map >web/$kind.gltf
done
for pair in webp.usda:png.usda webp.mtlx:png.mtlx webp.json:png.json webp.xml:png.xml webp.pbrt:png.pbrt webp:png; do
    same "web/${pair%:*}" "web/${pair#*:}" YES
done
same web/webp.gltf:M web/png.gltf:M YES
same web/webp.gltf:M web/png.gltf:N NO
same web/webp 'maps:base_color=web/other.png' NO
