"""A structure with the empty enclosure, as numbers: its modes, and what moves it.

Mode r has the angular frequency w_r, the damping ratio zeta_r and the shape phi_r of unit modal
mass. At the damper the receptance H and the bare response X_b to a force F0 and a base B are

    H = sum phi_r^2/d_r,   X_b = B + sum phi_r (psi_r F0 + p_r w^2 B)/d_r,
    d_r = w_r^2 - w^2 + 2 i zeta_r w_r w

with the shape psi_r where the force acts and the participation p_r. Of one mode of a mass M these
are 1/(k - w^2 M + i w c), F0 H and (k + i w c) B H. The product P of all d_r is taken out, so that
an undamped mode at its own frequency is no division by zero.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damper3d.case.case import DamperCase
from damper3d.case.host.several import name_of
from granulab.errors import InputError

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

DRIVES = ("force", "base_displacement", "base_acceleration")


@dataclass(frozen=True, eq=False)
class Structure:
    """Modes (r,) of a structure, and the amplitude of what moves it; base motion or a force."""

    omega: Floats  # [rad/s]
    damping_ratio: Floats  # [-]
    shape: Floats  # at the damper [kg^-0.5]
    force_shape: Floats  # where the force acts [kg^-0.5]
    participation: Floats  # [kg^0.5]
    force: float = 0.0  # [N]
    base_displacement: float = 0.0  # [m]
    base_acceleration: float = 0.0  # [m/s2]

    @classmethod
    def single(
        cls, mass: float, frequency: float, damping_ratio: float, **drive: float
    ) -> "Structure":
        """One mode of a mass [kg] and a frequency [Hz], moved by one of DRIVES."""
        shape = np.array([1.0 / math.sqrt(mass)])
        omega, ratio = np.array([2.0 * math.pi * frequency]), np.array([damping_ratio])
        return cls(omega, ratio, shape, shape, 1.0 / shape).driven(**drive)

    def driven(
        self, force: float = 0.0, base_displacement: float = 0.0, base_acceleration: float = 0.0
    ) -> "Structure":
        """The structure moved by these amplitudes [N, m, m/s2]."""
        return replace(
            self, force=force, base_displacement=base_displacement,
            base_acceleration=base_acceleration,
        )  # fmt: skip

    def modal(self, frequency: ArrayLike) -> tuple[Complexes, Floats, Floats]:
        """d_r (f, r), what drives each mode (f, r) and B (f,) at frequencies (f,) [Hz].

        The first two over w^2: psi_r F0/w^2 + p_r B [kg^0.5 m].
        """
        w = 2.0 * math.pi * np.asarray(frequency, float)[:, None]
        base = self.base(frequency)
        damping = 2j * self.damping_ratio * self.omega * w
        d = np.asarray((self.omega**2 - w**2 + damping) / w**2, complex)
        driven = self.force_shape * self.force / w**2 + self.participation * base[:, None]
        return d, driven, base

    def base(self, frequency: ArrayLike) -> Floats:
        """Amplitude B of the base (f,) at frequencies (f,) [Hz]; 0 where it stands still."""
        w = 2.0 * math.pi * np.asarray(frequency, float)
        return np.asarray(self.base_displacement + self.base_acceleration / w**2)

    def products(self, frequency: ArrayLike) -> tuple[Complexes, Complexes, Complexes]:
        """P, H P and X_b P at frequencies (f,) [Hz], each d_r divided by w^2."""
        w = 2.0 * math.pi * np.asarray(frequency, float)
        d, driven, base = self.modal(frequency)
        others = np.stack(
            [np.prod(np.delete(d, r, axis=1), axis=1) for r in range(len(self.omega))], axis=1
        )
        product = np.prod(d, axis=1)
        return (
            product,
            (others * self.shape**2).sum(axis=1) / w**2,
            base * product + (others * self.shape * driven).sum(axis=1),
        )

    def bare(self, frequency: ArrayLike) -> Complexes:
        """Response at the damper without a bed (f,) [m]; infinite for an undamped resonance."""
        product, _, moved = self.products(frequency)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(product == 0, np.inf, moved / product)


def structures_of(case: DamperCase) -> dict[str, Structure]:
    """The structure as each damper of a case sees it, by its name: shapes alone differ.

    Raises InputError as structure_of.
    """
    dampers = case.together.damper if case.together is not None else None
    if dampers is None:
        return {case.settings.host.at or "1": structure_of(case)}
    names = [name_of(one, k) for k, one in enumerate(dampers)]
    return {
        name if names.count(name) == 1 else f"{name}-{k + 1}": structure_of(one)
        for k, (name, one) in enumerate(zip(names, case.dampers, strict=True))
    }


def structure_of(case: DamperCase) -> Structure:
    """The structure of a case's [host] at its damper, the shown one of several.

    Raises InputError where it has none, or one that is let go.
    """
    keys, modes = case.settings.host, case.modes
    if case.arc is not None:
        raise InputError(
            f"{case.name}: its host twists, and a field is of a bed that is moved along; give "
            "[host] mass in place of inertia"
        )
    if modes is None or case.is_decay or case.excitation is not None:
        why = "its host is let go" if modes is not None else "it has no [host]"
        if case.excitation is not None:
            why = "[excitation] is no single sine"
        raise InputError(
            f"{case.name}: {why}, and a steady response is that of one which is moved; give [host] "
            f"with one of {', '.join(DRIVES)}"
        )
    drive = {name: value for name in DRIVES if (value := getattr(keys, name)) is not None}
    return Structure(
        modes.omega, modes.damping_ratio, modes.shape, modes.force_shape, modes.participation
    ).driven(**drive)
