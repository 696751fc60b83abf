"""A stranger's own silo: what its filling chooses, when its step is shortened, what is refused."""

import contextlib
import dataclasses
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from heaps import silent, small_case
from own_silos import tried
from refusals import refusal
from same_run import assert_same_run
from small_silo import DischargeStop, the_run, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.errors import SimulationError, Stopped
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.filling import rain_of
from silo2d.run import discharge, protocol
from silo2d.run.ending import Clock
from silo2d.run.pour import pour, rain

SOFT = {"law.kn": "10 N/mm", "law.keep_ratios": True}


@pytest.mark.parametrize(
    ("kn", "chosen"),
    [("1e4 N/mm", "quarter"), ("2e2 N/mm", "landing"), ("1.5e4 N/mm", "quarter")],
)
def test_the_rain_lands_at_most_a_third_of_the_spheroradius_deep(tmp_path, kn, chosen):
    """m g h = kn overlap^2/2 for the heaviest particle and the farthest fall of the rain."""
    case = small_case(tmp_path)
    materials = case.files["materials.toml"].replace("1.0e4 N/mm", kn)
    (tmp_path / "own.toml").write_text(materials, encoding="utf-8")
    case = small_case(tmp_path, {"particles.materials": str(tmp_path / "own.toml")})
    _, poses, _ = rain(case, np.random.default_rng(1))
    fall = poses[:, 1].max() - case.settings.fill.level
    heaviest = case.surface_density * max(shape.area for shape in case.shapes.shapes)
    kn_filling = case.pour_laws[0].kn
    overlap = math.sqrt(2 * heaviest * GRAVITY * fall / kn_filling)
    assert overlap < 0.3 * case.shapes.shapes[0].spheroradius
    if chosen == "quarter":
        assert kn_filling == case.particle_law.kn / 4
    else:
        assert kn_filling > case.particle_law.kn
    # The ratios of the file are held, and so is its restitution: none is damped too little.
    law, own = case.pour_laws[0], case.particle_law
    assert law.kt / law.kn == pytest.approx(own.kt / own.kn, rel=1e-12)
    assert law.gamma_n / math.sqrt(law.kn) == pytest.approx(own.gamma_n / math.sqrt(own.kn))


@pytest.mark.parametrize("layer", [None, "30 mm"])
def test_the_fall_of_the_rain_is_that_of_its_highest_particle(tmp_path, layer):
    """Never less, and a pitch more: what stands on the level falls as well."""
    case = small_case(tmp_path, {} if layer is None else {"fill.layer": layer})
    found = rain_of(case.outline, case.shapes, case.surface_density, case.settings.fill)
    _, poses, _ = rain(case, np.random.default_rng(1))
    fall = poses[:, 1].max() - case.settings.fill.level
    if layer is None:
        assert 0 < found.fall - fall <= 2.05 * case.shapes.bounding_radius * 1.001
    else:
        assert found.fall < fall  # of thinner rain


def test_a_filling_too_soft_is_poured_again_stiffer(tmp_path):
    """A four-hundredth of what is chosen does not stop the rain; the same goes every time."""
    case = small_case(tmp_path)
    softer = tuple(
        law._replace(kn=law.kn / 400, gamma_n=law.gamma_n / 20) for law in case.pour_laws
    )
    soft = dataclasses.replace(case, pour_laws=softer)
    first, second = pour(soft, 1, silent), pour(soft, 1, silent)
    assert first.attempts > 1
    assert first.attempts == second.attempts
    np.testing.assert_array_equal(first.poses, second.poses)


@pytest.fixture(scope="module")
def tight(tmp_path_factory):
    """A root of runs, and a case whose energy must close better than it does in its chosen step."""
    folder = tmp_path_factory.mktemp("tight")
    return write_case(folder, {"run.time_step": None, "run.max_time": "0.1 s"}), folder / "runs"


def _strictly(monkeypatch, tolerance: float) -> None:
    monkeypatch.setitem(discharge.ENERGY_TOLERANCE, "chosen", tolerance)
    monkeypatch.setitem(discharge.ENERGY_TOLERANCE, "given", tolerance)


def test_a_chosen_step_is_halved_until_the_energy_closes(tight, monkeypatch, tmp_path):
    """The same bits however often the run is stopped; a step that is given is never changed."""
    file, root = tight
    case = SiloCase.load(file)
    plain = protocol.run(case, out=root)
    assert plain.time_step_halvings == 0
    tolerance = abs(plain.energy_closure) / 2
    _strictly(monkeypatch, tolerance)
    halved = protocol.run(case, out=root, again=True)
    assert halved.time_step_halvings > 0
    assert halved.time_step_s == case.time_step / 2**halved.time_step_halvings
    assert abs(halved.energy_closure) < tolerance
    stop, result = DischargeStop(lambda: True), None
    shutil.copytree(root / "packings", tmp_path / "packings")
    while result is None:
        with contextlib.suppress(Stopped):
            result = protocol.run(case, out=tmp_path, progress=stop.progress, stop=stop)
    assert_same_run(the_run(tmp_path), RunFolder(Path(halved.run_folder)))
    given = SiloCase.load(file, {"run.time_step": "5 us"})
    with pytest.raises(SimulationError, match="J of energy"):
        protocol.run(given, out=root)


def test_a_filling_that_fails_is_no_reason_for_a_shorter_step(tmp_path, monkeypatch):
    """It has its own attempts, and the discharge's step is nothing to it."""
    poured = []

    def fails(*_: object) -> None:
        poured.append(1)
        raise SimulationError("no rest")

    monkeypatch.setattr(protocol, "get_packing", fails)
    with pytest.raises(SimulationError, match="no rest"):
        protocol.run(small_case(tmp_path, {"run.time_step": None}), out=tmp_path)
    assert poured == [1]


def test_a_halved_run_that_goes_on_and_fails_again_is_not_tried_in_longer_steps(
    tmp_path, monkeypatch
):
    """Its checkpoint knows how often it was halved."""
    case, tried = small_case(tmp_path, {"run.time_step": None}), []

    def started(_folder, _case, _packing, halvings, *_: object) -> tuple[object, Clock]:
        tried.append(2 if not tried else halvings)
        return None, Clock(halvings=tried[-1])

    def fails(*_: object) -> None:
        raise SimulationError("too much energy")

    monkeypatch.setattr(protocol, "get_packing", lambda *_: None)
    monkeypatch.setattr(protocol, "start_or_resume", started)
    monkeypatch.setattr(protocol, "_discharged", fails)
    with pytest.raises(SimulationError, match="energy"):
        protocol.run(case, out=tmp_path)
    assert tried == [2, 3, 4]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (SOFT, ["kn = 10 N/mm", "too soft", "at least"]),
        ({"silo.width": "22 mm", "silo.outlet": "21 mm"}, ["too small for its particles"]),
    ],
)
def test_what_cannot_be_filled_is_refused_before_it_is(tmp_path, changes, words):
    """With what to change; the stiffness that the line names is accepted."""
    said = refusal(small_case, tmp_path, changes)
    assert all(word in said for word in words), said
    if "at least" in said:
        enough = said.split("at least ")[1].split(" N/mm")[0]
        small_case(tmp_path, {**changes, "law.kn": f"{enough} N/mm"})


@pytest.mark.parametrize("number", [44, 22])
def test_silos_of_strangers_run_and_their_energy_closes(number, tmp_path):
    """Two of `make own-silos`, which runs two hundred."""
    row = tried(number, tmp_path)
    assert row["outcome"] in ("empty", "clogged", "clogged_at_opening", "dead_zones", "time_limit")
    assert abs(row["closure"]) < 0.005
