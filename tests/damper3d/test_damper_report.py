"""The command damper3d without a run: help, echo, options, templates; and the words of a result."""

import dataclasses
import subprocess
import sys
import time

import pytest
from small_damper import KEYS, damper3d, write_damper
from small_silo import DRY

from damper3d.case.case import DamperCase
from damper3d.case.plan import expected_cpu_s, expected_stages
from damper3d.measures.efficiency import settling
from damper3d.run.result import Result
from damper3d.view.report import report
from granulab.campaign.runs.folder import RunFolder
from granulab.errors import FolderError

HEAVY = {"numba", "cv2", "matplotlib", "pint", "h5py", "scipy", "shapely", "numpy"}

RESULT = Result(
    frequency_hz=40.0, gamma=20.0, orientation="vertical", particles="sphere:5mm",
    n_particles=358, fill_ratio=0.466, particle_mass_kg=7.8e-5, mass_kg=0.0279, seed=3,
    packing={"fraction": 0.58, "height_m": 0.031, "coordination": 4.1, "rms_speed_m_s": 2e-4},
    cycles=4, discarded=1, efficiency=0.812,
    efficiency_interval=(0.8, 0.82), efficiency_contact_count=0.861, efficiency_wall_work=0.813,
    efficiency_per_cycle=[0.4, 0.81, 0.82, 0.806],
    shares={
        "particle_particle": {"normal_damping": 0.1, "tangential_damping": 0.05, "friction": 0.6},
        "particle_wall": {"normal_damping": 0.05, "tangential_damping": 0.05, "friction": None},
    },
    law_term=-0.061, dissipated_power_w=2.2, loss_factor=1.03, equivalent_damping_n_s_per_m=7.2,
    effective_mass={"in_phase_kg": 0.01, "out_of_phase_kg": 0.02}, peak_wall_force_n=31.0,
    bed_height_m=0.02, energy_closure=0.0021,
    max_impact_over_yield_velocity={"particle_particle": 0.9, "particle_wall": None},
    hertz_validity={"particle_particle": 4.6674, "particle_wall": None},
    phase=None, phase_next=None, phase_measures=None, steady=None,
    time_step_s=1e-6, steps=100000, cpu_us_per_step=9.5, cpu_s=4.0,
    state_digest="abc", reused=True, run_folder="runs/x",
)  # fmt: skip


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--version"], []])
def test_help_loads_nothing_heavy(arguments):
    """numba alone takes half a second to load; --help has to print in less than that."""
    program = (
        "import sys; from damper3d.commands.main import main\n"
        "try: main()\n"
        "except SystemExit as leave: assert not leave.code\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("damper3d, version" if "--version" in arguments else "Usage: ")
    assert "damper3d.commands.main" in done.stderr.split()
    assert not HEAVY & {module.partition(".")[0] for module in done.stderr.split()}


def test_the_names_for_python_are_imported_on_first_use():
    program = (
        "import sys, damper3d; assert 'numba' not in sys.modules\n"
        "from damper3d import DamperCase, Result; assert DamperCase.load('thesis').count == 358"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_dry_run_says_what_would_be_run_and_writes_nothing(tmp_path):
    """The case in SI, the time step with the Rayleigh step, restitution, yield velocity, time."""
    result = damper3d("run", *DRY, "-o", tmp_path / "runs", "--gamma", "10")
    assert (result.code, result.err) == (0, "")
    for words in (
        "thesis, seed 1", "cylinder, 0.04 m in diameter, 0.04 m high", "358 of sphere:5mm",
        "fill ratio 0.466", "vertical, 40 Hz, gamma 10", "peak speed 0.3903 m/s", "mu 0.52",
        "1e-06 s: the usual one, 0.12 of the Rayleigh step 8.33e-06 s", "250 a sample",
        "restitution 0.86", "particles 3.5 m/s: restitution constant", "walls 7 m/s",
        "the last 5 count", "200,000 steps", "min of CPU",
    ):  # fmt: skip
        assert words in " ".join(result.out.split())  # lines end where the terminal does
    assert "warning" not in result.out
    plan = damper3d("run", *DRY, "--json", "--seed", 3).json
    assert (plan["seed"], plan["n_particles"], plan["time_step_s"]) == (3, 358, 1e-6)
    assert plan["steps"] == 200_000
    assert plan["expected_min"] > 0
    assert not list(tmp_path.iterdir())


OPTIONS = {
    "--frequency": ("80", "80 Hz"),
    "--gamma": ("7", "gamma 7"),
    "--orientation": ("horizontal", "gravity (-9.81, 0, 0)"),
    "--ramp": ("2", "growing over 2 cycles"),
    "--particles": ("sphere:4mm", "sphere:4mm: radius 0.002 m"),
    "--count": ("300", "300 of"),
    "--diameter": ("38 mm", "0.038 m in diameter"),
    "--height": ("45 mm", "0.045 m high"),
    "--density": ("1 g/cm3", "3.351e-05 kg each"),  # 4/3 pi (2 mm)^3 1000 kg/m3
    "--youngs-modulus": ("1.65 GPa", "4/3 E 1.274e+09 Pa"),
    "--friction": ("0.3", "mu 0.3, restitution 0.7"),
    "--friction-wall": ("0.2", "mu 0.2, restitution 0.6"),
    "--restitution": ("0.7", "restitution 0.7"),
    "--restitution-wall": ("0.6", "restitution 0.6"),
    "--tangential": ("force", "carries its force"),
    "--contact-end": ("force", "ends at zero force"),
    "--cycles": ("18", "after 18 cycles"),
    "--discard": ("4", "the last 14 count"),
    "--time-step": ("0.5 us", "5e-07 s: as given"),
    "--samples": ("50", "50 samples a cycle"),
    "--frames": ("10", ""),
    "--seed": ("7", "seed 7"),
}


def test_options_change_the_keys_they_name():
    """The echo of the case has the number of each option, in SI."""
    arguments = [text for flag, (value, _) in OPTIONS.items() for text in (flag, value)]
    result = damper3d("run", *DRY, *arguments, "--yielding", "--wall-curvature")
    assert result.code == 0, result.err
    shown = " ".join(result.out.split())  # lines end where the terminal does
    for flag, (_, echoed) in OPTIONS.items():
        assert echoed in shown, flag
    assert "restitution falls, as [law] yielding says" in shown
    assert "curvature counts" in shown
    steady = " ".join(damper3d("run", *DRY, "--steady", "--max-cycles", "40").out.split())
    assert "when steady, 8 cycles at least" in steady
    assert "40 cycles at most" in steady


def test_one_restitution_of_all_contacts_and_one_of_the_walls():
    plan = damper3d("run", *DRY, "--json", "--restitution", "0.7").json
    assert plan["restitution"] == {"particle_particle": 0.7, "particle_wall": 0.7}
    plan = damper3d("run", *DRY, "--json", "--restitution-wall", "0.6", "--restitution", "0.7").json
    assert plan["restitution"] == {"particle_particle": 0.7, "particle_wall": 0.6}


def test_material_is_a_shipped_table_or_a_file(tmp_path):
    """Of particles and walls; a file's only material, whatever its name."""
    steel = damper3d("run", *DRY, "--json", "--material", "steel", "--restitution", "0.9")
    assert steel.json["yield_velocity_m_s"]["particle_particle"] == pytest.approx(0.15, abs=0.005)
    mine = tmp_path / "mine.toml"
    mine.write_text(
        'schema = 1\n[material.pvc]\ndensity = "1400 kg/m3"\nyoungs_modulus = "3 GPa"\n'
        "poisson = 0.4\n[pair.pvc-pvc]\nfriction = 0.4\nrestitution = 0.8\n",
        encoding="utf-8",
    )
    plan = damper3d("run", *DRY, "--json", "--material", mine).json
    assert plan["restitution"] == {"particle_particle": 0.8, "particle_wall": 0.8}
    two = mine.read_text(encoding="utf-8").replace(
        "[pair", '[material.b]\ndensity = "1 g/cm3"\n[pair'
    )
    mine.write_text(two, encoding="utf-8")
    result = damper3d("run", *DRY, "--material", mine)
    assert result.code == 2
    assert "holds several materials (pvc, b)" in result.err


def test_init_writes_a_case_that_is_the_thesis(tmp_path):
    path = tmp_path / "mine.toml"
    assert damper3d("init", path).code == 0
    mine = damper3d("run", path, *DRY).out.replace("damper, seed", "thesis, seed")
    assert mine == damper3d("run", *DRY).out


def test_list_and_show_describe_what_there_is(tmp_path):
    listed = damper3d("list", "-o", tmp_path / "none")
    assert listed.code == 0
    for word in ("thesis", "damper", "acrylic", "glass"):
        assert word in listed.out
    assert "beverloo" not in listed.out  # a case of silo2d
    assert "example" not in listed.out  # a silo
    for name, word in {
        "thesis": "358 of sphere:5mm",
        "acrylic": "acrylic-acrylic: friction 0.52, restitution 0.86",
        str(write_damper(tmp_path)): "20 of sphere:5mm",
    }.items():
        assert word in damper3d("show", name).out


def test_expected_time_goes_with_particles_and_steps():
    """A cost per particle and step: twice the cycles cost twice, the filling the same."""
    usual, long = (DamperCase.load("thesis", {"run.cycles": n}) for n in (8, 16))
    few = DamperCase.load("thesis", {"particles.count": 179})
    stages = expected_stages(usual)
    twice = expected_stages(long)
    assert twice == {**stages, "shaking": pytest.approx(2 * stages["shaking"])}
    halves = {stage: pytest.approx(cost / 2) for stage, cost in stages.items()}
    assert expected_stages(few) == {**halves, "writing": stages["writing"]}
    assert sum(expected_cpu_s(usual)) == pytest.approx(sum(stages.values()))


def test_the_result_has_the_keys_that_scripts_rely_on():
    assert {field.name for field in dataclasses.fields(Result)} >= KEYS


@pytest.mark.parametrize(("eta", "by_walls", "words"), [
    (0.812, 0.75, None), (0.0, 0.0, None), (0.812, 0.5, "the bed gives itself"),
    (0.812, 1.2, "the bed takes up"), (8e14, 1e-3, "8e+14 of 8e+14"), (6.75, 0.02, "--steady"),
])  # fmt: skip
def test_a_bed_that_settles_has_no_efficiency_and_the_report_says_why(eta, by_walls, words):
    """More than a tenth of what is lost is the bed's own energy, at small Gamma all of it."""
    note = settling(eta, by_walls)
    known = None if note else eta
    text = report(
        dataclasses.replace(
            RESULT, efficiency=known, efficiency_note=note, efficiency_wall_work=by_walls
        )
    )
    assert (note is None) == (words is None)
    assert ("no efficiency" in text) == bool(words)
    assert (words or "efficiency") in text


def test_the_report_has_each_result():
    text = report(RESULT)
    for words in (
        "efficiency 0.812 (95 %: 0.800 to 0.820)", "0.400 | 0.810 0.820 0.806", "0.861 as the",
        "friction 60.0%", "friction none", "2.2 W", "loss factor 1.03", "7.2 N s/m",
        "0.01 kg in phase", "no phase named", "31 N", "particle-particle 0.9, particle-wall none",
        "^(1/5), to be much above 1: particle-particle 4.667, particle-wall none",
        "closed to 0.21 %", "work of the changing stiffness -6.1 %", "9.5 us", "(computed before)",
    ):  # fmt: skip
        assert words in text
    assert "^(1/5)" not in report(dataclasses.replace(RESULT, hertz_validity=None))
    many = dataclasses.replace(
        RESULT, cycles=30, discarded=6, efficiency_per_cycle=[0.5] * 30, steady=True,
        energy_closure=None, efficiency_interval=None,
    )  # fmt: skip
    assert "the last 24 of 30 count, 0.500 to 0.500; steady" in report(many)
    assert "nothing dissipated" in report(many)
    assert "too few to say whether they are steady" in text
    drifting = dataclasses.replace(RESULT, steady=False, steady_note="the counted cycles drift")
    assert "; not steady" in report(drifting)
    assert "warning: the counted cycles drift" in report(drifting)
    assert "take a shorter step" not in text
    assert "0.6 % of what is dissipated, more than 0.5 %: take a shorter step" in report(
        dataclasses.replace(RESULT, energy_closure=-0.006)
    )


@pytest.mark.parametrize(
    "harm",
    [{"efficiency": "high"}, {"efficiency_wall_work": None}, {"shares": [1]}, {"steps": 0.5}],
)
def test_a_damaged_summary_is_refused(tmp_path, harm):
    folder = RunFolder(tmp_path)
    kept = {
        k: v for k, v in dataclasses.asdict(RESULT).items() if k not in ("reused", "run_folder")
    }
    folder.write_summary(kept)
    assert Result.read(folder, reused=True) == dataclasses.replace(RESULT, run_folder=str(tmp_path))
    folder.write_summary(kept | harm)
    with pytest.raises(FolderError, match=r"summary.json: damaged .* --again"):
        Result.read(folder, reused=True)


def test_help_prints_in_half_a_second():
    """CPU time of the process, which other work on the machine does not touch."""
    import resource

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.monotonic()
    subprocess.run([sys.executable, "-m", "damper3d", "--help"], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert min(spent, time.monotonic() - begun) < 0.5
