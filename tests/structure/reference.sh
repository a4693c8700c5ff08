#!/bin/sh
# SPDX-License-Identifier: MIT
# doc/reference-c.md is what doc/reference.py makes from the headers.
set -eu
command -v python3 >/dev/null || exit 77
python3 "${NQM_SOURCE:?}/doc/reference.py" | diff "$NQM_SOURCE/doc/reference-c.md" - || {
    echo "doc/reference-c.md is old: run ./dev pages"
    exit 1
}
