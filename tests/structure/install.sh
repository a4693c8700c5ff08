#!/bin/sh
# SPDX-License-Identifier: MIT
# Install into a temporary folder and move that folder. Compile every program of examples/ against the installed headers and each
# library through pkg-config, as C11 with warnings as errors, and one through CMake's find_package; run them and compare what they
# print; run the installed tool; check the links of the installed pages.
set -eu
build=${NQM_BUILD:?} source=${NQM_SOURCE:?}
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cmake --install "$build" --prefix "$dir/before" >"$dir/install.log"
prefix=$dir/moved
mv "$dir/before" "$prefix"
libdir=$(dirname "$(find "$prefix" -name libnqm.so | head -n 1)")
fail() {
    echo "$1"
    exit 1
}
if grep -rlF "$dir/before" "$prefix" >&2 || grep -rlF "$source" "$prefix/share/doc" "$libdir/pkgconfig" "$libdir/cmake" >&2; then
    fail "these installed files contain the folder of the installation or of the source"
fi

# matches COMMAND PATTERN...: the lines that a program prints match the extended patterns, one each.
matches() {
    command=$1
    shift
    # shellcheck disable=SC2086
    $command $arguments >"$dir/out" || fail "$command fails"
    [ "$(wc -l <"$dir/out")" = $# ] || fail "$command prints $(cat "$dir/out")"
    i=0
    for pattern in "$@"; do
        i=$((i + 1))
        sed -n ${i}p "$dir/out" | grep -qxE "$pattern" || fail "$command prints $(cat "$dir/out"), not $pattern"
    done
}

# flags OPTIONS...: what pkg-config says.
flags() { PKG_CONFIG_PATH=$libdir/pkgconfig pkg-config "$@"; }

# compile NAME FLAGS...: compile examples/NAME.c to the program NAME.
compile() {
    name=$1
    shift
    ${CC:-cc} -std=c11 -Wall -Wextra -Werror "$source/examples/$name.c" -o "$dir/$name" "$@" -pthread -lm || fail "compile $name"
}

# prints NAME PATTERN...: examples/NAME.c prints this with either library.
prints() {
    example=$1
    shift
    for flavour in nqm nqm-full; do
        # shellcheck disable=SC2046
        compile "$example" $(flags --cflags --libs $flavour)
        LD_LIBRARY_PATH=$libdir matches "$dir/$example" "$@"
    done
    tested="$tested $example"
}
tested=
arguments="sgd:nickel ward:nickel sgd:nickel"
prints score_files 'ward:nickel: 4\.2[0-9] JOD \[4\.[0-9]+, 4\.[0-9]+\]' 'sgd:nickel: 10\.00 JOD \[10\.00, 10\.00\]'
arguments=
prints score_renderer 'by callbacks: 9\.9[0-9] JOD, by samples: 9\.9[0-9] JOD'
set -- 'ward:nickel: 4\.[12][0-9] JOD' 'abc:nickel: 5\.9[0-9] JOD' 'cook-torrance:nickel: (5\.0|5\.1)[0-9] JOD' 'sgd:nickel: 10\.00 JOD'
prints score_threads "$@"
for file in "$source"/examples/*.c; do
    case " $tested " in *" $(basename "$file" .c) "*) ;; *) fail "$file is not tested" ;; esac
done

# Static libraries through pkg-config, then all libraries through CMake: without LD_LIBRARY_PATH.
for flavour in nqm nqm-full; do
    # shellcheck disable=SC2046
    compile score_threads $(flags --cflags $flavour) $(flags --static --libs $flavour | sed "s/ -l$flavour / -l:lib$flavour.a /")
    matches "$dir/score_threads" "$@"
done
mkdir "$dir/user"
cmake -G Ninja -S "$source/tests/structure/package" -B "$dir/user" -DCMAKE_PREFIX_PATH="$prefix" -DEXAMPLE="$source/examples/score_threads.c" \
    -DCMAKE_C_FLAGS=-D_XOPEN_SOURCE=700 >"$dir/log" 2>&1 || fail "$(cat "$dir/log")"
cmake --build "$dir/user" >"$dir/log" 2>&1 || fail "$(cat "$dir/log")"
for library in nqm full nqm-static full-static; do
    matches "$dir/user/with-$library" "$@"
done

"$prefix/bin/nqm" --version | grep -q '^nqm [0-9]'
for verb in $("$prefix/bin/nqm" --help | sed -n 's/^  \([a-z]*\)  .*/\1/p'); do
    [ -s "$prefix/share/man/man1/nqm-$verb.1" ] || fail "there is no man page of $verb"
done
for file in bash-completion/completions/nqm zsh/site-functions/_nqm fish/vendor_completions.d/nqm.fish man/man1/nqm.1; do
    [ -s "$prefix/share/$file" ] || fail "share/$file is not installed"
done
# Each line: the folder of a page and a link in it, as one path.
grep -oHE '\]\([^)#: ]+' "$prefix"/share/doc/nqm/*.md "$prefix"/share/doc/nqm/doc/*.md | grep -vE '\(https?$' |
    sed 's|[^/]*\.md:](||' | sort -u >"$dir/links"
[ -s "$dir/links" ] || fail "the pages have no links: the test is broken"
while read -r link; do
    [ -e "$link" ] || fail "a page links to $link, which is not installed"
done <"$dir/links"
[ -e "$prefix/share/doc/nqm/doc/cli.md" ] || fail "the pages are not installed"
