"""Beds of unlike spheres and the rules of their contacts, as a case resolves them."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from damper_runs import small
from made_meshes import CUBE, CUBE_FACES, write_obj
from refusals import assert_refuses
from small_damper import damper3d
from small_silo import DRY

from damper3d.case.case import DamperCase
from damper3d.case.contacts import restitution_of_loss
from damper3d.engine.records import CLASSES
from damper3d.run.packing import packing_folder
from damper3d.run.protocol import run_digest
from damper3d.shapes.particle import parse_particle
from damper3d.studies.pack.computed import pack
from damper3d.view.report import echo
from granulab.contact.restitution import ratio_of_restitution
from granulab.contact.timestep import rayleigh_time_step

MATERIALS = """
schema = 1
[material.steel]
density = "7860 kg/m3"
youngs_modulus = "206 GPa"
poisson = 0.3
yield_strength = "1350 MPa"
[material.nylon]
density = "1150 kg/m3"
youngs_modulus = "2 GPa"
poisson = 0.4
[material.rubber]
density = "1100 kg/m3"
youngs_modulus = "6 MPa"
poisson = 0.49
loss_factor = 0.4
[pair.steel-steel]
friction = 0.4
restitution = 0.9
[pair.nylon-steel]
friction = 0.3
restitution = 0.7
[pair.nylon-nylon]
friction = 0.2
restitution = 0.8
[pair.rubber-rubber]
friction = 0.9
"""


@pytest.fixture(scope="module")
def materials(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("materials") / "mine.toml"
    path.write_text(MATERIALS, encoding="utf-8")
    return path


def made(materials: Path, **changes: Any) -> DamperCase:
    """The thesis's damper of steel, with changes such as motion__gamma=5."""
    usual = {
        "particles.materials": str(materials),
        "particles.material": "steel",
        "enclosure.material": "steel",
    }
    return DamperCase.load("thesis", usual | {k.replace("__", "."): v for k, v in changes.items()})


# Restitution that falls


@pytest.mark.parametrize(("gamma", "falls"), [(3.0, False), (5.0, True)])
def test_restitution_falls_where_common_impacts_yield(materials, gamma, falls):
    """v_y of steel, 0.15 m/s, is below half of the largest relative velocity 2 Gamma g/omega
    from Gamma 3.8 on at 40 Hz; against the wall it is twice that, so from 7.6 on."""
    case = made(materials, motion__gamma=gamma)
    pair, wall = case.pairings
    assert pair.falls == falls
    assert not wall.falls
    assert falls == (pair.yield_velocity < case.peak_speed)
    assert math.isinf(wall.law.yielding)
    assert math.isinf(pair.law.yielding) == (not falls)


def test_the_rule_gives_way_to_the_case_and_to_the_table(materials, tmp_path):
    """yielding says it for all; restitution_model = "constant" for a pair; no strength, no fall."""
    for yielding in (True, False):
        case = made(materials, motion__gamma=5.0, law__yielding=yielding)
        assert [pairing.falls for pairing in case.pairings] == [yielding] * 2
    same = tmp_path / "constant.toml"
    steel = "[pair.steel-steel]\n"
    text = MATERIALS.replace(steel, f'{steel}restitution_model = "constant"\n')
    same.write_text(text, encoding="utf-8")
    assert not any(one.falls for one in made(same, motion__gamma=50.0).pairings)
    soft = made(materials, particles__material="nylon", enclosure__material="nylon")
    assert [(one.falls, one.yield_velocity) for one in soft.pairings] == [(False, None)] * 2
    thesis = DamperCase.load("thesis", {"motion.gamma": 200})
    assert not any(one.falls for one in thesis.pairings), "acrylic is constant in the thesis"


def test_the_echo_names_rule_and_numbers(materials):
    given = ["--material", materials, "--restitution", "0.9"]
    assert damper3d("run", *given, "--dry-run").code == 2  # several materials: a case file says
    steel = ["--material", "steel", "--restitution", "0.9", *DRY]
    words = " ".join(damper3d("run", *steel, "--gamma", "5").out.split())
    assert "particles 0.149 m/s: restitution falls, as that is below half of the largest" in words
    assert "walls 0.298 m/s: restitution constant, as that is not below half" in words
    plan = damper3d("run", *steel, "--gamma", "5", "--json").json
    assert [one["restitution_falls"] for one in plan["pairs"]] == [True, False]
    off = damper3d("run", *steel, "--gamma", "5", "--no-yielding", "--json").json
    assert [one["restitution_falls"] for one in off["pairs"]] == [False, False]


def test_the_echo_names_the_pairs_of_two_kinds_that_are_alike(materials):
    ball = {"shape": "sphere:4mm", "count": 20, "material": "steel"}
    lines = echo(made(materials, particles__kind=[ball, ball]), dry_run=False).splitlines()
    laws = [line.split()[1] for line in lines if line.startswith("  law ")]
    assert laws == ["1-1", "1-2", "2-2", "1-wall", "2-wall"]


# Loss factor


def test_a_loss_factor_gives_the_damping_of_a_contact(materials):
    """zeta = eta/2, and e = exp(-pi zeta/sqrt(1 - zeta^2)); softer means its own loss counts."""
    case = made(materials, particles__material="rubber", enclosure__material="rubber")
    assert case.pair_law.damping == pytest.approx(0.2, rel=1e-12)
    e = case.restitution[CLASSES[0]]
    assert e == pytest.approx(math.exp(-math.pi * 0.2 / math.sqrt(1 - 0.04)), rel=1e-12)
    for loss in (0.01, 0.4, 1.5):
        assert ratio_of_restitution(restitution_of_loss(loss)) == pytest.approx(loss / 2)
    given = made(materials, particles__material="rubber", enclosure__material="rubber",
                 law__restitution=0.5)  # fmt: skip
    assert set(given.restitution.values()) == {0.5}


# Sizes


def distributed(materials: Path, **changes: Any) -> DamperCase:
    usual = {"particles__count": 2000, "enclosure__diameter": "90 mm",
             "enclosure__height": "90 mm", "particles__shape": "sphere:4mm"}  # fmt: skip
    return made(materials, **usual | changes)


def test_another_seed_draws_the_sizes_that_a_case_of_that_seed_has(materials, tmp_path):
    """As in sweeps, maps and reproduced tables; all that follows from the sizes goes with them."""
    wide = {"particles__size_distribution": "normal", "particles__size_deviation": "0.8 mm"}
    case, other = (made(materials, **wide, run__seed=seed) for seed in (1, 2))
    again = case.with_seed(2)
    assert np.array_equal(again.radii, other.radii)
    assert (again.mass, again.steps) == (other.mass, other.steps)
    assert run_digest(again) == run_digest(other) != run_digest(case)
    (tmp_path / "case.toml").write_text(again.to_toml(), encoding="utf-8")
    for name, text in again.files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert run_digest(DamperCase.load(tmp_path / "case.toml")) == run_digest(other)


def test_a_packing_serves_all_motions_where_the_restitution_falls_by_itself(materials):
    """Of steel it falls from Gamma 4 on: by the motion, which the settling has not begun."""
    slow, fast = (made(materials, motion__gamma=gamma) for gamma in (1.0, 20.0))
    assert not slow.pairings[0].falls
    assert fast.pairings[0].falls
    assert packing_folder(fast, Path()) == packing_folder(slow, Path())
    assert fast.settling.pair_law == slow.pair_law != fast.pair_law
    given, held = (made(materials, motion__gamma=20.0, law__yielding=on) for on in (True, False))
    assert len({run_digest(one) for one in (given, fast, held)}) == 3  # its packing differs, too
    assert given.settling.pair_law == given.pair_law


@pytest.mark.parametrize("shape", ["prolate:1.5", "toroid:0.2"])
def test_sizes_that_are_spread_leave_the_usual_number_of_particles(materials, shape):
    alike = made(materials, particles__shape=shape)
    spread = made(materials, particles__shape=shape, particles__size_distribution="normal",
                  particles__size_deviation="0.001 mm")  # fmt: skip
    assert spread.count == alike.count


@pytest.mark.parametrize("kind", ["normal", "lognormal"])
def test_diameters_are_distributed_as_asked(materials, kind):
    """Mean and deviation by number; even quantiles leave 1/n of the deviation of the mean, and
    cutting at 3 deviations takes 1.4 % of the deviation. Another seed draws other sizes."""
    case = distributed(materials, particles__size_distribution=kind,
                       particles__size_deviation="0.5 mm")  # fmt: skip
    diameter = 2 * case.radii
    values = np.log(diameter) if kind == "lognormal" else diameter
    assert diameter.mean() == pytest.approx(4e-3, rel=2e-3)
    assert diameter.std() == pytest.approx(0.5e-3, rel=0.03)
    skew = ((values - values.mean()) ** 3).mean() / values.std() ** 3
    assert abs(skew) < 0.02  # symmetrical, in the logarithm where that is normal
    assert case.mass == pytest.approx(case.masses.sum(), rel=1e-12)
    assert case.fill_ratio == pytest.approx(
        (4 / 3 * np.pi * case.radii**3).sum() / case.enclosure.volume, rel=1e-12
    )
    again, other = (
        distributed(materials, particles__size_distribution=kind,
                    particles__size_deviation="0.5 mm", run__seed=seed) for seed in (1, 2)
    )  # fmt: skip
    assert np.array_equal(again.radii, case.radii)
    assert not np.array_equal(other.radii, case.radii)
    assert run_digest(again) == run_digest(case)


def test_a_sieve_table_is_met_by_mass(materials):
    """The share of the mass that passes each sieve, and half of a class at its middle."""
    table = [["2 mm", 0.0], ["3 mm", 0.25], ["5 mm", 1.0]]
    case = distributed(materials, particles__size_distribution="sieve", particles__sieve=table,
                       particles__shape="sphere")  # fmt: skip
    diameter, mass = 2 * case.radii, case.masses
    for size, passing in ((3e-3, 0.25), (4e-3, 0.625), (2.5e-3, 0.125)):
        assert mass[diameter < size].sum() / mass.sum() == pytest.approx(passing, abs=2e-3)
    assert diameter.min() >= 2e-3
    assert diameter.max() <= 5e-3


# Mixtures


def kinds(*tables: dict[str, Any]) -> dict[str, Any]:
    return {"particles__kind": list(tables)}


STEEL, NYLON = {"shape": "sphere:5mm"}, {"shape": "sphere:4mm", "material": "nylon"}
PROLATE = {"shape": "prolate:1.5", "count": 30}


def test_a_mixture_by_mass_has_these_masses(materials):
    """Within half a sphere of each kind; the usual fill ratio of 7/15 within a sphere's volume."""
    case = made(materials, **kinds(STEEL | {"mass_fraction": 0.7}, NYLON | {"mass_fraction": 0.3}))
    steel, nylon = case.bed.described()
    assert steel["mass_fraction"] == pytest.approx(0.7, abs=0.005)
    assert (steel["material"], nylon["material"]) == ("steel", "nylon")
    assert steel["count"] + nylon["count"] == case.count == len(case.radii)
    assert case.fill_ratio == pytest.approx(7 / 15, abs=2e-3)
    assert case.mass == pytest.approx(steel["mass_kg"] + nylon["mass_kg"], rel=1e-12)


def test_each_pair_of_materials_has_its_own_law(materials):
    """Friction, restitution and modulus of steel-steel, steel-nylon, nylon-nylon, and the walls;
    by kinds in the engine's table, and the enclosure is the last kind."""
    case = made(materials, **kinds(STEEL | {"count": 20}, NYLON | {"count": 30}))
    found = [(one.materials, one.of_wall, one.law.mu, one.restitution) for one in case.pairings]
    assert found == [
        (("steel", "steel"), False, 0.4, 0.9),
        (("steel", "nylon"), False, 0.3, 0.7),
        (("nylon", "nylon"), False, 0.2, 0.8),
        (("steel", "steel"), True, 0.4, 0.9),
        (("nylon", "steel"), True, 0.3, 0.7),
    ]
    table, _ = case.laws(case.count)
    assert table.number.tolist() == [[0, 1, 3], [1, 2, 4], [3, 4, 0]]
    assert np.bincount(table.kind).tolist() == [20, 30, 1]
    assert table.constants[1, 0] == case.pairings[1].law.hertz
    stiffer, softer = case.pairings[0].law.hertz, case.pairings[2].law.hertz
    assert softer < case.pairings[1].law.hertz < stiffer


def test_a_mixture_survives_its_run_folder(materials, tmp_path):
    """case.toml of a run folder gives the same digest, whatever rounding by mass did."""
    for fraction in (0.31, 0.5, 0.77):
        case = made(materials, **kinds(
            STEEL | {"mass_fraction": fraction, "size_distribution": "normal",
                     "size_deviation": "0.2 mm"},
            NYLON | {"mass_fraction": 1 - fraction},
        ))  # fmt: skip
        (tmp_path / "case.toml").write_text(case.to_toml(), encoding="utf-8")
        (tmp_path / "materials.toml").write_text(MATERIALS, encoding="utf-8")
        assert run_digest(DamperCase.load(tmp_path / "case.toml")) == run_digest(case)


# Mixtures of shapes


def test_kinds_of_other_shapes_have_laws_and_masses_of_their_own(materials):
    """Pairs of materials as for spheres, looked up by sub-sphere; by mass within half a particle;
    and cycles as the thesis has them for shapes."""
    case = made(materials, **kinds(
        STEEL | {"mass_fraction": 0.6},
        {"shape": "oblate:0.7", "material": "nylon", "equal_volume_radius": "3 mm",
         "sub_spheres": 20, "mass_fraction": 0.4},
    ), enclosure__diameter="60 mm")  # fmt: skip
    steel, nylon = case.bed.described()
    assert nylon["mass_fraction"] == pytest.approx(0.4, abs=1.0 / nylon["count"])
    assert nylon["diameter_m"]["mean"] == pytest.approx(6e-3, rel=1e-12)
    table, _ = case.laws(case.count)
    assert np.bincount(table.kind).tolist() == [steel["count"], 20 * nylon["count"], 1]
    assert table.constants[1, 0] == case.pairings[1].law.hertz
    assert case.pairings[2].mass == pytest.approx(0.5 * nylon["mass_kg"] / nylon["count"])
    assert case.settings.run.cycles == 18
    assert made(materials, **kinds(STEEL | {"count": 20})).settings.run.cycles == 8


def test_walls_of_another_material_know_every_sub_sphere(materials):
    case = made(materials, particles__shape="prolate:1.5", enclosure__walls={"bottom": "nylon"})
    table, _ = case.laws(case.count)
    assert np.bincount(table.kind).tolist() == [51 * case.count, 0, 1]  # the last looks at a wall


def test_the_step_of_a_mixture_is_that_of_its_swiftest_contact(materials):
    """A spheroid's as of spheroids alone. A sphere meets at most as many sub-spheres at once as
    the spheroid does of a wall, so that its limit is its own over the same ratio."""
    alone = {
        shape: made(materials, particles__shape=shape) for shape in ("sphere:4mm", "prolate:3")
    }
    limit = {shape: case.steps.limit for shape, case in alone.items()}
    spheroid = alone["prolate:3"]
    faster = rayleigh_of(spheroid.particle.equal_volume_radius) / limit["prolate:3"]
    assert faster > 2.0
    mixed = made(materials, **kinds({"shape": "sphere:4mm", "count": 30}, PROLATE))
    large = made(materials, **kinds({"shape": "sphere:30mm", "count": 1},
                                    {"shape": "prolate:3", "count": 5}))  # fmt: skip
    assert large.steps.limit == limit["prolate:3"]
    own = made(materials, particles__shape="prolate:1.5").steps
    faster = rayleigh_of(3.8e-3) / own.limit
    assert mixed.steps.limit == pytest.approx(limit["sphere:4mm"] / faster, rel=1e-9)
    assert mixed.time_step < min(own.time_step, alone["sphere:4mm"].time_step)


def rayleigh_of(radius: float) -> float:
    """Rayleigh's step of a sphere of the table's steel [s]."""
    return rayleigh_time_step(radius, 7860.0, 206e9, 0.3)


def test_a_shape_is_scaled_to_its_sizes(materials):
    """Volumes go as the third power of the diameters drawn; offsets and radii as the first."""
    case = distributed(materials, particles__shape="prolate:2", particles__count=300,
                       particles__equal_volume_radius="2 mm", particles__sub_spheres=9,
                       particles__size_distribution="normal",
                       particles__size_deviation="0.5 mm")  # fmt: skip
    assert (2.0 * case.radii).mean() == pytest.approx(4e-3, rel=2e-3)
    assert (2.0 * case.radii).std() == pytest.approx(0.5e-3, rel=0.03)
    mean = parse_particle("prolate:2", 2e-3, sub_spheres=9)
    for one, radius in zip(case.bed.particles, case.radii.tolist(), strict=True):
        assert one.volume == pytest.approx(4 / 3 * math.pi * radius**3, rel=1e-12)
        assert one.offsets == pytest.approx(mean.offsets * radius / 2e-3, rel=1e-12)
        assert one.inertia == pytest.approx(mean.inertia * (radius / 2e-3) ** 5, rel=1e-12)
    assert case.mass == pytest.approx(case.masses.sum(), rel=1e-12)
    smallest = case.bed.sorts[0].smallest.smallest_radius
    assert case.steps.rayleigh == pytest.approx(rayleigh_of(smallest), rel=1e-12)


def test_a_mixture_of_shapes_survives_its_run_folder(materials, tmp_path):
    """With a mesh, of which the folder has a copy; a multi-contact model names another run."""
    write_obj(tmp_path / "cube.obj", CUBE, CUBE_FACES)
    mesh = {"shape": f"mesh:{tmp_path / 'cube.obj'}", "count": 4, "tolerance": 0.2}
    case = made(materials, **kinds(PROLATE, mesh | {"equal_volume_radius": "3 mm"}))
    run = tmp_path / "run"
    run.mkdir()
    (run / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    for name, text in case.files.items():
        (run / name).write_text(text, encoding="utf-8")
    assert "mesh:cube.obj" in case.to_toml()
    assert run_digest(DamperCase.load(run / "case.toml")) == run_digest(case)
    deepest = made(
        materials, law__contact_treatment="deepest", **kinds(STEEL | {"count": 9}, PROLATE)
    )
    assert run_digest(deepest) != run_digest(
        made(materials, **kinds(STEEL | {"count": 9}, PROLATE))
    )


def test_packings_of_a_mixture_are_refused(materials):
    """The sphere of the mean volume, by which it is described, packs otherwise."""
    changes = {"particles.kind": [STEEL | {"count": 9}, PROLATE], "particles.material": "steel",
               "particles.materials": str(materials), "enclosure.material": "steel"}  # fmt: skip
    assert_refuses(["particles that are all alike"], pack, "thesis", changes, out=Path())


def test_meshes_of_one_name_that_differ_are_refused(materials, tmp_path):
    for name, size in (("a", 1.0), ("b", 2.0)):
        (tmp_path / name).mkdir()
        write_obj(tmp_path / name / "rock.obj", size * CUBE, CUBE_FACES)
    rocks = [{"shape": f"mesh:{tmp_path / name / 'rock.obj'}", "count": 3, "tolerance": 0.2}
             for name in "ab"]  # fmt: skip
    words = ["[[particles.kind]] 2", "'rock'", "rename"]
    assert_refuses(words, made, materials, **kinds(*rocks))


NORMAL = {"particles__size_distribution": "normal"}
HALF = [{"shape": "sphere:5mm", "mass_fraction": 0.5}, {"shape": "sphere:4mm"}]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (kinds(HALF[0], HALF[1] | {"mass_fraction": 0.4}), ["add up to 0.9", "must add up to 1"]),
        (kinds(*HALF), ["every kind a count, or every kind a mass_fraction"]),
        (kinds(HALF[0], HALF[1] | {"count": 3}), ["every kind a count"]),
        (kinds(HALF[0] | {"mass_fraction": -0.5}), ["mass_fraction", "greater than 0"]),
        (kinds(HALF[0] | {"mass_fraction": 1.5}), ["mass_fraction", "1.5"]),
        (kinds(STEEL | {"count": 0}), ["count", "0"]),
        (kinds(STEEL | {"count": 3}) | {"particles__count": 5}, ["count", "both given"]),
        (kinds(STEEL | {"count": 3}) | {"particles__shape": "sphere:3mm"}, ["shape", "both given"]),
        (kinds(STEEL | {"count": 3, "material": "unobtainium"}), ["unobtainium", "known"]),
        (kinds(STEEL | {"count": 3, "material": "rubber"}), ["pair.rubber-steel", "friction"]),
        (kinds(STEEL | {"count": 3, "weight": 3}), ["unknown key 'weight'"]),
        (kinds({"shape": "brick", "count": 3}), ["[[particles.kind]] 1", "brick", "unknown"]),
        (kinds({"shape": "prolate", "count": 3}), ["[[particles.kind]] 1", "aspect ratio"]),
        (kinds(STEEL, {"shape": "mesh:none.stl", "count": 3}), ["particles.kind]] 2", "none.stl"]),
        (kinds(STEEL | {"equal_volume_radius": "2 mm", "count": 3}), ["has a size", "given too"]),
        (kinds(STEEL | {"sub_spheres": 5, "count": 3}), ["sub_spheres goes with other shapes"]),
        (kinds(PROLATE | {"sub_spheres": 4}), ["[[particles.kind]] 1", "must be odd"]),
        (kinds(PROLATE | {"mesh_unit": "mm"}), ["mesh_unit goes with a mesh"]),
        (kinds(PROLATE) | {"particles__sub_spheres": 51}, ["sub_spheres", "say it in each kind"]),
        (kinds(PROLATE | {"equal_volume_radius": "-1 mm"}), ["equal_volume_radius", "than 0"]),
        (kinds({"shape": "prolate:9", "equal_volume_radius": "10 mm", "count": 1}),
         ["smaller than a particle", "86.535 mm"]),
        (kinds(STEEL | {"count": 9}, PROLATE) | {"enclosure__cells": [2, 2],
                                                 "enclosure__cell_wall": "1 mm"},
         ["particles that are all alike"]),
        (kinds(STEEL | {"count": 9}, PROLATE) | {"law__rolling_friction": 0.1,
                                                 "law__rolling_stiffness": "1e4 N/m"},
         ["rolling_friction is of spheres"]),
        (kinds(STEEL | {"count": 9}, PROLATE) | {"law__cohesion": "jkr",
                                                 "law__surface_energy": "0.05 J/m2"},
         ["cohesion is of spheres"]),
        (kinds({"shape": "sphere:-5mm", "count": 3}), ["[[particles.kind]] 1", "above 0"]),
        (kinds(), ["holds no kind"]),
        (kinds({"shape": "sphere:50mm", "count": 3}), ["smaller than a particle"]),
        (kinds(STEEL | {"count": 5000}), ["fill ratio", "above 1"]),
        (kinds(STEEL | {"mass_fraction": 0.99999}, NYLON | {"mass_fraction": 1e-5}),
         ["[[particles.kind]] 2", "less than one particle"]),
        (NORMAL, ["size_deviation is missing"]),
        (NORMAL | {"particles__size_deviation": "2 mm"}, ["wider than its mean", "lognormal"]),
        (NORMAL | {"particles__size_deviation": "-1 mm"}, ["size_deviation", "greater than 0"]),
        ({"particles__size_distribution": "lognormal", "particles__size_deviation": "5 mm"},
         ["wider than its mean"]),
        ({"particles__size_deviation": "1 mm"}, ["size_distribution is missing"]),
        ({"particles__size_distribution": "sieve"}, ["sieve is missing"]),
        ({"particles__sieve": [["1 mm", 0.0], ["2 mm", 1.0]]}, ["size_distribution = 'sieve'"]),
        ({"particles__size_distribution": "sieve", "particles__shape": "sphere:3mm",
          "particles__sieve": [["1 mm", 0.0], ["2 mm", 1.0]]}, ["write shape = 'sphere'"]),
        ({"particles__size_distribution": "sieve",
          "particles__sieve": [["2 mm", 0.0], ["1 mm", 1.0]]}, ["ascend"]),
        ({"particles__size_distribution": "sieve",
          "particles__sieve": [["1 mm", 0.0], ["2 mm", 0.9]]}, ["rise from 0", "to 1"]),
        ({"particles__size_distribution": "sieve", "particles__shape": "toroid:0.2",
          "particles__sieve": [["1 mm", 0.0], ["2 mm", 1.0]]},
         ["by their width", "'normal' or 'lognormal'"]),
        ({"particles__size_distribution": "sieve", "particles__equal_volume_radius": "2 mm",
          "particles__sieve": [["1 mm", 0.0], ["2 mm", 1.0]]}, ["no equal_volume_radius"]),
        (NORMAL | {"particles__shape": "toroid:0.2", "particles__size_deviation": "3 mm"},
         ["wider than its mean of 7 mm"]),
    ],
)  # fmt: skip
def test_sizes_and_kinds_that_cannot_be_are_refused(materials, changes, words):
    assert_refuses(words, made, materials, **changes)


ROLLING = {"law__rolling_friction": 0.1, "law__rolling_stiffness": "1e4 N/m"}
JKR = {"law__cohesion": "jkr", "law__surface_energy": "0.05 J/m2"}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law__cohesion": "jkr"}, ["surface_energy is missing"]),
        ({"law__surface_energy": "0.05 J/m2"}, ["goes with cohesion"]),
        ({"law__cohesion": "glue"}, ["cohesion", "'dmt' or 'jkr'"]),
        (JKR | {"law__surface_energy": "-1 J/m2"}, ["surface_energy", "greater than 0"]),
        (JKR | {"law__surface_energy": "1 N"}, ["surface_energy", "unit is wrong"]),
        (JKR | {"law__contact_end": "force"}, ["lets nothing pull"]),
        (JKR | {"law__tangential": "force"}, ["tangential = 'force'", "'displacement'"]),
        (JKR | {"particles__shape": "prolate:1.5"}, ["cohesion is of spheres"]),
        (ROLLING | {"particles__shape": "prolate:1.5"}, ["rolling_friction is of spheres"]),
        ({"law__rolling_friction": 0.1}, ["rolling_stiffness is missing"]),
        ({"law__rolling_stiffness": "1e4 N/m"}, ["rolling_friction is missing"]),
        ({"law__rolling_damping": "1 N s/m"}, ["rolling_friction is missing"]),
        (ROLLING | {"law__rolling_friction": -0.1}, ["rolling_friction", "equal to 0"]),
        (ROLLING | {"law__rolling_stiffness": "1e9 N/m"}, ["more than steps of", "at most"]),
        (ROLLING | {"law__rolling_damping": "1e3 N s/m"}, ["more than steps of", "at most"]),
    ],
)
def test_options_of_a_law_that_do_not_go_together_are_refused(changes, words):
    named = {key.replace("__", "."): value for key, value in changes.items()}
    assert_refuses(words, DamperCase.load, "thesis", named)


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (("loss_factor = 0.4", "loss_factor = -0.4"), ["loss_factor", "above 0 and below 2"]),
        (("loss_factor = 0.4", "loss_factor = 2.5"), ["loss_factor", "above 0 and below 2"]),
        (("loss_factor = 0.4\n", ""), ["pair.rubber-rubber", "restitution"]),
        (("friction = 0.9", 'friction = 0.9\nrestitution_model = "falling"'),
         ["restitution_model", "'constant'"]),
    ],
)  # fmt: skip
def test_a_materials_table_that_says_what_cannot_be_is_refused(tmp_path, edit, words):
    path = tmp_path / "mine.toml"
    assert edit[0] in MATERIALS
    path.write_text(MATERIALS.replace(*edit), encoding="utf-8")
    assert_refuses(words, made, path, particles__material="rubber", enclosure__material="rubber")


def test_options_that_are_off_leave_the_digests_as_they_are():
    """The thesis's damper, and the small one, of versions before there were kinds and rules."""
    assert run_digest(DamperCase.load("thesis")) == "343971afec99"
    assert run_digest(small()) == "6ed976cc17a4"
