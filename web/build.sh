#!/bin/sh
# SPDX-License-Identifier: MIT
# ./dev web: build-web/nqm.html, one file that works without network, and the module build-web/npm (nqm.js, nqm.wasm, nqm.models, types).
# expat, jansson, OpenEXR and zlib come from Debian's source packages, which are fetched once into build-web/sources; NQM_WEB_SOURCES names a
# folder that has them already (expat/, jansson/, openexr/, zlib/).
set -eu
cd "$(dirname "$0")/.."
out=$PWD/build-web
say() { printf '%s\n' "$*" >&2; }

# The lists of source packages, in a folder of our own: no change of the system, no root.
apt_private() {
    tool=$1
    shift
    "$tool" -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$out/apt/parts" -o Dir::State::Lists="$out/apt/lists" \
        -o Dir::Cache="$out/apt/cache" "$@"
}

# fetch PACKAGE FOLDER: the newest version that the mirror has, with Debian's patches.
fetch() {
    [ ! -e "$sources/$2" ] || return 0
    say "fetching the sources of $1"
    for version in $(apt_private apt-cache showsrc "$1" | sed -n 's/^Version: //p' | sort -rVu); do
        rm -rf "$out/apt/new"
        mkdir -p "$out/apt/new"
        if (cd "$out/apt/new" && apt_private apt-get -qq source "$1=$version") >"$out/apt/log" 2>&1; then
            mkdir -p "$sources"
            mv "$out/apt/new/$1"-*/ "$sources/$2"
            return 0
        fi
    done
    cat "$out/apt/log" >&2
    say "the sources of $1 cannot be fetched; unpack them to a folder and set NQM_WEB_SOURCES (folders expat, jansson, openexr, zlib)"
    exit 1
}

fetch_all() {
    mkdir -p "$out/apt/parts" "$out/apt/lists/partial" "$out/apt/cache/archives/partial"
    for file in /etc/apt/sources.list.d/debian*.sources; do
        [ ! -e "$file" ] || sed 's/^Types:.*/Types: deb-src/' "$file" >"$out/apt/parts/${file##*/}"
    done
    [ ! -e /etc/apt/sources.list ] || sed -n 's/^deb /deb-src /p' /etc/apt/sources.list >"$out/apt/parts/old.list"
    apt_private apt-get -qq update >&2 || true
    fetch expat expat
    fetch jansson jansson
    fetch openexr openexr
    fetch zlib zlib
}

sources=${NQM_WEB_SOURCES:-$out/sources}
for name in expat jansson openexr zlib; do
    [ -d "$sources/$name" ] || { fetch_all && break; }
done
mkdir -p "$out/npm"
models_stamp=$out/models.bin
if [ ! -e "$models_stamp" ] || [ -n "$(find web/pack_models.py models -newer "$models_stamp" -name '*.safetensors' -o -newer "$models_stamp" -name pack_models.py)" ]; then
    python3 web/pack_models.py models "$out/models.bin" "$out/models.c"
fi
[ -f "$out/cmake/build.ninja" ] || cmake -S . -B "$out/cmake" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/web/toolchain.cmake" \
    -DCMAKE_BUILD_TYPE=Release -DNQM_WEB_SOURCES="$sources" -DNQM_WEB_MODELS="$out/models.c" >&2
cmake --build "$out/cmake" >&2
cp "$out/cmake/nqm_code.wasm" "$out/npm/nqm.wasm"
cp "$out/models.bin" "$out/npm/nqm.models"
cp web/nqm.js web/wasi.js web/zip.js web/index.js web/index.d.ts web/package.json "$out/npm/"
python3 web/pack_page.py "$out/npm/nqm.wasm" "$out/models.bin" "$out/nqm.html"
