"""Statements of the thesis on Figs 8.16 to 8.19 (sec. 8.5.1.2), judged.

Of compression by the secant stiffness; of shear, whose curves zig-zag as single particles slip, by
the rise of the force in its mean over the distance, as a secant catches the slip where it ends.
Two shapes differ where their means do beyond the 95 % interval of the difference, from the scatter
of one packing pooled over all shapes. Where they do not, a statement that one is stiffer is not
judged: more packings would show it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from damper3d.reproduce.statements import Check, Statement
from damper3d.studies.quasistatic.shapes import Scatter, Shape, family, scatter_of

MEASURE = {"compress": "stiffness_n_per_m", "shear": "force_mean_n"}  # that is judged
_ALIKE_TO = 0.2  # the largest hole ratio at which toroids are alike, as the thesis says
_SIGNIFICANT = 0.05
# Shapes count as alike only where a difference of half would be seen: by so much shape moves the
# onset, which these tests are to explain.
_TELLING = 0.5
_OF = {"prolate": "spheroids", "toroid": "toroids"}


def statements(test: str, shapes: dict[str, Shape]) -> list[Statement]:
    """Those about compression or about shear."""
    spheroids, toroids = family(shapes, "prolate"), family(shapes, "toroid")
    judge = _Judge(MEASURE[test], scatter_of(shapes, test, MEASURE[test]))
    if test == "compress":
        return [
            Statement(
                "the normal stiffness is lowest for perfect spheres",
                [
                    *judge.all_above(spheroids, 1.0, "prolate"),
                    *judge.all_above(toroids, 0.0, "toroid"),
                ],
            ),
            Statement(
                "it rises to a maximum and then reduces again as the ratio increases",
                [judge.falls(spheroids, "prolate"), judge.falls(toroids, "toroid")],
            ),
        ]
    alike = {ratio: s for ratio, s in toroids.items() if ratio <= _ALIKE_TO}
    return [
        Statement(
            "spheroids of an aspect ratio above 1 are stiffer in shear than spheres",
            judge.all_above(spheroids, 1.0, "prolate"),
        ),
        Statement("their curves are approximately the same", [judge.alike(spheroids, 1.0)]),
        Statement(
            "toroids of hole ratios up to 0.20 are stiffer in shear than spheres",
            judge.all_above(alike, 0.0, "toroid"),
        ),
        Statement("and nearly the same", [judge.alike(alike, 0.0)]),
        Statement(
            "above 0.20 the shear stiffness decreases", [judge.lower(toroids, alike)],
        ),
        Statement(
            "to a level similar to perfect spheres, or even smaller, at 0.33",
            [judge.not_above(toroids)],
        ),
    ]  # fmt: skip


@dataclass(frozen=True)
class _Judge:
    """Compares shapes by a column, given the scatter of one packing (None: not known)."""

    column: str
    scatter: Scatter | None

    def all_above(self, own: dict[float, Shape], sphere: float, kind: str) -> list[Check]:
        """That each other shape of a family is stiffer than its sphere."""
        others = [ratio for ratio in own if ratio != sphere]
        if sphere not in own and others:
            return [Check(None, f"no run of {kind}:{sphere:g}, their sphere", _OF[kind])]
        if not others:
            return [Check(None, "", _OF[kind])]
        return [self.above(own[r], own[sphere], f"{kind} {r:g}", "the sphere's") for r in others]

    def above(self, shape: Shape, other: Shape, of: str, whose: str) -> Check:
        """That a shape is stiffer than another."""
        first, second = shape.sample(self.column), other.sample(self.column)
        assert first.mean is not None
        assert second.mean is not None
        found = f"{first.mean / second.mean:.2f} of {whose}"
        if self.scatter is None:
            return Check(None, f"{found}; too few packings to judge", of)
        noise = self.scatter.half_width(first, second)
        found += f" (+- {noise / abs(second.mean):.2f})"
        if abs(first.mean - second.mean) <= noise:
            return Check(None, f"{found}: within the scatter", of)
        return Check(first.mean > second.mean, found, of)

    def falls(self, own: dict[float, Shape], kind: str) -> Check:
        """That the stiffest of a family is neither its sphere nor its last shape."""
        of = _OF[kind]
        if len(own) < 3:
            return Check(None, "", of)
        means = {ratio: shape.sample(self.column).mean or 0.0 for ratio, shape in own.items()}
        top, last = max(means, key=lambda ratio: means[ratio]), max(means)
        if top in (last, min(means)):
            return Check(False, f"largest at {top:g}", of)
        check = self.above(own[top], own[last], of, f"that at {last:g}")
        return Check(check.holds, f"largest at {top:g}: {check.found}", of)

    def alike(self, own: dict[float, Shape], sphere: float) -> Check:
        """That shapes other than the sphere differ no more than packings: analysis of variance."""
        from scipy.stats import f as fisher

        samples = [s.sample(self.column) for ratio, s in own.items() if ratio != sphere]
        means = [sample.mean or 0.0 for sample in samples]
        if len(samples) < 2 or self.scatter is None:
            return Check(None, "too few packings to judge" if samples else "")
        total = sum(s.n for s in samples)
        middle = sum(s.n * m for s, m in zip(samples, means, strict=True)) / total
        one = self.scatter.sd * (abs(middle) if self.scatter.relative else 1.0)
        between = sum(s.n * (m - middle) ** 2 for s, m in zip(samples, means, strict=True))
        freedom = len(samples) - 1
        p = float(fisher.sf(between / freedom / one**2, freedom, self.scatter.freedom))
        found = f"means {min(means) / middle:.2f} to {max(means) / middle:.2f} of their mean"
        if self.scatter.half_width(*samples[:2]) > _TELLING * abs(middle) and p >= _SIGNIFICANT:
            return Check(None, f"{found}: within the scatter, which would hide a half")
        return Check(p >= _SIGNIFICANT, f"{found}; packings alone spread so with p = {p:.2g}")

    def lower(self, toroids: dict[float, Shape], alike: dict[float, Shape]) -> Check:
        """That toroids of larger holes are less stiff than those up to 0.20."""
        wide = _pooled([s for ratio, s in toroids.items() if ratio > _ALIKE_TO])
        narrow = _pooled([s for ratio, s in alike.items() if ratio > 0.0])
        if wide is None or narrow is None:
            return Check(None, "")
        check = self.above(wide, narrow, "", "the mean of those up to 0.20")
        return Check(None if check.holds is None else not check.holds, check.found)

    def not_above(self, toroids: dict[float, Shape]) -> Check:
        """That the toroid of the largest hole is no stiffer than the sphere, beyond the scatter."""
        if 0.0 not in toroids or max(toroids) <= _ALIKE_TO:
            return Check(None, "")
        last, sphere = toroids[max(toroids)], toroids[0.0]
        check = self.above(last, sphere, "", "the sphere's")
        if self.scatter is None or check.holds is not None:
            return Check(None if self.scatter is None else not check.holds, check.found)
        of_sphere = sphere.sample(self.column)
        noise = self.scatter.half_width(last.sample(self.column), of_sphere)
        return Check(True if noise <= _TELLING * abs(of_sphere.mean or 0.0) else None, check.found)


def _pooled(shapes: Sequence[Shape]) -> Shape | None:
    """The tests of several shapes as of one."""
    return Shape("", [row for s in shapes for row in s.rows]) if shapes else None
