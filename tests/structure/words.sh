#!/bin/sh
# SPDX-License-Identifier: MIT
# No page names a verb, an option or a CMake option that does not exist (words.py).
set -eu
command -v python3 >/dev/null || exit 77
exec python3 "${NQM_SOURCE:?}/tests/structure/words.py"
