"""Beverloo's law fitted to made data with known constants, and its rows, report and picture."""

import json

import numpy as np
import pytest

from granulab.campaign.output.figure import write_figure
from silo2d.case.case import SiloCase
from silo2d.reproduce import beverloo
from silo2d.reproduce.quantities.beverloo_law import fit_law, law

C, K, DENSITY, SIZE = 0.95, 1.4, 45.0, 0.005
OUTLETS = np.repeat([0.03, 0.036, 0.042, 0.048, 0.054, 0.06], 3)


def test_law_of_one_outlet_by_hand():
    """45 kg/m2 sqrt(9.81 m/s2) 0.95 (0.03 m - 1.4 x 0.005 m)^1.5 = 0.46704 kg/s; 0 below k d."""
    assert law(0.03, C, K, DENSITY, SIZE) == pytest.approx(0.46704, rel=1e-4)
    assert law(0.006, C, K, DENSITY, SIZE) == 0.0


def test_fit_gives_back_the_constants_of_exact_data():
    """No noise: C and k come back, and the band has no width, to the search's tolerance."""
    rates = law(OUTLETS, C, K, DENSITY, SIZE)
    fit = fit_law(OUTLETS, rates, DENSITY, SIZE, 1e-6 * rates)
    assert (fit.c, fit.k) == pytest.approx((C, K), rel=1e-4)
    low, high = fit.band(np.array([0.04]))
    assert high[0] - low[0] < 1e-4 * fit.rate(0.04)
    assert fit.scatter < 1e-4


def test_intervals_hold_the_constants_as_often_as_they_say():
    """Noise of 3 %: of 50 made studies, 95 % hold each constant in their interval.

    Of 50 draws of 95 %, 44 and more are there with a probability of 97 %; the seed is fixed. The
    errors that the runs state are half of what they scatter by: the scatter must be noticed.
    """
    rng = np.random.default_rng(11)
    exact = law(OUTLETS, C, K, DENSITY, SIZE)
    held = np.zeros((50, 3), dtype=bool)
    for study in range(50):
        rates = exact * (1 + 0.03 * rng.standard_normal(len(exact)))
        fit = fit_law(OUTLETS, rates, DENSITY, SIZE, 0.015 * exact, draws=100)
        low, high = fit.band(np.array([0.045]))
        held[study] = (
            fit.c_interval[0] <= C <= fit.c_interval[1],
            fit.k_interval[0] <= K <= fit.k_interval[1],
            low[0] <= law(0.045, C, K, DENSITY, SIZE) <= high[0],
        )
    assert (held.mean(axis=0) >= 0.88).all()
    assert not held.all()  # nor are the intervals so wide that they always hold


def test_each_run_counts_by_its_own_density():
    """Runs of looser packings flow less: the constants stay."""
    density = np.linspace(42, 48, len(OUTLETS))
    fit = fit_law(OUTLETS, law(OUTLETS, C, K, density, SIZE), density, SIZE, 0.01)
    assert (fit.c, fit.k) == pytest.approx((C, K), rel=1e-4)


def test_no_fit_of_two_outlets():
    """Two constants need a third outlet to be judged by."""
    assert fit_law([0.03, 0.03, 0.04], [0.5, 0.5, 0.9], DENSITY, SIZE, 0.01) is None


def test_the_cases_are_the_paper_s_where_it_has_them():
    """A3, A4, D3, D4 as presets, so that their runs are shared; the wide silo as wide as it says.

    Wider than 2.5 outlets, and than the outlet and 30 particles to 1 %; filled to 1.2 widths.
    """
    chosen = list(beverloo.cases([2]))
    assert len(chosen) == 2 * len(beverloo.OUTLETS) + len(beverloo.WIDE)
    for labels, case in chosen:
        assert case.settings.run.seed == 2
        assert case.outline.outlet == pytest.approx(1e-3 * labels["outlet_mm"])
        if labels["silo"] != "wide":
            assert case.name == labels["silo"] + ("3" if labels["outlet_mm"] == 100 else "4")
            continue
        size = np.sqrt(4 * case.shapes.mean_area / np.pi)
        needed = max(2.5 * case.outline.outlet, case.outline.outlet + 30 * size)
        assert case.outline.width >= 0.99 * needed
        assert case.settings.fill.level >= 1.2 * case.outline.width


def made_rows() -> list[dict]:
    """A row a run as `run` gives them: the law with 2 % of noise; one clogged, one failed."""
    rng = np.random.default_rng(2)
    rows = []
    for silo, outlets in (("A", beverloo.OUTLETS), ("wide", beverloo.WIDE)):
        for outlet in outlets:
            rate = float(law(1e-3 * outlet, C, K, DENSITY, SIZE)) * rng.normal(1, 0.02)
            rows.append({
                "silo": silo, "outlet_mm": outlet, "seed": 1, "state": "done", "reason": "",
                "outcome": "empty", "grain_diameter_m": SIZE, "bulk_density_kg_per_m2": DENSITY,
                "rate_per_s": 900 * rate, "rate_kg_per_s": rate, "error_kg_per_s": 0.02 * rate,
            })  # fmt: skip
    rows[0] |= {"outcome": "clogged", "rate_kg_per_s": None}
    rows[1] |= {"state": "failed", "reason": "the disk is full"}
    return rows


def test_report_and_picture_of_made_rows(tmp_path):
    """The constants, who clogged, what failed, and that the paper's silos are out of range."""
    text = beverloo.report(made_rows())
    for words in ("no steady flow; 1 of 1 clogged", "A 110 mm, seed 1: the disk is full",
                  "OUTSIDE the law's range", "C = 0.9", "k = 1."):  # fmt: skip
        assert words in text
    picture = write_figure(tmp_path / "b.png", lambda: beverloo.draw(made_rows()))
    assert picture.stat().st_size


def test_row_of_a_run(reference):
    """A real run: its rate is that of its curve, its density that of its packing."""
    case = SiloCase.load(reference.path / "case.toml")
    one = {**reference.read_summary(), "run_folder": str(reference.path), "silo": "A",
           "outlet_mm": 50, "state": "done", "reason": ""}  # fmt: skip
    row = beverloo.row_of(one, case)
    json.dumps(row, allow_nan=False)
    assert row["rate_kg_per_s"] == pytest.approx(one["mean_mass_flow_kg_per_s"], rel=0.3)
    assert row["bulk_density_kg_per_m2"] == pytest.approx(54 * one["packing_fraction"])
    assert beverloo.row_of({**one, "outcome": "clogged"}, case)["rate_kg_per_s"] is None
    # Of the wide silo the part from 10 to 30 % out counts.
    wide = beverloo.row_of({**one, "silo": "wide"}, case)
    share = wide["rate_per_s"] * (wide["until_s"] - wide["from_s"]) / one["n_particles"]
    assert share == pytest.approx(0.2, abs=2 / one["n_particles"])


def test_every_run_is_requested_and_none_needs_to_end(monkeypatch, tmp_path):
    """The cases that the sweep is given; rows, report and picture where it did none of them."""
    sweep = pytest.importorskip("silo2d.run.sweep")
    requested = []

    def run_cases(cases, **options):
        requested.extend(cases)
        return [{**labels, "state": "interrupted", "reason": "Ctrl-C"} for labels, _ in cases]

    monkeypatch.setattr(sweep, "run_cases", run_cases)
    rows = beverloo.run(out=tmp_path, seeds=[1], workers=1, quiet=True)
    assert len(rows) == len(requested) == 2 * len(beverloo.OUTLETS) + len(beverloo.WIDE)
    assert "interrupted: wide 34 mm, seed 1: Ctrl-C" in beverloo.report(rows)
    assert write_figure(tmp_path / "b.png", lambda: beverloo.draw(rows)).exists()
