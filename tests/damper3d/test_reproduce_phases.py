"""Phases of the thesis's maps: readings, quantities, and made-up maps that follow its sentences."""

import math
from typing import Any

import pytest
from made_damper_rows import done, two_peaks

from damper3d.measures.phases.criteria import classify
from damper3d.reproduce.panels import close_onset, labels_of
from damper3d.reproduce.phases import COLUMNS, draw, report
from damper3d.reproduce.phases.optima import efficiency_by_kind, most_fluidised, optimum
from damper3d.reproduce.phases.points import panels
from damper3d.reproduce.phases.quantities import (
    PHASE_MAPS,
    alternating,
    among,
    best_over_onset,
    counts,
    end_of_rest,
    in_band,
    kept_names,
    likeness,
    onset,
    onset_exponent,
    steps_back,
)
from damper3d.reproduce.phases.readings import OURS, READINGS, Point, points_of
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.figure import write_figure

Row = dict[str, Any]

# Measures of a loose bed that is named by the last rule, and what makes it another.
REST = {
    "free_path": 0.0, "low_impulse": 0.5, "high_impulse": 0.0, "stroke": 0.1, "coherence": 0.3,
    "carried_share": 0.0, "contrast": 0.0, "travelling_share": 0.2, "packed_share": 0.9,
    "circulation": 0.0, "hot_low": 1.0, "agitated_share": 0.95, "deep_carried_share": 0.0,
    "fluidised_share": 0.8, "convecting_share": 0.15, "low_density": 0.3,
}  # fmt: skip
GOES_ON = {"travelling_share": 0.9, "packed_share": 0.3, "fluidised_share": 0.1,
           "convecting_share": 0.85}  # fmt: skip
OTHER: dict[str, Row] = {
    "global_fluidisation": {},
    "fluidisation_convection": {"fluidised_share": 0.4, "convecting_share": 0.55},
    "solid_like": {"carried_share": 1.0},
    "local_fluidisation": {"agitated_share": 0.3},
    "partial_fluidisation": {"agitated_share": 0.3, "deep_carried_share": 0.9},
    "transition": {"coherence": 0.7, "contrast": 0.8},
    "leidenfrost": GOES_ON | {"hot_low": 4.0},
    "buoyancy_convection": GOES_ON | {"circulation": 0.4},
    "convection": GOES_ON,
    "bouncing_bed": {"high_impulse": 0.5, "stroke": 0.9, "coherence": 0.9},
}


def point(gamma: float, name: str, frequency: float = 160.0, **other: Any) -> Point:
    """A point of 40 mm and 8 cycles with the measures of a name."""
    orientation = other.pop("orientation", "vertical")
    return Point(
        orientation, other.pop("height_mm", 40), other.pop("cycles", 8), frequency, gamma,
        other.pop("efficiency", 0.1), 0.1, dict.fromkeys(READINGS, name),
        REST | OTHER[name] | other,
    )  # fmt: skip


def row(labels: Row, name: str, efficiency: float, **measures: float) -> Row:
    """A run with these measures."""
    own = {f"phase_measures.{k}": v for k, v in (REST | OTHER[name] | measures).items()}
    return done(labels) | own | {"phase": name, "efficiency": efficiency,
                                 "efficiency_wall_work": efficiency}  # fmt: skip


def ridge(frequency: float) -> float:
    """Gamma of the optimum of fluidisation: near 3, falling with frequency."""
    return 2.6 * (frequency / 160) ** -0.15


def of_the_thesis(labels: Row) -> tuple[str, float]:
    """Name and efficiency as secs 6.3 and 6.4 have them, at a point of the table."""
    o, f, gamma = labels["orientation"], labels["frequency_hz"], labels["gamma"]
    fluid, bounces = ridge(f), close_onset(labels["height_mm"], f)
    eta = two_peaks(gamma, fluid, bounces if bounces < 200 else None)
    if o == "none":
        return ("bouncing_bed" if gamma > 20 else "gas_like"), 0.1
    if gamma >= bounces:
        return "bouncing_bed", eta
    if o == "horizontal":
        names = (
            (0.83, "solid_like"),
            (3.5, "partial_fluidisation"),
            (8.0, "fluidisation_convection"),
        )
        last = "convection"
    else:
        rest = 1.12 if f < 200 else 0.4
        local = 1.8 * (f / 160) ** -0.1
        names = ((rest, "solid_like"), (local, "local_fluidisation"), (6.5, "global_fluidisation"),
                 (10.0, "transition"), (75.0, "leidenfrost"))  # fmt: skip
        last = "buoyancy_convection"
    name = next((name for most, name in names if gamma <= most), last)
    return name, {"solid_like": 0.01}.get(name, eta if gamma < 8 else 0.1)


def thesis_rows() -> list[Row]:
    rows = []
    for labels in labels_of(panels()):
        name, eta = of_the_thesis(labels)
        if name == "gas_like":
            rows.append(row(labels, "convection", eta, free_path=2.0) | {"phase": name})
            continue
        part = 0.5 if labels["orientation"] == "horizontal" else 0.8
        away = math.log(labels["gamma"] / ridge(labels["frequency_hz"]))
        share = part * math.exp(-(away**2))
        goes_on = (0.2 if name == "partial_fluidisation" else 1.2) * share
        rows.append(row(labels, name, eta, fluidised_share=share, convecting_share=goes_on))
    return rows


def verdicts(rows: list[Row]) -> dict[str, list[bool | None]]:
    found = PHASE_MAPS.judge(claims_of("damper_phases"), points_of(rows))
    return {one.claim.id: [check.holds for check in one.checks] for one in found}


@pytest.mark.parametrize("name", OTHER)
def test_made_measures_have_the_name_that_they_are_made_for(name):
    orientation = "horizontal" if name in ("partial_fluidisation", "fluidisation_convection") else (
        "vertical")  # fmt: skip
    assert classify(REST | OTHER[name], orientation).name == name


@pytest.mark.parametrize(("measures", "partial"), [
    ({"agitated_share": 0.4, "fluidised_share": 0.1, "convecting_share": 0.3},
     {OURS, "a tenth rests"}),
    ({"agitated_share": 0.8, "fluidised_share": 0.1, "convecting_share": 0.7}, {"a tenth rests"}),
    ({"agitated_share": 1.0, "fluidised_share": 0.6, "convecting_share": 0.4}, {"more return"}),
    ({"agitated_share": 1.0, "fluidised_share": 0.4, "convecting_share": 0.6,
      "deep_carried_share": 0.6}, {"deep layers carried"}),
    ({"agitated_share": 0.0, "fluidised_share": 0.0, "convecting_share": 0.0},
     {OURS, "a tenth rests", "more return"}),  # where none moves, none goes on
])  # fmt: skip
def test_each_reading_has_its_own_border_of_partial_fluidisation(measures, partial):
    labels = {"orientation": "horizontal", "height_mm": 40, "cycles": 8, "frequency_hz": 80.0,
              "gamma": 2.0}  # fmt: skip
    (one,) = points_of([row(labels, "fluidisation_convection", 0.4, **measures)])
    assert {
        reading for reading, name in one.names.items() if name == "partial_fluidisation"
    } == partial
    assert set(one.names.values()) <= {"partial_fluidisation", "fluidisation_convection"}


def test_a_phase_begins_between_the_last_gamma_without_and_the_first_with_it():
    """At 80 Hz between 2 and 3; at 160 Hz it is there from the first Gamma on; at 320 never."""
    points = [
        *(point(g, n, 80.0) for g, n in ((1.0, "solid_like"), (2.0, "local_fluidisation"),
                                         (3.0, "global_fluidisation"))),
        *(point(g, "global_fluidisation", 160.0) for g in (1.0, 2.0)),
        *(point(g, "local_fluidisation", 320.0) for g in (1.0, 2.0)),
    ]  # fmt: skip
    (item,) = onset(points, "global_fluidisation")
    assert (item["frequency_hz"], item["low"], item["high"]) == (80.0, 2.0, 3.0)
    assert item["value"] == pytest.approx(math.sqrt(6.0))
    (rest,) = end_of_rest(points, 1.0, 1.2)
    assert (rest["frequency_hz"], rest["low"], rest["high"]) == (80.0, 1.0, 2.0)


def test_the_exponent_of_an_onset_is_that_of_its_law():
    points = [
        point(gamma * (f / 80) ** -0.5, name, f)
        for f in (80.0, 160.0, 320.0)
        for gamma, name in ((1.0, "local_fluidisation"), (2.0, "global_fluidisation"))
    ]
    (item,) = onset_exponent(points, "global_fluidisation")
    assert item["value"] == pytest.approx(-0.5)
    assert item["number"] == 3


def test_a_phase_that_comes_back_is_a_step_back_and_the_bouncing_bed_is_none():
    names = [
        "solid_like",
        "global_fluidisation",
        "bouncing_bed",
        "local_fluidisation",
        "leidenfrost",
    ]
    (item,) = steps_back([point(1.0 + k, name) for k, name in enumerate(names)])
    assert item["value"] == 1
    assert item["shown"] == "global fluidisation at 2, local fluidisation at 4"
    (item,) = steps_back([point(1.0 + k, name) for k, name in enumerate(names[:3])])
    assert item["value"] == 0


def test_the_band_of_the_leidenfrost_effect_is_above_40_hz_with_its_ends():
    """Five points of the name, three of them in the band, which holds four points."""
    points = [
        point(12.0, "leidenfrost", 80.0), point(80.0, "leidenfrost", 80.0),
        point(20.0, "leidenfrost", 160.0), point(30.0, "convection", 160.0),
        point(20.0, "leidenfrost", 40.0), point(100.0, "leidenfrost", 80.0),
    ]  # fmt: skip
    assert in_band(points, "leidenfrost", "the phase")[0]["value"] == pytest.approx(3 / 5)
    assert in_band(points, "leidenfrost", "the band")[0]["value"] == pytest.approx(3 / 4)
    assert among(points, "leidenfrost", "convection")[0]["value"] == pytest.approx(5 / 6)


def test_counts_are_of_the_gammas_of_the_map():
    """Those close about Gamma 1 are in no map, and those below 1 only where asked for."""
    points = [point(g, "solid_like", 20.0) for g in (0.5, 1.0, 1.1, 2.0)]
    for least, value in ((1.0, 2), (0.0, 3), (1.3, 1)):
        solid = next(i for i in counts(points, least=least) if i["phase"] == "solid_like")
        assert solid["value"] == solid["of"] == value


def test_maps_are_alike_by_their_principal_phases():
    """Local and partial fluidisation are one kind; solid-like and partial are two."""
    points = [
        point(1.0, "solid_like"), point(1.0, "partial_fluidisation", orientation="horizontal"),
        point(2.0, "local_fluidisation"),
        point(2.0, "partial_fluidisation", orientation="horizontal"),
        point(30.0, "leidenfrost"), point(30.0, "convection", orientation="horizontal"),
        point(50.0, "bouncing_bed"), point(50.0, "bouncing_bed", orientation="horizontal"),
        point(80.0, "bouncing_bed"),
    ]  # fmt: skip
    (item,) = likeness(points)
    assert (item["value"], item["of"]) == (3 / 4, 4)


def test_the_optimum_is_the_best_up_to_gamma_6_without_the_bouncing_bed():
    points = [
        point(2.0, "local_fluidisation", efficiency=0.3, fluidised_share=0.3),
        point(3.0, "global_fluidisation", efficiency=0.5, fluidised_share=0.6),
        point(4.0, "transition", efficiency=0.4, fluidised_share=0.7),
        point(5.0, "bouncing_bed", efficiency=0.9),
        point(8.0, "leidenfrost", efficiency=0.95),
    ]  # fmt: skip
    (item,) = optimum(points, phase="global_fluidisation")
    assert (item["gamma"], item["value"], item["fluidised"]) == (3.0, 1.0, 0.6)
    (most,) = most_fluidised(points)
    assert (most["value"], most["low"], most["most"], most["high"]) == (3.0, 3.0, 4.0, 8.0)
    (bounce,) = best_over_onset(points)
    assert (bounce["high"], bounce["best"], bounce["value"]) == (5.0, 8.0, 1.6)
    kinds = {item["kind"]: item["value"] for item in efficiency_by_kind(points)}
    assert kinds == pytest.approx({"fluidisation": 0.4, "convection": 0.95})


def test_collisions_alternate_where_a_coherent_bed_has_unequal_ones():
    """As in the transition, whatever the orientation; an incoherent bed is none."""
    points = [
        point(4.0, "fluidisation_convection", orientation="horizontal", coherence=c, contrast=k)
        for c, k in ((0.7, 0.8), (0.3, 0.8), (0.7, 0.1))
    ]
    assert [item["value"] for item in alternating(points)] == [1.0, 0.0, 0.0]


def test_names_of_both_numbers_of_cycles_are_of_one_point():
    points = [point(8.0, "leidenfrost"), point(8.0, "global_fluidisation", cycles=60),
              point(9.0, "leidenfrost")]  # fmt: skip
    (item,) = kept_names(points)
    assert (item["gamma"], item["short"], item["long"]) == (
        8.0,
        "leidenfrost",
        "global_fluidisation",
    )


def test_a_bed_as_in_the_thesis_holds_but_for_what_it_says_in_two_ways():
    """Partial fluidisation at 40 Hz and Gamma 3, where sec. 6.4.3.1 has the other name."""
    found = verdicts(thesis_rows())
    failed = {name for name, checks in found.items() if not all(checks)}
    assert failed == {"fluidisation-convection-at-40-hz-3"}


def test_sentences_fail_where_the_bed_does_otherwise():
    """All points global fluidisation: what says that there is something else fails."""
    rows = [
        row(labels, "global_fluidisation" if labels["orientation"] == "vertical"
            else "fluidisation_convection", 0.3)
        for labels in labels_of(panels())
    ]  # fmt: skip
    found = verdicts(rows)
    for name in ("seven-vertical", "four-horizontal", "solid-at-one", "solid-below-one",
                 "two-without-gravity"):  # fmt: skip
        assert False in found[name], name
    assert None in found["bouncing-later-with-less-fill"]


def test_the_report_and_the_figure_are_made_of_the_columns_that_are_kept(tmp_path):
    labels = ["seed", "state", "reason"]
    rows = [
        {key: one[key] for key in one if key in COLUMNS or key in labels} for one in thesis_rows()
    ]
    text = report(rows)
    assert text.startswith("complete: 667 points, 1 packing each")
    assert "after 50 cycles" in text
    assert "claims: " in text
    assert write_figure(tmp_path / "phases.png", lambda: draw(rows)).stat().st_size > 10_000
    assert report([]).startswith("INCOMPLETE: 0 of 667")
    draw([])
