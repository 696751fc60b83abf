"""Films of discharges: rendered ones whose truth is known, and made motions of tracers."""

import json
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused
from small_silo import silo2d, the_run, write_case

from calibration.flow.discharge import Crossing, Opening
from calibration.flow.layers import Lines
from calibration.flow.measure import measure_flow
from calibration.flow.silo import Settings
from calibration.flow.survey import Tones
from calibration.flow.velocity import VelocityField
from calibration.flow.watch import _time_base
from calibration.rendered.camera import Camera, write_film
from calibration.rendered.flow import Look, Stage, film_of_run, truth
from calibration.rendered.flow_velocity import true_field
from calibration.tracking.film.reader import Film

INTERVAL = 0.05  # s: the small silo empties in 0.3 s


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """The small silo's discharge: run folder, film, and its truth."""
    root = tmp_path_factory.mktemp("filmed")
    case = write_case(root, {"output.layer_height": "17 mm"})
    result = silo2d("run", case, "-o", root / "runs", "--no-figures", "--quiet")
    assert result.code == 0, result.err
    run = the_run(root / "runs").path
    look = Look(scale=0.4e-3, lead=0.05, rest=0.2, texture_size=0.8e-3)
    stage, camera = Stage(run, look), Camera(rate=120, moments=2)
    times, pictures = film_of_run(stage, camera)
    film = write_film(pictures, root / "silo.mp4", camera.rate)
    return run, film, truth(run, stage, times, camera, INTERVAL), (stage, times)


@pytest.fixture(scope="module")
def measured(filmed):
    """Results of the film."""
    settings = Settings(width="80 mm", interval=f"{INTERVAL} s", columns=5)
    return measure_flow(filmed[1], settings)


def test_the_silo_s_inside_is_found(measured, filmed):
    """Sides and outlet by what changes; a pixel for the lens' blur and whole pixels."""
    left, top, width, height = filmed[2]["silo_px"]
    assert measured.silo.left == pytest.approx(left, abs=1.5)
    assert measured.silo.width == pytest.approx(width, abs=1.5)
    assert measured.silo.outlet == pytest.approx(top + height, abs=1.5)


def test_opening_and_last_particle_are_found(measured, filmed):
    """Within three sigma, or a frame, whichever is more; the outcome is the run's."""
    known, rate = filmed[2], filmed[2]["frames_per_s"]
    opening, end = measured.opening, measured.discharge
    assert abs(opening.value - known["opening_frame"]) < max(3 * opening.sigma, 1)
    assert measured.outcome == known["outcome"] == "empty"
    assert abs(end.value - known["discharge_time_s"]) < max(3 * end.sigma, 1 / rate)


@pytest.mark.parametrize(("fps", "said"), [(120, False), (30, True), (480, True)])
def test_a_rate_at_which_nothing_falls_so_is_said(measured, fps, said):
    """A quarter of the rate makes a sixteenth of the fall, which is g less what arches hold: the
    rate of free fall lies above the true one, 120 frames/s, by less than two."""
    found = replace(measured, rate=float(fps), warnings=[])
    assert 0.25 < measured.first_fall / 9.81 < 1.3
    warned = _time_base(found)
    assert bool(warned) is said
    if said:
        assert 120 <= float(re.search(r"be (\S+) frames/s", warned[0])[1]) < 240


def test_profiles_come_back_within_their_uncertainty(measured, filmed):
    """Of some forty lines 68 % lie within sigma; they share particles: as few as ten count as
    independent: two binomial standard deviations are 0.29. No line is off by five sigma."""
    known = np.array(
        [[[np.nan if y is None else y for y in row] for row in layer["lines_m"]]
         for layer in filmed[2]["layers"]]
    ).swapaxes(0, 1)  # fmt: skip
    count = min(len(known), len(measured.profiles))
    off = np.array([p.lines for p in measured.profiles[:count]]) - known[:count]
    z = off / np.array([p.sigma for p in measured.profiles[:count]])
    seen = np.isfinite(z)
    assert seen.sum() > 0.8 * np.isfinite(known).sum()
    assert np.mean(np.abs(z[seen]) < 1) > 0.39
    assert np.abs(z[seen]).max() < 5


def test_velocities_come_back_within_their_uncertainty(measured, filmed):
    """Of some two hundred components 68 % lie within sigma; windows overlap by half and share
    particles, so that one in ten counts as independent: two binomial standard deviations are 0.2.
    On average they are right to a twentieth of the speed, which is what a window's edges show, and
    two standard deviations of such a mean."""
    off, sigma, speed = [], [], []
    for field in measured.velocities:
        true = true_field(*filmed[3], field)
        both = np.isfinite(field.sigma) & np.isfinite(true.vx)
        off.append(np.stack([field.vx - true.vx, field.vy - true.vy])[:, both])
        sigma.append(np.stack([field.sigma] * 2)[:, both])
        speed.append(np.hypot(true.vx, true.vy)[both])
    off, sigma, speed = (np.concatenate(part, axis=-1) for part in (off, sigma, speed))
    assert off.size > 150
    assert np.mean(np.abs(off) < sigma) > 0.48
    chance = 2 * off.std(axis=1) / np.sqrt(off.shape[1] / 10)
    assert (np.abs(off.mean(axis=1)) < 0.05 * speed.mean() + chance).all()


def test_true_velocities_are_none_before_the_opening(filmed):
    """Particles at rest behind the door: 0 in every window that they fill."""
    stage, times = filmed[3]
    x, y = np.arange(10, 75, 8) * 1e-3, np.arange(40, 5, -8) * 1e-3
    none = np.zeros((len(y), len(x)))
    rest = VelocityField(-0.03, -0.005, x, y, none, none, none, none.astype(int))
    true = true_field(stage, times, rest)
    assert np.nanmax(np.hypot(true.vx, true.vy)) < 1e-12


def test_the_curve_is_that_of_the_mass(measured, filmed):
    """The area of plane particles is their mass; the two ways differ by twice the stated."""
    out = np.array(filmed[2]["out_times_s"])
    true = 1 - np.searchsorted(out, measured.curve.time) / filmed[2]["n_grains"]
    assert np.sqrt(np.mean((measured.curve.area - true) ** 2)) < 2 * measured.curve.sigma


def test_a_run_and_its_own_film_are_as_near_as_equal_flows(filmed, tmp_path):
    """D is below twice the lines' own uncertainty, and the times agree within three sigma."""
    result = calibrate("compare", filmed[0], filmed[1], "--interval", "0.05 s", "--out", tmp_path,
                       "--quiet", "--json").json  # fmt: skip
    assert result["distance_m"]["value"] < 2 * result["distance_of_equal_flows_m"]
    off = result["discharge_time_difference_s"]
    assert abs(off["value"]) < 3 * off["sigma"]
    assert Path(result["figure"]).stat().st_size > 0


def squares(side=0.1, step=0.002):
    """Tracers on a grid over a square silo, two layers."""
    x, y = np.meshgrid(np.arange(step / 2, side, step), np.arange(step / 2, side, step))
    start = np.column_stack([x.ravel(), y.ravel()])
    return Lines(start, (start[:, 1] > side / 2).astype(int), np.linspace(0, side, 6), 0.04), start


def test_layers_that_come_down_as_one_stay_level():
    """Rigid fall: each line one fall below the layer's level, whatever the parting; to rounding.

    The level is the mean over particles that might have been, known to about a tenth of a
    particle's 10 mm for these forty."""
    lines, start = squares()
    profile = lines.at(0.5, start - (0, 0.02), np.zeros(len(start)))
    upper = profile.lines[1]
    np.testing.assert_allclose(upper, upper[0], atol=1e-12)
    np.testing.assert_allclose(upper, 0.075 - 0.02, atol=1e-3)
    assert np.isfinite(profile.sigma[1]).all()


def test_a_piece_is_where_most_of_it_is():
    """A third of all tracers are far below: pieces of nine, of which half and more are elsewhere,
    keep the median, and so do lines. Pieces by chance hold up to a half of those; their line is
    then a mean of 20 mm and 150 mm, and that of all is off by less than a tenth of a particle's 10
    mm where not one piece in a hundred is such."""
    lines, start = squares()
    place = start - (0, 0.02)
    place[::3] -= (0, 0.15)
    profile = lines.at(0.5, place, np.zeros(len(start)))
    np.testing.assert_allclose(profile.lines[1], 0.075 - 0.02, atol=1e-3)


def test_tracers_that_left_are_in_no_line():
    """All of the lower layer below the outlet's level: no line."""
    lines, start = squares()
    profile = lines.at(0.5, start - (0, 0.06), np.zeros(len(start)))
    assert np.isnan(profile.lines[0]).all()
    assert np.isfinite(profile.lines[1]).any()


def opened(fall, noise=0.0, seed=0):
    """The opening of falls fall(tau) [px] of particles of 20 px, and how far it is off [sigma]."""
    random = np.random.default_rng(seed)
    opening, start, frame = Opening(particle=20.0), 10 + random.uniform(), 0
    while opening.clock is None:
        tau = max(frame - start, 0.0)
        opening.see(frame, fall(tau) + random.normal(0, noise) * (tau > 0))
        frame += 1
    return (opening.clock.value - start) / opening.clock.sigma


@pytest.mark.parametrize("pull", [0.3, 1.0, 3.0])
def test_opening_of_a_free_fall_is_its_vertex(pull):
    """s = a tau^2/2 without noise: what the pull might have done else lies to both sides."""
    assert abs(opened(lambda tau: pull * tau**2 / 2)) < 1 / 3


def test_opening_is_within_its_uncertainty_where_the_pull_walks():
    """a = a0 (1 + rho W(tau/T)), rho from 0 to 1: the law behind sigma, in steps of 1/50 frame. Of
    200 openings 68 % lie within sigma; two binomial standard deviations are 0.066. Walks that lift
    the material are left out: they are no fall."""
    random, off = np.random.default_rng(11), []
    tau = np.arange(0, 30, 0.02)
    for seed in range(1000):
        pull = random.uniform(0.4, 3)
        rho, length = random.uniform(), np.sqrt(2 * 20 / pull)
        walk = np.cumsum(random.normal(0, np.sqrt(0.02 / length), len(tau)))
        a = pull * (1 + rho * walk)
        if a[tau < 2 * length].min() > 0 and len(off) < 200:
            fall = np.cumsum(np.cumsum(a)) * 0.02**2
            off.append(opened(lambda at, fall=fall: np.interp(at, tau, fall), 0.1, seed))
    assert len(off) == 200
    assert abs(np.mean(np.abs(off) < 1) - 0.68) < 0.066


@pytest.mark.parametrize("settling", [4.0, 8.0, 1e3])
def test_opening_of_a_fall_that_settles_is_within_three_sigma(settling):
    """v = a T (1 - exp(-tau/T)), places good to 0.1 px: a pull that is spent within the fall, or
    not at all, is the least likely of walks; of 60 none is off by more than three sigma."""
    off = [
        opened(lambda tau: 0.9 * settling * (tau + settling * np.expm1(-tau / settling)), 0.1, k)
        for k in range(60)
    ]
    assert np.abs(off).max() < 3


def test_opening_of_a_slow_film_lies_between_two_frames():
    """Falls of particles per frame: all that is known is between which frames it began."""
    opening = Opening(particle=5.0)
    for frame, fall in enumerate([0.0, 0.0, 12.0, 40.0]):
        opening.see(frame, fall)
    assert 0 < opening.clock.value < 2
    assert opening.clock.sigma > 0.25


def test_last_particle_s_centroid_passes_half_its_length_before_its_end():
    """A particle of 10 px at 5 px/frame, last seen in frame 20: 20 + 1/2 - 1."""
    crossing = Crossing(particle=10.0)
    for frame in range(30):
        crossing.see(frame, np.arange(40) < (8 if frame <= 20 else 0), np.full(9, 5.0))
    assert crossing.last().value == pytest.approx(19.5)


def test_a_tracer_that_creeps_out_after_the_last_particle_does_not_set_its_speed():
    """One of nine at a fiftieth of the speed: the median is the particle's."""
    crossing = Crossing(particle=10.0)
    crossing.see(20, np.full(8, True), np.full(9, 5.0))
    crossing.see(90, np.full(8, False), np.array([0.1]))
    assert crossing.last().value == pytest.approx(19.5)


@pytest.mark.parametrize("grey", [40, 120])
def test_a_particle_before_two_backdrops_is_distinguished_from_both(grey):
    """At the outlet a white backing ends, and a dark plate begins: the mean of such rows, 117, is
    as bright as a light particle. In each row it differs by more than half of the contrast to the
    nearer tone there; a dark particle does by 20 sqrt(3) before the plate, where 30 is what
    particles differ by. What differs by less, or in one row only, is none: here a codec's ten grey
    levels."""
    tones = Tones(np.array([[40] * 3, [120] * 3, [230] * 3], np.float32), 2, 30.0)
    behind = np.full((3, 4, 3), 60, np.uint8)
    behind[0] = 230
    rows = behind.copy()
    rows[:, 1] = grey
    rows[:, 2] += 10
    rows[1, 3] = grey
    assert tones.stands(rows, behind, 1.0).tolist() == [False, True, False, False]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--columns", "4"], "--columns 4"),
        (["--roi", "1,2,3"], "--roi"),
        (["--roi", "0,0,9999,10"], "picture"),
        (["--width", "300"], "unit"),
        (["--width", "80 mm", "--scale", "1 mm/px"], "give one"),
        (["--interval", "1 us"], "--interval"),
        (["--fps", "0"], "--fps"),
        (["--fps", "nan"], "--fps"),
    ],
)
def test_bad_options_are_one_line(filmed, options, word):
    result = calibrate("flow", filmed[1], "--quiet", *options)
    assert result.code == 2
    assert word in result.err
    assert result.err.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--scale", "3 apples"], "mm/px"),
        (["--scale", "-1 mm/px"], "positive"),
        (["--roi", "10,10"], "--roi"),
        (["--fps", "-5"], "from 1 to"),
        (["--fps", "-5", "--collapse"], "from 1 to"),
        (["--scale", "-1 mm/px", "--collapse"], "positive"),
        (["--fps", "3"], "--interval 0.25 s"),
        (["--layer-height", "20 mm"], "--layer-height: needs a scale"),
        (["--width", "80 mm", "--layer-height", "0 mm"], "must be above 0"),
        (["--width", "80 mm", "--layer-height", "-5 mm"], "must be above 0"),
        (["--width", "80 mm", "--layer-height", "5 apples"], "--layer-height"),
        (["--columns", "4"], "--columns 4"),
        (["--columns", "100001"], "--columns 100001: on 80 px"),
        (["--columns", "21", "--roi", "10,10,50,50"], "--columns 21: on 50 px"),
        *(
            (["--collapse", *option], f"{option[0]}: --collapse does not take it")
            for option in (
                ["--width", "80 mm"],
                ["--interval", "0.1 s"],
                ["--columns", "11"],
                ["--layer-height", "20 mm"],
                ["--no-velocity"],
            )
        ),
        (["--out", "FILE/under"], "--out"),
    ],
)
def test_what_is_said_wrongly_is_refused_before_the_film_is_read(
    tmp_path, monkeypatch, options, word
):
    """A film may take minutes to read: none of its frames is."""
    film = write_film([np.full((80, 80, 3), 90, np.uint8)] * 8, tmp_path / "still.mp4", 30)
    monkeypatch.setattr(Film, "frames", lambda self: pytest.fail("the film was read"))
    options = [option.replace("FILE", str(film)) for option in options]
    result = calibrate("flow", film, *options)
    assert_refused(result, word)


def test_what_is_no_flow_is_refused(tmp_path):
    """No film, and a film in which nothing moves: one line each, exit code 2."""
    words = tmp_path / "words.mp4"
    words.write_text("no film", encoding="utf-8")
    still = write_film([np.full((80, 80, 3), 90, np.uint8)] * 8, tmp_path / "still.mp4", 30)
    for path in (words, still):
        for more in ([], ["--collapse"]):
            result = calibrate("flow", path, "--quiet", *more)
            assert_refused(result)


def heap_film(path, rate=60):
    """A dark disc on a light plate whose radius grows as 20 + 60 (1 - exp(-4 t)) px."""
    y, x = np.mgrid[:200, :240] + 0.5
    times = np.arange(40) / rate
    radius = 20 + 60 * (1 - np.exp(-4 * times))
    away = np.hypot(x - 120, y - 100)
    random = np.random.default_rng(3)
    frames = [
        np.clip(200 - 160 * np.clip(r - away + 0.5, 0, 1) + random.normal(0, 2, away.shape), 0, 255)
        for r in radius
    ]
    pictures = (np.repeat(f.astype(np.uint8)[:, :, None], 3, axis=2) for f in frames)
    return write_film(pictures, path, rate), radius


def test_front_of_a_spreading_heap_comes_back(tmp_path):
    """Half of the width is the radius; the mean over the outermost fiftieth of the rows lies below
    the extreme by r (1 - sqrt(1 - 0.02^2))/3 < 0.01 px, edges and codec are good for a pixel."""
    film, radius = heap_film(tmp_path / "heap.mp4")
    result = calibrate("flow", film, "--collapse", "--scale", "1 mm/px", "--quiet", "--json").json
    found = np.array([np.nan if r is None else r for r in result["half_width"]])
    assert np.isfinite(found[10:]).all()
    np.testing.assert_allclose(1e3 * found[10:], radius[10:], atol=1.2)


@pytest.mark.validation
def test_front_of_a_filmed_collapse_follows_its_table():
    """Webb's column at 240 frames/s: one scale and one start make our half width the table's front.

    The camera looks down aslant: a circle's width is foreshortened by the square of its radius over
    its distance, here below 1 % of the front's 64 mm of way. The file says 120 frames/s, at which
    the same way would take twice the time, which one scale and start cannot mend.
    """
    media = Path(os.environ.get("GRANULAB_MEDIA", Path(__file__).parents[3] / "shared" / "media"))
    film = media / "webb_04g_010w_cam1.mp4"
    if not film.exists():
        pytest.skip(f"{film} is not here")
    table = np.genfromtxt(media / "webb_04g_010w.txt", skip_header=1)
    way = table[np.isfinite(table[:, 1]), 1]
    result = calibrate("flow", film, "--collapse", "--fps", "240", "--quiet", "--json").json
    assert result["fps_header"] == 120
    half = np.array([np.nan if r is None else r for r in result["half_width"]])
    time = np.array(result["time_s"])

    def misfit(rate):
        best = np.inf
        for start in np.arange(30, 80) / 240:
            known = np.interp(time - start, np.arange(len(way)) / rate, way, np.nan, np.nan)
            both = np.isfinite(known) & np.isfinite(half) & (np.arange(len(half)) > 60)
            if both.sum() > 40:
                scale = half[both] @ known[both] / (half[both] @ half[both])
                off = np.sqrt(np.mean((scale * half[both] - known[both]) ** 2))
                best = min(best, off)
        return best

    assert misfit(240) < 0.01 * np.ptp(way)
    assert misfit(120) > 5 * misfit(240)


def test_the_result_is_json_and_tables_have_units(filmed, tmp_path):
    """The keys that scripts read, and a diagnostic figure."""
    options = ["--width", "80mm", "--columns", "5", "--no-velocity", "--json", "--quiet"]
    result = calibrate("flow", filmed[1], "--interval", "0.1 s", "--out", tmp_path, *options).json
    json.dumps(result, allow_nan=False)
    assert {"discharge_time_s", "curve", "profile", "scale_m_per_px", "outcome"} <= set(result)
    heads = [Path(path).read_text(encoding="utf-8").split("\n")[0] for path in result["tables"]]
    assert "y_m" in heads[1]
    assert Path(result["sheet"]).stat().st_size > 0
