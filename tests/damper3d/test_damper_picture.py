"""Pictures of a damper's run: drawn from its folder alone, with the right numbers on their axes."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from fake_damper_run import EFFICIENCY, LAW_GAIN, SHARES, G, write_fake_damper_run
from small_damper import damper3d

from damper3d.view.charts import efficiency_of_cycles, energy_chart, motion_chart
from damper3d.view.colouring import power
from damper3d.view.picture import cycle_figure, make_figures, panel_frames
from damper3d.view.scene import read_scene
from damper3d.view.spheres import corners, cut_open, window
from granulab.errors import FolderError

FIGURES = ["cycle.png", "energy.png", "motion.png"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Vertical, 40 Hz, Gamma 20, five cycles of which two count, eight frames a cycle."""
    return write_fake_damper_run(tmp_path_factory.mktemp("vertical")).path


@pytest.fixture(scope="module")
def scene(run):
    return read_scene(run)


@pytest.fixture(scope="module")
def lying(tmp_path_factory):
    """A box that lies: gravity along -x, motion along z."""
    folder = tmp_path_factory.mktemp("lying")
    return read_scene(
        write_fake_damper_run(folder, orientation="horizontal", shape="box", gamma=5.0).path
    )


def series(axes) -> dict[str, np.ndarray]:
    """Ordinates of the lines that have a name."""
    return {line.get_label(): line.get_ydata() for line in axes.lines
            if not line.get_label().startswith("_")}  # fmt: skip


def test_particles_are_read_as_they_were_stored(scene):
    """Closed-form motion: s = (c/2)(1 - cos(w t)) in the enclosure, u' + s' in the lab."""
    omega, clearance = 2 * np.pi * 40.0, 6e-3
    first = scene.particles(0).position
    for frame in (1, 11, 40):
        t = scene.time[scene.frame_sample[frame]]
        found = scene.particles(frame)
        rise = clearance / 2 * (1 - np.cos(omega * t))
        # Kept in single precision: 2e-9 m of some centimetres, 1e-7 m/s of one.
        np.testing.assert_allclose(found.position[:, 2] - first[:, 2], rise, atol=5e-9)
        speed = 20 * G / omega * np.cos(omega * t) + clearance / 2 * omega * np.sin(omega * t)
        np.testing.assert_allclose(found.velocity[:, 2], speed, atol=2e-7)
        shift = 20 * G / omega**2 * np.sin(omega * t)
        np.testing.assert_allclose(scene.shift(frame), [0, 0, shift], atol=1e-15)


def test_gravity_points_down_and_the_motion_is_seen(scene, lying):
    """Vertical: z upwards. Horizontal (gravity along -x): x upwards, z (the motion) to the right.

    Right, up and towards the eye are right-handed: no picture is a mirror image.
    """
    np.testing.assert_array_equal(scene.view.up, [0, 0, 1])
    np.testing.assert_array_equal(lying.view.up, [1, 0, 0])
    np.testing.assert_array_equal(lying.view.right, [0, 0, 1])
    for one in (scene, lying):
        right, up, nearer = one.view
        np.testing.assert_array_equal(np.cross(right, up), nearer)
        assert one.view.project(one.gravity)[1] == pytest.approx(-G)
        assert one.view.project(one.gravity)[0] == one.view.project(one.gravity)[2] == 0


@pytest.mark.parametrize("which", ["scene", "lying"])
def test_the_window_holds_the_enclosure_wherever_it_goes(which, request):
    """And every sphere that is drawn lies in the enclosure as drawn, at its displacement."""
    one = request.getfixturevalue(which)
    shown, (low, high) = window(one, 1.0), corners(one)
    for frame in range(len(one.tables)):
        moved = one.view.project(one.shift(frame))[:2]
        assert (np.array([shown.left, shown.bottom]) < low + moved).all()
        assert (np.array([shown.right, shown.top]) > high + moved).all()
        centre, kept = cut_open(one, frame)
        assert kept.any()
        assert not kept.all()
        reach = one.radius[:, None] - 1e-8
        assert (centre[:, :2] - reach >= low + moved).all()
        assert (centre[:, :2] + reach <= high + moved).all()
        # What is taken away is nearer to the eye than what stays.
        assert centre[kept, 2].max() <= centre[~kept, 2].min()


@pytest.mark.parametrize(
    ("samples", "frames", "panels"), [(40, 8, 8), (40, 20, 7), (40, 5, 5), (40, 1, 1), (40, 40, 8)]
)
def test_panels_stand_at_even_parts_of_the_last_cycle(tmp_path, samples, frames, panels):
    """At most eight, from the start of the cycle."""
    write_fake_damper_run(tmp_path, samples=samples, frames=frames, cycles=4)
    scene = read_scene(tmp_path)
    found = scene.frame_sample[panel_frames(scene)]
    assert len(found) == panels
    assert found[0] == 3 * samples
    assert len(set(np.diff(found))) <= 1
    assert found[-1] < 4 * samples


def test_each_panel_stands_over_its_time(scene):
    """Panels are to scale, in a row, over their part of the cycle in the graph below."""
    figure = cycle_figure(scene)
    figure.draw_without_rendering()
    strip, *panels, bar = figure.axes
    assert len(panels) == 8
    assert bar.get_ylabel() == "velocity along\nthe motion [m/s]"
    shown = window(scene, 1.0)
    for panel, part in zip(panels, np.arange(8) / 8, strict=True):
        box = panel.get_position()
        middle = figure.transFigure.transform(((box.x0 + box.x1) / 2, 0))[0]
        assert strip.transData.inverted().transform((middle, 0))[0] == pytest.approx(part, abs=1e-6)
        size = panel.get_window_extent()
        shape = (shown.top - shown.bottom) / (shown.right - shown.left)
        assert size.height / size.width == pytest.approx(shape, rel=1e-6)
    found = series(strip)
    np.testing.assert_array_equal(found["enclosure"], scene.trajectory["velocity"][160:])
    np.testing.assert_array_equal(found["bed"], scene.trajectory["mean_velocity"][160:, 2])


def test_velocity_and_power_have_their_colours(scene):
    """Velocities are even about 0; power is the heat gained since the frame before, by dt."""
    bar = cycle_figure(scene).axes[-1]
    low, high = bar.get_ylim()
    assert low == pytest.approx(-high)
    assert high >= scene.peak_speed
    frame = 17
    gained = power(scene, frame) * 5 / 40 / 40  # 5 samples of the 40 of a cycle of 1/40 s
    change = scene.particles(frame).dissipated - scene.particles(frame - 1).dissipated
    np.testing.assert_allclose(gained, change, rtol=1e-12)
    bar = cycle_figure(scene, "dissipation").axes[-1]
    assert bar.get_yscale() == "log"
    assert bar.get_ylabel() == "dissipated at\na particle [W]"


def test_stacked_dissipation_is_the_mean_of_the_counted_cycles(scene):
    """D = E eta of each cycle; shares as put in; on the right the same over 4 V^2 M (eq. 6.10)."""
    stack, _ = energy_chart(scene).axes
    rim = [c.get_paths()[0].vertices[:, 1].max() for c in stack.collections]
    full = 1e3 * 4 * scene.peak_speed**2 * scene.mass  # mJ
    assert stack.get_ylabel() == "dissipated in the cycle [mJ]"
    eta = np.mean(EFFICIENCY[3:])
    np.testing.assert_allclose(rim, np.cumsum(list(SHARES.values())) * eta * full, rtol=1e-9)
    words = [text.get_text() for text in stack.get_legend().get_texts()]
    assert words[0] == "tangential damping,\nparticle\N{EN DASH}wall: 2.0 %"
    assert words[5] == "friction,\nparticle\N{EN DASH}particle: 50.0 %"
    assert words[6] == "sum in each of\ncycles 4 to 5"
    (right,) = stack.child_axes
    right.figure.draw_without_rendering()
    assert right.get_ylim()[1] == pytest.approx(stack.get_ylim()[1] / full)


def test_efficiency_of_each_cycle_is_from_the_budget(scene):
    """Eqs 6.8-6.10: what is dissipated less what the law itself gains; discarded ones hollow."""
    expected = (1 - LAW_GAIN) * np.array(EFFICIENCY)
    np.testing.assert_allclose(efficiency_of_cycles(scene), expected, rtol=1e-9)
    _, cycles = energy_chart(scene).axes
    found = series(cycles)
    np.testing.assert_allclose(found["discarded"], expected[:3], rtol=1e-9)
    np.testing.assert_allclose(found["counted"], expected[3:], rtol=1e-9)
    assert set(found[f"mean: {scene.summary['efficiency']:.3f}"]) == {scene.summary["efficiency"]}


def test_motion_has_velocities_forces_and_height(scene):
    """Means over the counted cycles; the force of all walls is the sum of floor and lid."""
    velocity, force, height = motion_chart(scene).axes
    part = scene.phase
    peak = 20 * G / (2 * np.pi * 40)
    found = series(velocity)
    np.testing.assert_allclose(found["enclosure"], peak * np.cos(2 * np.pi * part), atol=1e-12)
    bed = found["enclosure"] + 3e-3 * 2 * np.pi * 40 * np.sin(2 * np.pi * part)
    np.testing.assert_allclose(found["bed, mean"], bed, atol=1e-12)
    found = series(force)
    assert list(found) == ["bottom", "top", "all walls"]  # the side bears nothing
    np.testing.assert_allclose(found["all walls"], found["bottom"] + found["top"], atol=1e-12)
    assert (found["bottom"] <= 0).all()  # the bed presses it down
    (centre,) = series(height).values()
    np.testing.assert_allclose(centre, 7 + 3 * (1 - np.cos(2 * np.pi * part)), atol=1e-9)  # mm


def test_height_of_a_lying_bed_is_counted_from_its_lowest_wall(lying):
    """Gravity along -x: x + width/2; the fake bed's mean x is 0."""
    height = motion_chart(lying).axes[2]
    assert height.get_ylabel() == "height above\nthe lowest point [mm]"
    (centre,) = series(height).values()
    np.testing.assert_allclose(centre, 10.0, atol=1e-9)


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ("prolate:1.5", "particles prolate:1.5, fill"),
        ("mesh:rock.obj", "particles mesh:rock, fill"),
    ],
)
def test_headline_names_shapes_that_are_no_spheres(scene, shape, words):
    """A mesh as it was called; the run folder's copy of it is an OBJ file."""
    particles = scene.settings.particles.model_copy(update={"shape": shape})
    settings = scene.settings.model_copy(update={"particles": particles})
    title = dataclasses.replace(scene, settings=settings).title
    assert title.startswith(f"{len(scene.radius)} {words} ratio 0.1")


def test_headline_gives_particles_motion_and_outcome(scene, lying, tmp_path):
    assert scene.title.startswith(f"{len(scene.radius)} spheres of 3 mm, fill ratio 0.1")
    assert scene.title.endswith("; 40 Hz, Γ = 20, vertical")
    assert lying.title.endswith("; 40 Hz, Γ = 5, horizontal")
    assert scene.outcome == f"efficiency {scene.summary['efficiency']:.3f}, bouncing bed"
    write_fake_damper_run(tmp_path, finished=False, cycles=2)
    assert read_scene(tmp_path).outcome == "unfinished, 2.0 cycles"


@pytest.mark.parametrize("cycles", [1, 4])
def test_unfinished_run_is_drawn(tmp_path, cycles):
    """From its parts; while only discarded cycles are there, these are shown."""
    write_fake_damper_run(tmp_path, finished=False, cycles=cycles)
    scene = read_scene(tmp_path)
    assert list(scene.counted) == ([0] if cycles == 1 else [3])
    for draw in (cycle_figure, energy_chart, motion_chart):
        draw(scene).draw_without_rendering()


def test_render_writes_the_figures_again(run):
    """Their paths on stdout, nothing else."""
    result = damper3d("render", run, "--no-film", "--by", "dissipation")
    assert (result.code, result.err) == (0, "")
    paths = [run / "figures" / name for name in FIGURES]
    assert result.out.splitlines() == [str(path) for path in paths]
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in (run / "figures").iterdir()) == FIGURES


def test_run_without_frames_has_graphs_only(tmp_path):
    """output.frames = 0: the samples are there, the particles are not."""
    write_fake_damper_run(tmp_path, frames=0)
    assert [path.name for path in make_figures(tmp_path)] == FIGURES[1:]
    with pytest.raises(FolderError, match=r"^no frame in the last cycle.*frames above 0$"):
        cycle_figure(read_scene(tmp_path))


@pytest.mark.parametrize(
    ("made", "arguments", "words"),
    [
        ({"keep": "summary"}, [], 'only its summary was kept (output.keep = "summary")'),
        ({}, ["--engine", "blender"], "--engine 'blender': known: matplotlib, pyvista"),
        ({}, ["--by", "speed"], "--by 'speed': known: velocity, dissipation"),
        ({"until": 0, "finished": False}, [], "no sample yet; wait"),
        ({"until": 20, "finished": False}, [], "no whole cycle yet; wait"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_one_line(tmp_path, made, arguments, words):
    """With what would do; exit code 2."""
    write_fake_damper_run(tmp_path / "run", **made)
    result = damper3d("render", tmp_path / "run", *arguments)
    assert result.code == 2
    assert words in result.err
    assert len(result.err.splitlines()) == 1


def test_no_run_folder_and_damaged_ones_are_refused(tmp_path, run):
    for folder, words in ((tmp_path, "not a run folder"), (tmp_path / "none", "not a run folder")):
        result = damper3d("render", folder)
        assert (result.code, len(result.err.splitlines())) == (2, 1)
        assert words in result.err
    from granulab.campaign.runs.trajectory import TrajectoryWriter

    (tmp_path / "case.toml").write_text((run / "case.toml").read_text())
    writer = TrajectoryWriter(tmp_path)
    writer.write_static({"radius": np.ones(1)}, {})
    for time in range(90):
        writer.append({"time": float(time)})
    writer.flush()
    with pytest.raises(FolderError, match=r"damaged \(no displacement, [^\n]*; use --again"):
        read_scene(tmp_path)


def test_pictures_need_no_simulation():
    """They read run folders; what a command without them needs is not even imported."""
    code = "import sys, damper3d.commands.results; print([m for m in %r if m in sys.modules])"
    unwanted = ["numba", "numpy", "matplotlib", "cv2", "h5py", "damper3d.engine.state"]
    done = subprocess.run(
        [sys.executable, "-c", code % unwanted], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_missing_pyvista_is_reported_in_one_line(run, monkeypatch):
    """It is an extra: the line says how to get it."""
    monkeypatch.setitem(sys.modules, "pyvista", None)
    result = damper3d("render", run, "--engine", "pyvista")
    assert result.code == 2
    words = "pyvista is not installed; get it with: pip install granulab[pyvista]"
    assert words in result.err
    assert len(result.err.splitlines()) == 1


def test_the_bed_in_space_moves_with_the_enclosure(scene):
    """The eye stands still: what is drawn rises with u from the start to a quarter of a cycle."""
    pytest.importorskip("pyvista", reason="an extra")
    from damper3d.view.colouring import colouring
    from damper3d.view.picture import draw_space

    colours = colouring(scene, "velocity", [0, 2])
    middle = []
    for frame in (0, 2):
        image = draw_space(scene, frame, colours)
        rows, columns = np.nonzero((image != 255).any(axis=2))
        middle.append(rows.min() + rows.max())
        assert 0 < columns.min() < columns.max() < image.shape[1] - 1
        assert 0 < rows.min() < rows.max() < image.shape[0] - 1
    assert middle[1] < middle[0] - 10  # rows count downwards
