"""Contact parameters drawn from pair to pair: their distribution, and what each pair then does."""

import math
import random
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from analytic import (
    angular_frequency,
    block_sliding_down,
    contact_time,
    damping_of_restitution,
    restitution_at_zero_overlap,
)
from numpy.testing import assert_allclose
from refusals import assert_refused
from same_run import assert_same_run
from scenes import (
    HARD_LAW,
    HARD_STEP,
    LEVEL,
    SPHERORADIUS,
    WOOD,
    G,
    block,
    corner_on_face,
    launch,
    mass,
    position,
    simulation_of,
    velocity,
    wall,
)
from scipy.special import ndtr
from scipy.stats import truncnorm
from small_silo import DRY, DischargeStop, silo2d, the_run, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import Stopped
from silo2d.case.case import SiloCase
from silo2d.case.disorder import FARTHEST, Spread, cut_normal, drawn_laws, pair_constants, scores
from silo2d.case.settings import Settings, check_settings
from silo2d.case.stability import largest_stable_step
from silo2d.engine.pair_law import LEVELS
from silo2d.run import protocol

KN, KT, MU, GAMMA_N = range(4)  # columns of pair_constants
N_PARTICLES = 600
# The measured ones, Table 4 and Tables 2 and 3 of the wood-silo paper.
MEASURED = Spread(friction=0.10, stiffness=0.18, restitution=0.17, mean_restitution=0.45)
AT_WALLS = Spread(friction=0.17, stiffness=0.18, restitution=0.26, mean_restitution=0.53)
NOTHING = Spread(0.0, 0.0, 0.0, 1.0)
# A step that the stiffest pair of the small silo stands.
SLOW = {"run.time_step": "8 us"}


def settings(per: str, seed: int = 1) -> Settings:
    """Settings with disorder, of which only seed and disorder count here."""
    tables = {"silo": {"preset": "A4"}, "disorder": {"per": per}, "run": {"seed": seed}}
    return check_settings(tables, "test")


def laws(per: str, spread=(MEASURED, AT_WALLS), law=WOOD, n=N_PARTICLES, seed=1):
    return drawn_laws((law, law), spread, settings(per, seed), n)


def all_pairs(n: int = N_PARTICLES) -> tuple[np.ndarray, np.ndarray]:
    return np.triu_indices(n, 1)


# What is drawn


def test_the_cut_normal_keeps_mean_and_deviation():
    """A normal cut at +-2.5 of its own deviations, widened to deviation 1. Tolerance: LEVELS
    middles instead of a continuum leave out about (2.6 - quantile of the last) on each side."""
    values = cut_normal()
    assert abs(values.mean()) < 1e-12
    assert values.std() == pytest.approx(1.0, abs=1e-4)
    assert -FARTHEST < values.min() < -0.99 * FARTHEST
    assert pytest.approx(2.5 / truncnorm(-2.5, 2.5).std(), rel=1e-9) == FARTHEST


@pytest.mark.parametrize("per", ["particle", "pair"])
def test_pairs_have_the_measured_mean_and_deviation(per):
    """All pairs of 600 particles. Tolerance: four standard errors; per particle the mean of the 600
    scores is what counts, sqrt(2/n) of a deviation, and their variance, sqrt(2/n)/2."""
    law = laws(per)[0]
    drawn = pair_constants(law, *all_pairs(), N_PARTICLES)
    n = len(drawn) if per == "pair" else N_PARTICLES / 2
    for column, mean, spread in ((MU, WOOD.mu, 0.10), (KN, WOOD.kn, 0.18)):
        scaled = (drawn[:, column] / mean - 1) / spread
        assert abs(scaled.mean()) < 4 / math.sqrt(n)
        assert scaled.std() == pytest.approx(1.0, abs=4 / math.sqrt(n))
        assert abs(scaled).max() < FARTHEST
    assert_allclose(drawn[:, KT] / drawn[:, KN], WOOD.kt / WOOD.kn, rtol=1e-14)


@pytest.mark.parametrize("per", ["particle", "pair"])
def test_restitution_scales_the_damping(per):
    """gamma_n/sqrt(kn) = its mean times zeta(e)/zeta(mean e), so e comes back from it: with mean
    0.45 and 17 %. Tolerance: as above."""
    law = laws(per)[0]
    drawn = pair_constants(law, *all_pairs(), N_PARTICLES)
    ratio = drawn[:, GAMMA_N] / WOOD.gamma_n / np.sqrt(drawn[:, KN] / WOOD.kn)
    usual = damping_of_restitution(1.0, 0.45)
    # The inverse of zeta(e): with z = gamma/(2 omega0), e = exp(-pi z/sqrt(1 - z^2)).
    e = [restitution_at_zero_overlap(1.0, damping) for damping in ratio * usual]
    n = len(drawn) if per == "pair" else N_PARTICLES / 2
    assert np.mean(e) == pytest.approx(0.45, abs=0.17 * 0.45 * 4 / math.sqrt(n))
    assert np.std(e) == pytest.approx(0.17 * 0.45, rel=4 / math.sqrt(n))


def test_pairs_are_even_and_independent_of_each_other():
    """Per pair: levels of neighbours in the list, of the three quantities, and of two seeds do not
    correlate, and all levels are as frequent. Tolerance: four deviations of 1/sqrt(n), and of
    chi-squared with 63 degrees of freedom, sqrt(126)."""
    first, second = all_pairs()
    drawn = pair_constants(laws("pair")[0], first, second, N_PARTICLES)
    other = pair_constants(laws("pair", seed=2)[0], first, second, N_PARTICLES)
    n = len(drawn)
    mu, kn = drawn[:, MU], drawn[:, KN]
    for a, b in (
        (mu[1:], mu[:-1]),
        (mu, kn),
        (mu, other[:, MU]),
        (kn, drawn[:, GAMMA_N] / kn**0.5),
    ):
        assert abs(np.corrcoef(a, b)[0, 1]) < 4 / math.sqrt(n)
    scaled = (mu / WOOD.mu - 1) / 0.10
    level = np.searchsorted(cut_normal(), scaled - 1e-9)
    counts = np.bincount(level * 64 // LEVELS, minlength=64)
    assert ((counts - n / 64) ** 2 / (n / 64)).sum() < 63 + 4 * math.sqrt(126)


def test_pairs_that_share_a_particle_go_together():
    """Per particle: z_ij = (z_i + z_j)/sqrt 2, so two pairs with one particle in common correlate
    by 1/2, with a wall by 1/sqrt 2, others not at all. Tolerance: four standard errors, and 0.01
    because values are a cut normal's of the levels."""
    n = 4000
    particle, wall_law = laws("particle", n=n)
    i = np.arange(0, n - 3, 4)
    one, shared, apart = (
        pair_constants(particle, i + a, i + b, n)[:, MU] for a, b in ((0, 1), (1, 2), (2, 3))
    )
    at_wall = pair_constants(wall_law, i, np.full(len(i), n + 3), n)[:, MU]
    near = 4 / math.sqrt(len(i)) + 0.01
    assert np.corrcoef(one, shared)[0, 1] == pytest.approx(0.5, abs=near)
    assert np.corrcoef(one, apart)[0, 1] == pytest.approx(0.0, abs=near)
    assert np.corrcoef(one, at_wall)[0, 1] == pytest.approx(math.sqrt(0.5), abs=near)
    assert_allclose(scores(1, n)[:, :100], scores(1, 100))


@pytest.mark.parametrize("per", ["particle", "pair"])
def test_a_pair_draws_the_same_either_way_round(per):
    """And with more particles; another seed draws otherwise."""
    i, j = np.array([3, 3, 70]), np.array([5, 80, 2])
    once = pair_constants(laws(per)[0], i, j, N_PARTICLES)
    np.testing.assert_array_equal(once, pair_constants(laws(per)[0], j, i, N_PARTICLES))
    np.testing.assert_array_equal(once, pair_constants(laws(per, n=900)[0], i, j, 900))
    assert (once != pair_constants(laws(per, seed=2)[0], i, j, N_PARTICLES))[:, MU].all()


def test_a_level_is_the_share_of_the_standard_normal_below_the_score():
    """Per particle at a wall: mu at the quantile Phi(z) of the cut normal."""
    law = laws("particle")[1]
    z = scores(1, N_PARTICLES)[0]
    mu = pair_constants(
        law, np.arange(N_PARTICLES), np.full(N_PARTICLES, N_PARTICLES), N_PARTICLES
    )[:, MU]
    expected = cut_normal()[(ndtr(z) * LEVELS).astype(int)]
    assert_allclose((mu / WOOD.mu - 1) / 0.17, expected, atol=1e-12)


# What a pair then does: the engine, compiled for constants of each pair, takes 40 s of CPU.
dynamic = pytest.mark.validation


@dynamic
@pytest.mark.parametrize(("per", "seed"), [("particle", 30), ("pair", 16)])
def test_a_block_slides_or_rests_by_its_own_friction(per, seed):
    """Four blocks on one incline: those with mu < tan slide by g (sin - mu cos), the others stay.
    Tolerance: as for one block in test_motion_on_plane."""
    flat, angle, n = block(20e-3, 10e-3), math.radians(20), 4
    spread = NOTHING._replace(friction=0.17)
    law = HARD_LAW._replace(mu=math.tan(angle), gamma_t=300.0)
    both = laws(per, (spread, spread), law, n, seed)
    mu = pair_constants(both[1], np.arange(n), np.full(n, n), n)[:, MU]
    assert mu.min() < 0.95 * math.tan(angle) < 1.05 * math.tan(angle) < mu.max()
    weight = 54.0 * flat.area * G * math.cos(angle)
    height = SPHERORADIUS - flat.core[:, 1].min() - weight / (2 * law.kn)
    along = np.array([-0.15, -0.05, 0.05, 0.15])
    poses = [
        (s * math.cos(angle) - height * math.sin(angle),
         LEVEL + s * math.sin(angle) + height * math.cos(angle), angle)
        for s in along
    ]  # fmt: skip
    incline = [wall(angle)]
    sim = simulation_of([flat] * n, poses, walls=incline, law=both[0], wall_law=both[1],
                        gravity=G, time_step=HARD_STEP)  # fmt: skip
    starts = [position(sim, k).copy() for k in range(n)]
    sim.run(round(0.05 / HARD_STEP))
    swing = G * math.sin(angle) / angular_frequency(law.kt, mass(sim), 2)
    for k in range(n):
        vx, vy, _ = velocity(sim, k)
        speed = -(vx * math.cos(angle) + vy * math.sin(angle))
        if mu[k] < math.tan(angle):
            # Both pairs' tangential dashpots slow it: v0 (1 - exp(-2 gamma_t t))/(2 gamma_t t).
            free = block_sliding_down(angle, mu[k], G)
            rate = 2 * law.gamma_t
            expected = free / rate * -math.expm1(-rate * sim.time)
            assert speed == pytest.approx(expected, abs=2 * swing)
            assert expected > 2 * swing
        else:
            stretch = mass(sim) * G * math.sin(angle) / (2 * law.kt)
            assert math.hypot(*(position(sim, k) - starts[k])[:2]) < 10 * stretch


@pytest.mark.parametrize("per", ["particle", "pair"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_impact_obeys_what_its_pair_draws(per, seed):
    """A corner on a face: e = exp(-pi b/w) and time pi/w with the pair's own kn and gamma_n
    (eqs 3.7, 3.8). Tolerance: one of 2000 steps, and its half for the restitution."""
    both = laws(per, n=2, seed=seed)
    ((kn, _, _, gamma_n),) = pair_constants(both[0], np.array([0]), np.array([1]), 2)
    assert abs(kn / WOOD.kn - 1) > 1e-3
    sim = corner_on_face(both[0], 1.0)
    reduced = 1 / (1 / mass(sim, 0) + 1 / mass(sim, 1))
    omega0 = angular_frequency(kn, reduced)
    duration = contact_time(omega0, gamma_n)
    step = duration / 2000
    sim = corner_on_face(both[0], step)
    launch(sim, vy=-0.1)
    touching, pairs = 0, 0
    while pairs or not touching:
        sim.run(1)
        pairs = len(sim.touching())
        touching += pairs > 0
    sim.run(1)
    rebound = velocity(sim, 0)[1] - velocity(sim, 1)[1]
    assert touching * step == pytest.approx(duration, abs=2 * step)
    assert rebound / 0.1 == pytest.approx(restitution_at_zero_overlap(omega0, gamma_n), abs=1e-3)


def test_the_stable_step_covers_the_stiffest_pair(tmp_path):
    """The limit is that of (1 + 2.62 sigma) kn with the damping of e (1 - 2.62 sigma), and the
    laws of all pairs are within."""
    case = SiloCase.load("A4", {"disorder.per": "pair"})
    both = case.laws(N_PARTICLES)
    bounds = [law.quantiles.max(axis=1) for law in both]
    for law, (_, kn, damping) in zip(both, bounds, strict=True):
        assert kn <= law.mean.kn * (1 + FARTHEST * 0.18)
        assert damping > 1.5
    stiff = [
        law.mean._replace(
            kn=kn, kt=law.mean.kt * kn / law.mean.kn,
            gamma_n=law.mean.gamma_n * math.sqrt(kn / law.mean.kn) * damping,
        )
        for law, (_, kn, damping) in zip(both, bounds, strict=True)
    ]  # fmt: skip
    limit, _ = largest_stable_step(case.shapes, case.surface_density, *stiff)
    assert case.time_step < limit
    assert f"{limit * 1e6:.2g}" in case.time_step_reason  # the cut itself is 0.1 % beyond
    with pytest.raises(ValueError, match="stable"):
        SiloCase.load("A4", {"disorder.per": "pair", "run.time_step": "5 us"})


# Whole runs


def drawn_run(folder: Path, runs: Path, changes: dict[str, Any]) -> dict[str, Any]:
    case = write_case(folder, SLOW | changes)
    result = silo2d("run", case, "-o", runs, "--no-figures", "--quiet", "--json")
    return result.json


@pytest.fixture(scope="module")
def kinds(_finished_root, tmp_path_factory) -> dict[str, dict[str, Any]]:
    """Results of the small silo without disorder, with it per particle and per pair."""
    root = tmp_path_factory.mktemp("kinds")
    shutil.copytree(_finished_root / "runs" / "packings", root / "runs" / "packings")
    return {
        per: drawn_run(root, root / "runs", {"disorder.per": per})
        for per in ("none", "particle", "pair")
    }


@dynamic
@pytest.mark.parametrize("per", ["particle", "pair"])
def test_disorder_of_no_width_gives_the_bits_of_none(per, kinds, tmp_path, runs):
    """The kernels of drawn laws are those of shared ones."""
    off = dict.fromkeys(("disorder.friction", "disorder.stiffness", "disorder.restitution"), False)
    result = drawn_run(tmp_path, runs, {"disorder.per": per, **off})
    assert result["state_digest"] == kinds["none"]["state_digest"]


@dynamic
@pytest.mark.parametrize("per", ["particle", "pair"])
def test_a_run_with_disorder_is_reproducible_and_its_energy_balance_closes(
    per, kinds, tmp_path, runs
):
    """Stopped and gone on with at random, or looked at more often, it has the same bits; its
    energies close as those of a run without (a few parts in a thousand of what is dissipated)."""
    result = kinds[per]
    assert abs(result["energy_closure"]) < 0.01
    again = tmp_path / "again"
    shutil.copytree(runs, again)
    case = SiloCase.load(write_case(tmp_path, SLOW | {"disorder.per": per}))
    chance, stops, ended = random.Random(3), 0, None
    stop = DischargeStop(lambda: chance.random() < 0.3)
    while ended is None:
        try:
            ended = protocol.run(case, out=again, progress=stop.progress, stop=stop)
        except Stopped:
            stops += 1
    assert stops >= 3
    assert_same_run(the_run(again), RunFolder(Path(result["run_folder"])))
    often = {"disorder.per": per, "output.frame_interval": "3.3 ms"}
    assert drawn_run(tmp_path, runs, often)["state_digest"] == result["state_digest"]
    kept = read_trajectory(the_run(again).path).static
    if per == "particle":
        for row, name in enumerate(("friction", "stiffness", "restitution")):
            expected = scores(case.settings.run.seed, len(kept["kind"]))[row]
            assert_allclose(kept[f"score_{name}"], expected, rtol=1e-6)


def test_the_kinds_of_disorder_differ(kinds):
    """None, per particle and per pair are three runs of one packing."""
    for key, number in (("state_digest", 3), ("run_folder", 3), ("packing_fraction", 1)):
        assert len({result[key] for result in kinds.values()}) == number, key


# Bad input


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"disorder.per": "grain"}, ["[disorder] per = 'grain'", "'particle' or 'pair'"]),
        ({"disorder.frction": True}, ["unknown key 'frction'", "did you mean 'friction'?"]),
        ({"disorder.friction": "50 %"}, ["[disorder] friction", "50 %", "at most 38.1 %"]),
        ({"disorder.stiffness": "2 mm"}, ["stiffness = '2 mm'", "unit is wrong"]),
        (
            {"disorder.restitution": "35 %"},
            ["[disorder] restitution", "about 0.53", "less than 33.8 %"],
        ),
        ({"disorder.friction": -0.1}, ["friction = -0.1", "greater than or equal to 0"]),
        (
            {"disorder.per": None, "disorder.stiffness": "10 %"},
            ["[disorder] stiffness: drawn of nothing", "per = 'particle'"],
        ),
        ({"law.gamma_n": "0 1/s"}, ["gamma_n = 0", "[disorder] restitution = false"]),
        ({"run.time_step": "10 us"}, ["time_step = 10 us", "stiffest pair"]),
    ],
)
def test_disorder_that_cannot_be(changes, words, tmp_path):
    case = write_case(tmp_path, SLOW | {"disorder.per": "pair"} | changes)
    assert_refused(silo2d("run", case, "--dry-run"), *words)


def test_disorder_needs_measured_deviations(tmp_path):
    """A materials file without sigma: the line says where, and what to write instead."""
    from granulab.contact.files.datafile import data_file

    path = data_file("materials", "wood")
    assert path is not None
    text = path.read_text(encoding="utf-8").replace('sigma = "10 %", ', "")
    (tmp_path / "bare.toml").write_text(text, encoding="utf-8")
    changes = SLOW | {"disorder.per": "pair", "particles.materials": "bare.toml"}
    case = write_case(tmp_path, changes)
    words = "[pair.wood-wood] friction has no sigma", "[disorder] friction = '10 %'"
    assert_refused(silo2d("run", case, "--dry-run"), *words)
    given = SLOW | {
        "disorder.per": "pair",
        "particles.materials": "bare.toml",
        "disorder.friction": 0.1,
    }
    assert silo2d("run", write_case(tmp_path, given), *DRY).code == 0


@pytest.mark.parametrize(("sigma", "scatter", "code"), [("50 %", "10 %", 0), ("10 %", "50 %", 2)])
def test_what_is_drawn_is_the_scatter_of_trials_not_the_uncertainty_of_their_mean(
    sigma, scatter, code, tmp_path
):
    """Contacts differ as single trials do. More than 38.1 % would draw values below zero."""
    from granulab.contact.files.datafile import data_file

    path = data_file("materials", "wood")
    assert path is not None
    both = f'sigma = "{sigma}", scatter = "{scatter}", '
    text = path.read_text(encoding="utf-8").replace('sigma = "10 %", ', both)
    (tmp_path / "both.toml").write_text(text, encoding="utf-8")
    changes = SLOW | {"disorder.per": "pair", "particles.materials": "both.toml"}
    result = silo2d("run", write_case(tmp_path, changes), *DRY)
    assert result.code == code, result.err
    assert code == 0 or "a standard deviation of 50 %" in result.err
