"""Printed numbers of the thesis: closed forms, and made-up runs with and without yielding."""

import math

import pytest
from made_damper_rows import done

from damper3d.reproduce.printed import cases, draw, report
from damper3d.reproduce.printed.quantities import (
    LAWS,
    PRINTED,
    change_by_yielding,
    fill_of_toroids,
    onset_of_fill,
    points,
    rayleigh,
    share_of_rayleigh,
    toroid_fill,
)
from damper3d.shapes.particle import parse_particle
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.figure import write_figure


def made(ratio=3.0, efficiency=1.0, force=1.0, scatter=0.002):
    """Three packings of each point; with yielding efficiency and force are so many times more."""
    rows = []
    for labels in points():
        times = (efficiency, force) if LAWS[labels["law"]] else (1.0, 1.0)
        for seed, off in ((1, -scatter), (2, 0.0), (3, scatter)):
            rows.append(done(labels) | {
                "seed": seed, "efficiency": 0.1 * times[0] * (1 + off),
                "peak_wall_force_n": 100.0 * times[1] * (1 + off),
                "max_impact_over_yield_velocity.particle_particle": ratio,
                "impacts_beyond_yield.particle_particle": 1e-3,
            })  # fmt: skip
    return rows


def verdicts(rows):
    found = PRINTED.judge(claims_of("damper_printed"), rows)
    return {one.claim.id: [check.holds for check in one.checks] for one in found}


def test_a_hundred_and_ten_toroids_fill_the_cylinder_as_their_volumes_do():
    """110 times the volume of the particle as it is run, over pi/4 D^2 L; eq. 6.1."""
    volume = parse_particle("toroid:0.2", equal_volume_radius=3.5e-3).volume
    assert toroid_fill() == pytest.approx(110 * volume / (math.pi / 4 * 0.04**3), rel=1e-9)
    (item,) = fill_of_toroids([])
    assert toroid_fill(item["number"]) == pytest.approx(0.38, rel=1e-12)
    assert toroid_fill(radius=1e-3 * item["radius_mm"]) == pytest.approx(0.38, rel=1e-12)


def test_the_onset_goes_as_the_clearance_that_the_fill_leaves():
    """Eqs 6.11 and 6.13: the ratio is that of 1 - fill/packing, whatever frequency and length."""
    for item, packing in zip(onset_of_fill([], 0.38), (0.55, 0.64), strict=True):
        wanted = (1 - 0.38 / packing) / (1 - toroid_fill() / packing)
        assert item["value"] == pytest.approx(wanted, rel=1e-12)


def test_the_rayleigh_step_is_open_by_the_digits_of_its_properties():
    """Eq. 3.31 goes as R root(rho (1 + nu)/E)/(0.1631 nu + 0.8766); the ends are corners."""

    def step(e, nu, rho):
        return math.pi * 2500 * math.sqrt(2 * rho * (1 + nu) / e) / (0.1631 * nu + 0.8766)

    (item,) = rayleigh([], 2.5, 0.05)
    assert item["value"] == pytest.approx(step(3.3e9, 0.37, 1190.0), rel=1e-12)
    assert item["high"] == pytest.approx(step(3.25e9, 0.375, 1195.0), rel=1e-12)
    assert item["low"] == pytest.approx(step(3.35e9, 0.365, 1185.0), rel=1e-12)
    assert step(1e9 * item["modulus"], 0.37, 1190.0) == pytest.approx(8.4, rel=1e-12)
    assert step(3.3e9, 0.37, item["density"]) == pytest.approx(8.4, rel=1e-12)
    (share,) = share_of_rayleigh([], 2.5)
    assert share["value"] * item["value"] == pytest.approx(1.0, rel=1e-12)


def test_changes_by_yielding_are_those_of_the_rows_with_their_noise():
    """Means of three with a relative scatter of 0.002: Welch's t times 0.002 root(2/3)."""
    for item in change_by_yielding(made(efficiency=1.1), "efficiency"):
        assert item["value"] == pytest.approx(0.1, rel=1e-9)
        assert 2.7 * 0.002 * math.sqrt(2 / 3) < item["noise"] < 3.2 * 0.002 * math.sqrt(2 / 3)


@pytest.mark.parametrize(("changes", "claim", "holds"), [
    ({"ratio": 1.2}, "fastest-impact", [True]),
    ({"ratio": 1.3}, "fastest-impact", [False]),
    ({}, "constant-restitution-serves", [True, True]),
    ({"efficiency": 1.08}, "constant-restitution-serves", [False, False]),
    ({"scatter": 0.1}, "constant-restitution-serves", [True, None]),
    ({}, "force-of-yielding", [True, True]),
    ({"force": 0.85}, "force-of-yielding", [False, False]),
])  # fmt: skip
def test_runs_decide_whether_constant_restitution_serves(changes, claim, holds):
    assert verdicts(made(**changes))[claim] == holds


def test_cases_differ_in_the_restitution_alone_and_the_table_is_told_and_drawn(tmp_path):
    laws = {}
    for labels, case in cases([1]):
        rest = tuple(value for key, value in labels.items() if key != "law")
        laws.setdefault(rest, {})[labels["law"]] = case
    for two in laws.values():
        assert [two[law].settings.law.yielding for law in LAWS] == list(LAWS.values())
        assert two["constant"].mass == two["yielding"].mass
    text = report(made(efficiency=1.1))
    assert text.startswith("complete")
    assert "+10.0 +- " in text
    assert "INCOMPLETE" in report(made()[:5])
    one_law = {"orientation": "vertical", "gamma": 60.0, "law": "yielding"}
    lacks = [row for row in made() if not one_law.items() <= row.items()]
    lines = [line.split() for line in report(lacks).splitlines() if line.startswith("  vertical")]
    assert [line[4] for line in lines] == ["40", "100", "100", "100"]
    assert write_figure(tmp_path / "printed.png", lambda: draw(made())).exists()
