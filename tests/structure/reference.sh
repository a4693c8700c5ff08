#!/bin/sh
# SPDX-License-Identifier: MIT
# doc/reference-c.md and python/nqm/_abi.py are what their scripts make from the headers.
set -eu
command -v python3 >/dev/null || exit 77
cd "${NQM_SOURCE:?}"
is_made_by() {
    python3 "$2" | diff "$1" - || {
        echo "$1 is old: run ./dev pages"
        exit 1
    }
}
is_made_by doc/reference-c.md doc/reference.py
is_made_by python/nqm/_abi.py python/headers.py
