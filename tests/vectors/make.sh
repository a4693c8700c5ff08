#!/bin/sh
# SPDX-License-Identifier: MIT
# Make every stored vector anew: each script here writes the files that stand beside it and that carry its name. metric_torch.py needs
# the library: NQM_LIBRARY=.../libnqm-full.so
set -eu
cd "$(dirname "$0")"
export PYTHONPATH="../../python${PYTHONPATH:+:$PYTHONPATH}"
for script in *.py; do
    echo "$script"
    "${PYTHON:-/usr/bin/python3}" "$script"
done
