#!/bin/sh
# SPDX-License-Identifier: MIT
# Write build/dist/nqm-VERSION.tar.gz, the sources of the last commit; the same commit gives the same bytes. In an unpacked tarball
# ./dev works as in a clone.
# usage: packages/dist.sh        (from the folder of ./dev)
set -eu
version=$(sed -n 's/^#define NQM_VERSION_[A-Z]* //p' include/nqm/base.h | tr '\n' '.' | sed 's/\.$//')
mkdir -p build/dist
archive=build/dist/nqm-$version.tar.gz
if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
    echo "./dev dist needs the git repository: this is not a clone" >&2
    exit 1
fi
[ -z "$(git status --porcelain --untracked-files=no)" ] || echo "changes that are not committed are not in $archive" >&2
git archive --format=tar --prefix="nqm-$version/" HEAD | gzip -n -9 >"$archive.part"
mv "$archive.part" "$archive"
echo "$archive"
