#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm label and nqm render of textured materials: a map of one value is the BRDF, tiles and texels change the picture, refusals.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

map() {
    run 0 render "$1" -o "$2" --size "$3" --light overcast
}
map lambert:kd=.8,.2,.1 "$dir/ball.png" 32

picture() {
    out=$1
    shift
    run 0 render "maps:base_color=$dir/ball.png;roughness=.5;model=gltf" -o "$out" --size 24 "$@"
}
picture "$dir/once.png"
picture "$dir/tiled.png" --tiles 5
picture "$dir/nearest.png" --texels 1
cmp -s "$dir/once.png" "$dir/tiled.png" && fail "--tiles changes nothing"
cmp -s "$dir/once.png" "$dir/nearest.png" && fail "--texels changes nothing"
OMP_NUM_THREADS=2 "$tool" render "maps:base_color=$dir/ball.png;roughness=.5;model=gltf" -o "$dir/one.png" --size 24
cmp "$dir/one.png" "$dir/once.png" || fail "the number of threads changes the picture"

run 0 label "maps:base_color=$dir/ball.png;roughness=.5;model=gltf" \
    "maps:base_color=$dir/ball.png;roughness=.5;model=gltf" "maps:base_color=$dir/ball.png;roughness=.2;model=gltf" \
    gltf:roughness=.5 --points 256 --lights 32 --light studio --quiet
[ "$(sed -n 1p "$dir/out")" = 10.0000 ] || fail "equal textures differ"
[ "$(sed -n 2p "$dir/out")" != 10.0000 ] || fail "another roughness shows no difference"
[ "$(wc -l <"$dir/out")" = 3 ] || fail "three tests have no three labels"
run 0 label "maps:base_color=$dir/ball.png;model=gltf" gltf:roughness=.5 --points 64 --lights 32 --tiles 3 --texels 2 --json
grep -q '"tiles": 3' "$dir/out" && grep -q '"texels": 2' "$dir/out" || fail "the view is not in the JSON"

run 2 render "maps:base_color=$dir/ball.png;model=gltf" -o "$dir/x.png" --size 16 --interreflection
grep -q interreflection "$dir/err" || fail "interreflection is not named"
run 2 render "maps:base_color=$dir/ball.png;model=gltf" -o "$dir/x.png" --tiles 0
