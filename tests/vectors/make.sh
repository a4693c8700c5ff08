#!/bin/sh
# SPDX-License-Identifier: MIT
# Make every stored vector anew: each script here writes the files that stand beside it and that carry its name.
set -eu
cd "$(dirname "$0")"
for script in *.py; do
    echo "$script"
    "${PYTHON:-/usr/bin/python3}" "$script"
done
