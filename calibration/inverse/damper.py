"""Dampers for the inverse fit: efficiency over frequency and amplitude."""

import numpy as np

from calibration.inverse.observation import (
    Kind,
    Observation,
    Row,
    Simulated,
    Values,
    Written,
    finite,
)
from calibration.inverse.statistics.prior import Array
from damper3d.case.case import DamperCase
from damper3d.case.settings import Settings
from damper3d.run.sweep import DAMPER
from granulab.contact.files.keys import Keys
from granulab.errors import InputError


def _read_eta(written: Written) -> list[Observation]:
    """An observation for each row, as each is a motion of its own."""
    table = written.table()
    eta = finite(table.column("eta", "1"), table, "eta")
    names = [("frequency" if table.has("frequency", "Hz") else "f", "Hz"), ("gamma", "1")]
    frequency, gamma = (
        finite(table.column(n, u, written_in="Hz" if u == "Hz" else None), table, n)
        for n, u in names
    )
    for name, values in (("frequency", frequency), ("gamma", gamma)):
        if not (values > 0).all():
            raise InputError(f"{table.path}: {name} = {values.min():g}: must be above 0")
    sigma, trials = written.sigma(table, "1"), written.count("trials", 1)
    return [
        Observation(
            "eta", (("motion.frequency", float(f)), ("motion.gamma", float(g))), np.array([e]),
            np.array([s]), trials, np.zeros((1, 0)), (f"{f:g} Hz",), np.array([g]),
            ("Gamma [-]", "efficiency [-]"), table.path,
        )
        for f, g, e, s in zip(frequency, gamma, eta, sigma, strict=True)
    ]  # fmt: skip


def _eta_of(_observation: Observation, row: Row) -> Array:
    """The efficiency that a force transducer sees, of the wall's work.

    The one of what contacts dissipate is null while the bed settles: to take now this and now
    that would scatter by more than the packings do.
    """
    return np.array([row["efficiency_wall_work"]], dtype=float)


def _parameters(case: DamperCase) -> Values:
    """Friction and restitution of both pairs, modulus and density of the particles."""
    particle, wall = case.settings.particles.material, case.settings.enclosure.material
    found: Values = {(f"material.{particle}", "density"): case.density}
    if case.settings.law.youngs_modulus is not None:
        modulus = case.settings.law.youngs_modulus
        found |= {(f"material.{name}", "youngs_modulus"): modulus for name in {particle, wall}}
    laws = {"particle_particle": (particle, case.pair_law), "particle_wall": (wall, case.wall_law)}
    for pair, (other, law) in laws.items():
        section = f"pair.{particle}-{other}"
        for key, value in (("friction", law.mu), ("restitution", case.restitution[pair])):
            if found.setdefault((section, key), value) != value:
                raise InputError(
                    f"particles and walls are both {particle}, with a {key} of their own: a "
                    "parameter file has one for the pair; name the wall's material otherwise"
                )
    return found


SIMULATED = Simulated(
    campaign=DAMPER,
    keys=Keys(Settings),
    load=DamperCase.load,
    kinds={"eta": Kind(_read_eta, _eta_of)},
    passed=lambda row: True,
    parameters=_parameters,
)
