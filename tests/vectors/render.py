# SPDX-License-Identifier: MIT
"""Directional albedo of a microfacet BRDF (GGX, Smith's G with separate shadowing and masking, Schlick's Fresnel term with
f0 = 0.5) by the midpoint rule over half vectors. Writes render.safetensors to the folder of this script.
Usage: python3 render.py"""
import numpy as np

import store

N = 3000
F0 = 0.5


def g1(alpha, cosine):
    tan2 = 1 / cosine**2 - 1
    return 2 / (1 + np.sqrt(1 + alpha**2 * tan2))


def albedo(alpha, theta):
    """Integral of f cos(theta_i) over the light's hemisphere, for a viewer at theta."""
    u, v = np.meshgrid((np.arange(N) + 0.5) / N, (np.arange(N) + 0.5) / N)
    tan = alpha * np.sqrt(u / (1 - u))  # D(h) cos(theta_h) is even over (u, v)
    cos_h = 1 / np.sqrt(1 + tan**2)
    sin_h = tan * cos_h
    phi = np.pi * v  # half of the range: the other half is its mirror image
    h = np.stack([sin_h * np.cos(phi), sin_h * np.sin(phi), cos_h])
    wo = np.array([np.sin(theta), 0, np.cos(theta)])
    d = np.tensordot(wo, h, 1)
    cos_i = 2 * d * h[2] - wo[2]
    up = (cos_i > 0) & (d > 0)
    d, cos_h, cos_i = d[up], cos_h[up], cos_i[up]
    fresnel = F0 + (1 - F0) * (1 - d) ** 5
    return np.sum(fresnel * g1(alpha, cos_i) * g1(alpha, wo[2]) * d / (wo[2] * cos_h)) / N**2


def main():
    rows = [(alpha, theta, albedo(alpha, np.radians(theta))) for alpha in (0.002, 0.01, 0.05, 0.2, 0.6) for theta in (0, 20, 45, 65, 80)]
    store.safetensors("render.safetensors", {"albedo": np.round(rows, 7)}, {"made_by": store.made_by("render.py")})


main()
