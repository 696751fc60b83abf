"""A shape of one's own: a chain of equal spheres that touch, as one rigid particle."""

import math

import numpy as np

from damper3d import DamperCase, register_shape
from damper3d.shapes import Family, MultiSphere, Surface, Value, sphere


def chain(numbers, _sub_spheres, _tolerance):
    """At an equal-volume radius of 1 m, along x; moments by Steiner's theorem."""
    n = int(numbers[0])
    r, volume = n ** (-1 / 3), 4 / 3 * math.pi
    offsets = np.zeros((n, 3))
    offsets[:, 0] = 2 * r * (np.arange(n) - (n - 1) / 2)
    ball = sphere(r).surface
    surface = Surface(
        np.concatenate([ball.vertices + offset for offset in offsets]),
        np.concatenate([ball.triangles + k * len(ball.vertices) for k in range(n)]),
    )
    across = 0.4 * r**2 + np.mean(offsets[:, 0] ** 2)
    inertia = volume * np.array([0.4 * r**2, across, across])
    return MultiSphere("", "chain", offsets, np.full(n, r), volume, n * 4 * math.pi * r**2, inertia,
                       surface, "any", 0.0)  # fmt: skip


register_shape("chain", Family("chain:3", chain, values=(Value("number of spheres", 2, 6),)))

if __name__ == "__main__":
    case = DamperCase.load("thesis", {"particles.shape": "chain:3"})
    print(case.particle.name, case.count, case.particle.sphericity)
