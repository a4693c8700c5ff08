# SPDX-License-Identifier: MIT
"""Values of MaterialX nodes with constant inputs, in NumPy and colorsys, from the text of the specification (MaterialX.StandardNodes.md):
materialx_nodes.csv, each an element of a document and its value as color3."""
import colorsys
import pathlib

import numpy as np

rng = np.random.default_rng(32)
rows = []


def text(value):
    return ", ".join(repr(float(v)) for v in np.atleast_1d(value))


def add(node, expected, **inputs):
    """A node of the type color3 and its value; an input of n numbers has the type with n components."""
    assert np.min(expected) >= 0  # a color below 0 is refused
    types = {1: "float", 2: "vector2", 3: "color3", 4: "color4"}
    body = "".join(f"<input name='{k.rstrip('_')}' type='{types[np.size(v)]}' value='{text(v)}'/>" for k, v in inputs.items())
    rows.append((f"<{node} name='n' type='color3'>{body}</{node}>", np.broadcast_to(np.asarray(expected, float), 3)))


def smooth(x, low, high):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def hsv(c):
    return np.array(colorsys.rgb_to_hsv(*c))


def rgb(c):
    return np.array(colorsys.hsv_to_rgb(c[0] % 1, c[1], c[2]))


LUMA = np.array([0.2722287, 0.6740818, 0.0536895])
for _ in range(4):
    a, b, c = rng.uniform(0.05, 1, (3, 3))
    s, t = rng.uniform(0.1, 0.9, 2)
    add("add", a + b, in1=a, in2=b)
    add("add", a + s, in1=a, in2=s)
    add("subtract", a - 0.01 * b, in1=a, in2=0.01 * b)
    add("multiply", a * b, in1=a, in2=b)
    add("multiply", a, in1=a)
    add("divide", a / b, in1=a, in2=b)
    add("modulo", np.mod(a, s / 3), in1=a, in2=s / 3)
    add("modulo", np.mod(-a, b), in1=-a, in2=b)
    add("power", a**s, in1=a, in2=s)
    add("min", np.minimum(a, b), in1=a, in2=b)
    add("max", np.maximum(a, s), in1=a, in2=s)
    add("absval", a, in_=-a)
    add("floor", np.floor(5 * a), in_=5 * a)
    add("ceil", np.ceil(5 * a), in_=5 * a)
    add("round", np.round(5 * a), in_=5 * a)
    add("sin", np.sin(a), in_=a)
    add("cos", np.cos(a), in_=a)
    add("sqrt", np.sqrt(a), in_=a)
    add("invert", 1 - a, in_=a)
    add("invert", 2 - a, in_=a, amount=2)
    add("clamp", np.clip(3 * a - 1, 0, 1), in_=3 * a - 1)
    add("clamp", np.clip(a, 0.3, 0.6), in_=a, low=0.3, high=0.6)
    add("mix", a * s + b * (1 - s), fg=a, bg=b, mix=s)
    add("mix", a * c + b * (1 - c), fg=a, bg=b, mix=c)
    add("smoothstep", smooth(a, 0.2, 0.8), in_=a, low=0.2, high=0.8)
    add("remap", 0.1 + (a - 0.2) / 0.6 * 0.3, in_=a, inlow=0.2, inhigh=0.8, outlow=0.1, outhigh=0.4)
    x = (a - 0.1) / 0.8
    add("range", 0.2 + 0.5 * np.sign(x) * np.abs(x) ** (1 / 2.2), in_=a, inlow=0.1, inhigh=0.9, gamma=2.2, outlow=0.2, outhigh=0.7)
    add("contrast", (a - 0.4) * 0.3 + 0.4, in_=a, amount=0.3, pivot=0.4)
    add("luminance", LUMA @ a, in_=a)
    add("luminance", b @ a, in_=a, lumacoeffs=b)
    add("saturate", LUMA @ a + s * (a - LUMA @ a), in_=a, amount=s)
    add("rgbtohsv", hsv(a), in_=a)
    add("hsvtorgb", rgb(a), in_=a)
    h = hsv(a)
    add("hsvadjust", rgb(np.array([h[0] + c[0], h[1] * s, h[2] * t])), in_=a, amount=[c[0], s, t])
    add("ifgreater", a if s > t else b, value1=s, value2=t, in1=a, in2=b)
    add("ifgreatereq", a, value1=s, value2=s, in1=a, in2=b)
    add("ifgreatereq", a if s >= t else b, value1=s, value2=t, in1=a, in2=b)
    add("ifequal", a, value1=s, value2=s, in1=a, in2=b)
    add("ifequal", b, value1=s, value2=t, in1=a, in2=b)
    add("dotproduct", a @ b, in1=a, in2=b)
    add("magnitude", np.linalg.norm(a), in_=a)
    add("normalize", a / np.linalg.norm(a), in_=a)
    add("combine3", [a[0], s, t], in1=a[0], in2=s, in3=t)
    add("combine2", [a[0], a[1], s], in1=a[:2], in2=s)
    add("extract", a[2], in_=a, index=2)
    add("convert", s, in_=s)
    add("convert", a, in_=[*a, t])
add("divide", 0, in1=1.0, in2=0.0)
add("modulo", 0, in1=1.0, in2=0.0)
add("normalize", 0, in_=[0.0, 0, 0])
rows.append(("<range name='n' type='color3'><input name='in' type='float' value='3'/><input name='doclamp' type='boolean' "
             "value='true'/></range>", np.ones(3)))
rows.append(("<swizzle name='n' type='color3'><input name='in' type='color3' value='0.1,0.2,0.3'/><input name='channels' type='string' "
             "value='bb1'/></swizzle>", np.array([0.3, 0.3, 1])))

with open(pathlib.Path(__file__).with_suffix(".csv"), "w", encoding="utf-8") as file:
    file.write(f"# made by materialx_nodes.py: numpy {np.__version__}, seed 32\ntext,red,green,blue\n")
    for element, value in rows:
        file.write(f'"{element}",{",".join(repr(float(v)) for v in value)}\n')
