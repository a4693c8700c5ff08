#!/bin/sh
# SPDX-License-Identifier: MIT
# Build the Debian packages libnqm0, libnqm-dev, nqm and python3-nqm of this source tree in build/deb, and check them with lintian.
# usage: packages/deb.sh         (from the folder of ./dev; ./dev deb installs what it needs)
set -eu
version=$(sed -n 's/^#define NQM_VERSION_[A-Z]* //p' include/nqm/base.h | tr '\n' '.' | sed 's/\.$//')
grep -q "^nqm ($version) " debian/changelog || {
    echo "debian/changelog does not begin with version $version" >&2
    exit 1
}
folder=build/deb
rm -rf "$folder"
mkdir -p "$folder/nqm-$version"
# The files of git; in an unpacked tarball all files.
if git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
    git ls-files -co --exclude-standard -z | xargs -0 cp --parents -t "$folder/nqm-$version"
else
    tar -c --exclude='./build*' . | tar -x -C "$folder/nqm-$version"
fi
launcher=
if command -v ccache >/dev/null 2>&1; then launcher="-DCMAKE_C_COMPILER_LAUNCHER=ccache"; fi
(cd "$folder/nqm-$version" &&
    NQM_CMAKE=$launcher DEB_BUILD_OPTIONS="noautodbgsym parallel=$(nproc)" dpkg-buildpackage -us -uc -b >../build.log 2>&1) || {
    tail -n 40 "$folder/build.log"
    echo "the build failed; all of its output is in $folder/build.log" >&2
    exit 1
}
rm -rf "$folder/nqm-$version"
echo "lintian: $(lintian --version)"
lintian --fail-on error,warning "$folder"/*.changes
ls -l "$folder"/*.deb
