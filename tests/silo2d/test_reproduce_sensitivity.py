"""The sensitivity table: its cases hold the ratios that the paper holds, its words fit."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_rows import ended, failed

from silo2d import SiloCase
from silo2d.reproduce import sensitivity
from silo2d.reproduce.parameters import BASELINES, IMPLIED, TABLE_4
from silo2d.reproduce.quantities.published import sensitivity as published
from silo2d.reproduce.quantities.trends import Trend

N_PER_MM = 1e3  # [N/m]


def laws_of(parameters):
    case = SiloCase.load("A4", parameters.changes())
    return case.particle_law, case.wall_law


def test_table_4_is_the_case_as_it_is():
    """Journal Table 4: nothing to change, so that its runs are those of `reproduce discharge`."""
    assert TABLE_4.changes() == {}
    particle, wall = laws_of(TABLE_4)
    for law in (particle, wall):
        assert (law.kn, law.kt, law.gamma_t) == (1e4 * N_PER_MM, 650 * N_PER_MM, 3)
    assert (particle.mu, wall.mu) == (0.38, 0.44)
    assert (particle.gamma_n, wall.gamma_n) == (6085, 4303)


def test_the_implied_baseline_gives_0_99_s_in_every_table():
    """Its values stand in Tables 7 to 11, each in a row of 0.99 s; Table 7 pairs kn and gamma_n."""
    for parameter in ("kn", "kt", "gamma_n", "gamma_t"):
        value = getattr(IMPLIED, parameter)
        (row,) = (p for p in published() if (p.parameter, p.value) == (parameter, value))
        assert row.time_s == 0.99
    (row,) = (p for p in published() if (p.parameter, p.value) == ("mu", IMPLIED.mu_wall))
    assert row.time_s == 0.99
    particle, wall = laws_of(IMPLIED)
    assert (particle.mu, wall.mu, particle.gamma_n, wall.gamma_n) == (0.4, 0.4, 4000, 4000)
    assert particle.kt == wall.kt == 1000 * N_PER_MM


@pytest.mark.parametrize("name", BASELINES)
@pytest.mark.parametrize("kn", [625, 2500, 1e4, 4e4])
def test_kn_takes_kt_and_the_damping_along(name, kn):
    """Sec. 4.3.1: kt/kn and gamma_n/omega_0 are constant, omega_0 = sqrt(kn/m). Ten digits."""
    base, found = laws_of(BASELINES[name]), laws_of(BASELINES[name].varied("kn", kn))
    for before, after in zip(base, found, strict=True):
        assert after.kn == kn * N_PER_MM
        assert after.kt / after.kn == pytest.approx(before.kt / before.kn, rel=1e-9)
        rate, usual = (law.gamma_n / math.sqrt(law.kn) for law in (after, before))
        assert rate == pytest.approx(usual, rel=1e-9)
        assert (after.mu, after.gamma_t) == (before.mu, before.gamma_t)


def test_table_7_s_gamma_n_is_that_of_the_implied_baseline():
    """Printed with kn: 1000, 2000, 4000, 8000 1/s."""
    for kn, gamma_n in ((625, 1000), (2500, 2000), (1e4, 4000), (4e4, 8000)):
        assert IMPLIED.varied("kn", kn).gamma_n == pytest.approx(gamma_n)


@given(st.sampled_from(list(BASELINES)), st.floats(500, 20000))
def test_gamma_n_keeps_the_ratio_of_its_pairs(name, value):
    base = BASELINES[name]
    found = base.varied("gamma_n", value)
    assert found.gamma_n_wall / found.gamma_n == pytest.approx(base.gamma_n_wall / base.gamma_n)
    assert {"law.gamma_n", "law.gamma_n_wall"} <= set(found.changes()) or found == TABLE_4


@pytest.mark.parametrize("name", BASELINES)
def test_friction_of_each_pair_alone(name):
    base = BASELINES[name]
    particle, wall = laws_of(base)
    found = {
        pairs: laws_of(base.varied("mu", 0.1, pairs)) for pairs in ("both", "particle", "wall")
    }
    assert [law.mu for law in found["both"]] == [0.1, 0.1]
    assert [law.mu for law in found["particle"]] == [0.1, wall.mu]
    assert [law.mu for law in found["wall"]] == [particle.mu, 0.1]
    assert found["particle"][0]._replace(mu=particle.mu) == particle


@pytest.mark.parametrize(("parameter", "value"), [("kt", 5000), ("gamma_t", 0), ("gamma_t", 100)])
def test_other_parameters_change_alone(parameter, value):
    particle, wall = laws_of(IMPLIED.varied(parameter, value))
    unit = N_PER_MM if parameter == "kt" else 1
    assert getattr(particle, parameter) == getattr(wall, parameter) == value * unit
    usual = laws_of(IMPLIED)[0]
    assert particle._replace(**{parameter: getattr(usual, parameter)}) == usual


def test_every_line_of_the_tables_is_run_from_both_baselines(monkeypatch, tmp_path):
    """4 + 6 + 3 * 5 + 5 + 4 lines; those that meet in a baseline are one run by their digest."""
    from silo2d.run import sweep
    from silo2d.run.protocol import run_digest

    taken = []
    monkeypatch.setattr(sweep, "run_cases", lambda cases, **how: taken.extend(cases))
    sensitivity.run(out=tmp_path, seeds=[1, 2], workers=1, quiet=True)
    assert len(taken) == 2 * 2 * 34  # seeds, baselines
    names = {}
    for labels, case in taken:
        key = tuple(labels[k] for k in ("baseline", "parameter", "pairs", "value", "seed"))
        names[key] = run_digest(case)
    meet = (("kn", 1e4), ("kt", 1000), ("mu", 0.4), ("gamma_n", 4000), ("gamma_t", 3))
    shared = {names["implied", parameter, "both", value, 2] for parameter, value in meet}
    assert len(shared) == 1
    usual = run_digest(SiloCase.load("A4", {"run.seed": 2}))
    assert names["Table 4", "kn", "both", 1e4, 2] == usual
    # In the implied baseline 7 of 34 lines are the baseline itself, in Table 4's 2 (kn, gamma_t).
    assert len(set(names.values())) == 2 * ((34 - 6) + (34 - 1))


def made(times, baseline="Table 4", parameter="mu", pairs="both"):
    """Three seeds at each value, 0.01 s apart; `times` by value."""
    labels = {"baseline": baseline, "parameter": parameter, "pairs": pairs, "unit": "1"}
    return [
        ended("empty", time + off, **labels, value=value, seed=seed)
        for value, time in times.items()
        for seed, off in enumerate((-0.01, 0.0, 0.01), 1)
    ]


AS_PRINTED = {0.1: 0.70, 0.2: 0.80, 0.3: 0.86, 0.4: 0.99, 0.5: 1.08}


def words(text, start):
    return next(line for line in text.splitlines() if line.strip().startswith(start))


def test_times_as_printed_agree_in_rows_and_trend():
    """Table 9: 43 % more time from mu = 0.1 to 0.5 (0.094 s a tenth; mean 0.886 s)."""
    text = sensitivity.report(made(AS_PRINTED))
    assert words(text, "SPOLY").strip().startswith("SPOLY rises by 43 %")
    assert "): agrees; T90 rises by 43 %" in words(text, "Table 4:")
    line = words(text, "0.1").split()
    t90 = ["0.630", "+-", "0.009", "(3)"]
    assert line == ["0.1", "0.70", "0.700", "+-", "0.010", "(3)", "agrees", *t90]


def test_restitution_of_the_masses_stands_next_to_the_printed_one():
    """Table 10 prints 0.022 for 16000 1/s; the made rows have 0.80 and, face to face, 0.53."""
    line = words(sensitivity.report(made({1000: 0.93, 16000: 1.05}, parameter="gamma_n")), "16000")
    assert line.split()[:3] == ["16000", "1.05", "0.022"]
    assert line.endswith("0.80 / 0.53")


@pytest.mark.parametrize(
    ("change", "word"),
    [(lambda t: 0.886 + 0.3 * (t - 0.886), "weaker"), (lambda t: 2 * t, "steeper"),
     (lambda t: 2 * 0.886 - t, "opposite")],
)  # fmt: skip
def test_trends_that_differ_are_reported(change, word):
    text = sensitivity.report(made({value: change(time) for value, time in AS_PRINTED.items()}))
    assert f"): {word}; T90" in words(text, "Table 4:")


def test_a_row_beyond_the_scatter_is_high():
    """Scatter 0.01 s: 0.1 s is beyond t(10) 0.01 sqrt(4/3) = 0.026 s."""
    text = sensitivity.report(made(AS_PRINTED | {0.3: 0.96}))
    assert "high by 12 %" in words(text, "0.3")


def test_what_is_not_published_has_no_word_and_failures_are_named():
    rows = made(AS_PRINTED, pairs="particle")
    rows.append(failed("lost", baseline="Table 4", parameter="mu", pairs="particle", value=0.1,
                       unit="1", seed=4))  # fmt: skip
    text = sensitivity.report(rows)
    assert "agrees" not in text.split("scatter of a run")[0]
    assert "Table 4: rises by 43 %" in text
    assert ", 1 failed or cut off" in words(text, "0.1")
    assert "failed: baseline Table 4, parameter mu, pairs particle, value 0.1, seed 4: lost" in text


def test_a_series_whose_runs_all_failed_has_no_trend(tmp_path):
    from granulab.campaign.output.figure import write_figure

    labels = {"baseline": "implied", "parameter": "kt", "pairs": "both", "unit": "N/mm"}
    rows = [failed("lost", **labels, value=value, seed=1) for value in (500, 750)]
    text = sensitivity.report(rows)
    assert "implied: too few runs for a trend" in text
    assert "-, 1 failed or cut off" in words(text, "500")
    write_figure(tmp_path / "failed.png", lambda: sensitivity.draw(rows))


def test_a_flat_series_is_flat_within_noise():
    trend = Trend.of("kn", [1, 10, 100, 1000], [1.0, 1.01, 0.99, 1.0], 0.01)
    assert trend is not None
    assert trend.words().startswith("flat within noise")
