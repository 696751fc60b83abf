"""kt/kn of a flat and of a rough contact, and how well each is known.

sigma has parts that are added as squares: the mesh (the change from half as many columns, which for
first-order convergence is what is still missing), the profiles (Student's t over random ones), for
the stiffnesses Young's modulus, to which every force is proportional, and what had to be assumed
where that was varied (assumptions.py).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calibration.statistics.uncertainty import Estimate, of_trials
from calibration.stiffness_fe.protocol import Case, Load, Outcome, press_and_shear
from calibration.stiffness_fe.surfaces import Paths, Waves

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Quantity:
    """An estimate and the parts of its sigma."""

    whole: Estimate
    mesh: float
    profiles: float | None  # None for one profile, or a flat surface
    assumed: float | None = None  # None where the assumptions were not varied

    def with_assumed(self, assumed: float) -> "Quantity":
        """With the sigma that the assumptions make."""
        sigma = math.hypot(self.whole.sigma or 0.0, assumed)
        return replace(self, whole=replace(self.whole, sigma=sigma), assumed=assumed)


@dataclass(frozen=True)
class Contact:
    """Result of the tests of one kind of surface; stiffnesses in N/m of the whole depth.

    ratio     kt/kn by eq. 3.3 at the end of shear; onset: of its first step
    outcomes  one for each pair of profiles
    """

    load: Load
    ratio: Quantity
    onset: Quantity
    kn: Quantity
    kt: Quantity
    outcomes: tuple[Outcome, ...]

    def mean(self, value: Callable[[Outcome], float]) -> float:
        """The mean of something over the profiles."""
        return float(np.mean([value(one) for one in self.outcomes]))


@dataclass(frozen=True)
class Found:
    """The flat contact, the rough one, and what is left of the normal stress in it."""

    case: Case
    flat: Contact | None
    rough: Contact | None
    stress: Quantity | None  # of the rough over that of the flat one, at the same travel across


def measure(
    case: Case, flat: Load | None, rough: tuple[Load, Waves | Paths] | None, *,
    profiles: int, seed: int, sigma_e: float, progress: Progress = lambda _: None,
) -> Found:  # fmt: skip
    """Test the surfaces requested; sigma_e is that of Young's modulus, relative."""
    even = found = None
    if flat is not None:
        progress("flat")
        even = contact(case, flat, [outcomes(case, flat, None, 1, seed)], sigma_e)
    if rough is not None:
        load, surface = rough
        pairs = []
        for k in range(profiles):
            progress(f"rough, profile {k + 1} of {profiles}")
            pairs.append(outcomes(case, load, surface, k, seed))
        found = contact(case, load, pairs, sigma_e)
    return Found(case, even, found, _stress(even, found))


def outcomes(
    case: Case, load: Load, surface: Waves | Paths | None, number: int, seed: int
) -> tuple[Outcome, Outcome]:
    """The test of a pair of surfaces, and with half as many columns; surface None is flat."""
    coarse = replace(case, columns=case.columns // 2)
    fine, half = (one_test(mesh, load, surface, number, seed) for mesh in (case, coarse))
    return fine, half


def one_test(
    case: Case, load: Load, surface: Waves | Paths | None, number: int, seed: int
) -> Outcome:
    """The test of the pair of surfaces that has this number; the same on any mesh."""
    x = case.points()
    if surface is None:
        return press_and_shear(case, load, np.zeros_like(x), np.zeros_like(x))
    rng = np.random.default_rng([seed, number])
    return press_and_shear(case, load, *surface.draw(x, case.sides == "periodic", rng))


def contact(
    case: Case, load: Load, pairs: Sequence[tuple[Outcome, Outcome]], sigma_e: float
) -> Contact:
    """Result of fine and coarse outcomes of one kind of surface."""

    def kt(one: Outcome) -> float:
        return case.depth * one.kt

    def kn(one: Outcome) -> float:
        return case.depth * one.kn

    return Contact(
        load,
        _quantity(pairs, lambda one: one.ratio),
        _quantity(pairs, lambda one: one.onset),
        _quantity(pairs, kn, sigma_e),
        _quantity(pairs, kt, sigma_e),
        tuple(fine for fine, _ in pairs),
    )


def _quantity(
    pairs: Sequence[tuple[Outcome, Outcome]], value: Callable[[Outcome], float],
    proportional: float = 0.0,
) -> Quantity:  # fmt: skip
    """The mean over the profiles; proportional is a relative sigma that all of them share."""
    fine, coarse = ([value(pair[k]) for pair in pairs] for k in (0, 1))
    known = of_trials(fine)
    mesh = abs(float(np.mean(fine)) - float(np.mean(coarse)))
    parts = (mesh, known.sigma or 0.0, proportional * known.value)
    return Quantity(replace(known, sigma=math.hypot(*parts)), mesh, known.sigma)


def _stress(flat: Contact | None, rough: Contact | None) -> Quantity | None:
    """kn of the rough over that of the flat contact, in which Young's modulus cancels."""
    if flat is None or rough is None:
        return None
    even = flat.kn.whole.value
    scale = rough.kn.whole.value / even

    def relative(one: Quantity) -> float:
        return math.hypot(one.mesh, one.profiles or 0.0) / one.whole.value

    sigma = scale * math.hypot(relative(flat.kn), relative(rough.kn))
    known = replace(
        rough.kn.whole, value=scale, sigma=sigma,
        scatter=None if rough.kn.whole.scatter is None else rough.kn.whole.scatter / even,
    )  # fmt: skip
    profiles = None if rough.kn.profiles is None else rough.kn.profiles / even
    return Quantity(known, rough.kn.mesh / even, profiles)
