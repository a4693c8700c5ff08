#!/bin/sh
# SPDX-License-Identifier: MIT
# Build build/wheel/nqm-VERSION-py3-none-manylinux_2_XX_x86_64.whl, which has the library, models and the tool for any Python, and the
# sdist of the Python package alone. Libraries that not every Linux has are inside under names of their own. Left out: the models of
# the paper (20 MB packed).
# usage: packages/wheel.sh        (on Debian 12, from the folder of ./dev; ./dev wheel installs what it needs; NQM_MIRROR: another mirror)
set -eu
version=$(sed -n 's/^#define NQM_VERSION_[A-Z]* //p' include/nqm/base.h | tr '\n' '.' | sed 's/\.$//')
folder=$PWD/build/wheel
site=$folder/unpacked/nqm-$version info=$folder/unpacked/nqm-$version/nqm-$version.dist-info
mkdir -p "$folder/models" "$folder/embree"
rm -rf "$folder/unpacked" "$folder/python" "$folder"/*.whl "$folder"/*.tar.gz
run() { "$@" >>"$folder/build.log" 2>&1 || { tail -n 30 "$folder/build.log"; echo "failed: $*; all output is in $folder/build.log" >&2; exit 1; }; }
: >"$folder/build.log"
if command -v ccache >/dev/null 2>&1; then export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi

# Debian's Embree has each instruction set and geometry (16 MB packed); nqm needs triangles by SSE2. The same sources give the same labels.
embree=$folder/embree/libnqm-embree3.so.3
if [ ! -f "$embree" ]; then
    cd "$folder/embree"
    mkdir -p parts lists/partial
    # shellcheck source=/dev/null
    printf 'deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main\n' "${NQM_MIRROR:-http://deb.debian.org/debian}" \
        "$(. /etc/os-release && echo "$VERSION_CODENAME")" >parts/sources.list
    apt="apt-get -q -o Dir::Etc::SourceList=$PWD/parts/sources.list -o Dir::Etc::SourceParts=/dev/null -o Dir::State::Lists=$PWD/lists"
    # shellcheck disable=SC2086
    { run $apt update && run $apt source --tar-only embree; }
    tar -xf embree_*.orig.tar.xz
    off=
    for geometry in QUAD CURVE SUBDIVISION USER INSTANCE GRID POINT; do off="$off -DEMBREE_GEOMETRY_$geometry=OFF"; done
    # shellcheck disable=SC2086
    run cmake -S embree-3* -B obj -G Ninja -DCMAKE_BUILD_TYPE=Release -DEMBREE_TUTORIALS=OFF -DEMBREE_ISPC_SUPPORT=OFF \
        -DEMBREE_MAX_ISA=SSE2 -DEMBREE_TASKING_SYSTEM=INTERNAL -DEMBREE_RAY_PACKETS=OFF $off
    run cmake --build obj --target embree
    cp -L obj/libembree3.so.3 "$embree"
    cd ../../..
fi

for file in models/*.safetensors models/encoders; do ln -sfn "$PWD/$file" "$folder/models/"; done
run cmake -S . -B "$folder/obj" -G Ninja -DNQM_TESTS=OFF -DNQM_SHARED_MODELS=ON -DNQM_MODELS_DIR="$folder/models" \
    -DEMBREE_LIBRARY="$embree" -DCMAKE_SKIP_RPATH=ON
run cmake --build "$folder/obj" --target nqm_full nqm_tool

# The Python package alone, then with what it needs.
cp -r python "$folder/python"
cp LICENSE "$folder/python"
rm -rf "$folder/python/build" "$folder/python"/*.egg-info
(cd "$folder/python" && run /usr/bin/python3 -c 'import setuptools; setuptools.setup()' -q sdist -d .. bdist_wheel -d pure)
run /usr/bin/python3 -m wheel unpack -d "$folder/unpacked" "$folder/python/pure"/*.whl
mkdir -p "$site/nqm/lib" "$site/nqm/bin" "$info/licenses" "$site/nqm-$version.data/scripts"
cp "$folder/obj/nqm" "$site/nqm/bin/"
cp -L "$folder/obj/libnqm-full.so.0" "$folder/obj"/libnqm-models.so.*[0-9] "$embree" "$site/nqm/lib/"
cp "$folder"/embree/embree-3*/LICENSE.txt "$info/licenses/embree"
ldd "$site/nqm/bin/nqm" "$site/nqm/lib"/* | awk '$3 ~ /^\// { print $3 }' | sort -u | while read -r path; do
    name=$(basename "$path")
    case $name in
    libc.so.* | libm.so.* | libgcc_s.so.* | libstdc++.so.* | libnqm-*) continue ;;
    esac
    cp -L "$path" "$site/nqm/lib/libnqm-${name#lib}"
    package=$(dpkg-query -S "*/$(basename "$(readlink -f "$path")")" | head -n 1 | cut -d: -f1)
    cp "/usr/share/doc/$package/copyright" "$info/licenses/$package"
done
# Debian's files of copyright refer to these for the texts.
grep -hoE '/usr/share/common-licenses/[A-Za-z0-9.+-]*[A-Za-z0-9]' "$info/licenses"/* | sort -u | while read -r path; do
    cp "$path" "$info/licenses/common-$(basename "$path")"
done
chmod 755 "$site/nqm/bin/nqm" "$site/nqm/lib"/*
for file in "$site/nqm/bin/nqm" "$site/nqm/lib"/*; do
    strip --strip-unneeded "$file"
    [ "$file" = "$site/nqm/bin/nqm" ] || patchelf --set-soname "$(basename "$file")" "$file"
    for name in $(patchelf --print-needed "$file"); do
        [ ! -f "$site/nqm/lib/libnqm-${name#lib}" ] || patchelf --replace-needed "$name" "libnqm-${name#lib}" "$file"
    done
    # shellcheck disable=SC2016
    patchelf --set-rpath '$ORIGIN/../lib' "$file"
done
# Not an entry point: that would import NumPy before each command.
cat >"$site/nqm-$version.data/scripts/nqm" <<'END'
#!python
import importlib.util, os, sys
tool = os.path.join(os.path.dirname(importlib.util.find_spec("nqm").origin), "bin", "nqm")
os.environ.setdefault("NQM_PYTHON", sys.executable)
os.execv(tool, [tool, *sys.argv[1:]])
END
chmod 755 "$site/nqm-$version.data/scripts/nqm"
glibc=$(objdump -T "$site/nqm/bin/nqm" "$site/nqm/lib"/* | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -n 1)
tag=py3-none-manylinux_$(echo "${glibc#GLIBC_}" | tr . _)_$(uname -m)
sed -i "s/^Root-Is-Purelib:.*/Root-Is-Purelib: false/; s/^Tag:.*/Tag: $tag/" "$info/WHEEL"
run /usr/bin/python3 -m wheel pack -d "$folder" "$site"
NQM_SOURCE=$PWD /usr/bin/python3 tests/python/test_wheel.py
ls -l "$folder"/*.whl "$folder"/*.tar.gz
