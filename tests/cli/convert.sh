#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm convert: a table opens as the same BRDF; an interrupted or failed conversion keeps the previous file; exit codes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

"$tool" convert 'lambert:kd=.3,.2,.1' -o "$dir/a.binary" >"$dir/out"
grep -q "$dir/a.binary" "$dir/out" || fail "text: $(cat "$dir/out")"
[ "$(wc -c <"$dir/a.binary")" = 34992012 ] || fail "size"
"$tool" info "$dir/a.binary" --json | grep -q '"format": "merl"' || fail "the table is no MERL table"
"$tool" convert "$dir/a.binary" --output "$dir/b.binary" --json >"$dir/out"
grep -q '"output": "'"$dir"'/b.binary"' "$dir/out" || fail "json: $(cat "$dir/out")"
cmp "$dir/a.binary" "$dir/b.binary" || fail "a copy of a table differs"
"$tool" convert "$dir/a.binary" -o - | cmp - "$dir/a.binary" || fail "standard output"
"$tool" convert "$dir/a.binary" --format merl-360 -o "$dir/full.binary" --json | grep -q '90 x 90 x 360' || fail "360"
"$tool" info "$dir/full.binary" --json | grep -q '"reciprocal": false' || fail "a table of 360 phi_d is called reciprocal"
rm "$dir/full.binary"
"$tool" convert "$dir/a.binary" --format npy -o "$dir/a.npy" >/dev/null
"$tool" info "$dir/a.npy" --json | grep -q '"layout": "90x46x24 nodes"' || fail "the array is no table"

# A slow conversion is interrupted: the previous file is unchanged, and there is no new file.
"${NQM_BUILD:?}/tests/make_brdf_files" "$dir"
rm -f "$dir"/*-*
cp "$dir/a.binary" "$dir/kept.binary"
: >"$dir/err"
before=$(ls "$dir")
OMP_NUM_THREADS=1 "$tool" convert "$dir/valid.bin:first" -o "$dir/kept.binary" >"$dir/out" 2>"$dir/err" &
sleep 1
kill -INT $!
sleep 1
kill -INT $! || true # the first may precede the handler if starting takes a second; a third one would kill
got=0
wait $! || got=$?
[ "$got" = 130 ] || fail "interrupted: exit code $got: $(cat "$dir/err")"
cmp "$dir/a.binary" "$dir/kept.binary" || fail "the old file is gone"
[ "$(ls "$dir")" = "$before" ] || fail "left behind: $(ls "$dir")"
