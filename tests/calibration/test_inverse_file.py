"""Fit files of calibrate inverse: what they stand for, and what is refused in one line."""

import calibrating
import numpy as np
import pytest
from refusals import assert_refused
from small_damper import write_damper
from small_silo import write_case

from calibration.inverse.fit_file import read_fit
from calibration.inverse.silo import SIMULATED

DAMPER = """
schema = 1
simulator = "damper3d"
case = "small.toml"
seeds = 2
runs = 16
[parameters]
law.restitution = { distribution = "uniform", min = 0.2, max = 0.95 }
[[observation]]
kind = "eta"
file = "eta.csv"
"""
ETA = "frequency [Hz],gamma,eta,sigma\n80,10,0.13,0.005\n"
SILO = """
schema = 1
simulator = "silo2d"
case = "small.toml"
seeds = 2
runs = 16
[parameters]
law.mu_particle = { distribution = "uniform", min = 0.1, max = 0.5 }
[[observation]]
kind = "discharge_time"
value = "0.31 s"
sigma = "10 ms"
trials = 3
"""
CURVE = '[[observation]]\nkind = "curve"\nfile = "curve.csv"\nsigma = 0.02\n'
PROFILE = '[[observation]]\nkind = "profile"\nfile = "profile.csv"\nsigma = "3 mm"\n'


def written(folder, text, eta=ETA):
    """A fit file with its case and tables next to it."""
    (write_damper if "damper3d" in text else write_case)(folder)
    (folder / "eta.csv").write_text(eta)
    (folder / "curve.csv").write_text("time [s],fraction\n0.1,0.4\n0.2,0.8\n")
    (folder / "profile.csv").write_text("time [s],layer,x [mm],y [mm]\n0.1,0,0,20\n0.1,0,30,25\n")
    path = folder / "fit.toml"
    path.write_text(text)
    return path


def test_each_motion_is_a_case_and_its_efficiency_an_observed_value(tmp_path):
    eta = "f [Hz];gamma;eta;sigma\n40;10;0,4;0,01\n60;10;0,3;0,02\n"
    fit = read_fit(written(tmp_path, DAMPER.replace("runs = 16", "runs = 32"), eta))
    assert [changes for _, changes in fit.cases] == [
        {"motion.frequency": 40.0, "motion.gamma": 10.0},
        {"motion.frequency": 60.0, "motion.gamma": 10.0},
    ]
    assert fit.observed().values.tolist() == [0.4, 0.3]
    assert fit.observed().sigma.tolist() == [0.01, 0.02]
    assert (fit.points, fit.seeds, fit.runs) == (8, 2, 32)
    case = fit.case(1, np.array([0.0]))
    assert case.settings.motion.frequency == 60.0
    assert case.restitution["particle_particle"] == pytest.approx((0.2 + 0.95) / 2)


def test_a_time_a_curve_and_a_profile_are_values_of_one_case(tmp_path):
    text = SILO + CURVE + PROFILE + '[[observation]]\nkind="clogging"\nclogged=1\ntrials=4\n'
    fit = read_fit(written(tmp_path, text))
    observed = fit.observed()
    assert observed.values == pytest.approx([0.31, 0.4, 0.8, 0.020, 0.025])
    assert observed.sigma == pytest.approx([0.01, 0.02, 0.02, 0.003, 0.003])
    assert observed.trials.tolist() == [3, 1, 1, 1, 1]
    assert (observed.passed, observed.blocked) == (3, 1)
    assert len(fit.cases) == 1
    assert {one.kind for _, one in fit.observations} == set(SIMULATED.kinds) - {"t90"}


def test_a_time_says_nothing_of_the_trials_that_clogged(tmp_path):
    """It is that of trials which passed; that all did is known where `clogging` says so."""
    observed = read_fit(written(tmp_path, SILO)).observed()
    assert (observed.passed, observed.blocked) == (0, 0)
    text = SILO + '[[observation]]\nkind="clogging"\nclogged=0\ntrials=3\n'
    observed = read_fit(written(tmp_path, text)).observed()
    assert (observed.passed, observed.blocked) == (3, 0)


def test_keys_that_stand_together_take_one_value(tmp_path):
    text = SILO.replace("law.mu_particle", '"law.mu_particle, law.mu_wall"')
    case = read_fit(written(tmp_path, text)).case(0, np.array([0.0]))
    assert case.particle_law.mu == case.wall_law.mu == pytest.approx(0.3)


def test_a_prior_carries_units(tmp_path):
    old = 'law.mu_particle = { distribution = "uniform", min = 0.1, max = 0.5 }'
    new = 'law.gamma_n = { distribution = "lognormal", mean = "900 1/s", sd = "300 1/s" }'
    (prior,) = read_fit(written(tmp_path, SILO.replace(old, new))).priors
    values = prior.value(prior.quantile((np.arange(10_000) + 0.5) / 10_000))
    # Cut off at three standard deviations of its logarithm, which takes 0.27 % of each tail: the
    # mean loses less than 1 %.
    assert values.mean() == pytest.approx(900, rel=0.01)
    assert values.std() == pytest.approx(300, rel=0.05)
    assert prior.unit == "1/s"


def test_the_fit_is_named_by_what_was_measured_too(tmp_path):
    path = written(tmp_path, DAMPER)
    first = read_fit(path).digest
    assert first == read_fit(path).digest
    (tmp_path / "eta.csv").write_text(ETA.replace("0.13", "0.14"))
    assert read_fit(path).digest != first


def test_the_shipped_example_is_a_fit(tmp_path):
    done = calibrating.calibrate("inverse", tmp_path / "mine.toml", "--init")
    assert done.code == 0
    plan = calibrating.calibrate("inverse", tmp_path / "mine.toml", "--dry-run", "--json").json
    assert plan["runs"] == 30
    assert plan["cpu_min"] > 1
    again = calibrating.calibrate("inverse", tmp_path / "mine.toml", "--init")
    assert_refused(again)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("schema = 1", "", "schema is missing; write schema = 1"),
        ("schema = 1", "schema = 2", "schema = 2: unknown; this version reads 1"),
        ("damper3d", "damper", "simulator = 'damper': one of silo2d, damper3d"),
        ("small.toml", "none.toml", "fit.toml: case 'none.toml': no such preset or file"),
        ("seeds = 2", "seeds = 1", "seeds = 1: give a whole number, 2 or more"),
        ("runs = 16", "runs = 15", "7 points of 2 runs (seeds times cases); give 16 at least"),
        ("runs = 16", "rums = 16", "unknown key 'rums'; did you mean 'runs'?"),
        ("law.restitution", "law.restitutions", "unknown key 'law.restitutions'; did you mean"),
        ("law.restitution", "restitution", "write section.key, such as law.mu_wall"),
        ("law.restitution", "run.seed", "the fit chooses the seeds"),
        ("law.restitution", "law.youngs_modulus", "the unit is missing"),
        ("min = 0.2", 'min = "0.2 mm"', "the unit is wrong here"),
        ("min = 0.2", "min = 1.2", "must be below max"),
        ("min = 0.2", "low = 0.2", "unknown key 'low'"),
        ("uniform", "flat", "distributions: uniform, normal, lognormal"),
        ('"uniform"', '["uniform"]', "distributions: uniform, normal, lognormal"),
        ('"uniform", min = 0.2, max = 0.95', '"normal", mean = 0.5, sd = 0.3',
         "law.restitution: the prior reaches to -0.4, which damper3d does not take"),
        ("law.restitution", "motion.gamma",
         "[[observation]] 1: each row has its motion.gamma; leave it out of [parameters]"),
        ("[parameters]", "[settings]\nmotion.frequency = 60\n[parameters]",
         "[[observation]] 1: each row has its motion.frequency; leave it out of [settings]"),
        ('kind = "eta"', 'kind = ["eta"]', "damper3d has eta"),
        ("max = 0.95", "max = 1.2", "the prior reaches to 1.2, which damper3d does not take"),
        ('kind = "eta"', 'kind = "discharge_time"', "damper3d has eta"),
        ('file = "eta.csv"', "", "file is missing"),
        ('file = "eta.csv"', 'file = "none.csv"', "none.csv: cannot be read"),
        ('file = "eta.csv"', 'file = "eta.csv"\nsigma = 0.1', "has a column sigma; give one"),
        ('file = "eta.csv"', 'file = "eta.csv"\ntrial = 3', "unknown key 'trial'; did you mean"),
        ('file = "eta.csv"', 'file = "eta.csv"\ntrials = 0', "trials = 0: give a whole number"),
        ("[[observation]]", "[[observations]]", "unknown key 'observations'"),
        ("[parameters]", "[settings]\nlaw.restitution = 0.5\n[parameters]",
         "law.restitution: is a parameter of the fit; leave it out"),
    ],
)  # fmt: skip
def test_a_wrong_fit_file_is_refused_in_one_line(old, new, words, tmp_path):
    path = written(tmp_path, DAMPER.replace(old, new, 1))
    done = calibrating.calibrate("inverse", path, "-o", tmp_path / "runs")
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith("calibrate: ")
    assert words in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("eta", "words"),
    [
        ("frequency,gamma,eta\n80,10,0.1\n", "sigma is missing: "),
        ("frequency,gamma,sigma\n80,10,0.1\n", "no column 'eta'"),
        ("frequency,gamma,eta,sigma\n80,10,0.1,0\n", "line 2: sigma = 0: must be a number above 0"),
        ("frequency,gamma,eta,sigma\n80,10,0.1,inf\n", "line 2: sigma = inf: must be a number"),
        ("frequency,gamma,eta,sigma\n80,10,0.1,\n", "line 2: sigma = nan: must be a number"),
        ("frequency,gamma,eta,sigma\n80,10,,0.1\n", "line 2: eta is missing"),
        ("frequency [s],gamma,eta,sigma\n80,10,0.1,0.1\n", "unit is wrong"),
        ("frequency,gamma,eta,sigma\n80,-1,0.1,0.1\n", "gamma = -1: must be above 0"),
    ],
)
def test_a_wrong_table_is_refused_in_one_line(eta, words, tmp_path):
    done = calibrating.calibrate("inverse", written(tmp_path, DAMPER, eta))
    assert_refused(done, words)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"0.31 s"', "0.31", "value = 0.31: the unit is missing"),
        ('"0.31 s"', '"31 mm"', "the unit is wrong here"),
        ('"10 ms"', '"0 s"', "sigma = 0: must be above 0"),
        ('sigma = "10 ms"\n', "", "sigma is missing"),
        ("max = 0.5", "max = -0.1", "must be below max"),
        ("min = 0.1", "min = -0.1", "the prior reaches to -0.1, which silo2d does not take"),
        ("trials = 3", 'trials = 3\n[[observation]]\nkind="clogging"\nclogged=4\ntrials=3',
         "clogged = 4: more than the 3 trials"),
        ("trials = 3", 'trials = 3\n[[observation]]\nkind="curve"\nfile="eta.csv"\nsigma=0.1',
         "no column of what has left"),
        ("trials = 3", '[[observation]]\nkind="profile"\nfile="curve.csv"\nsigma="1 mm"',
         "no column 'layer'"),
        ("trials = 3", '[[observation]]\nkind="clogging"\ncase="A4"\nclogged=1\ntrials=3',
         "clogging goes with one case"),
    ],
)  # fmt: skip
def test_a_wrong_measurement_of_a_silo_is_refused_in_one_line(old, new, words, tmp_path):
    text = SILO.replace("runs = 16", "runs = 64").replace(old, new, 1)
    done = calibrating.calibrate("inverse", written(tmp_path, text))
    assert_refused(done, words)


def test_no_fit_file_is_refused_in_one_line(tmp_path):
    for path in (tmp_path / "none.toml", tmp_path):
        done = calibrating.calibrate("inverse", path)
        assert_refused(done)
    (tmp_path / "bad.toml").write_bytes(b"\xff\xfe")
    assert "not valid TOML" in calibrating.calibrate("inverse", tmp_path / "bad.toml").err
