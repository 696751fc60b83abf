"""Result of the test of two blocks, compared with what the paper prints."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from calibration.result import Parameter
from calibration.statistics.quantity import plus_minus
from calibration.statistics.uncertainty import Estimate, as_pair, through
from calibration.stiffness_fe import markers
from calibration.stiffness_fe.assumptions import Row
from calibration.stiffness_fe.measure import Contact, Found, Quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Journal sec. 3.2.2: kt/kn and its spread; "(2.8 +- 0.09)" of the flat one is 0.28 (errata)
PRINTED = {"flat": (0.28, 0.09), "rough": (0.065, 0.04)}
_VALUES = "kt_over_kn_flat", "kt_over_kn_rough", "normal_stress_rough_over_flat"
PRINTED_STRESS = 0.5  # "typically by 50 %"


@dataclass(frozen=True)
class Stiffness:
    """Test of two blocks compared with the paper; a result (calibration.result).

    rows      what was assumed and changed
    kn        measured normal stiffness [N/m], which makes kt of kt/kn
    source    of the surfaces, for a parameter file; None where files were measured
    """

    found: Found
    rows: Sequence[Row] = ()
    kn: Estimate | None = None
    source: str | None = "made surfaces"

    @property
    def kt(self) -> Estimate | None:
        """(kt/kn) kn [N/m] of the rough contact, or of the flat one where only that was tested."""
        contact = self.found.rough or self.found.flat
        if self.kn is None or contact is None:
            return None
        return through(lambda ratio, normal: ratio * normal, contact.ratio.whole, self.kn)

    def to_dict(self) -> dict[str, Any]:
        """The keys of docs/laboratory/stiffness-fe.md, SI."""
        found, stress = self.found, None
        if found.stress is not None:
            stress = _quantity(found.stress)
            stress |= {"printed": PRINTED_STRESS, "printed_table": _table_stress()}
        return {
            "flat": _contact(found, "flat"),
            "rough": _contact(found, "rough"),
            "normal_stress_rough_over_flat": stress,
            "assumptions": [
                {"what": row.what, "change": row.change, "assumed": row.assumed,
                 **dict(zip(_VALUES, row.values or [None] * len(_VALUES), strict=True)),
                 "reason": row.reason or None}
                for row in self.rows
            ],
            "kt_n_per_m": as_pair(self.kt),
        }  # fmt: skip

    def text(self) -> str:
        """Values compared with the printed ones, what was checked, and what was assumed."""
        found = self.found
        lines = [f"{'':28}{'found':>16}  {'mesh':>8} {'profiles':>8} {'assumed':>8}   printed"]
        contacts = {"flat": found.flat, "rough": found.rough}
        tested = {name: one for name, one in contacts.items() if one is not None}
        for name, one in tested.items():
            mean, sd = PRINTED[name]
            lines.append(_line(f"kt/kn {name}", one.ratio, f"{mean:g} +- {sd:g}"))
        if found.stress is not None:
            printed = f"about {PRINTED_STRESS:g}; Table 1 {_table_stress():.2f}"
            lines.append(_line("normal stress, rough/flat", found.stress, printed))
        for name, one in tested.items():
            lines += ["", *_details(name, one, found)]
        lines.append("")
        lines += _varied(self.rows) if self.rows else ["sigma leaves out what had to be assumed"]
        if (kt := self.kt) is not None:
            shown = plus_minus(1e-3 * kt.value, 1e-3 * (kt.sigma or 0))
            lines.append(f"kt = (kt/kn) kn = {shown} N/mm")
        return "\n".join(lines)

    def figure(self) -> "Figure":
        """Mesh, fields, interface and curves of the first profile."""
        from calibration.stiffness_fe.figure import draw

        return draw(self.found)

    def parameters(self) -> dict[str, Parameter]:
        """kt, where kn is known."""
        kt = self.kt
        return {} if kt is None else {"kt": Parameter(kt, "finite elements", self.source)}


def _line(name: str, one: Quantity, printed: str) -> str:
    value = plus_minus(one.whole.value, known_sigma(one))
    parts = (one.mesh, one.profiles, one.assumed)
    shown = " ".join(f"{'-' if part is None else f'{part:.2g}':>8}" for part in parts)
    return f"{name:28}{value:>16}  {shown}   {printed}"


def known_sigma(one: Quantity) -> float | None:
    """The sigma of a quantity; None where it is nothing but rounding, or not known."""
    sigma = one.whole.sigma
    return sigma if sigma and sigma > 1e-6 * abs(one.whole.value) else None


def _details(name: str, one: Contact, found: Found) -> list[str]:
    area = found.case.width
    load = one.load
    slid = one.mean(lambda o: o.sliding)
    return [
        f"{name}: friction {load.friction:g}, travel {1e3 * load.across:.4g} mm across, "
        f"{1e3 * load.along:.4g} mm along",
        f"  kn {_in_n_per_mm(one.kn)}, kt {_in_n_per_mm(one.kt)} N/mm of "
        f"{1e3 * found.case.depth:g} mm depth; kt/kn when shear begins "
        f"{plus_minus(one.onset.whole.value, known_sigma(one.onset))}",
        f"  mean normal stress {1e-6 * one.mean(lambda o: o.force[-1, 1]) / area:.3g} MPa, shear "
        f"stress {1e-6 * one.mean(lambda o: o.force[-1, 0]) / area:.3g} MPa; touching "
        f"{100 * one.mean(lambda o: o.touching):.3g} % of the width, sliding {100 * slid:.3g} % "
        "of that",
        f"  unaccounted work {max(abs(o.unaccounted) for o in one.outcomes):.1g}, unbalanced force "
        f"{max(o.imbalance for o in one.outcomes):.1g}",
    ]


def _in_n_per_mm(one: Quantity) -> str:
    return plus_minus(1e-3 * one.whole.value, 1e-3 * (one.whole.sigma or 0.0))


def _varied(rows: Sequence[Row]) -> list[str]:
    """The table of what was changed."""
    lines = [f"{'changed':24}{'to':20}{'flat':>8}{'rough':>8}{'stress':>8}"]
    for row in rows:
        given = "" if row.assumed else "  given"
        shown = f"    no test came to its end, not in sigma: {row.reason}"
        if row.values is not None:
            shown = "".join(f"{value:8.3f}" for value in row.values)
        lines.append(f"{row.what:24}{row.change:20}{shown}{given if row.change else ''}".rstrip())
    return [
        *lines,
        "flat, rough: kt/kn; stress: normal, of the rough over that of the flat contact; with half",
        "as many columns and load steps and four profiles; 'given': by the paper, not in sigma",
    ]


def _quantity(one: Quantity) -> dict[str, Any]:
    known = one.whole
    return {
        "value": known.value, "sigma": known.sigma, "trials": known.trials,
        "scatter": known.scatter, "sigma_mesh": one.mesh, "sigma_profiles": one.profiles,
        "sigma_assumed": one.assumed,
    }  # fmt: skip


def _contact(found: Found, name: str) -> dict[str, Any] | None:
    one: Contact | None = getattr(found, name)
    if one is None:
        return None
    mean, sd = PRINTED[name]
    first, width = one.outcomes[0], found.case.width
    read = markers.read(first)
    return {
        "kt_over_kn": _quantity(one.ratio)
        | {"printed": mean, "printed_sd": sd},
        "kt_over_kn_onset": _quantity(one.onset),
        "kn_n_per_m": _quantity(one.kn),
        "kt_n_per_m": _quantity(one.kt),
        "friction": one.load.friction,
        "travel_across_m": one.load.across,
        "travel_along_m": one.load.along,
        "sigma_n_pa": one.mean(lambda o: o.force[-1, 1]) / width,
        "sigma_t_pa": one.mean(lambda o: o.force[-1, 0]) / width,
        "contact_share": one.mean(lambda o: o.touching),
        "sliding_share": one.mean(lambda o: o.sliding),
        "energy_closure": max((o.unaccounted for o in one.outcomes), key=abs),
        "force_imbalance": max(o.imbalance for o in one.outcomes),
        "per_profile": [
            {"kt_over_kn": o.ratio, "kn_n_per_m": found.case.depth * o.kn,
             "contact_share": o.touching, "sliding_share": o.sliding}
            for o in one.outcomes
        ],
        "curve": {
            "along_m": first.platen[:, 0].tolist(), "across_m": first.platen[:, 1].tolist(),
            "shear_n_per_m": first.force[:, 0].tolist(),
            "normal_n_per_m": first.force[:, 1].tolist(),
        },
        "markers": None if read is None else {
            key: values.tolist() for key, values in read.items()
        },
    }  # fmt: skip


def _table_stress() -> float:
    flat, rough = markers.printed("flat"), markers.printed("rough")
    return rough.sigma_n / flat.sigma_n
