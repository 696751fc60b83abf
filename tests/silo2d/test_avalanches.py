"""Runs that go on after a clog: mass, level and energy are kept, and so are the bits."""

import random
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import scenes
from forking import forked, killed_at
from hand_built import GRAVITY, STICKY, simulation_in
from refusals import assert_refused
from small_silo import DischargeStop, silo2d, the_run, write_case

from granulab.campaign.output.results import read_results
from granulab.campaign.runs.stages import Stages
from granulab.errors import Stopped
from silo2d.avalanches import flow, protocol
from silo2d.avalanches.arches import Bed
from silo2d.avalanches.case import AvalancheCase, Protocol
from silo2d.case.case import SiloCase
from silo2d.case.outline import hopper, outline_from_polygon
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.run.protocol import at_opening, get_packing
from silo2d.run.refill import Surface, put_on

# Rough particles over an outlet of three of them: they clog after ten or so.
ROUGH = {
    "silo.outlet": "22 mm",
    "law.mu_particle": 0.4,
    "law.mu_wall": 0.4,
}
AVALANCHES = 3
DIGESTS = ("state_digest", "sizes", "cut", "durations_s", "arch_particles", "waits", "refilled")


def case_in(folder: Path, **protocol) -> AvalancheCase:
    return AvalancheCase.of(
        SiloCase.load(write_case(folder, ROUGH)), Protocol(**{"avalanches": AVALANCHES} | protocol)
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of a run, by the command and so by a worker, what it printed, and what it found."""
    folder = tmp_path_factory.mktemp("avalanches")
    case = write_case(folder, {**ROUGH, "silo.outlet": "50 mm"})
    table = silo2d(
        "clog", case, "--outlets", "22 mm", "--avalanches", AVALANCHES, "--workers", 1,
        "-o", folder / "runs", "--quiet", "--json",
    ).json  # fmt: skip
    return folder, table, protocol.run(case_in(folder), out=folder / "runs")


@pytest.fixture
def root(whole, tmp_path):
    """A folder of runs that has the packing."""
    shutil.copytree(whole[0] / "runs" / "packings", tmp_path / "runs" / "packings")
    return tmp_path / "runs"


def stop_in_avalanches(says):
    """A stop that `says` so from the opening on, with the progress that it goes by."""
    stop = DischargeStop(says)
    stop.progress = lambda fraction, text: setattr(stop, "_is_open", "avalanches" in text)
    return stop


def kept_energy(sim):
    """What a silo holds, carried out and dissipated: it stays."""
    table = sim.energies()
    held = sum(table[k] for k in ("kinetic", "potential", "elastic_normal", "elastic_tangential",
                                  "carried_out"))  # fmt: skip
    return held + sim.world.account[: state.CARRIED_OUT].sum()


def bits(result):
    return [getattr(result, name) for name in DIGESTS]


# Refilling


def test_particles_are_put_at_the_lowest_place_and_touch_nothing():
    """Thirty discs in an empty silo, one after the other: apart from each other and the walls, and
    as level as discs can be stacked, none more than two diameters above any open place."""
    silo, radius = hopper(0.0, 0.02, 0.1, 0.2), 8e-3
    found = Surface(silo, radius).places(np.zeros((0, 2)), np.zeros(0), np.full(30, radius))
    assert len(found) == 30
    apart = np.hypot(*(found[:, None] - found[None]).T) + np.eye(30)
    assert apart.min() >= 2 * radius
    assert np.abs(found[:, 0]).max() <= 0.05 - radius
    assert found[:, 1].min() == pytest.approx(1.01 * radius, rel=1e-6)
    top = [found[np.abs(found[:, 0] - x) < radius][:, 1].max() for x in np.linspace(-0.04, 0.04, 9)]
    assert np.ptp(top) <= 4 * radius


def test_a_full_silo_takes_no_more():
    silo, radius = hopper(0.0, 0.02, 0.1, 0.1), 8e-3
    found = Surface(silo, radius).places(np.zeros((0, 2)), np.zeros(0), np.full(200, radius))
    assert 20 < len(found) < 40
    assert found[:, 1].max() < 0.1 - radius


def test_particles_are_put_where_the_open_top_reaches_down_to():
    """Below an overhang is no place: nothing could be let down to it."""
    points = [[-10, 0], [10, 0], [10, 40], [50, 40], [50, 60], [10, 60], [10, 100], [-10, 100]]
    silo = outline_from_polygon(np.array(points) * 1e-3)
    found = Surface(silo, 4e-3).places(np.zeros((0, 2)), np.zeros(0), np.full(6, 4e-3))
    assert np.abs(found[:, 0]).max() <= 6e-3 + 1e-9


def test_a_particle_that_is_put_elsewhere_takes_its_energy_along():
    """E + carried out + dissipated stays: of one that moves, leans on another, or is gone."""
    block = scenes.block(20e-3, 10e-3)
    silo = hopper(0.0, 0.06, 0.2, 0.4, "wide")
    poses = [(-0.05, 5e-3, 0.0), (-0.05, 15e-3, 0.0), (0.0, 0.05, 0.3)]
    sim = simulation_in(silo, [block] * 3, poses, STICKY)
    sim.run(60_000)  # 0.12 s: the third has fallen through the outlet

    assert sim.live.tolist() == [0, 1]
    assert sim.energies()["elastic_normal"] > 0.0
    before = kept_energy(sim)
    sim.push(np.array([1]), np.array([[0.3, 0.2]]))
    assert sim.energies()["kinetic"] == pytest.approx(0.5 * 54 * block.area * 0.13, rel=1e-3)
    sim.put(np.array([0, 1, 2]), np.array([(0.05, 0.1, 0.5), (0.0, 0.2, 1.0), (-0.05, 0.15, 2.0)]))
    assert kept_energy(sim) == pytest.approx(before, rel=1e-9)
    assert sim.live.tolist() == [0, 1, 2]
    weight = 54 * block.area * GRAVITY
    assert sim.energies()["potential"] == pytest.approx(0.45 * weight, rel=1e-9)
    assert sim.energies()["elastic_normal"] == 0.0
    assert np.isnan(sim.world.bodies.out_time[:3]).all()
    sim.run(500)
    assert sim.rows[:, state.Y].tolist() == pytest.approx(
        [height - 0.5 * GRAVITY * 1e-3**2 for height in (0.1, 0.2, 0.15)], abs=1e-8
    )


def test_particles_put_on_move_as_those_nearest_to_them_do():
    """And keep the energy: E + carried out + dissipated stays. None is faster than what fell from
    there to the outlet, and in an empty silo all are at rest."""
    block, silo = scenes.block(20e-3, 10e-3), hopper(0.0, 0.06, 0.2, 0.4, "wide")
    poses = [(-0.06, 5e-3, 0.0), (0.06, 5e-3, 0.0), (-0.06, 0.3, 0.0), (0.06, 0.3, 0.0)]
    sim = simulation_in(silo, [block] * 4, poses, STICKY)
    radius = block.bounding_radius
    surface, radii, angles = Surface(silo, radius), np.full(4, radius), np.zeros(2)
    sim.push(np.array([0, 1]), np.array([[0.1, -0.2], [-30.0, 40.0]]))

    before = kept_energy(sim)
    assert put_on(surface, sim, np.array([2, 3]), radii, angles) == 2
    assert kept_energy(sim) == pytest.approx(before, rel=1e-12)
    for put in (2, 3):
        x, y, vx, vy = sim.rows[put][[state.X, state.Y, state.UX, state.UY]]
        nearest = int(x > 0)
        assert np.hypot(x - sim.rows[nearest][state.X], y - 5e-3) < 0.1
        fastest = np.sqrt(2 * GRAVITY * y)
        expected = [(0.1, -0.2), (-0.6 * fastest, 0.8 * fastest)][nearest]
        assert (vx, vy) == pytest.approx(expected, rel=1e-12)
    assert put_on(surface, sim, sim.live, radii, np.zeros(4)) == 4
    assert not sim.rows[:4, [state.UX, state.UY]].any()


def test_share_above_the_outlet_is_of_particles_between_its_edges_up_to_the_level(root):
    """Three of them; not the one beside its edge, above the level or below the outlet."""
    bed = Bed.of(case_in(root.parent), get_packing(case_in(root.parent).silo, root, None))
    silo, level = bed.silo, bed.silo.settings.fill.level
    sim, _ = at_opening(bed.silo, bed.packing, 0, Stages.of(None), lambda: False)
    centre, half = silo.outline.outlet_centre, 0.5 * silo.outline.outlet
    edge = centre + 1.01 * half
    places = [(centre, 0.3 * level), (centre - 0.99 * half, 0.01 * level),
              (centre + 0.99 * half, 0.99 * level), (edge, 0.5 * level),
              (centre, 1.01 * level), (centre, -0.01 * level)]  # fmt: skip
    poses = np.array([(x, y, 0.0) for x, y in places] + [(edge, level, 0.0)] * sim.n_particles)
    sim.put(np.arange(sim.n_particles), poses[: sim.n_particles])
    areas = [silo.shapes.shapes[kind].area for kind in bed.packing.kinds[:3]]
    assert bed.above_outlet(sim) == pytest.approx(sum(areas) / (2 * half * level), rel=1e-12)


def test_a_rathole_is_one_once_more_left_through_it_than_would_fill_it(root):
    """Not through a bed, nor of a hollow below an arch that nothing leaves; begun anew in between
    where a bed filled it."""
    bed = Bed.of(case_in(root.parent), get_packing(case_in(root.parent).silo, root, None))
    silo, ledger = bed.silo, flow.Ledger()
    full = bed.above / silo.shapes.mean_area
    hollow, some = 0.99 * flow.RATHOLE, int(0.6 * full)
    for left, above, expected in [
        (some, flow.RATHOLE, False), (some, flow.RATHOLE, False), (some, hollow, False),
        (0, hollow, False), (0, hollow, False), (some, flow.RATHOLE, False), (some, hollow, False),
        (some, hollow, True),
    ]:  # fmt: skip
        assert flow._is_rathole(bed, ledger, left, above) == expected


# Runs


def test_avalanches_end_in_arches_or_are_cut(whole):
    """As many as asked for, of at least one particle; each clog has an arch of two or more."""
    *_, found = whole
    assert found.outcome == "whole"
    assert len(found.sizes) == len(found.cut) == len(found.durations_s) == AVALANCHES
    assert min(found.sizes) >= 1
    assert sum(found.cut) == 0
    clogs = AVALANCHES + found.first_clogged
    assert len(found.arch_particles) + found.arches_not_found == clogs
    assert min(found.arch_particles) >= 2
    assert found.breaks >= AVALANCHES
    # Of k particles that leave one after the other there are k - 1 times between them.
    assert sum(found.waits) == sum(found.sizes) - AVALANCHES


def test_mass_and_level_are_kept(whole):
    """Each particle is inside, or below the outlet since the last look; each crossing is counted;
    the surface stays where it was, to within two of the largest particles."""
    folder, _, found = whole
    bed = Bed.of(case_in(folder), get_packing(case_in(folder).silo, folder / "runs", None))
    sim, _ = at_opening(bed.silo, bed.packing, 0, Stages.of(None), lambda: False)
    ledger, mass, seen = flow.Ledger(), 1 / sim.rows[:, state.INV_MASS], []

    def look():
        counted = ledger.size + sum(ledger.sizes) + sum(ledger.first[:1])
        seen.append((sim.n_out - counted, sim.n_particles - len(sim.live),
                     np.sort(sim.rows[sim.live, state.Y])[-10:].mean()))  # fmt: skip
        return len(ledger.sizes) == 1

    with pytest.raises(Stopped):
        flow.flow(sim, bed, ledger, lambda: None, Stages.of(None), look)
    assert ledger.sizes == found.sizes[:1]
    not_counted, gone, level = np.array(seen).T
    assert not_counted.max() == 0
    assert gone.max() <= 0
    assert np.abs(level - level[0]).max() < 4 * bed.silo.shapes.bounding_radius
    assert (1 / sim.rows[:, state.INV_MASS] == mass).all()
    assert ledger.refilled > ledger.first[0]  # those of the arch too


def test_a_run_whose_bed_is_a_rathole_ends_there(root, monkeypatch):
    """What left until then counts as cut; stopped on the way it ends alike."""
    monkeypatch.setattr(flow, "RATHOLE", 1.1)  # any bed is one
    case = case_in(root.parent, avalanches=40)
    found = protocol.run(case, out=root)
    assert found.outcome == "rathole"
    again = root.parent / "again"
    shutil.copytree(root / "packings", again / "packings")
    stop = stop_in_avalanches(lambda: True)
    with pytest.raises(Stopped):
        protocol.run(case, out=again, progress=stop.progress, stop=stop)
    assert bits(protocol.run(case, out=again)) == bits(found)


def test_bed_stays_filled_however_fast_the_flow(root):
    """An outlet of eight particles: what is above it stays as dense as flows are. Particles that
    were put at rest stayed behind a surface that sank, and the next behind them: a rathole."""
    case = SiloCase.load(write_case(root.parent, {**ROUGH, "silo.outlet": "60 mm"}))
    case = AvalancheCase.of(case, Protocol(avalanches=3, largest=200))
    bed = Bed.of(case, get_packing(case.silo, root, None))
    sim, _ = at_opening(bed.silo, bed.packing, 0, Stages.of(None), lambda: False)
    ledger, above = flow.Ledger(), []

    def look():
        above.append(bed.above_outlet(sim))
        return False

    assert flow.flow(sim, bed, ledger, lambda: None, Stages.of(None), look) == "whole"
    assert sum(ledger.cut) == 3
    assert np.mean(above) > 0.6
    assert min(above) > flow.RATHOLE


def test_a_run_stopped_many_times_ends_with_the_same_bits(whole, root):
    *_, found = whole
    chance, stops, result = random.Random(5), 0, None
    stop = stop_in_avalanches(lambda: chance.random() < 0.05)
    while result is None:
        try:
            result = protocol.run(case_in(root.parent), out=root, progress=stop.progress, stop=stop)
        except Stopped:
            stops += 1
    assert stops >= 3
    assert bits(result) == bits(found)


def test_a_run_killed_in_the_middle_ends_with_the_same_bits(whole, root):
    """kill -9 after its first checkpoint, and at the write of a later one."""
    *_, found = whole
    case = case_in(root.parent)
    begun = lambda: list(root.glob("*/checkpoint.h5"))  # noqa: E731
    assert killed_at(begun, 0.1, lambda: protocol.run(case, out=root))
    assert forked(lambda: protocol.run(case, out=root), kill_at_write=2) != 0
    assert the_run(root).state == "unfinished"
    assert bits(protocol.run(case, out=root)) == bits(found)


def test_an_avalanche_is_cut_at_its_largest_size(whole, root):
    """Cut at 1, every one is cut, none is larger by more than what leaves between two looks, and
    the flow goes on."""
    *_, found = whole
    cut = protocol.run(case_in(root.parent, largest=1, avalanches=6), out=root)
    assert list(cut.cut) == [True] * 6
    assert max(cut.sizes) <= 1 + 5
    assert found.first_size >= cut.first_size


def test_a_shaken_arch_breaks_too(root):
    """Nothing is put on top but what has left; it takes more breaks where an arch holds."""
    found = protocol.run(case_in(root.parent, breaking="shake", avalanches=1), out=root)
    assert found.outcome == "whole"
    assert found.refilled <= sum(found.sizes) + found.first_size
    assert found.breaks >= 1


# The command


def test_clog_gives_outlets_and_their_avalanches(whole):
    """Once they are there they are not run again, and `show` and `list` say them too."""
    folder, table, found = whole
    (one,) = table["outlets"]
    assert one["outlet_m"] == pytest.approx(0.022)
    assert one["avalanches"] == AVALANCHES
    assert one["mean_avalanche"] == pytest.approx(sum(found.sizes) / AVALANCHES)
    assert found.reused
    made = folder / "runs" / "clog"
    assert {path.suffix for path in made.iterdir()} == {".csv", ".parquet", ".txt", ".png"}
    said = silo2d("clog", folder / "small.toml", "--outlets", "22 mm", "--avalanches", AVALANCHES,
                  "-o", folder / "runs", "--no-figures")  # fmt: skip
    assert said.code == 0, said.err
    assert f"{one['mean_avalanche']:.1f} [" in said.out
    shown = silo2d("show", table["runs"][0])
    assert shown.code == 0, shown.err
    assert f"{AVALANCHES} avalanches" in shown.out
    assert f"{AVALANCHES} avalanches" in silo2d("list", "-o", folder / "runs").out


def test_rows_that_are_kept_are_not_run_and_those_of_other_options_are_refused(whole, tmp_path):
    """Elsewhere there is no run: --add takes the avalanches from the table, and says so there."""
    folder, table, _ = whole
    made = shutil.copytree(folder / "runs" / "clog", tmp_path / "clog")
    (file,) = made.glob("*.csv")
    words = ["clog", folder / "small.toml", "--outlets", "22 mm", "--avalanches", AVALANCHES,
             "--workers", 1, "-o", tmp_path, "--no-figures", "--add"]  # fmt: skip
    dry = silo2d(*words, "--dry-run", "--json")
    assert dry.json["outlets"] == []
    again = silo2d(*words, "--json")
    assert again.code == 0, again.err
    assert again.json["outlets"] == table["outlets"]
    assert not list(tmp_path.glob("*-seed*"))
    assert read_results(str(file))[0]["kept"].startswith("1 rows of ")
    for other in (("--drop", "1 mm"), ("--largest", "900"), ("--mu-wall", "0.3")):
        assert_refused(silo2d(*words, *other), f"--add: {file} was made by", "another silo")
    text = file.read_text()
    file.write_text(re.sub(r"# case: .*\n", "", text))  # as versions before wrote it
    assert silo2d(*words, "--dry-run").code == 0
    assert_refused(silo2d(*words, "--largest", "900", "--dry-run"), "another silo")
    file.write_text(text)
    refused = silo2d(*words[:-1], "--mu-wall", "0.3")  # without --add, of its name
    assert_refused(refused, f"{file}: is of", "would be replaced", "--write")
    assert file.read_text() == text


def test_cost_is_told_before(tmp_path):
    case = write_case(tmp_path, ROUGH)
    said = silo2d(
        "clog", case, "--outlets", "22 mm,30 mm", "--seeds", 3, "--dry-run", "--json"
    ).json
    assert [one["runs"] for one in said["outlets"]] == [3, 3]
    assert said["expected_min"] == pytest.approx(sum(o["expected_min"] for o in said["outlets"]))
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["'--outlets'"]),
        (["--outlets", "45"], ["--outlets = '45'", "unit is missing"]),
        (["--outlets", "45 mm,,50 mm"], ["--outlets = ''"]),
        (["--outlets", "45 mm,4.5 cm"], ["45 mm stands there twice"]),
        (["--outlets", "400 mm"], ["outlet = 400 mm", "wider than the silo"]),
        (["--outlets", "2 mm"], ["outlet = 2 mm", "narrowest particle"]),
        (["--outlets", "45 mm", "--avalanches", "0"], ["--avalanches = 0", "from 1 to"]),
        (["--outlets", "45 mm", "--largest", "0"], ["--largest = 0", "from 1 to"]),
        (["--outlets", "45 mm", "--break", "blow"], ["--break = 'blow'", "'remove' or 'shake'"]),
        (["--outlets", "45 mm", "--drop", "-1 mm"], ["--drop = -1 mm", "'0 mm'"]),
        (["--outlets", "45 mm", "--drop", "1"], ["--drop = '1'", "unit is missing"]),
        (["--outlets", "45 mm", "--seeds", "0"], ["'--seeds'"]),
        (["--outlets", "45 mm", "--workers", "0"], ["--workers = 0"]),
        (["--outlets", "45 mm", "--outlet", "45 mm"], ["--outlet", "--outlets says this"]),
        (["--outlets", "45 mm", "--seed", "2"], ["--seed", "--seeds says this"]),
        (["--outlets", "45 mm", "--engine", "pymunk"], ["--engine", "contacts of dem"]),
        (["--outlets", "45 mm", "--refill", "30"], ["[flow] refill", "leave it out"]),
        (
            [
                "--outlets",
                "45 mm",
                "--vibration-amplitude",
                "0.5 mm",
                "--vibration-frequency",
                "30 Hz",
            ],
            ["[flow] vibration_amplitude", "never comes to rest", "leave it out"],
        ),
    ],
)
def test_what_cannot_clog_is_refused_before_anything_is_computed(
    arguments, words, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert_refused(silo2d("clog", "A3", *arguments), *words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"silo.outlets": [[[-40, 40], [-40, 60]]]}, ["[silo] outlets", "one outlet"]),
        ({"silo.inserts": [[[-5, 50], [5, 50], [0, 58]]]}, ["[silo] inserts", "between the walls"]),
        ({"run.engine": "pymunk"}, ["engine = 'pymunk'", "dem"]),
    ],
)
def test_a_silo_without_one_arch_between_its_walls_is_refused(tmp_path, changes, words):
    case = write_case(tmp_path, changes)
    assert_refused(silo2d("clog", case, "--outlets", "22 mm"), *words)


def test_threads_share_the_flow_not_the_filling_alone(root, monkeypatch):
    """Of a packing that is kept: what is shared is the settling and the flow after it."""
    shared = []
    monkeypatch.setattr(Simulation, "share", lambda sim, n: shared.append(n))
    with pytest.raises(Stopped):
        protocol.run(case_in(root.parent), out=root, threads=2, stop=lambda: True)
    assert shared == [2]
