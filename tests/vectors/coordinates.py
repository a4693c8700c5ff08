# SPDX-License-Identifier: MIT
"""Half-vector coordinates as Rusinkiewicz (1998) and the MERL reader define them: rotate the light by -phi_h about z, then by
-theta_h about y; in 80-bit floats, independent of the library's formulas. coordinates.csv: wi, wo, theta_h, theta_d, phi_d."""
import numpy

SEED = 7
real = numpy.longdouble
rng = numpy.random.default_rng(SEED)


def unit(theta, phi):
    return numpy.array([numpy.sin(theta) * numpy.cos(phi), numpy.sin(theta) * numpy.sin(phi), numpy.cos(theta)], dtype=real)


def rotate(v, axis, angle):
    """Rodrigues' formula."""
    return v * numpy.cos(angle) + numpy.cross(axis, v) * numpy.sin(angle) + axis * numpy.dot(axis, v) * (1 - numpy.cos(angle))


pairs = [(real(a), real(b), real(c), real(d)) for a, b, c, d in rng.uniform(size=(60, 4)) * [1.5, 6.28, 1.5, 6.28]]
pairs += [(real("0.7"), real("0.3"), real("0.7"), real("0.3")), (real("1e-4"), real(1), real("3e-5"), real(2)),
          (real("0.5"), real(1), real("0.5"), real(1) + real("3.1415")), (real("1.2"), real(0), real("1.2001"), real("0.0001"))]
with open("coordinates.csv", "w") as out:
    out.write(f"# made by coordinates.py: numpy {numpy.__version__}, {numpy.finfo(real).nmant + 1} bit floats, seed {SEED}\n")
    out.write("wix,wiy,wiz,wox,woy,woz,theta_h,theta_d,phi_d\n")
    pi = numpy.arctan2(real(0), real(-1))
    for theta_i, phi_i, theta_o, phi_o in pairs:
        # the test reads doubles, so start from doubles
        wi = unit(theta_i, phi_i).astype(float).astype(real)
        wo = unit(theta_o, phi_o).astype(float).astype(real)
        h = wi + wo
        h /= numpy.sqrt(numpy.dot(h, h))
        theta_h, phi_h = numpy.arctan2(numpy.hypot(h[0], h[1]), h[2]), numpy.arctan2(h[1], h[0])
        d = rotate(wi, numpy.array([0, 0, 1], dtype=real), -phi_h)
        d = rotate(d, numpy.array([0, 1, 0], dtype=real), -theta_h)
        theta_d, phi_d = numpy.arctan2(numpy.hypot(d[0], d[1]), d[2]), numpy.arctan2(d[1], d[0])
        phi_d = phi_d + pi if phi_d < 0 else phi_d
        row = list(wi) + list(wo) + [theta_h, theta_d, phi_d]
        out.write(",".join(repr(float(v)) for v in row) + "\n")
