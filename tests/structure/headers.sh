#!/bin/sh
# SPDX-License-Identifier: MIT
# Every public header compiles alone, as C11, C17 and C++17, with warnings as errors.
set -eu
cd "${NQM_SOURCE:-$(dirname "$0")/../..}"
for header in include/nqm/*.h; do
    for language in "c -std=c11" "c -std=c17"; do
        # shellcheck disable=SC2086
        echo "#include <nqm/$(basename "$header")>" |
            ${CC:-cc} -x $language -Wall -Wextra -Wpedantic -Werror -Iinclude -fsyntax-only -
    done
    if command -v c++ >/dev/null 2>&1; then
        echo "#include <nqm/$(basename "$header")>" | c++ -x c++ -std=c++17 -Wall -Wextra -Werror -Iinclude -fsyntax-only -
    fi
done
