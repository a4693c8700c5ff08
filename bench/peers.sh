#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs bench/peers.py, which compares nqm with PyTorch (Debian's python3-torch with OpenBLAS) and ONNX Runtime (the npm
# package onnxruntime-node, downloaded into FOLDER). ./dev bench peers runs it.
# usage: peers.sh TOOL FOLDER [options of peers.py]   (nqm-bench is beside the tool)
set -eu
tool=$1 folder=$2 here=$(dirname "$0")
shift 2
onnx_version=1.23.2
python=${PYTHON:-/usr/bin/python3}
"$python" -c 'import numpy, torch' 2>/dev/null || {
    echo "peers: $python has no PyTorch: install python3-torch, python3-numpy and libopenblas0" >&2
    exit 1
}
"$python" "$here/torch_worker.py" check
command -v npm >/dev/null 2>&1 || {
    echo "peers: npm is missing: install nodejs and npm" >&2
    exit 1
}
mkdir -p "$folder"
# The package's install script would download GPU libraries.
[ -d "$folder/node_modules/onnxruntime-node" ] ||
    npm install --prefix "$folder" --ignore-scripts --no-audit --no-fund --save-exact "onnxruntime-node@$onnx_version" >&2
exec "$python" "$here/peers.py" --tool "$tool" --model "$here/../models/full/paper.safetensors" --packages "$folder" \
    --json "$folder/peers.json" "$@"
