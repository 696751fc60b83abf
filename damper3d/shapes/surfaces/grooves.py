"""Depth of the grooves between sub-spheres under a flat wall (eqs 5.18-5.20).

A lying row or ring touches the wall with the tops of its sub-spheres. Once the overlap reaches the
bottom of the groove between two of them, the spheres' caps fill the space in which the smooth
surface would have one contact, and their sum is stiffer than it.
"""

import math

import numpy as np

from damper3d.shapes.multisphere import MultiSphere
from granulab.contact.hertz import HertzLaw


def groove_depth(particle: MultiSphere) -> float | None:
    """Depth of the groove that a wall meets first on a lying row or ring [m]; None: neither.

    Two neighbours meet in a circle; its nearest point to the wall lies so far above the lowest
    point of the lower one. Of a ring all grooves are alike: b - sqrt(b^2 - (d/2)^2) with eq. 4.30,
    which eq. 5.19 approximates by d = 2 pi a/n. Of a row it is the one next to its middle sphere.
    """
    radius = float(particle.radii.max())
    if particle.arrangement == "ring":
        apart = float(np.linalg.norm(particle.offsets[1] - particle.offsets[0]))
        return radius - math.sqrt(radius**2 - (0.5 * apart) ** 2)
    if particle.arrangement == "row":
        middle = len(particle.radii) // 2
        apart = float(particle.offsets[middle + 1, 0] - particle.offsets[middle, 0])
        other = float(particle.radii[middle + 1])
        meet = 0.5 * (apart + (radius**2 - other**2) / apart)  # from the middle sphere's centre
        return radius - math.sqrt(radius**2 - meet**2)
    return None


def limit_of_ring(distance: float, tube: float, number: int) -> float:
    """Eq. 5.19: the depth [m] of a ring of many sub-spheres, a = distance, b = tube [m].

    nan where the spheres would not touch.
    """
    half = math.pi * distance / number
    return tube - math.sqrt(tube**2 - half**2) if half < tube else math.nan


def most_sub_spheres(distance: float, tube: float, overlap: float) -> float:
    """Eq. 5.20: how many sub-spheres have grooves as deep as an overlap up to the radius [m]."""
    return math.pi * distance / math.sqrt(tube**2 - (tube - overlap) ** 2)


def speed_to_groove(particle: MultiSphere, law: HertzLaw, mass: float) -> float | None:
    """The impact speed [m/s] at which one Hertz contact with a wall gets as deep as the groove.

    (1/2) m v^2 = (2/5) K d^2.5, K of the wall and the largest sub-sphere, without damping and with
    the whole mass behind it: a contact that meets the particle off its centroid has less, and needs
    more speed. None where there is no groove.
    """
    depth = groove_depth(particle)
    if depth is None:
        return None
    constant = law.hertz * math.sqrt(float(particle.radii.max()))
    return math.sqrt(0.8 * constant * depth**2.5 / mass)
