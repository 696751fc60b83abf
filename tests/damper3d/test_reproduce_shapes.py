"""The table of particle shapes (thesis, chapter 8): its plan, and its words on made curves."""

import math

import numpy as np
import pytest

from damper3d.case.closed_forms import bouncing_bed_onset
from damper3d.reproduce import shapes
from damper3d.reproduce.panels import labels_of
from damper3d.reproduce.quantities import shapes as quantities
from damper3d.reproduce.quantities.shapes import SHAPES, Line, Readings, optima
from granulab.campaign.claims.claim import claims_of

SPHERE_ONSET = float(bouncing_bed_onset(40.0, 0.0143))


def thesis_like(shape, frequency):
    """Onset as the thesis says: a V round 1.0, flat from 1.5; toroids up at 0.05 and back."""
    sphere = SPHERE_ONSET * (frequency / 40) ** 2 / 1.35
    family, ratio = shape
    if family == "toroid":
        return sphere * (1.0 if ratio == 0 else 1.5 - 0.55 * (ratio - 0.05) / 0.28)
    if family == quantities.GRIDDED:
        return sphere
    if ratio < 1:
        return sphere * (1 + 0.6 * (1 - ratio) / 0.3)
    return sphere * (1 + 0.6 * min(ratio - 1, 0.5) / 0.5)


def alike(shape, frequency):
    """Onset of spheres whatever the shape."""
    return SPHERE_ONSET * (frequency / 40) ** 2


def rows(onset, points, level=0.8, seeds=(1,)):
    """Runs whose eta is a hump over ln Gamma: made, not computed."""
    found = []
    for labels in points:
        shape = (labels["shape"], labels["ratio"])
        frequency, gamma = labels["frequency_hz"], labels["gamma"]
        top = onset(shape, frequency) if frequency <= 40 else 3.0 * (160 / frequency) ** 0.1
        eta = level * (frequency / 40) ** 0.05 * math.exp(-(math.log(gamma / top) ** 2))
        kept = {"efficiency": eta, "efficiency_interval": [eta - 1e-4, eta + 1e-4]}
        found += [
            {**labels, **kept, "seed": s, "state": "done", "reason": "", "fill_ratio": 0.411}
            for s in seeds
        ]
    return found


def onset_rows(onset):
    return rows(onset, labels_of(onset_panels()))


def onset_panels():
    return [panel for f in quantities.BOUNCING for panel in shapes.onset_panels(f)]


def verdicts(rows):
    """The verdict on each claim by its name."""
    return {name: one.holds for name, one in judged(rows).items()}


def judged(rows):
    claims = claims_of("damper_shapes")
    found = SHAPES.judge(claims, Readings(rows, optima(rows)))
    return {claim.id: one for claim, one in zip(claims, found, strict=True)}


def test_plan_has_the_shapes_and_counts_of_chapter_8():
    """Tables 8.1 and 8.2: 11 spheroids and 6 toroids; sec. 8.3: 90 and 110 of them."""
    assert [family for family, _ in quantities.shapes()].count("spheroid") == 11
    assert [family for family, _ in quantities.shapes()].count("toroid") == 6
    counts = {p.labels["shape"]: p.changes["particles.count"] for p in onset_panels()}
    assert counts == {"spheroid": 90, "toroid": 110, quantities.GRIDDED: 90}
    oblates = [ratio for family, ratio in quantities.gridded() if family == quantities.GRIDDED]
    assert oblates == [r for family, r in quantities.shapes() if family == "spheroid" and r < 1]
    cycles = {(p.changes["run.cycles"], p.changes["run.discard"]) for p in onset_panels()}
    assert cycles == {(18, 3)}  # sec. 8.4


@pytest.mark.parametrize(("shape", "text"), [
    (("spheroid", 0.7), "oblate:0.7"), (("spheroid", 1.0), "prolate:1"),
    (("spheroid", 1.5), "prolate:1.5"), (("toroid", 0.0), "toroid:0"),
    (("toroid", 0.33), "toroid:0.33"), ((quantities.GRIDDED, 0.7), "oblate_grid:0.7"),
])  # fmt: skip
def test_shapes_are_called_as_the_command_takes_them(shape, text):
    assert quantities.particle_text(shape) == text


def test_fill_ratios_of_the_plan_are_those_of_its_cases():
    """The Gammas of the plan go by them (eq. 6.13); to the digits that it states."""
    for family, reference in (("spheroid", 1.0), ("toroid", 0.0)):
        panel = shapes.panel((family, reference), "vertical", [(40.0, 20.0)])
        ((_, case),) = panel.cases([1])
        assert case.fill_ratio == pytest.approx(shapes.FILL[family], abs=5e-4)
        assert case.particle.is_sphere


def test_time_step_shortens_with_stiffer_and_lighter_particles():
    """Eq. 3.31: it goes as root(rho/E); never longer than the standard's 2 us.

    Three digits are kept, which is half a unit of the third: 0.5 %.
    """
    steps = {
        (p.labels["property"], p.labels["value"]): float(p.changes["run.time_step"].split()[0])
        for p in shapes.sensitivity_panels()
    }
    assert steps["standard", 1.0] == 2.0
    assert steps["modulus", 33e9] == pytest.approx(2 / math.sqrt(10), rel=5e-3)
    assert steps["density", 595.0] == pytest.approx(2 / math.sqrt(2), rel=5e-3)
    assert max(steps.values()) == 2.0


def test_statements_hold_for_onsets_as_the_thesis_gives_them():
    found = verdicts(onset_rows(thesis_like))
    of_onsets = list(found)[: list(found).index("best-efficiency-insensitive")]
    assert len(of_onsets) == 13
    assert [name for name in of_onsets if not found[name]] == []


def test_statements_of_a_shift_fail_where_shape_does_nothing():
    """The rise to 1.5, its flat, the rises to 0.7, to the toroid of 0.05, and by sphericity."""
    found = verdicts(onset_rows(alike))
    shift = ["more-than-50-%-higher-by-1.5", "flat-from-1.5", "rises-to-oblates-likewise",
             "toroid-of-0.05-rises-likewise", "sphericity-rises-to-0.97-to-0.95",
             "sphericity-constant-to-0.85", "sphericity-below-the-sphere-at-0.70"]  # fmt: skip
    assert [found[name] for name in shift] == [False] * len(shift)


def test_the_thesis_own_oblates_must_not_fall_towards_the_sphere_as_true_ones_do():
    def as_true(shape, frequency):
        family = "spheroid" if shape[0] == quantities.GRIDDED else shape[0]
        return thesis_like((family, shape[1]), frequency)

    assert verdicts(onset_rows(as_true))["thesis-own-oblates-show-no-left-side"] is False


def test_onset_is_found_where_it_was_made():
    """The parabola in ln Gamma is that of a hump to within its grid; 10 % of a wide one."""
    found = optima(onset_rows(thesis_like))
    for line, one in found.items():
        assert one is not None
        assert one.gamma == pytest.approx(thesis_like(line.shape, line.frequency), rel=0.1)


def test_prolates_past_their_onset_damp_more_where_it_is_later():
    words = "prolates-better-past-their-onset"
    assert verdicts(onset_rows(thesis_like))[words]
    made = onset_rows(lambda shape, f: alike(shape, f) / (1.5 if shape[1] > 1 else 1.0))
    assert verdicts(made)[words] is False


def test_fluidisation_optimum_that_goes_with_frequency_alone_passes():
    found = verdicts(rows(alike, labels_of(shapes.curve_panels())))
    assert found["fluidisation-not-shifted"]
    assert found["thesis-own-oblates-fluidise-alike"]
    assert found["fluidisation-efficiency-rises-with-frequency"]
    assert found["fluidisation-falls-with-frequency"]


def test_a_fluidisation_optimum_that_one_orientation_shifts_is_seen():
    """Appendix E: the claims look at both."""
    made = rows(alike, labels_of(shapes.curve_panels()))
    for row in made:
        if row["orientation"] == "horizontal" and row["ratio"] == 3.0:
            row["gamma"] *= 2.0
    found = judged(made)["fluidisation-not-shifted"]
    of_each = {check.of: check.holds for check in found.checks}
    assert {label for label, holds in of_each.items() if holds is False} == {
        f"{frequency:g} Hz horizontal" for frequency in shapes.FLUIDISED
    }


def test_curves_without_a_peak_are_distinguished_from_curves_without_runs():
    flat = [{**row, "efficiency": 0.5, "efficiency_interval": [0.4, 0.6]}
            for row in rows(alike, labels_of(shapes.curve_panels()))]  # fmt: skip
    found = judged(flat)
    independent, trend = found["fluidisation-not-shifted"], found["fluidisation-without-trend"]
    words = {check.found for check in (*independent.checks, *trend.checks)}
    assert words == {"0 of 17 shapes have a peak"}
    assert {check.found for check in judged([])["fluidisation-not-shifted"].checks} == {""}


def test_a_trend_is_judged_where_scatter_does_not_hide_it():
    """Gamma as ratio^0.5 fails and as 1 holds; scattered by 30 % from shape to shape, neither."""
    random = np.random.default_rng(4)
    scattered = {shape: math.exp(0.3 * random.standard_normal()) for shape in quantities.shapes()}
    made = {}
    for name, times in {
        "trend": lambda shape: (1 + shape[1]) ** 0.5, "none": lambda _: 1.0,
        "scatter": lambda shape: scattered.get(shape, 1.0),
    }.items():  # fmt: skip
        found = rows(alike, labels_of(shapes.curve_panels()))
        for row in found:
            row["gamma"] *= times((row["shape"], row["ratio"]))
        made[name] = {c.holds for c in judged(found)["fluidisation-without-trend"].checks}
    assert made == {"trend": {False}, "none": {True}, "scatter": {None}}


def test_sphericity_orders_prolates_and_toroids():
    """Figs 8.13, 8.14: from the sphere down; oblates are left out (sec. 8.5.1.1)."""
    found = optima(onset_rows(thesis_like))
    pairs = quantities.by_sphericity(found, Line(("spheroid", 1.0), "vertical", 40.0))
    assert [x for x, _ in pairs] == sorted((x for x, _ in pairs), reverse=True)
    assert len(pairs) == 6 + 6
    assert pairs[0][0] == 1.0


def properties(rows):
    found = list(verdicts(rows).items())
    return dict(found[[name for name, _ in found].index("falls-with-density") :])


def made_properties(sign=1.0, scatter=0.0):
    """Each point of two packings, which differ by twice the scatter."""
    found = []
    for labels in labels_of(shapes.sensitivity_panels()):
        ratio, name, value = labels["ratio"], labels["property"], labels["value"]
        friction = value if name == "friction" else 0.52
        eta = 0.3 + (0.2 if ratio > 1 else 0.0) * (1.5 - friction)
        if name in ("density", "modulus", "restitution"):
            standard = shapes.STANDARD[name]
            eta += (
                {"density": -1, "modulus": 1, "restitution": 1}[name]
                * sign
                * 0.02
                * math.log(value / standard)
            )
        found += [
            {**labels, "efficiency": eta + off, "seed": seed, "state": "done"}
            for seed, off in ((1, -scatter), (2, scatter))
        ]
    return found


def test_property_statements_follow_the_made_trends():
    """Sec. 8.5.1.3: density down, modulus and restitution up; less friction, more shape."""
    assert set(properties(made_properties()).values()) == {True}
    turned = properties(made_properties(-1.0))
    assert [turned[words] for words in list(turned)[:3]] == [False] * 3
    clear, hidden = (properties(made_properties(scatter=s)) for s in (1e-3, 0.2))
    assert [clear[words] for words in list(clear)[:3]] == [True] * 3
    assert [hidden[words] for words in list(hidden)[:3]] == [None] * 3
    level = properties(made_properties(0.0))
    assert [level[words] for words in list(level)[:3]] == [None] * 3


def test_without_runs_nothing_is_judged_and_the_table_is_drawn():
    text = shapes.report([])
    assert text.count("INCOMPLETE: 0 of ") == len(shapes.plan())
    assert "PASS" not in text
    assert "FAIL" not in text
    shapes.draw([])


def test_report_names_the_multi_contact_models_and_draws_all_panels():
    points = [
        labels for part in shapes.plan() for labels in labels_of(part.panels)
        if labels["part"] == "curves"
    ]  # fmt: skip
    made = rows(thesis_like, points, seeds=(1, 2)) + made_properties()
    text = shapes.report(made)
    assert "deepest" in text
    assert "fluidisation optimum, vertical" in text
    shapes.draw(made)


def test_high_frequencies_and_20_hz_take_every_third_packing(monkeypatch, tmp_path):
    taken = {}

    def noted(panels, seeds, **_):
        for labels in labels_of(panels):
            taken.setdefault((labels["part"], labels["frequency_hz"]), set()).update(seeds)
        return []

    monkeypatch.setattr(shapes, "run_panels", noted)
    shapes.run(out=tmp_path, seeds=(1, 2, 3, 4), workers=1, quiet=True)
    assert taken["curves", 40.0] == taken["sensitivity", 40.0] == {1, 2, 3, 4}
    assert taken["curves", 20.0] == taken["curves", 1024.0] == {1, 4}
