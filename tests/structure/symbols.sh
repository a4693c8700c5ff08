#!/bin/sh
# SPDX-License-Identifier: MIT
# Symbols of the libraries: every external symbol starts with nqm_; the shared libraries export exactly the functions that the
# public headers declare with NQM_API; libnqm.so contains no symbol of the rooms of libnqm-full.so and needs no
# library for rendering, because scoring must not depend on them; libraries that are loaded on demand are not linked; no library
# prints, exits, starts programs, or uses the environment.
set -eu
build=${NQM_BUILD:?} source=${NQM_SOURCE:?}
bad=0
fail() {
    echo "$1"
    bad=1
}

strangers=$(nm --defined-only --extern-only "$build/libnqm-full.a" | awk 'NF == 3 && $3 !~ /^nqm_/ {print $3}')
[ -z "$strangers" ] || fail "symbols without the nqm_ prefix: $strangers"

# Declared names: the identifier before the first "(" after NQM_API.
declared() { { tr '\n' ' ' <"$1"; echo; } | sed 's/NQM_API/\n&/g' | sed -n 's/^NQM_API[^(;]*[ *]\(nqm_[a-z0-9_]*\)(.*/\1/p'; }
exported() { nm --dynamic --defined-only "$1" | awk '$3 ~ /./ {print $3}' | sort -u; }
core_headers="base material brdf samples percept model metric texture pairs library"
for h in $core_headers; do declared "$source/include/nqm/$h.h"; done | sort -u >"$build/declared-core.txt"
for h in $core_headers fit render match data train label translate conform corpus; do declared "$source/include/nqm/$h.h"; done | sort -u >"$build/declared-full.txt"
[ "$(wc -l <"$build/declared-core.txt")" -gt 30 ] || fail "hardly any declaration was found: the test is broken"
exported "$build/libnqm.so" | diff "$build/declared-core.txt" - || fail "libnqm.so exports other names than its headers declare (< declared, > exported)"
exported "$build/libnqm-full.so" | diff "$build/declared-full.txt" - || fail "libnqm-full.so: the same"

for room in encode fit render data train judge label translate conform corpus; do
    nm --defined-only --extern-only "$build"/CMakeFiles/nqm_full_objects.dir/src/"$room"/*.o
done | awk 'NF == 3 {print $3}' | sort -u >"$build/full-symbols.txt"
[ -s "$build/full-symbols.txt" ] || fail "no symbol of the full library was found: the test is broken"
nm "$build/libnqm.so" | awk '{print $NF}' | sort -u | comm -12 - "$build/full-symbols.txt" >"$build/leaked.txt"
[ ! -s "$build/leaked.txt" ] || fail "libnqm.so contains symbols of the full library: $(cat "$build/leaked.txt")"
if readelf -d "$build/libnqm.so" | grep -E 'NEEDED.*embree'; then fail "libnqm.so needs a library of the labelling chain"; fi
for binary in libnqm.so libnqm-full.so nqm; do
    if readelf -d "$build/$binary" | grep -E 'NEEDED.*(matio|dnnl|embree)'; then fail "$binary is linked with a library that must be loaded on demand"; fi
done

for library in libnqm.so libnqm-full.so; do
    forbidden=$(nm --dynamic --undefined-only "$build/$library" | awk '{ sub(/@.*/, "", $NF); print $NF }' |
        grep -xE 'printf|__printf_chk|vprintf|__vprintf_chk|puts|putchar|perror|stderr|getenv|secure_getenv|setenv|putenv|system|popen|posix_spawnp?|v?fork|exec[lv][pe]*|umask|stdin|stdout|_?exit|_Exit|quick_exit|abort|setlocale' || true)
    [ -z "$forbidden" ] || fail "$library calls $(echo "$forbidden" | tr '\n' ' ')"
done

# Programs that only score install libnqm.so alone, with the built-in model.
size=$(wc -c <"$build/libnqm.so")
[ "$size" -le 20000000 ] || fail "libnqm.so has $size bytes, more than 20 MB"
exit $bad
