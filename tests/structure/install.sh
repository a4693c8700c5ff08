#!/bin/sh
# SPDX-License-Identifier: MIT
# Install into a temporary folder; compile every program of examples/ against the installed headers and each library through
# pkg-config, as C11 with warnings as errors; run them and compare what they print; run the installed tool.
set -eu
build=${NQM_BUILD:?} source=${NQM_SOURCE:?}
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix" >"$prefix/install.log"
libdir=$(dirname "$(find "$prefix" -name libnqm.so | head -n 1)")
fail() {
    echo "$1"
    exit 1
}

# prints NAME PATTERN...: the lines that examples/NAME.c prints match the extended patterns, one each, with either library.
prints() {
    name=$1
    shift
    for flavour in nqm nqm-full; do
        # The .pc files contain the configured prefix; --define-variable replaces it, as packaging with DESTDIR does.
        flags=$(PKG_CONFIG_PATH=$libdir/pkgconfig pkg-config --define-variable=prefix="$prefix" --cflags --libs $flavour)
        # shellcheck disable=SC2086
        ${CC:-cc} -std=c11 -Wall -Wextra -Werror "$source/examples/$name.c" -o "$prefix/$name" $flags -pthread -lm
        # shellcheck disable=SC2086
        LD_LIBRARY_PATH=$libdir "$prefix/$name" $arguments >"$prefix/out" || fail "examples/$name.c with lib$flavour fails"
        [ "$(wc -l <"$prefix/out")" = $# ] || fail "examples/$name.c prints $(cat "$prefix/out")"
        i=0
        for pattern in "$@"; do
            i=$((i + 1))
            sed -n ${i}p "$prefix/out" | grep -qxE "$pattern" || fail "examples/$name.c prints $(cat "$prefix/out"), not $pattern"
        done
    done
    tested="$tested $name"
}
tested=
arguments="sgd:nickel ward:nickel sgd:nickel"
prints score_files 'ward:nickel: 4\.1[0-9] JOD \[3\.[0-9]+, 4\.[0-9]+\]' 'sgd:nickel: 10\.00 JOD \[10\.00, 10\.00\]'
arguments=
prints score_renderer 'by callbacks: 9\.9[0-9] JOD, by samples: 9\.9[0-9] JOD'
prints score_threads 'ward:nickel: 4\.1[0-9] JOD' 'abc:nickel: 5\.[89][0-9] JOD' 'cook-torrance:nickel: (4\.9|5\.0)[0-9] JOD' 'sgd:nickel: 10\.00 JOD'
for file in "$source"/examples/*.c; do
    case " $tested " in *" $(basename "$file" .c) "*) ;; *) fail "$file is not tested" ;; esac
done
"$prefix/bin/nqm" --version | grep -q '^nqm [0-9]'
