"""A damper's case as resolved: the thesis's numbers, overrides, time step, files, digests."""

import itertools
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import example, given, settings
from hypothesis import strategies as st

from damper3d.case.case import DamperCase
from damper3d.case.parameters import SAFE_SHARE
from damper3d.case.parts import USUAL_FILL_RATIO
from damper3d.case.plan import plan, warnings
from damper3d.case.settings import Excitation, Settings, check_settings, to_toml
from damper3d.engine.enclosures import box, cylinder
from damper3d.engine.records import CLASSES
from damper3d.shapes.particle import parse_particle
from granulab.campaign.runs.folder import digest
from granulab.contact.files.casefile import LARGEST, SMALLEST, known_keys
from granulab.contact.files.datafile import data_file, data_root
from granulab.errors import InputError


def case_with(**changes: Any) -> DamperCase:
    """The thesis's damper with changes such as motion__gamma=5."""
    return DamperCase.load("thesis", {key.replace("__", "."): v for key, v in changes.items()})


def run_digest(case: DamperCase) -> str:
    return digest(case.identity())


def packing_digest(case: DamperCase) -> str:
    return digest(case.packing_identity())


# Enclosure and particles


@pytest.mark.parametrize(("diameter", "count"), [(3, 1659), (4, 700), (5, 358), (6, 207)])
def test_the_same_fill_ratio_gives_the_thesis_numbers_of_spheres(diameter, count):
    """Table 6.1: 1659, 700, 358 and 207 spheres of 3 to 6 mm in 40 mm x 40 mm."""
    case = case_with(particles__shape=f"sphere:{diameter}mm")
    assert case.count == count
    assert case.fill_ratio == pytest.approx(7 / 15, abs=1e-3)  # printed as 0.466
    assert case.particle_mass == pytest.approx(1190 * math.pi / 6 * (1e-3 * diameter) ** 3)
    assert case.mass == pytest.approx(0.0279, abs=5e-5)  # the thesis holds it constant


@pytest.mark.parametrize(("height", "ratio"), [(40, 0.466), (45, 0.415), (50, 0.373), (55, 0.339)])
@pytest.mark.parametrize(("diameter", "count"), [(3, 1659), (4, 700), (5, 358), (6, 207)])
def test_fill_ratios_of_the_thesis(height, ratio, diameter, count):
    """Eq. 6.1 with Table 6.1, one number for all four sizes, which differ by 9e-4."""
    case = case_with(
        enclosure__height=f"{height} mm",
        particles__shape=f"sphere:{diameter}mm",
        particles__count=count,
    )
    assert case.fill_ratio == pytest.approx(ratio, abs=1.1e-3)


def test_another_enclosure_is_filled_alike():
    """Left out, the count keeps the fill ratio, to half a particle."""
    for changes in (
        {"enclosure__height": "55 mm"},
        {"enclosure__diameter": "31 mm", "particles__shape": "sphere:2mm"},
        {"enclosure__shape": "box", "enclosure__width": "25 mm", "enclosure__depth": "35 mm"},
    ):
        case = case_with(**changes)
        half = 0.5 * case.particle.volume / case.enclosure.volume
        assert abs(case.fill_ratio - USUAL_FILL_RATIO) <= half * (1 + 1e-9)


@pytest.mark.parametrize("enclosure", [cylinder(0.04, 0.05), box(0.03, 0.02, 0.05)])
def test_walls_enclose_the_void(enclosure):
    """Normals point inwards and have length one; random points inside are on the right side.

    The share of points of the bounding box that are inside gives the volume, to four standard
    deviations of 20,000 draws.
    """
    planes = enclosure.planes
    assert np.linalg.norm(planes[:, :3], axis=1) == pytest.approx(np.ones(len(planes)))
    assert len(planes) + (enclosure.cylinder_radius > 0) == len(enclosure.wall_names)
    n, size = 20_000, 2 * max(enclosure.width, enclosure.depth, enclosure.height)
    points = np.random.default_rng(1).uniform(-0.5 * size, size, (n, 3))
    inside = np.all(points @ planes[:, :3].T > planes[:, 3], axis=1)
    if enclosure.cylinder_radius:
        inside &= np.hypot(points[:, 0], points[:, 1]) < enclosure.cylinder_radius
    share = enclosure.volume / (1.5 * size) ** 3
    assert inside.mean() == pytest.approx(share, abs=4 * math.sqrt(share / n))
    assert enclosure.wall_names[:2] == ["bottom", "top"]


@given(st.floats(1e-5, 1.0))
def test_a_sphere_is_a_multi_sphere_particle_of_one(radius):
    """Volume 4/3 pi r^3, moment of inertia 2/5 m r^2, and it bounds itself."""
    ball = parse_particle("sphere", radius)
    assert ball.volume == pytest.approx(4 / 3 * math.pi * radius**3, rel=1e-15)
    assert ball.inertia / ball.volume == pytest.approx(np.full(3, 0.4 * radius**2), rel=1e-14)
    assert ball.bounding_radius == ball.smallest_radius == radius
    assert ball.equal_volume_radius == pytest.approx(radius, rel=1e-14)
    assert parse_particle(f"sphere:{2 * radius!r} m").radii == pytest.approx(radius, rel=1e-15)


# Motion and gravity


@pytest.mark.parametrize(
    ("orientation", "gravity"), [("vertical", (0, 0, -9.81)), ("horizontal", (-9.81, 0, 0))]
)
def test_orientation_is_that_of_the_axis(orientation, gravity):
    case = case_with(motion__orientation=orientation)
    assert tuple(case.gravity) == tuple(case.settling_gravity) == gravity
    assert tuple(case.direction) == (0, 0, 1)


@pytest.mark.parametrize(
    ("motion", "orientation"),
    [
        ({"gravity": [-1, 0, 0]}, "horizontal"),
        ({"direction": [1, 0, 0]}, "horizontal"),
        ({"direction": [1, 0, 0], "gravity": [-1, 0, 0]}, "vertical"),
        ({"gravity": [-0.6, 0, -0.8]}, "vertical"),
        ({"gravity": [-0.8, 0, -0.6]}, "horizontal"),
        ({"orientation": "none"}, "none"),
    ],
)
def test_orientation_follows_gravity_and_direction_however_they_are_given(motion, orientation):
    case = case_with(**{f"motion__{key}": value for key, value in motion.items()})
    assert case.orientation == orientation
    assert plan(case)["orientation"] == orientation


def test_without_gravity_the_particles_still_settle_under_it():
    case = case_with(motion__orientation="none")
    assert not case.gravity.any()
    assert tuple(case.settling_gravity) == (0, 0, -9.81)


@given(st.lists(st.floats(-1e300, 1e300), min_size=3, max_size=3).filter(any))
def test_directions_are_normalised(vector):
    """Any vector but zero, however long or short, has length one: 3 roundings."""
    case = case_with(motion__direction=vector, motion__gravity=vector)
    assert np.linalg.norm(case.direction) == pytest.approx(1, abs=1e-15)
    assert case.gravity == pytest.approx(9.81 * case.direction, rel=1e-15)


def test_amplitude_and_peak_speed_are_those_of_equation_6_2():
    """Gamma g/omega^2 and Gamma g/omega at 40 Hz, Gamma 20: 3.106 mm and 0.7807 m/s."""
    case = case_with(motion__frequency=40, motion__gamma=20)
    assert case.amplitude == pytest.approx(20 * 9.81 / (80 * math.pi) ** 2, rel=1e-14)
    assert case.peak_speed == pytest.approx(20 * 9.81 / (80 * math.pi), rel=1e-14)
    assert case.shaker.amplitude[0] == case.amplitude


# The law


def test_yield_velocities_are_the_thesis_numbers():
    """Sec. 6.2.2: 3.5 m/s between acrylic spheres; twice that against the wall (eq. 5.26).

    R^3/m of the wall's pair is 8/2 = 4 times that of two spheres. Independent of size.
    """
    for size in ("3mm", "5mm"):
        found = case_with(particles__shape=f"sphere:{size}").yield_velocity
        assert found["particle_particle"] == pytest.approx(3.5, abs=0.05)
        assert found["particle_wall"] == pytest.approx(2 * found["particle_particle"], rel=1e-14)


def test_wave_speeds_are_those_of_the_slower_material():
    """Eq. 5.12 of the case's own materials: acrylic's 2,215 m/s, and less by the root of ten for a
    tenth of its modulus."""
    assert case_with().wave_speed == pytest.approx(dict.fromkeys(CLASSES, 2214.66), abs=0.01)
    soft = case_with(law__youngs_modulus="0.33 GPa").wave_speed
    assert soft == pytest.approx(dict.fromkeys(CLASSES, 2214.66 / math.sqrt(10)), abs=0.01)


OVERRIDES: list[tuple[dict[str, Any], tuple[float, float], tuple[float, float]]] = [
    ({}, (0.52, 0.86), (0.52, 0.86)),
    ({"friction": 0.3}, (0.3, 0.86), (0.3, 0.86)),
    ({"friction_wall": 0.3}, (0.52, 0.86), (0.3, 0.86)),
    ({"friction": 0.1, "friction_wall": 0.0}, (0.1, 0.86), (0.0, 0.86)),
    ({"restitution": 0.5}, (0.52, 0.5), (0.52, 0.5)),
    ({"restitution_wall": 0.5}, (0.52, 0.86), (0.52, 0.5)),
    ({"restitution": 0.5, "restitution_wall": 0.7}, (0.52, 0.5), (0.52, 0.7)),
]


@pytest.mark.parametrize(("changes", "pair", "wall"), OVERRIDES)
def test_an_override_of_all_contacts_and_then_of_the_walls(changes, pair, wall):
    """(friction, restitution) of both kinds; the damping b = -ln e/sqrt(ln^2 e + pi^2)."""
    case = case_with(**{f"law__{key}": value for key, value in changes.items()})
    restitution = case.restitution.values()
    for law, e, wanted in zip(
        (case.pair_law, case.wall_law), restitution, (pair, wall), strict=True
    ):
        assert (law.mu, e) == wanted
        b = -math.log(e) / math.hypot(math.log(e), math.pi)
        assert law.damping == pytest.approx(b, rel=1e-14)


def test_modulus_and_density_are_replaced():
    """K ~ E; m ~ rho; the Rayleigh step goes with sqrt(rho/E) (eq. 3.31)."""
    usual = case_with()
    changed = case_with(law__youngs_modulus="6.6 GPa", law__density="2.38 g/cm3")
    for law, before in ((changed.pair_law, usual.pair_law), (changed.wall_law, usual.wall_law)):
        assert law.hertz == pytest.approx(2 * before.hertz, rel=1e-14)
        assert law.tangential == pytest.approx(before.tangential, rel=1e-14)
    assert changed.mass == pytest.approx(2 * usual.mass, rel=1e-14)
    assert changed.steps.rayleigh == pytest.approx(usual.steps.rayleigh, rel=1e-14)


def test_options_of_the_law_reach_it():
    law = case_with(law__contact_end="force", law__tangential="force").wall_law
    assert not law.pulls
    assert law.stored_force
    assert case_with().pair_law.yielding == math.inf
    yielding = case_with(law__yielding=True)
    mass = 0.5 * yielding.particle_mass
    speed = yielding.pair_law.yielding * math.sqrt((0.5 * 2.5e-3) ** 3 / mass)
    assert speed == pytest.approx(yielding.yield_velocity["particle_particle"], rel=1e-12)


# The time step


def test_the_rayleigh_step_is_that_of_equation_3_31():
    """8.33 us for 5 mm and 5.0 us for 3 mm (errata to Table 6.1)."""
    assert case_with().steps.rayleigh == pytest.approx(8.33e-6, abs=5e-9)
    small = case_with(particles__shape="sphere:3mm")
    assert small.steps.rayleigh == pytest.approx(5.0e-6, abs=5e-9)
    assert case_with().time_step == small.time_step == 1e-6  # the thesis's


@given(st.floats(1.0, 2000.0), st.sampled_from([8, 100, 500]), st.floats(0.2, 3.0))
@settings(deadline=None)
def test_steps_make_whole_samples_and_samples_whole_cycles(frequency, samples, step_us):
    """At most the step that was requested, and one more a sample would be too many."""
    changes = {"motion.frequency": frequency, "output.samples": samples, "output.frames": 0}
    changes["run.time_step"] = f"{step_us!r} us"
    if 1 / (frequency * samples) < step_us * 1e-6 * (1 - 1e-9):
        with pytest.raises(InputError, match="less than a time step"):
            DamperCase.load("thesis", changes)
        return
    case = DamperCase.load("thesis", changes)
    n, step = case.steps_per_sample, case.time_step
    assert n * samples * step * frequency == pytest.approx(1, rel=1e-14)
    assert step <= step_us * 1e-6 * (1 + 2e-9)
    assert n == 1 or 1 / (frequency * samples * (n - 1)) > step_us * 1e-6


def test_stiff_or_small_particles_get_a_shorter_step():
    """0.2 of the Rayleigh step where the usual 1 us is longer, by two digits, rounded down."""
    for changes in ({"law__youngs_modulus": "206 GPa"}, {"particles__shape": "sphere:1.2mm"}):
        steps = case_with(**changes).steps
        assert 0.18 * steps.rayleigh < steps.free <= 0.2 * steps.rayleigh
        assert steps.free < 1e-6


def test_a_step_near_the_rayleigh_step_is_warned_of():
    limit = case_with().steps.rayleigh
    for share in (0.9 * SAFE_SHARE, 0.99):
        case = case_with(run__time_step=f"{share * limit!r} s", motion__frequency=20)
        assert any("Rayleigh" in line for line in warnings(case)) == (share > SAFE_SHARE)
    with pytest.raises(InputError, match="above the Rayleigh limit of"):
        case_with(run__time_step=f"{1.001 * limit!r} s")


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"law__density": "26 g/cm3"}, "heavier than any metal"),
        ({"motion__frequency": 1, "motion__gamma": 10}, "times the yield velocity"),
        ({"law__youngs_modulus": "0.1 MPa"}, "overlap by"),
        ({"motion__ramp": 3.5}, "full amplitude"),
        ({"motion__gamma": 1}, "moves with its enclosure"),
        ({"motion__gamma": 0.5, "motion__orientation": "horizontal"}, "up to 0.52 a rigid bed"),
    ],
)
def test_absurd_values_are_warned_of(changes, word):
    assert not warnings(case_with())
    assert any(word in line for line in warnings(case_with(**changes)))


@pytest.mark.parametrize("frequency", [40, 40.0, "40", "40 Hz", "0.04 kHz", "40 1/s"])
def test_a_frequency_is_a_number_of_hertz_or_carries_its_unit(frequency):
    assert case_with(motion__frequency=frequency).settings == case_with().settings


def test_a_material_without_pairs_takes_friction_and_restitution_from_the_case():
    case = case_with(
        particles__materials="glass", particles__material="glass", enclosure__material="glass",
        law__friction=0.3, law__restitution=0.9,
    )  # fmt: skip
    assert case.pair_law.mu == case.wall_law.mu == 0.3
    assert set(case.restitution.values()) == {0.9}


def test_a_ramp_that_is_left_out_is_not_warned_of():
    assert not warnings(case_with(motion__ramp=3))


# What names a packing and a run

OF_THE_MOTION: dict[str, Any] = {
    "motion.frequency": 41.0,
    "motion.gamma": 19.0,
    "motion.ramp": 1.0,
    "motion.direction": [1.0, 0.0, 0.0],
    "run.cycles": 9,
    "run.discard": 2,
    "run.steady": True,
    "output.samples": 200,
    "output.keep": "summary",
}
OF_THE_PACKING: dict[str, Any] = {
    "enclosure.diameter": "41 mm",
    "enclosure.height": "41 mm",
    "particles.shape": "sphere:5.1mm",
    "particles.count": 357,
    "motion.orientation": "horizontal",
    "law.friction": 0.5,
    "law.restitution_wall": 0.5,
    "law.tangential": "force",
    "law.contact_end": "force",
    "law.wall_curvature": True,
    "law.yielding": True,
    "particles.kind": [{"shape": "sphere:5mm", "count": 300}, {"shape": "sphere:4mm", "count": 9}],
    "law.youngs_modulus": "3 GPa",
    "law.density": "1 g/cm3",
    "fill.settle_time": "0.1 s",
    "fill.friction": False,
    "run.seed": 2,
    "run.time_step": "0.9 us",
}


@pytest.mark.parametrize("key", OF_THE_MOTION)
def test_packings_are_shared_by_motions(key):
    case = DamperCase.load("thesis", {key: OF_THE_MOTION[key]})
    assert packing_digest(case) == packing_digest(case_with())
    assert run_digest(case) != run_digest(case_with())


@pytest.mark.parametrize("key", OF_THE_PACKING)
def test_what_acts_while_settling_makes_another_packing(key):
    case = DamperCase.load("thesis", {key: OF_THE_PACKING[key]})
    assert packing_digest(case) != packing_digest(case_with())
    assert run_digest(case) != run_digest(case_with())


DISTRIBUTED = {"particles.size_distribution": "normal", "particles.size_deviation": "0.1 mm"}
SIEVED = {
    "particles.size_distribution": "sieve",
    "particles.sieve": [["4 mm", 0.0], ["5 mm", 0.5], ["6 mm", 1.0]],
}
ROLLING = {"law.rolling_friction": 0.1, "law.rolling_stiffness": "1e5 N/m"}
COHESIVE = {"law.cohesion": "dmt", "law.surface_energy": "0.05 J/m2"}
TOROIDS = {"particles.shape": "toroid:0.2"}
HOST = {"mass": "1 kg", "frequency": 20.0, "damping_ratio": 0.01}
CHANGED = {"mass": "2 kg", "frequency": 21.0, "damping_ratio": 0.02, "force": "2 N"}
MOVED = {"force": "1 N", "base_displacement": "1 mm", "base_acceleration": "1 g",
         "start_displacement": "1 mm", "start_velocity": "1 m/s"}  # fmt: skip


def test_all_keys_that_act_are_in_the_digests():
    """Every key of a case file is in one of the lists above, or changes no result by itself."""
    named = {"particles.material", "particles.materials", "enclosure.material"}  # by numbers
    other = {
        "enclosure.shape", "enclosure.width", "enclosure.depth",
        # of other shapes, and fill ratio: test_enclosure_cases.py
        "enclosure.top_diameter", "enclosure.across_flats", "enclosure.vertices",
        "enclosure.faces", "enclosure.file", "enclosure.unit", "enclosure.cells",
        "enclosure.cell_wall", "enclosure.walls", "particles.fill_ratio",
        "particles.equal_volume_radius", "particles.sub_spheres",
        "particles.tolerance", "particles.mesh_unit",
        "motion.gravity", "motion.kind",  # another kind: test_extend_motion.py
        "law.friction_wall", "law.restitution", "law.contact_treatment",
        "run.max_cycles", "output.frames",
        "host.modes",  # by its modes: test_host_cases.py
        "host.at", "host.shown",  # by shapes and the damper shown: test_several_dampers.py
        *(f"host.{key}" for key in (*HOST, *MOVED)),
        "host.inertia", "host.torque", "host.start_angle",  # as mass and force: test_host_cases.py
        *(f"excitation.{key}" for key in Excitation.model_fields),  # test_excitation_cases.py
        *DISTRIBUTED, *SIEVED, *ROLLING, "law.rolling_damping", *COHESIVE,
    }  # fmt: skip
    known = {f"{table}.{key}" for table, keys in known_keys(Settings).items() for key in keys}
    assert known == named | other | OF_THE_MOTION.keys() | OF_THE_PACKING.keys()
    twins = [
        ({}, {"enclosure.shape": "box", "enclosure.width": "40 mm", "particles.count": 358}),
        ({}, {"motion.gravity": [0, 1, 0]}),
        (TOROIDS, {**TOROIDS, "particles.sub_spheres": 49}),
        ({}, DISTRIBUTED),
        (DISTRIBUTED, {**DISTRIBUTED, "particles.size_deviation": "0.2 mm"}),
        ({}, SIEVED),
        (SIEVED, {**SIEVED, "particles.sieve": [["4 mm", 0.0], ["6 mm", 1.0]]}),
        ({}, ROLLING),
        (ROLLING, {**ROLLING, "law.rolling_friction": 0.2}),
        (ROLLING, {**ROLLING, "law.rolling_stiffness": "2e5 N/m"}),
        (ROLLING, {**ROLLING, "law.rolling_damping": "0.01 N s/m"}),
        ({}, COHESIVE),
        (COHESIVE, {**COHESIVE, "law.cohesion": "jkr"}),
        (COHESIVE, {**COHESIVE, "law.surface_energy": "0.1 J/m2"}),
        (TOROIDS, {**TOROIDS, "law.contact_treatment": "deepest"}),
        (TOROIDS, {**TOROIDS, "particles.equal_volume_radius": "3.4 mm"}),
        ({"law.friction": 0.5}, {"law.friction": 0.5, "law.friction_wall": 0.4}),
        ({"law.restitution": 0.5}, {"law.restitution_wall": 0.5}),
        ({"run.steady": True}, {"run.steady": True, "run.max_cycles": 61}),
        ({}, {"output.frames": 10}),
    ]
    ridden = {f"host.{key}": value for key, value in HOST.items()} | {"host.force": "1 N"}
    twins += [(ridden, {**ridden, f"host.{key}": value}) for key, value in CHANGED.items()]
    still = {key: value for key, value in ridden.items() if key != "host.force"}
    moved = [{**still, f"host.{key}": value} for key, value in MOVED.items()]
    twins += list(itertools.combinations(moved, 2))
    for first, second in twins:
        a, b = DamperCase.load("thesis", first), DamperCase.load("thesis", second)
        assert run_digest(a) != run_digest(b), second


@pytest.mark.parametrize(
    ("key", "spellings"),
    [
        ("enclosure.diameter", ["40 mm", "4 cm", "0.04 m", None]),
        ("particles.shape", ["sphere:5mm", "sphere:5 mm", "sphere: 0.005 m"]),
        ("law.density", ["1.19 g/cm3", "1190 kg/m3", None]),
        ("motion.direction", [[0, 0, 1], [0, 0, 2.5], None]),
        ("run.time_step", ["1 us", "1e-6 s", None]),
        ("fill.friction", [False, 0, 0.0, "0"]),
    ],
)
def test_one_case_in_other_words_is_the_same_run(key, spellings):
    assert len({run_digest(DamperCase.load("thesis", {key: text})) for text in spellings}) == 1


# The case as a file


def test_the_template_is_the_thesis_case():
    """Every key stands in it, and every value there is the default."""
    template = data_file("cases", "damper")
    assert template is not None
    case = DamperCase.load("damper")
    assert run_digest(case) == run_digest(case_with())
    text = template.read_text(encoding="utf-8")
    for key in itertools.chain.from_iterable(known_keys(Settings).values()):
        assert f"{key} = " in text


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"run.time_step": "0.7 us", "run.seed": 12, "motion.direction": [1, 2, 3]},
        {"enclosure.shape": "box", "enclosure.width": "3 cm", "motion.orientation": "none"},
        {"law.restitution": 0.7, "law.youngs_modulus": "1 GPa", "output.keep": "summary"},
        {"particles.shape": "sphere", "particles.equal_volume_radius": "3 mm"},
        {"particles.shape": "prolate:1.5", "particles.sub_spheres": 25},
    ],
)
def test_a_case_written_to_its_folder_is_the_same_run(tmp_path, changes):
    """to_toml and the copy of the materials give back every number: resuming needs it."""
    case = DamperCase.load("thesis", changes)
    for name, text in {**case.files, "case.toml": case.to_toml()}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    again = DamperCase.load(tmp_path / "case.toml")
    assert (again.name, again.count) == (case.name, case.count)
    assert run_digest(again) == run_digest(case)
    assert packing_digest(again) == packing_digest(case)
    assert again.to_toml() == case.to_toml()


def test_materials_count_by_their_numbers_not_by_their_files(tmp_path):
    acrylic = (data_root() / "materials" / "acrylic.toml").read_text(encoding="utf-8")
    for name, text in {"m.toml": acrylic, "n.toml": acrylic.replace("1.19", "1.2")}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    same, other = (case_with(particles__materials=str(tmp_path / n)) for n in ("m.toml", "n.toml"))
    assert run_digest(same) == run_digest(case_with())
    assert packing_digest(other) != packing_digest(case_with())


# Whatever stands in a case file


def words() -> st.SearchStrategy[Any]:
    return st.text(st.characters(exclude_categories=["Cs"]), max_size=8)


def anything() -> st.SearchStrategy[Any]:
    """What TOML can hold."""
    numbers = st.floats() | st.integers(-(2**63), 2**63 - 1)
    units = st.sampled_from(["m", "mm", "s", "us", "kg/m3", "GPa", "Pa", "1/s", "", "parsec"])
    quantities = st.builds(lambda x, u: f"{x!r} {u}", numbers, units)
    leaves = numbers | quantities | words() | st.booleans() | st.dates() | st.datetimes()
    return leaves | st.lists(leaves, max_size=4) | st.dictionaries(words(), leaves, max_size=2)


PLAUSIBLE: dict[str, st.SearchStrategy[Any]] = {
    "enclosure.shape": st.sampled_from(["cylinder", "box"]),
    "particles.shape": st.builds(
        lambda x, u: f"sphere:{x!r}{u}", st.floats(0), st.sampled_from(["mm", "m", "km"])
    ),
    "particles.count": st.integers(1, 10**7),
    "particles.material": st.sampled_from(["acrylic", "steel", "wood"]),
    "enclosure.material": st.sampled_from(["acrylic", "steel", "wood"]),
    "particles.materials": st.sampled_from(["acrylic", "steel", "wood", "glass"]),
    "motion.orientation": st.sampled_from(["vertical", "horizontal", "none"]),
    "motion.frequency": st.floats(0, exclude_min=True),
    "motion.gamma": st.floats(0, exclude_min=True),
    "motion.ramp": st.floats(0),
    "motion.direction": st.lists(st.floats(), min_size=3, max_size=3),
    "motion.gravity": st.lists(st.floats(), min_size=3, max_size=3),
    "law.friction": st.floats(0),
    "law.restitution": st.floats(0, 1),
    "law.yielding": st.booleans(),
    "run.cycles": st.integers(1, 10**6),
    "run.discard": st.integers(0, 10),
    "run.steady": st.booleans(),
    "output.samples": st.integers(8, 10_000),
    "output.frames": st.integers(0, 100),
    **{
        f"{key}": st.builds(lambda x, u=unit: f"{x!r} {u}", st.floats(0))
        for key, unit in {
            "enclosure.diameter": "mm",
            "enclosure.height": "mm",
            "enclosure.width": "mm",
            "law.density": "kg/m3",
            "law.youngs_modulus": "Pa",
            "run.time_step": "us",
            "fill.settle_time": "s",
        }.items()
    },
}


def any_changes() -> st.SearchStrategy[dict[str, Any]]:
    keys = [f"{table}.{key}" for table, keys in known_keys(Settings).items() for key in keys]
    likely = st.sampled_from(sorted(PLAUSIBLE)).flatmap(
        lambda key: st.tuples(st.just(key), PLAUSIBLE[key])
    )
    unlikely = st.tuples(st.sampled_from(keys) | words(), anything())
    return st.lists(likely | likely | unlikely, max_size=6).map(dict)


def case_or_line(changes: dict[str, Any]) -> DamperCase | str:
    try:
        return DamperCase.load("thesis", changes)
    except InputError as error:
        return str(error)


@given(any_changes())
@example({"motion.direction": [0.0, 1.0, math.nan]})
@example({"law.density": "5e305 kg/m3"})
@settings(deadline=None, max_examples=examples(80))
def test_whatever_stands_in_a_case_file_is_resolved_or_refused_in_one_line(changes):
    """A case is all finite numbers and can be reported; else one line says what is wrong."""
    from damper3d.view.report import echo

    found = case_or_line(changes)
    if isinstance(found, str):
        assert "\n" not in found
        assert len(found) < 1200  # the longest lists all keys, and the one that is not known
        return
    case = found
    assert case.time_step > 0
    assert case.mass > 0
    assert np.linalg.norm(case.direction) == pytest.approx(1)
    assert echo(case, dry_run=True)
    assert plan(case)["steps"] > 0
    assert run_digest(case)


def any_settings() -> st.SearchStrategy[Settings]:
    """Settings of any values that their ranges allow, whether or not a damper can have them."""
    sizes = st.floats(min_value=0, exclude_min=True, allow_infinity=False)
    lengths = st.floats(SMALLEST, LARGEST)
    finite = st.floats(allow_nan=False, allow_infinity=False)
    vectors = st.lists(finite, min_size=3, max_size=3)
    tables = {
        "enclosure": {"diameter": st.none() | lengths, "height": lengths, "material": words()},
        "particles": {"shape": words(), "count": st.none() | st.integers(1, 10**7)},
        "motion": {
            "gamma": sizes,
            "direction": st.none() | vectors,
        },
        "law": {
            "friction": st.none() | st.floats(0, 1000),
            "yielding": st.booleans(),
            "density": sizes,
        },
        "fill": {"settle_time": sizes},
        "run": {"seed": st.integers(0, 2**63 - 1), "time_step": st.none() | sizes},
        "output": {"frames": st.integers(0, 10_000)},
    }
    fields = Settings.model_fields
    built = {
        name: st.fixed_dictionaries(table).map(
            lambda values, name=name: fields[name].annotation.model_construct(**values)
        )
        for name, table in tables.items()
    }
    return st.fixed_dictionaries(built).map(lambda parts: Settings.model_construct(**parts))


@given(any_settings())
@settings(deadline=None)
def test_settings_survive_the_file_to_the_last_bit(given_settings):
    """Any text is escaped, any float written with all its digits and its unit."""
    document = tomllib.loads(to_toml(given_settings))
    assert document.pop("schema") == 1
    assert check_settings(document, "case.toml").model_dump() == given_settings.model_dump()


def test_a_file_in_a_folder_that_is_no_folder(tmp_path):
    for name in (str(tmp_path), str(tmp_path / "none.toml"), "x" * 5000, "\0", ""):
        with pytest.raises(InputError):
            DamperCase.load(name)
        with pytest.raises(InputError):
            case_with(particles__materials=name)
    assert Path(tmp_path).is_dir()
