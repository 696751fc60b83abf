"""Result of a pair of pictures: the field in pixels and in metres, as table, text and figure."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from calibration.piv.field import Array, Field, Reason
from calibration.piv.measure import displacement
from calibration.piv.pictures import read_mask, read_picture
from calibration.statistics.quantity import six_digits
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_EXTREME = 1e60  # m/px, 1/s, or m/px/s
_FEW = 0.75  # share of valid vectors below which a field is doubtful (Raffel et al. 2018, sec. 7.1:
# a good recording has more than 95 %)


@dataclass(frozen=True)
class Displacement:
    """A field, its vectors also in other units; a result (calibration.result).

    first    picture a
    scale    m/px; None where it is not known
    dt       s from a to b; None where it is not known
    """

    first: Path
    second: Path
    field: Field
    scale: float | None = None
    dt: float | None = None

    @property
    def unit(self) -> str:
        """Unit of the vectors, the largest known: m/s, px/s, m or px."""
        return ("px" if self.scale is None else "m") + ("" if self.dt is None else "/s")

    @property
    def factor(self) -> float:
        """Factor from pixels to `unit`."""
        return (self.scale or 1.0) / (self.dt or 1.0)

    @property
    def warnings(self) -> list[str]:
        """Reasons to doubt the field, a line each."""
        field, found = self.field, []
        share = field.valid.sum() / (field.reason != Reason.MASKED).sum()
        if share < _FEW:
            found.append(f"{share:.0%} of the vectors are valid: {_most(field)}")
        largest = np.abs(np.stack([field.u, field.v])[:, field.valid]).max()
        if largest > 0.75 * field.window:
            found.append(
                f"displacements up to {largest:.1f} px: farther than the window of {field.window} "
                f"px nothing is found; take larger windows or pictures that follow faster"
            )
        return found

    def rows(self) -> list[dict[str, float | int | str | None]]:
        """The table: a row for each window, units in the heads."""
        field = self.field
        columns: dict[str, Array] = {"x [px]": field.x, "y [px]": field.y}
        vectors = {"u": field.u, "v": field.v, "sigma_u": field.sigma_u, "sigma_v": field.sigma_v}
        columns |= {f"{name} [px]": values for name, values in vectors.items()}
        if self.scale is not None:
            columns |= {"x [m]": self.scale * field.x, "y [m]": self.scale * field.y}
        if self.unit != "px":
            columns |= {f"{name} [{self.unit}]": self.factor * v for name, v in vectors.items()}
        columns["peak_ratio" if field.method == "piv" else "residual [px]"] = field.quality
        numbers = np.stack([values.ravel() for values in columns.values()], axis=1).tolist()
        rows = []
        for values, reason in zip(numbers, field.reason.ravel().tolist(), strict=True):
            row: dict[str, float | int | str | None] = {
                name: six_digits(value) for name, value in zip(columns, values, strict=True)
            }
            rows.append(row | {"valid": int(reason == Reason.MEASURED), "reason": _name(reason)})
        return rows

    def to_dict(self) -> dict[str, Any]:
        """Numbers of the valid vectors."""
        field, good = self.field, self.field.valid
        return {
            "method": field.method,
            "window_px": field.window,
            "vectors": good.size,
            "valid": int(good.sum()),
            "reasons": {_name(one): int((field.reason == one).sum()) for one in Reason},
            "u_px": _spread(field.u[good]),
            "v_px": _spread(field.v[good]),
            "sigma_px": {
                "median": float(np.median(field.sigma[good])),
                "largest": float(field.sigma[good].max()),
            },
            "scale_m_per_px": self.scale,
            "dt_s": self.dt,
            "speed_m_s": None if self.unit != "m/s" else _spread(self.speed()[good]),
            "warnings": self.warnings,
        }

    def text(self) -> str:
        """Number of valid vectors, and their spread."""
        found = self.to_dict()
        window = found["window_px"]
        lines = [f"{found['valid']} of {found['vectors']} vectors valid, windows of {window} px"]
        lost = {name: n for name, n in found["reasons"].items() if n and name != "measured"}
        lines += [f"  {n} {name.replace('_', ' ')}" for name, n in lost.items()]
        lines.append(f"{'[px]':6}{'mean':>10}{'sd':>10}{'lowest':>10}{'highest':>10}")
        for name in ("u", "v"):
            cells = "".join(f"{value:10.3f}" for value in found[f"{name}_px"].values())
            lines.append(f"{name:6}{cells}")
        sigma = found["sigma_px"]
        lines.append(f"sigma of a component {sigma['median']:.3f} px (median), "
                     f"{sigma['largest']:.3f} px at most")  # fmt: skip
        if self.unit != "px":
            speeds = self.speed()[self.field.valid]
            lines.append(f"size of a vector {speeds.mean():.4g} {self.unit} (mean), "
                         f"{speeds.max():.4g} {self.unit} at most")  # fmt: skip
        return "\n".join([*lines, *(f"warning: {words}" for words in self.warnings)])

    def figure(self) -> "Figure":
        """Vectors over the first picture, their sigma, and fractions of pixels."""
        from calibration.piv.figure import draw

        return draw(self)

    def speed(self) -> Array:
        """(rows, columns) size of the vectors in `unit`."""
        return np.asarray(self.factor * np.hypot(self.field.u, self.field.v))


def measure_pair(
    first: Path, second: Path, *, window: int = 32, overlap: float = 0.5, method: str = "piv",
    mask: Path | None = None, scale: float | None = None, dt: float | None = None,
) -> Displacement:  # fmt: skip
    """The displacement between two pictures in files; see calibration.piv.displacement.

    Raises InputError where nothing of the first picture is found in the second.
    """
    if dt is not None and not 0 < dt < np.inf:
        raise InputError(f"--dt = {dt:g} s: must be positive, the time from A to B")
    factor = (scale or 1.0) / (dt or 1.0)
    if not (1 / _EXTREME < factor < _EXTREME):
        raise InputError(
            f"--scale {scale or 1:g} m/px over --dt {dt or 1:g} s: no picture has such a scale or "
            "rate; check their units"
        )
    a, b = read_picture(first), read_picture(second)
    inside = None if mask is None else read_mask(mask)
    for path, other in ((second, b), (mask, inside)):
        if other is not None and other.shape[:2] != a.shape[:2]:
            raise InputError(f"{path}: {_size(other)} pixels, and {first} has {_size(a)}")
    field = displacement(a, b, window=window, overlap=overlap, mask=inside, method=method)
    if not field.valid.any():
        raise InputError(f"{first}, {second}: nothing is found in both pictures ({_most(field)})")
    return Displacement(first, second, field, scale, dt)


def _most(field: Field) -> str:
    """The reason of most vectors that are not valid, in words."""
    words = {
        Reason.MASKED: "outside the mask",
        Reason.NO_TEXTURE: "no texture",
        Reason.TOO_FAR: f"moved farther than {field.window} px",
        Reason.AMBIGUOUS: "two positions fit about as well",
        Reason.VAGUE: "sigma above half a pixel",
        Reason.OUTLIER: "unlike their neighbours",
    }
    counts = {one: int((field.reason == one).sum()) for one in words}
    most = max(counts, key=lambda one: counts[one])
    return f"{counts[most]} of {field.reason.size}: {words[most]}"


def _size(picture: NDArray) -> str:
    return f"{picture.shape[1]} x {picture.shape[0]}"


def _name(reason: int) -> str:
    return Reason(reason).name.lower()


def _spread(values: Array) -> dict[str, float]:
    return {
        "mean": float(values.mean()),
        "sd": float(values.std()),
        "lowest": float(values.min()),
        "highest": float(values.max()),
    }
