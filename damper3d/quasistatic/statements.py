"""What the thesis says of Figs 8.16 to 8.19 (sec. 8.5.1.2), judged.

Of compression by the secant stiffness; of shear, whose curves zig-zag as single particles slip, by
the rise of the force in its mean over the distance, as a secant catches the slip where it ends.
Two shapes differ where their means do beyond Welch's 95 % interval over the packings. Where they do
not, a statement that one is stiffer is not judged: more packings would tell.
"""

from collections.abc import Sequence

from campaign.statistics import noise_of_difference
from damper3d.quasistatic.shapes import Shape, family
from damper3d.reproduce.statements import Check, Statement

MEASURE = {"compress": "stiffness_n_per_m", "shear": "force_mean_n"}  # that is judged
_ALIKE_TO = 0.2  # the largest hole ratio at which toroids are alike, as the thesis says
_SIGNIFICANT = 0.05
_OF = {"prolate": "spheroids", "toroid": "toroids"}


def statements(test: str, shapes: dict[str, Shape]) -> list[Statement]:
    """Those about compression or about shear."""
    spheroids, toroids = family(shapes, "prolate"), family(shapes, "toroid")
    column = MEASURE[test]
    if test == "compress":
        return [
            Statement(
                "the normal stiffness is lowest for perfect spheres",
                [
                    *_all_above(spheroids, 1.0, "prolate", column),
                    *_all_above(toroids, 0.0, "toroid", column),
                ],
            ),
            Statement(
                "it rises to a maximum and then reduces again as the ratio increases",
                [_falls(spheroids, "prolate", column), _falls(toroids, "toroid", column)],
            ),
        ]
    alike = {ratio: s for ratio, s in toroids.items() if ratio <= _ALIKE_TO}
    return [
        Statement(
            "spheroids of an aspect ratio above 1 are stiffer in shear than spheres",
            _all_above(spheroids, 1.0, "prolate", column),
        ),
        Statement("their curves are approximately the same", [_alike(spheroids, 1.0, column)]),
        Statement(
            "toroids of hole ratios up to 0.20 are stiffer in shear than spheres",
            _all_above(alike, 0.0, "toroid", column),
        ),
        Statement("and nearly the same", [_alike(alike, 0.0, column)]),
        Statement(
            "above 0.20 the shear stiffness decreases", [_lower(toroids, alike, column)],
        ),
        Statement(
            "to a level similar to perfect spheres, or even smaller, at 0.33",
            [_not_above(toroids, column)],
        ),
    ]  # fmt: skip


def _all_above(own: dict[float, Shape], sphere: float, kind: str, column: str) -> list[Check]:
    """That each other shape of a family is stiffer than its sphere."""
    others = [ratio for ratio in own if ratio != sphere]
    if sphere not in own or not others:
        return [Check(None, "", _OF[kind])]
    return [_above(own[ratio], own[sphere], f"{kind} {ratio:g}", column) for ratio in others]


def _above(shape: Shape, sphere: Shape, of: str, column: str) -> Check:
    first, second = shape.sample(column), sphere.sample(column)
    assert first.mean is not None
    assert second.mean is not None
    found = f"{first.mean / second.mean:.2f} of the sphere's"
    noise = noise_of_difference(first, second)
    if noise is None:
        return Check(None, f"{found}; too few packings to judge", of)
    found += f" (+- {noise / second.mean:.2f})"
    if abs(first.mean - second.mean) <= noise:
        return Check(None, f"{found}: within the scatter", of)
    return Check(first.mean > second.mean, found, of)


def _falls(own: dict[float, Shape], kind: str, column: str) -> Check:
    """That the stiffest of a family is neither its sphere nor its last shape."""
    of = _OF[kind]
    if len(own) < 3:
        return Check(None, "", of)
    means = {ratio: shape.sample(column).mean or 0.0 for ratio, shape in own.items()}
    top, last = max(means, key=lambda ratio: means[ratio]), max(means)
    found = f"largest at {top:g}; at {last:g} {means[last] / means[top]:.2f} of that"
    noise = noise_of_difference(own[top].sample(column), own[last].sample(column))
    if top in (last, min(means)):
        return Check(False, found, of)
    if noise is None or means[top] - means[last] <= noise:
        return Check(None, f"{found}: within the scatter", of)
    return Check(True, found, of)


def _alike(own: dict[float, Shape], sphere: float, column: str) -> Check:
    """That shapes other than the sphere do not differ: one-way analysis of variance."""
    from scipy.stats import f_oneway

    groups = [s.values(column) for ratio, s in own.items() if ratio != sphere]
    if len(groups) < 2 or min(map(len, groups)) < 2:
        return Check(None, "too few packings to judge" if groups else "")
    means = [sum(group) / len(group) for group in groups]
    p = float(f_oneway(*groups).pvalue)
    found = f"means within {max(means) / min(means) - 1:.0%} of each other, p = {p:.2g}"
    return Check(p >= _SIGNIFICANT, f"{found} that one value gives such a spread")


def _lower(toroids: dict[float, Shape], alike: dict[float, Shape], column: str) -> Check:
    """That toroids of larger holes are less stiff than those up to 0.20."""
    wide = _pooled([s for ratio, s in toroids.items() if ratio > _ALIKE_TO])
    narrow = _pooled([s for ratio, s in alike.items() if ratio > 0.0])
    if wide is None or narrow is None:
        return Check(None, "")
    check = _above(narrow, wide, "", column)
    ratio = (wide.sample(column).mean or 0.0) / (narrow.sample(column).mean or 1.0)
    scatter = ": within the scatter" if check.holds is None else ""
    return Check(check.holds, f"{ratio:.2f} of the mean of those up to 0.20{scatter}")


def _pooled(shapes: Sequence[Shape]) -> Shape | None:
    """The tests of several shapes as of one."""
    return Shape("", [row for s in shapes for row in s.rows]) if shapes else None


def _not_above(toroids: dict[float, Shape], column: str) -> Check:
    """That the toroid of the largest hole is no stiffer than the sphere, beyond the scatter."""
    if 0.0 not in toroids or max(toroids) <= _ALIKE_TO:
        return Check(None, "")
    check = _above(toroids[max(toroids)], toroids[0.0], "", column)
    few = len(toroids[0.0].rows) < 2 or len(toroids[max(toroids)].rows) < 2
    return Check(None if few else check.holds is not True, check.found)
