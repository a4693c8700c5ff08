#!/bin/sh
# SPDX-License-Identifier: MIT
# Broken BRDF files of every format, folders and missing files: each is refused with exit code 3 or 4 within a second,
# with limited memory, and with a message that names the file and, for invalid bytes, the byte offset.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/make_brdf_files" "$dir"
mkdir "$dir/folder.binary"

# The limit of one second is processor time, which does not depend on other load; the limit of wall-clock time only ends
# a tool that hangs. Both limits are relaxed under sanitizers, which map terabytes and start slowly. Plain loops take longer.
if [ -n "${NQM_SANITIZE:-}" ]; then limit=unlimited cpu=20; else limit=400000 cpu=1; fi
[ "${NQM_KERNELS:-}" != scalar ] || unset NQM_KERNELS

# info FILE: run `nqm info FILE`; the exit code goes to $got, the message to $dir/err.
info() {
    got=0
    # shellcheck disable=SC3045 # dash has both options, although POSIX does not require them
    (ulimit -v "$limit" && ulimit -t "$cpu" && exec timeout 1800 "$tool" info "$1") >"$dir/out" 2>"$dir/err" || got=$?
}

# refused CODE ARGUMENT FILE
refused() {
    info "$2"
    [ "$got" = "$1" ] || fail "$2: exit code $got, not $1: $(cat "$dir/err")"
    [ ! -s "$dir/out" ] || fail "$2: results on failure"
    grep -qF "$3" "$dir/err" || fail "$2: the message does not name the file: $(cat "$dir/err")"
    [ "$(wc -l <"$dir/err")" = 1 ] || fail "$2: more than one line: $(cat "$dir/err")"
}

for file in valid.binary valid.bsdf valid.h5 valid.zip:valid valid.bin:first valid-network.safetensors valid-table.safetensors; do
    info "$dir/$file"
    [ "$got" = 0 ] || fail "$file: exit code $got: $(cat "$dir/err")"
done

n=0
for file in "$dir"/merl-* "$dir"/rgl-* "$dir"/nbrdf-*.h5 "$dir"/nbrdf-*.zip:short "$dir"/nps-* "$dir"/saved-*; do
    case $file in
    *.zip:short) argument=$dir/nbrdf-truncated.zip:short file=$dir/nbrdf-truncated.zip ;;
    *.bin) argument=$file:first ;;
    *) argument=$file ;;
    esac
    refused 4 "$argument" "$file"
    grep -q 'byte [0-9]' "$dir/err" || fail "$argument: the message names no byte: $(cat "$dir/err")"
    n=$((n + 1))
done
[ "$n" -ge 20 ] || fail "only $n broken files"

refused 3 "$dir/folder.binary" folder.binary
refused 3 "$dir/missing.binary" missing.binary
refused 3 "$dir/missing.zip:steel" missing.zip
refused 3 "$dir/valid.zip:missing" valid.zip
refused 3 "$dir/valid.bin:missing" nps_latents.csv
if [ "$(id -u)" != 0 ]; then
    chmod a-r "$dir/valid.bsdf"
    refused 3 "$dir/valid.bsdf" valid.bsdf
fi
echo "$n broken files refused"
