#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm render: pictures have the requested size and format; a Lambert sphere under a white light has its albedo times the
# exposure; frames and their names; the same bytes for 1 and 2 threads; refusals.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
# render CODE ARGUMENTS...
render() {
    code=$1
    shift
    run "$code" render "$@"
}

{
    printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n'
    i=0
    while [ $i -lt 32 ]; do
        printf '\200\200\200\201'
        i=$((i + 1))
    done
} >"$dir/white.hdr"

render 0 lambert:kd=.5,.5,.5 -o "$dir/grey.hdr" --light "$dir/white.hdr" --size 40x24 --exposure 100 --json
grep -q '"mean": 50\.' "$dir/out" || grep -q '"mean": 49\.99' "$dir/out" || fail "a grey of 0.5 does not show at 50 cd/m2"
grep -q "\"$dir/grey.hdr\"" "$dir/out" || fail "the file is not named"
head -n 1 "$dir/grey.hdr" | grep -q '^#?RADIANCE' || fail "no Radiance HDR"
grep -a -q '^-Y 24 +X 40$' "$dir/grey.hdr" || fail "not 40 x 24 pixels"
# A written picture can be read as a light map.
render 0 lambert:kd=.5,.5,.5 -o "$dir/grey.exr" --light "$dir/grey.hdr" --size 16
[ "$(od -A n -t x1 -N 4 "$dir/grey.exr")" = " 76 2f 31 01" ] || fail "no OpenEXR"
render 0 lambert:kd=.5,.5,.5 -o "$dir/again.png" --light "$dir/grey.exr" --size 16

OMP_NUM_THREADS=1 "$tool" render sgd:nickel -o "$dir/one.png" --size 24
OMP_NUM_THREADS=2 "$tool" render sgd:nickel -o "$dir/two.png" --size 24
cmp "$dir/one.png" "$dir/two.png" || fail "the number of threads changes the picture"
[ "$(png_size "$dir/one.png")" = "24 24" ] || fail "not 24 x 24 pixels"
render 0 sgd:nickel -o "$dir/black.png" --size 24 --background black
! cmp -s "$dir/one.png" "$dir/black.png" || fail "the background changes nothing"
render 0 sgd:nickel -o "$dir/light.png" --size 24 --background light
! cmp -s "$dir/light.png" "$dir/black.png" || fail "the light is black"

# Frames: the number is inserted before the file extension, or at %d in the name.
render 0 sgd:nickel -o "$dir/turn.png" --size 8 --frames 2 --supersample 1
{ [ -f "$dir/turn-0001.png" ] && [ -f "$dir/turn-0002.png" ] && [ ! -f "$dir/turn.png" ]; } || fail "names of frames"
render 0 sgd:nickel -o "$dir/%03d-turn.exr" --size 8 --frames 2 --supersample 1
{ [ -f "$dir/001-turn.exr" ] && [ -f "$dir/002-turn.exr" ]; } || fail "names of frames with %03d"

render 2 sgd:nickel
grep -q -e '-o FILE' "$dir/err" || fail "the message does not say what is missing"
render 2 -o "$dir/x.png"
render 2 sgd:nickel -o "$dir/x.jpg" --size 8
render 2 sgd:nickel -o "$dir/x.png" --size 0
render 2 sgd:nickel -o "$dir/x.png" --size 8x
render 2 sgd:nickel -o "$dir/x.png" --size 99999
render 2 sgd:nickel -o "$dir/x.png" --size 4096 --supersample 16
render 2 sgd:nickel -o "$dir/x.png" --size 3000 --quality
says '2 x 2 points per pixel (--supersample): at most 4096 x 2048 pixels'
render 2 sgd:nickel -o "$dir/x.png" --points 100
render 2 sgd:nickel -o "$dir/x.png" --background green
render 2 sgd:nosuchmetal -o "$dir/x.png" --size 8
render 3 sgd:nickel -o "$dir/nowhere/x.png" --size 8
render 3 sgd:nickel -o "$dir/x.png" --size 8 --shape "$dir/nowhere.ply"
printf 'ply\nformat ascii 1.0\nelement vertex 9\n' >"$dir/bad.ply"
render 4 sgd:nickel -o "$dir/x.png" --size 8 --shape "$dir/bad.ply"
grep -q 'bad.ply: PLY in line' "$dir/err" || fail "the message does not name file and line"
[ ! -f "$dir/x.png" ] || fail "a failure left a picture"

# The output is checked before the work, and Ctrl-C stops it: this picture would take minutes.
long="--size 256 --lights 16384"
# shellcheck disable=SC2086
render 3 sgd:nickel -o "$dir/nowhere/x.png" $long
# shellcheck disable=SC2086
interrupt render sgd:nickel -o "$dir/stopped.png" $long
[ -z "$(find "$dir" -name '*stopped*')" ] || fail "Ctrl-C left a file"
