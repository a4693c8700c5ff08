#!/bin/sh
# SPDX-License-Identifier: MIT
# Install into a temporary folder; compile an outside program against it through pkg-config, once with each library; run it,
# and the installed tool.
set -eu
build=${NQM_BUILD:?} source=${NQM_SOURCE:?}
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix" >"$prefix/install.log"
libdir=$(dirname "$(find "$prefix" -name libnqm.so | head -n 1)")
# The .pc files carry the configured prefix; --define-variable moves it, as DESTDIR packaging does.
for flavour in nqm nqm-full; do
    flags=$(PKG_CONFIG_PATH=$libdir/pkgconfig pkg-config --define-variable=prefix="$prefix" --cflags --libs $flavour)
    # shellcheck disable=SC2086
    ${CC:-cc} -std=c11 -Wall -Wextra -Werror "$source/examples/score_files.c" -o "$prefix/score-$flavour" $flags
    LD_LIBRARY_PATH=$libdir "$prefix/score-$flavour" sgd:nickel ward:nickel >"$prefix/$flavour.txt"
    grep -q 'JOD' "$prefix/$flavour.txt"
done
diff "$prefix/nqm.txt" "$prefix/nqm-full.txt"
"$prefix/bin/nqm" --version | grep -q '^nqm [0-9]'
