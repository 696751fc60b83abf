"""The sources' printed measurements compared with what follows from their own parts.

Only means and standard deviations of the trials are printed, but for the markers of Table 1: means
of means, whether samples are alike, and what is computed from them can be found again; single
angles, heights, curves, profiles and masses cannot.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from calibration.bench import compression, interface, slide
from calibration.bench.sections import Request
from calibration.files.tables import Table, read_table
from calibration.statistics.mixed import mixed
from calibration.statistics.uncertainty import Estimate, Pooled, pooled_summaries
from granulab.contact.files.datafile import data_file
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError


@dataclass(frozen=True)
class Statement:
    """A printed number and what its own ingredients give; units in `what`."""

    what: str
    printed: float
    printed_sd: float | None
    found: float
    sigma: float | None = None
    scatter: float | None = None
    groups_p: float | None = None  # of the hypothesis that the samples are alike
    remark: str = ""


@dataclass(frozen=True)
class Published:
    """Statements of the sources by table; a result (calibration.result)."""

    tables: dict[str, list[Statement]]

    def to_dict(self) -> dict[str, Any]:
        """Fields of the statements, by table."""
        return {name: [asdict(one) for one in ones] for name, ones in self.tables.items()}

    def text(self) -> str:
        """Printed and found side by side, with what is to be said about them below."""
        width = max(len(one.what) for ones in self.tables.values() for one in ones)
        lines = [
            f"{'':{width}}  {'printed':>16}  {'from its parts':>16}  scatter  p(samples alike)"
        ]
        for name, ones in self.tables.items():
            lines.append(name)
            for one, remark_below in zip(ones, [*(o.remark for o in ones[1:]), None], strict=True):
                sd = "" if one.printed_sd is None else f" +- {one.printed_sd:g}"
                sigma = "" if one.sigma is None else f" +- {one.sigma:.2g}"
                scatter = "-" if one.scatter is None else f"{one.scatter:.2g}"
                p = "" if one.groups_p is None else f"{one.groups_p:.2g}"
                printed, own = f"{one.printed:g}{sd}", f"{one.found:.4g}{sigma}"
                lines.append(
                    f"{one.what:{width}}  {printed:>16}  {own:>16}  {scatter:>7}  {p}".rstrip()
                )
                if one.remark and one.remark != remark_below:  # once, below the last it is about
                    lines.append(f"  {one.remark}")
        return "\n".join(lines)

    def figure(self) -> None:
        """None: the numbers are few."""


def friction() -> list[Statement]:
    """Sec. 3.1: three pairings each."""
    table = _table("incline_friction")
    printed = {"particle-wall": (0.44, ""), "particle-particle": (0.38, "the mean is 0.37")}
    statements = []
    for pairing, (mean, remark) in printed.items():
        groups = {
            label: Estimate(m, None, int(n), m * sd / 100)
            for kind, label, m, sd, n in zip(
                table.labels("pairing"), table.labels("sample"), table.columns["mean"],
                table.columns["sd_percent"], table.columns["trials"], strict=True,
            )
            if kind == pairing
        }  # fmt: skip
        statements.append(_pooled(f"friction {pairing}", mean, pooled_summaries(groups), remark))
    return statements


def restitution() -> list[Statement]:
    """Tables 2 and 3, against eps_w and eps_p of sec. 3.3.3, which has the two swapped."""
    drops, swings = _table("drop_test_restitution"), _table("pendulum_restitution")
    swapped = "swapped in sec. 3.3.3 and Table 4"
    by_particle: dict[str, Estimate] = {}
    particle_of: dict[str, str] = {}
    for k, particle in enumerate(drops.labels("particle")):
        name = f"{particle}, {drops.columns['H0_mm'][k]:g} mm"
        by_particle[name], particle_of[name] = _row(drops, k, 10), particle
    nested = replace(pooled_summaries(by_particle), all=mixed(by_particle, particle_of).mean)
    by_height = {f"{h:g} mm": _row(swings, k, 12) for k, h in enumerate(swings.columns["H0_mm"])}
    return [
        _pooled("restitution particle-wall", 0.53, nested, swapped),
        _pooled(
            "restitution particle-particle", 0.45, pooled_summaries(by_height),
            f"{swapped}; 12 trials at each height, 15 in the text",
        ),
    ]  # fmt: skip


def interfaces() -> list[Statement]:
    """Table 1 by eq. 3.3, each marker and the means of sec. 3.2.2."""
    path = data_file("published", "interface_markers")
    assert path is not None
    table = read_table(path)
    (found,) = interface.stiffness_ratio([path], Request(group="surface"))
    last = "displacements are printed to 0.01 mm"
    statements = [
        Statement(f"kt/kn {surface}, marker {int(point)}", printed, None, one.value, remark=last)
        for surface, point, printed, (_, _, one) in zip(
            table.labels("surface"), table.columns["point"], table.columns["kt_over_kn_printed"],
            found.trials, strict=True,
        )
    ]  # fmt: skip
    means = {"flat": (0.28, 0.09, "printed 2.8 +- 0.09"), "rough": (0.065, 0.04, "")}
    for surface, (mean, sd, remark) in means.items():
        one = found.pooled.groups[surface]
        statements.append(
            Statement(
                f"kt/kn {surface}, mean", mean, sd, one.value, one.sigma, one.scatter, None, remark
            )
        )
    return statements


def stiffness() -> list[Statement]:
    """kn = E A/L with the paper's E, A = 10 x 120 mm2 and L = 20 mm (sec. 3.2.1)."""
    statements = []
    for name, printed in (("E_transverse", 1.0e4), ("E_longitudinal", 3.9e4)):
        modulus, share = _parameter(name)
        constants = {"modulus": modulus * 1e6, "contact_area": 1200e-6, "contact_length": 20e-3}
        what = Request(constants=constants, shared={"modulus": modulus * 1e6 * share})
        (found,) = compression.stiffness([], what)
        whole = found.pooled.all
        needed = printed * 1e3 * 20e-3 / 1200e-6 / 1e6
        remark = f"{printed:g} needs E = {needed:.0f} MPa" if round(needed) != modulus else ""
        statements.append(
            Statement(
                f"kn = E A/L, {name} = {modulus:g} MPa [N/mm]", printed, 0.18e4,
                whole.value / 1e3, None, (whole.sigma or 0.0) / 1e3,
                remark=remark,
            )
        )  # fmt: skip
    return statements


def damping() -> list[Statement]:
    """gamma_t by eq. 3.11c; its inclination is not printed, so the one that would do is found."""
    from scipy.optimize import brentq

    v0, v0_sd, mu, printed, sd = 0.43, 0.08, 0.43, 3.0, 0.5
    least = float(np.arctan(mu)) + 1e-6
    angle = brentq(
        lambda a: slide.of_terminal_velocity(v0, a, mu) - printed, least, np.pi / 2 - 1e-6
    )
    of_friction = slide.GRAVITY * np.cos(angle) / v0
    return [
        Statement(
            f"gamma_t with v0 = {v0} +- {v0_sd} m/s, mu = {mu} at 30 deg [1/s]", printed, sd,
            slide.of_terminal_velocity(v0, np.pi / 6, mu), None, printed * v0_sd / v0,
            remark=f"the inclination is not printed: 3.0 needs {np.degrees(angle):.1f} deg; the "
            f"scatter is that of v0 alone: mu +- 0.3, as printed, adds {0.3 * of_friction:.1f}, "
            f"+- 0.03 {0.03 * of_friction:.2f}",
        )
    ]  # fmt: skip


def density() -> list[Statement]:
    """Volume density times the length of the prisms is the surface density (sec. 3.5)."""
    rho, share = _parameter("rho")
    length, _ = _parameter("length")
    area, _ = _parameter("rho_area")
    return [
        Statement(
            "surface density = density x length [g/mm2]", area, None, rho * length, None,
            rho * share * length, remark="the five masses and sizes are not printed",
        )
    ]  # fmt: skip


def roughness() -> list[Statement]:
    """Averages of thesis Table 7.1, from its five specimens of four paths."""
    table = _table("surface_roughness")
    printed = {"smooth": 0.16, "perpendicular": 11.97, "on_ridge": 0.35}
    statements = []
    for surface, mean in printed.items():
        groups = {
            particle: Estimate(value, None, 4, sd)
            for particle, value, sd in zip(
                table.labels("particle"), table.columns[surface], table.columns[f"{surface}_sd"],
                strict=True,
            )
        }  # fmt: skip
        statements.append(_pooled(f"Ra {surface} [um]", mean, pooled_summaries(groups), ""))
    return statements


TABLES: dict[str, Callable[[], list[Statement]]] = {
    "friction": friction,
    "restitution": restitution,
    "interface": interfaces,
    "stiffness": stiffness,
    "damping": damping,
    "density": density,
    "roughness": roughness,
}


def published(names: Sequence[str] = ()) -> Published:
    """Statements of the named tables, of all where none is named; InputError for an unknown one."""
    for name in names:
        if name not in TABLES:
            raise InputError(f"no table {name!r}; {nearest(name, TABLES)}")
    return Published({name: TABLES[name]() for name in names or TABLES})


def _table(name: str) -> Table:
    path = data_file("published", name)
    assert path is not None, name
    return read_table(path)


def _row(table: Table, k: int, trials: int) -> Estimate:
    mean = float(table.columns["mean"][k])
    return Estimate(mean, None, trials, mean * float(table.columns["sd_percent"][k]) / 100)


def _pooled(what: str, printed: float, found: Pooled, remark: str) -> Statement:
    whole = found.all
    return Statement(what, printed, None, whole.value, whole.sigma, whole.scatter, found.p, remark)


def _parameter(symbol: str) -> tuple[float, float]:
    """A row of wood_contact_parameters: its value as printed, and its deviation as a share."""
    table = _table("wood_contact_parameters")
    k = table.labels("symbol").index(symbol)
    sd = table.labels("std")[k]
    return float(table.columns["value"][k]), to_si(sd, "1", symbol) if sd else 0.0
