"""Beds that others measured: made-up rows that keep each law, and that break it."""

import math

import pytest
from made_damper_rows import done

from damper3d.case.closed_forms import collect_and_collide
from damper3d.reproduce import measured
from damper3d.reproduce.measured import cases, draw, drop, report, run
from damper3d.reproduce.measured.beds import (
    AT_REST,
    BEDS,
    clearance_onset,
    onset_of_mean,
    points,
)
from damper3d.reproduce.measured.quantities import (
    MEASURED,
    found_in,
    of_beds,
    published,
    rises,
    unlike,
)
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.figure import write_figure

LAWS = {"lift_off": 1.1, "sliding": 0.85, "doubling": 3.72, "convection": 1.0,
        "leidenfrost": 12.5, "onset": 1.0, "body": 0.9, "in_phase": -2.0, "loss_factor": -1.0,
        "speed": 1.0, "number": -0.5, "rebound": 0.6}  # fmt: skip
MASS = 0.01  # [kg]


def made(**changes):
    """Three packings of each point that follow LAWS, or others."""
    law = LAWS | changes
    rows = []
    for labels in points():
        bed, at = labels["bed"], labels["at"]
        for seed in (1, 2, 3):
            frequency = BEDS[bed].changes.get("motion.frequency")
            row = done(labels, gamma=at, frequency_hz=frequency, mass_kg=MASS, efficiency=0.1,
                       efficiency_interval=None, discarded=0)  # fmt: skip
            rows.append(row | _of(bed, at, labels["count"], law) | {"seed": seed})
    return rows


def _of(bed, at, count, law):
    if bed in ("vertical", "horizontal", "horizontal, rolling"):
        begins = law["lift_off" if bed == "vertical" else "sliding"]
        return {"efficiency_wall_work": 0.1 if at > begins else 1e-4}
    if bed == "flying":
        return {"efficiency_per_cycle": [0.2, 0.8] * 4 if at > law["doubling"] else [0.5] * 8}
    if bed == "rolls":
        return {"phase_measures.circulation": 0.3 if at >= law["convection"] else 0.05}
    if bed.startswith("suspended"):
        return {"phase": "leidenfrost" if at > law["leidenfrost"] else "global_fluidisation"}
    if bed == "weightless":
        part = at / (law["onset"] * onset_of_mean())
        return {"efficiency": law["body"] * float(collect_and_collide(part)) if part > 1 else 0.1}
    if bed.startswith("no lid"):
        parts = {"in_phase": law["in_phase"], "out_of_phase": law["loss_factor"]}
        return {f"effective_mass.{part}_kg": MASS * (at / 1.4) ** power
                for part, power in parts.items()}  # fmt: skip
    if bed == "thin":
        rise = 0.0 if at == AT_REST else 0.02 * at ** law["speed"] * count ** law["number"]
        return {"bed_height_m": 1e-4 * count + rise}
    return {"rebound": 0.1 if at < law["rebound"] else 1e-3}


def verdicts(rows):
    found = MEASURED.judge(claims_of("damper_measured"), found_in(rows))
    return {one.claim.id: [check.holds for check in one.checks] for one in found}


def test_beds_that_follow_the_laws_hold_but_for_fewer_particles_in_a_dropped_one():
    found = verdicts(made())
    assert not any(found.pop("least-for-no-rebound"))  # 0.6 e0 is not 1.5 e0
    assert all(all(checks) for checks in found.values()), found


@pytest.mark.parametrize(("claim", "changes"), [
    ("lift-off", {"lift_off": 0.85}),
    ("sliding", {"sliding": 0.55}),
    ("doubling", {"doubling": 4.3}),
    ("convection", {"convection": 1.4}),
    ("leidenfrost", {"leidenfrost": 8.5}),
    ("transition", {"onset": 1.15}),
    ("one-body", {"body": 0.7}),
    ("apparent-mass", {"in_phase": -1.5}),
    ("loss-factor", {"loss_factor": -0.7}),
    ("rise-with-speed", {"speed": 1.5}),
    ("rise-with-number", {"number": -0.8}),
    ("no-rebound", {"rebound": 2.0}),
])  # fmt: skip
def test_a_bed_that_breaks_a_law_is_seen(claim, changes):
    assert False in verdicts(made(**changes))[claim]


def test_powers_come_out_as_they_were_put_in():
    """Exact powers, so that the interval is that of rounding: the root of 1e-16 of a variance."""
    wanted = {"in_phase": -2.0, "loss_factor": -1.0, "rise_speed": 1.0, "rise_number": -0.5}
    found = [one for one in of_beds(found_in(made())) if one["name"] in wanted]
    assert len(found) == 6  # two frequencies of the effective mass
    for one in found:
        assert one["value"] == pytest.approx(wanted[one["name"]], abs=1e-9)
        assert one["high"] - one["low"] < 1e-6


def test_a_run_whose_bed_does_not_rise_counts_in_no_power():
    rows = made()
    thin = [row for row in rows if row["bed"] == "thin"]
    low = next(k for k, row in enumerate(thin) if row["at"] > 1.0)
    sunk = [row | ({"bed_height_m": 0.0} if k == low else {}) for k, row in enumerate(thin)]
    assert len(rises(sunk)) == len(rises(thin)) - 1


def test_thresholds_lie_between_the_last_that_fails_and_the_first_that_passes():
    found = {(one["name"], one["bed"]): one for one in of_beds(found_in(made(lift_off=1.12)))}
    off = found["lift_off", "vertical"]
    assert (off["low"], off["high"]) == (1.1, 1.15)
    own = found["transition", "weightless"]
    assert own["low"] < 1.0 < own["high"]


def test_a_bed_that_moves_at_every_gamma_has_no_threshold():
    names = {one["name"] for one in of_beds(found_in(made(sliding=0.0)))}
    assert "sliding" not in names
    assert verdicts(made(sliding=0.0))["sliding"] == [None, None]
    assert "not found" in report(made(sliding=0.0))


def test_cycles_are_unlike_by_their_difference_over_their_sum():
    """|0.8 - 0.2|/(0.8 + 0.2) = 0.6; those that do not count are left out."""
    assert unlike({"efficiency_per_cycle": [9.0, 1.0, 0.2, 0.8, 0.2, 0.8], "discarded": 2}) == (
        pytest.approx(0.6, rel=1e-12)
    )


def test_the_clearance_of_the_weightless_bed_is_that_of_its_case():
    """Eqs 6.1, 6.11 and 6.13 with the fill ratio of the case as it is run."""
    case = next(case for labels, case in cases([1]) if labels["bed"] == "weightless")
    omega = 2 * math.pi * 20
    for packing, most in (("loose", 0.55), ("close", 0.64)):
        clearance = (1 - case.fill_ratio / most) * 0.045
        wanted = omega**2 * clearance / (math.pi * 9.81)
        assert clearance_onset(packing) == pytest.approx(wanted, rel=1e-6)


def test_counted_cycles_are_pairs_and_every_published_interval_is_compared():
    for labels, case in cases([1]):
        assert labels["bed"] != "flying" or (case.settings.run.cycles
                                             - case.settings.run.discard) % 2 == 0  # fmt: skip
    assert {one["name"] for one in of_beds(found_in(made()))} == set(published())


def test_the_table_is_told_and_drawn(tmp_path):
    text = report(made())
    assert text.startswith("complete")
    assert "in common" in text
    assert "INCOMPLETE" in report(made()[:40])
    assert write_figure(tmp_path / "measured.png", lambda: draw(made())).exists()


def test_drops_that_an_earlier_table_has_are_not_made_again(tmp_path):
    """With all rows known nothing is run: each comes back as it is."""
    known = made()
    rows = run(out=tmp_path, seeds=[1, 2, 3], workers=1, quiet=True, known=known)
    assert sorted(map(repr, rows)) == sorted(map(repr, known))


def test_a_drop_of_the_table_has_its_bed_ratio_and_height(monkeypatch):
    """At 0.25 of a box with e0 = 0.9 the bed has 0.225 of its mass; it falls by 100 mm."""
    given = []
    monkeypatch.setattr(measured, "rebound", lambda *arguments: given.append(arguments) or 0.1)
    labels = {"bed": "dropped, e0 0.9", "count": 150, "at": 0.25, "seed": 2}
    assert drop(labels, bool) == 0.1
    ((case, *numbers, _),) = given
    assert numbers == pytest.approx([0.225, 0.9, 0.1], rel=1e-12)
    assert (case.settings.run.seed, case.settings.particles.count) == (2, 150)
