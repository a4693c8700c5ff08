# SPDX-License-Identifier: MIT
"""What the scripts here share: safetensors files beside them, and random numbers that the tests in C make too."""
import hashlib
import json
import os
import struct
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))


def made_by(script, *versions):
    return f"{script}: numpy {np.__version__}, Python {sys.version.split()[0]}" + "".join(f", {v}" for v in versions)


def safetensors(name, tensors, metadata):
    """Write the file; a checksum "sha256" of 64 zeros in the metadata is set."""
    header, data = {"__metadata__": metadata}, b""
    for key, x in tensors.items():
        x = np.ascontiguousarray(x)
        header[key] = {"dtype": {"f2": "F16", "f4": "F32", "f8": "F64", "u1": "U8", "i8": "I64"}[x.dtype.str[1:]], "shape": list(x.shape),
                       "data_offsets": [len(data), len(data) + x.nbytes]}
        data += x.tobytes()
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-(8 + len(text)) % 64)
    whole = struct.pack("<Q", len(text)) + text + data
    zeros = b"0" * 64
    if metadata.get("sha256"):
        whole = whole.replace(zeros, hashlib.sha256(whole).hexdigest().encode(), 1)
    with open(os.path.join(HERE, name), "wb") as file:
        file.write(whole)


def units(seed):
    """In [0, 1), as random_unit() of tests/support/random_network.c."""
    while True:
        seed = (seed * 6364136223846793005 + 1442695040888963407) % 2**64
        yield (seed >> 11) / 2**53
