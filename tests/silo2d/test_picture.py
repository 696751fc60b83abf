"""Pictures of a run: drawn from its folder alone, to scale, finished or not."""

import subprocess
import sys

import numpy as np
import pytest
from fake_run import write_fake_run

from granulab.campaign.output.figure import round_length
from granulab.errors import FolderError
from silo2d.case.outline import outline_from_polygon, preset
from silo2d.run.numbers import dissipated
from silo2d.view.charts import discharge_chart, energy_chart, force_chart
from silo2d.view.picture import make_figures, panel_frames, silo_figure
from silo2d.view.scene import read_scene

FIGURES = ["silo.png", "discharge.png", "energy.png", "forces.png"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A finished discharge of A4."""
    return write_fake_run(tmp_path_factory.mktemp("a4")).path


@pytest.fixture(scope="module")
def clogged(tmp_path_factory):
    """A3, clogged: published times, and no time of its own."""
    return write_fake_run(
        tmp_path_factory.mktemp("a3"), silo=preset("A3"), n_frames=40, outcome="clogged"
    ).path


def labels(axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_outlines_have_the_particles_area_and_position(run):
    """Area x density x length is the mass; five points a corner cut off at most 0.3 % of it."""
    scene = read_scene(run)
    mass, traj = scene.trajectory.static["mass"], scene.trajectory
    seen = 0
    for particles, outlines in scene.outlines(0):
        x, y = outlines[..., 0], outlines[..., 1]
        area = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
        np.testing.assert_allclose(54.0 * area, mass[particles], rtol=3e-3)
        for axis, name in enumerate("xy"):
            assert (np.abs(outlines[..., axis] - traj[name][0][particles, None]) < 0.016).all()
        seen += len(particles)
    assert seen == scene.n_particles


@pytest.mark.parametrize(
    ("end", "times"),
    [
        (1.06, [0, 0.25, 0.5, 0.75, 1.06]),
        (1.15, [0, 0.25, 0.5, 0.75, 1.0, 1.15]),
        (1.75, [0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75]),
        (2.4, [0, 0.5, 1.0, 1.5, 2.0, 2.4]),
        (6.0, [0, 1, 2, 3, 4, 5, 6]),
        (0.0, [0]),
        (0.1, [0, 0.1]),
    ],
)
def test_panels_stand_at_even_times(end, times):
    """0.25 s as in the paper, or a multiple of it that gives at most eight; and the end."""
    frames = panel_frames(np.arange(round(100 * end) + 1) / 100)
    assert [k / 100 for k in frames] == times


@pytest.mark.parametrize(
    ("length", "rounded"), [(0.1, 0.1), (0.0999, 0.05), (0.4, 0.2), (9.99, 5.0)]
)
def test_scale_bar_is_a_round_length(length, rounded):
    """1, 2 or 5 times a power of ten, not above what was requested."""
    assert round_length(length) == pytest.approx(rounded, rel=1e-12)


def test_silo_figure_is_to_scale_and_gives_time_and_count(run):
    """A metre is as many pixels across as upwards, in every panel."""
    scene = read_scene(run)
    figure = silo_figure(scene)
    figure.draw_without_rendering()
    n_out = scene.trajectory["n_out"]
    assert [panel.get_title() for panel in figure.axes] == [
        f"{k / 100:.2f} s, {n_out[k]} out" for k in (0, 25, 50, 75, 105)
    ]
    for panel in figure.axes:
        (x0, y0), (x1, y1) = panel.transData.transform([(0, 0), (0.1, 0.1)])
        assert x1 - x0 == pytest.approx(y1 - y0, rel=1e-9)


def test_discharge_chart_shows_published_times(run):
    """A4: 0.99 +- 0.03 s in the experiment, 1.00 s by SPOLY."""
    (axes,) = discharge_chart(read_scene(run)).axes
    t90 = read_scene(run).summary["t90_s"]
    assert labels(axes) == [
        "experiment: 0.99 \N{PLUS-MINUS SIGN} 0.03 s", "SPOLY: 1.00 s", f"T90: {t90:.2f} s"
    ]  # fmt: skip


def test_clogged_run_has_no_t90(clogged):
    """The times of the few that left are no discharge times."""
    (axes,) = discharge_chart(read_scene(clogged)).axes
    assert labels(axes) == ["experiment: 2.09 \N{PLUS-MINUS SIGN} 0.04 s, 1 of 5 clogged"]
    assert axes.get_xlim()[1] > 2.13  # beyond the band, though the run ended at 0.4 s


def test_published_clogging_is_reported(tmp_path):
    """A2 clogged in the one trial, and in SPOLY."""
    write_fake_run(tmp_path, silo=preset("A2"), n_frames=5, outcome="clogged_at_opening")
    (axes,) = discharge_chart(read_scene(tmp_path)).axes
    assert labels(axes) == ["experiment: 1 of 1 clogged", "SPOLY: clogged"]


def test_stacked_energies_sum_to_the_dissipated_energy(run):
    """The upper rim of the stack is the sum over the six mechanisms."""
    scene = read_scene(run)
    _, lost, _ = energy_chart(scene).axes
    rim = max(path.vertices[:, 1].max() for c in lost.collections for path in c.get_paths())
    assert rim == pytest.approx(sum(series[-1] for series in dissipated(scene.trajectory).values()))


def test_wall_forces_press_outwards(run):
    """The fake particles push every wall outwards: no sign is lost between walls and normals."""
    vertical, normal = force_chart(read_scene(run)).axes
    for line in normal.lines:
        assert (line.get_ydata() > 0).all()
    *walls, total = (line.get_ydata() for line in vertical.lines[:10:2])  # each as it stands
    np.testing.assert_allclose(np.sum(walls, axis=0)[1:], total[1:])  # the door has gone
    assert labels(vertical)[:2] == ["right hopper", "right wall"]


def test_a_door_that_closes_again_bears_with_the_walls(run):
    """It has its line, and its part of all: the weight that a closed outlet bears."""
    scene = read_scene(run)
    scene.trajectory.attributes["gate_times"] = np.array([0.0, 0.5])
    vertical, _ = force_chart(scene).axes
    assert labels(vertical)[-2:] == ["door", "all walls"]
    *walls, total = (line.get_ydata() for line in vertical.lines[::2])
    assert walls[-1][0] > 0
    np.testing.assert_allclose(np.sum(walls, axis=0), total)


@pytest.mark.parametrize(
    ("outcome", "words"),
    [
        ("empty", "Silo A4: empty after 0.0"),
        ("dead_zones", "Silo A4: dead zones remain; the last particle left at 0.0"),
        ("clogged", "Silo A4: clogged, "),
        ("time_limit", "Silo A4: stopped at the time limit, "),
    ],
)
def test_headline_gives_the_outcome(tmp_path, outcome, words):
    """One line above every figure."""
    write_fake_run(tmp_path, n_frames=5, outcome=outcome)
    assert read_scene(tmp_path).headline.startswith(words)


def test_figures_of_any_silo_are_files_in_its_folder(tmp_path, capfd):
    """A lopsided polygon, and nothing on the console."""
    silo = outline_from_polygon(
        [(0.2, 0), (0.5, 0), (0.7, 0.3), (0.7, 0.5), (0, 0.5), (0, 0.3)], 0.12, 0.3, "mine"
    )
    write_fake_run(tmp_path, silo=silo, n_frames=5)
    paths = make_figures(tmp_path, film=False)
    assert paths == [tmp_path / "figures" / name for name in FIGURES]
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in (tmp_path / "figures").iterdir()) == sorted(FIGURES)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("n_frames", [1, 2, 30])
def test_unfinished_run_is_drawn(tmp_path, n_frames):
    """From its parts, from the first frame on."""
    write_fake_run(tmp_path, n_frames=n_frames, finished=False)
    scene = read_scene(tmp_path)
    assert "unfinished" in scene.headline
    for draw in (silo_figure, discharge_chart, energy_chart, force_chart):
        draw(scene).draw_without_rendering()


def test_run_without_frames_is_refused_in_one_line(tmp_path):
    """The folder of a run that is being filled."""
    (tmp_path / "parts").mkdir()
    with pytest.raises(FolderError, match=r"^[^\n]*no frame yet[^\n]*$"):
        make_figures(tmp_path)


def test_pictures_need_no_simulation():
    """They read run folders: no kernel is even imported, nor what a command without them needs."""
    code = "import sys, silo2d.view.picture; print([m for m in %r if m in sys.modules])"
    unwanted = ["numba", "silo2d.engine.state", "silo2d.case.case", "matplotlib", "cv2", "shapely"]
    done = subprocess.run(
        [sys.executable, "-c", code % unwanted], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"
