#!/bin/sh
# SPDX-License-Identifier: MIT
# Run one test of the Python package with the library of the build. The first Python that has NumPy runs it; without one it is skipped (77).
# usage: run.sh TEST.py [ARGUMENTS]      (environment: NQM_SOURCE, NQM_BUILD; optional NQM_SANITIZE)
set -eu
source=${NQM_SOURCE:?} build=${NQM_BUILD:?}
for python in "${PYTHON:-python3}" python3 /usr/bin/python3; do
    if "$python" -c 'import sys, numpy; sys.exit(sys.version_info < (3, 9))' 2>/dev/null; then break; fi
    python=
done
[ -n "$python" ] || { echo "skipped: there is no Python 3.9 with NumPy"; exit 77; }
export PYTHONPATH="$source/python${PYTHONPATH:+:$PYTHONPATH}" PYTHONDONTWRITEBYTECODE=1 NQM_LIBRARY="$build/libnqm-full.so"
if [ -n "${NQM_SANITIZE:-}" ]; then
    # Python itself is not built with the sanitizer: its library must be loaded first, and Python's own memory is not a leak.
    preload=$(${CC:-cc} -print-file-name=libasan.so)
    [ -f "$preload" ] || { echo "skipped: the sanitizer's library is not found"; exit 77; }
    LD_PRELOAD="$(readlink -f "$preload") $(readlink -f "$(${CC:-cc} -print-file-name=libstdc++.so)")"
    export LD_PRELOAD
    export ASAN_OPTIONS="detect_leaks=0:${ASAN_OPTIONS:-}"
fi
exec "$python" "$@" -v # names what is skipped
