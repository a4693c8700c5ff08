#!/bin/sh
# SPDX-License-Identifier: MIT
# Every public header compiles alone, as C11, C17, C++11 and C++17, with warnings as errors; as C++ by g++ and clang++ where they are installed.
set -eu
cd "${NQM_SOURCE:-$(dirname "$0")/../..}"
for header in include/nqm/*.h; do
    while read -r compiler options; do
        command -v "$compiler" >/dev/null 2>&1 || continue
        # shellcheck disable=SC2086
        echo "#include <nqm/$(basename "$header")>" |
            "$compiler" $options -Wall -Wextra -Wpedantic -Werror -Iinclude -fsyntax-only -
    done <<END
${CC:-cc} -x c -std=c11
${CC:-cc} -x c -std=c17
g++ -x c++ -std=c++11
g++ -x c++ -std=c++17
clang++ -x c++ -std=c++11
clang++ -x c++ -std=c++17
END
done
