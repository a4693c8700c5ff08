# SPDX-License-Identifier: MIT
"""Reads nqm's model files for other frameworks: weights as NumPy arrays, the features of a pair, and the network as an
ONNX file. ONNX files are protocol buffers; this file encodes the messages without a library."""
import json
import struct

import numpy as np


class Model:
    """A model file (doc/files.md)."""

    def __init__(self, path):
        data = open(path, "rb").read()
        n = struct.unpack("<Q", data[:8])[0]
        header = json.loads(data[8 : 8 + n])
        self.facts = header.pop("__metadata__")
        types = {"F32": np.float32, "F64": np.float64}
        self.tensors = {}
        for name, t in header.items():
            begin, end = (8 + n + x for x in t["data_offsets"])
            self.tensors[name] = np.frombuffer(data[begin:end], types[t["dtype"]]).reshape(t["shape"])
        self.n_layers = sum(name.endswith(".weight") and ".norm." not in name for name in self.tensors)
        self.sizes = [self.weight(0).shape[1]] + [self.weight(i).shape[0] for i in range(self.n_layers)]

    def weight(self, layer):
        return self.tensors[f"layers.{layer}.weight"]

    def bias(self, layer):
        return self.tensors[f"layers.{layer}.bias"]

    def norm(self, layer):
        return self.tensors[f"layers.{layer}.norm.weight"], self.tensors[f"layers.{layer}.norm.bias"]

    def input(self, ref, test):
        """The network's input for samples of f_r in 1/sr, (n, 3), of both BRDFs; layout ref_test only."""
        mean, std = self.tensors["whitening.mean"], self.tensors["whitening.std"]
        halves = [(np.log(np.cbrt(f) + 1) - mean) / std for f in (ref, test)]
        return np.concatenate([h.reshape(-1) for h in halves]).astype(np.float32)

    def jod(self, z):
        mean, std, low, high = self.tensors["target"]
        return mean + std * (low + (high - low) / (1 + np.exp(-np.asarray(z, np.float64))))


# ---- ONNX ---------------------------------------------------------------------------------------------------------------


def varint(n):
    out = b""
    while n > 127:
        out += bytes([n & 127 | 128])
        n >>= 7
    return out + bytes([n])


def field(number, value):
    """One field of a message: an int, bytes, or text."""
    if isinstance(value, int):
        return varint(number << 3) + varint(value)
    value = value.encode() if isinstance(value, str) else value
    return varint(number << 3 | 2) + varint(len(value)) + value


FLOAT = 1  # TensorProto.DataType


def tensor(name, array):
    dims = b"".join(field(1, n) for n in array.shape)
    return dims + field(2, FLOAT) + field(8, name) + field(9, array.tobytes())


def integer(name, value):
    return field(1, name) + field(3, value) + field(20, 2)


def number(name, value):
    return field(1, name) + varint(2 << 3 | 5) + struct.pack("<f", value) + field(20, 1)


def value_info(name, width):
    dims = field(1, field(2, "pairs")) + field(1, field(1, width))
    return field(1, name) + field(2, field(1, field(1, FLOAT) + field(2, dims)))


class Graph:
    def __init__(self):
        self.nodes, self.tensors, self.n = [], [], 0

    def add(self, op, inputs, attributes=()):
        name = f"v{self.n}"
        self.n += 1
        node = b"".join(field(1, x) for x in inputs) + field(2, name) + field(4, op)
        self.nodes.append(node + b"".join(field(5, a) for a in attributes))
        return name

    def constant(self, array):
        name = f"c{len(self.tensors)}"
        self.tensors.append(tensor(name, np.ascontiguousarray(array, np.float32)))
        return name

    def linear(self, x, weight, bias):
        return self.add("Gemm", [x, self.constant(weight), self.constant(bias)], [integer("transB", 1)])

    def gelu(self, x):
        """GELU as the sequence of nodes that ONNX Runtime recognises and fuses into one operation."""
        erf = self.add("Erf", [self.add("Div", [x, self.constant(np.float32(np.sqrt(2)))])])
        half = self.add("Mul", [x, self.add("Add", [erf, self.constant(np.float32(1))])])
        return self.add("Mul", [half, self.constant(np.float32(0.5))])


def write_onnx(model, path):
    g = Graph()
    x = "x"
    for layer in range(model.n_layers):
        x = g.linear(x, model.weight(layer), model.bias(layer))
        if layer < model.n_layers - 1:
            norm = [g.constant(a) for a in model.norm(layer)]
            x = g.gelu(g.add("LayerNormalization", [x] + norm, [integer("axis", 1), number("epsilon", 1e-5)]))
    graph = b"".join(field(1, n) for n in g.nodes) + field(2, "nqm") + b"".join(field(5, t) for t in g.tensors)
    graph += field(11, value_info("x", model.sizes[0])) + field(12, value_info(x, 1))
    with open(path, "wb") as out:  # IR version 8, operator set 17
        out.write(field(1, 8) + field(8, field(1, "") + field(2, 17)) + field(7, graph))
