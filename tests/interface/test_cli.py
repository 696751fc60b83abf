"""The command: what stands on stdout and stderr, what it reuses, what it writes."""

import json
import subprocess
import sys

import pytest
from small_silo import DRY, contents, finish, silo2d, start, the_run, write_case

from granulab.campaign.runs.folder import resume_run
from silo2d.case.outline import PRESETS

# Scripts rely on these names: to change one needs a reason in the changelog.
KEYS = {
    "silo", "seed", "engine", "outcome", "n_particles", "n_out", "mass_kg", "mass_out_kg",
    "discharge_time_s", "t90_s", "mean_rate_per_s", "mean_mass_flow_kg_per_s", "time_step_s",
    "steps", "cpu_us_per_step", "cpu_s", "energy_closure", "restitution", "published",
    "state_digest", "reused", "run_folder",
}  # fmt: skip
PUBLISHED = {
    "experiment_mean_s", "experiment_sd_s", "experiment_n", "experiment_clogged", "simulation_s",
}  # fmt: skip
HEAVY = {"numba", "cv2", "matplotlib", "pydantic", "pint", "h5py", "scipy", "shapely", "numpy"}


def no_filling(*arguments):
    raise AssertionError("the silo was filled again")


# Without a run


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--version"], []])
def test_help_loads_nothing_heavy(arguments):
    """numba alone takes half a second to load; --help has to print in less than that.

    The options of `run` come from the schema, and with it pydantic: a tenth of a second.
    """
    program = (
        "import sys; from silo2d.commands.main import main\n"
        "try: main()\n"
        "except SystemExit as leave: assert not leave.code\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("silo2d, version" if "--version" in arguments else "Usage: ")
    assert "silo2d.commands.main" in done.stderr.split()
    allowed = {"pydantic"} if arguments[:1] == ["run"] else set()
    assert not (HEAVY - allowed) & {module.partition(".")[0] for module in done.stderr.split()}


def test_dry_run_says_what_would_be_run_and_writes_nothing(tmp_path):
    """The case in SI, the time step and its reason, and what it will take."""
    result = silo2d("run", "A4", *DRY, "-o", tmp_path / "runs", "--kn", "8e3 N/mm")
    assert (result.code, result.err) == (0, "")
    words = ["A4, seed 1", "outlet 0.15 m", "filled to 0.475 m", "kn 8e+06 N/m", "mu 0.44"]
    words += ["5e-06 s: the usual one; stable up to", "face to face", "expected", "min"]
    for word in words:
        assert word in result.out
    plan = silo2d("run", "A4", *DRY, "--json", "--seed", 3).json
    assert (plan["silo"], plan["seed"], plan["time_step_s"]) == ("A4", 3, 5e-6)
    assert plan["steps_at_most"] == 1_200_000
    assert plan["expected_min"] > 0
    assert not list(tmp_path.iterdir())


def test_dry_run_knows_the_number_of_particles(tmp_path, reference):
    """From the usual packing fraction, 0.88; that of so small a silo is up to a tenth off."""
    plan = silo2d("run", write_case(tmp_path), *DRY, "--json").json
    assert plan["n_particles"] == pytest.approx(reference.read_summary()["n_particles"], rel=0.1)


def test_options_change_the_keys_they_name():
    """The echo of the case has the number of each option, in SI."""
    options = {
        "--outlet": ("120 mm", "outlet 0.12 m"),
        "--fill-level": ("400 mm", "filled to 0.4 m"),
        "--mu": ("0.3", "mu 0.3, gamma_n 5000 1/s"),
        "--mu-wall": ("0.2", "mu 0.2, gamma_n 40 1/s"),
        "--kt": ("600 N/mm", "kt 600000 N/m"),
        "--gamma-n": ("5000 1/s", "gamma_n 5000 1/s"),
        "--gamma-n-wall": ("40 1/s", "gamma_n 40 1/s"),
        "--gamma-t": ("7 1/s", "gamma_t 7 1/s"),
        "--contact-end": ("force", "ends at zero force"),
        "--time-step": ("4 us", "4e-06 s: as given"),
        "--max-time": ("3 s", "or after 3 s"),
        "--seed": ("7", "A4, seed 7"),
    }
    arguments = [text for flag, (value, _) in options.items() for text in (flag, value)]
    result = silo2d("run", "A4", *DRY, *arguments)
    assert result.code == 0, result.err
    for flag, (_, echoed) in options.items():
        assert echoed in result.out, flag
    ratios = silo2d("run", "A4", *DRY, "--kn", "4e4 N/mm", "--keep-ratios").out
    assert "kn 4e+07 N/m, kt 2.6e+06 N/m, mu 0.38, gamma_n 12170 1/s" in ratios


def test_init_writes_a_case_that_is_a4(tmp_path):
    """Every key has its default there, and the silo is spelled out."""
    path = tmp_path / "mine.toml"
    assert silo2d("init", path).code == 0
    mine = silo2d("run", path, *DRY).out.replace("example, seed", "A4, seed")
    assert mine == silo2d("run", "A4", *DRY).out


def test_list_and_show_describe_what_there_is(tmp_path, finished):
    n = the_run(finished).read_summary()[
        "n_out"
    ]  # 67 or 68: how particles land goes by the processor
    listed = silo2d("list", "-o", finished).out
    for word in (*PRESETS, "wood19", "glass", "example", "packings ", str(the_run(finished).path)):
        assert word in listed
    assert f"{the_run(finished).path}: empty" in " ".join(listed.split())
    nothing = silo2d("list", "-o", tmp_path / "none")
    assert nothing.code == 0
    assert "damper" not in nothing.out  # a case of damper3d
    assert "run " not in nothing.out
    for name, word in {
        "A4": "outlet 0.15 m",
        "wood19": "19 shapes",
        "wood": "wood-methacrylate: friction 0.44",
        str(write_case(tmp_path)): "outlet 0.05 m",
        str(tmp_path / "small_shapes.toml"): "3 shapes",
        str(the_run(finished).path): f"empty, {n} of {n}",
    }.items():
        assert word in silo2d("show", name).out


# Running


def test_json_is_one_object_on_stdout_and_progress_is_on_stderr(runs, tmp_path):
    """A process of its own: also what libraries print by themselves would be caught."""
    case = write_case(tmp_path)
    result = finish(start("run", case, "-o", runs, "--json", "--no-figures"))
    table = json.loads(result.out)
    assert result.code == 0
    assert table.keys() >= KEYS
    assert table["published"].keys() >= PUBLISHED
    for pair in ("particle_particle", "particle_wall"):
        assert table["restitution"][pair].keys() == {"one_contact", "face_to_face"}
    assert not table["reused"]
    assert "time step" in result.err
    assert "pouring" not in result.err  # the packing was there


def test_the_results_of_a_run_are_consistent(reference):
    """All particles are out: their number, mass and times follow from one another."""
    table = reference.read_summary()
    assert table["outcome"] == "empty"
    assert table["n_out"] == table["n_particles"] > 60
    assert table["mass_out_kg"] == table["mass_kg"]
    assert 0 < table["t90_s"] < table["discharge_time_s"] <= table["simulated_s"]
    assert table["steps"] * table["time_step_s"] == pytest.approx(table["simulated_s"], rel=1e-12)
    assert table["cpu_us_per_step"] * table["steps"] < 1e6 * table["cpu_s"]
    assert abs(table["energy_closure"]) < 0.02  # at 10 us, twice the usual step


def test_a_finished_run_is_not_computed_again(finished, tmp_path, monkeypatch):
    """Requested again, the stored result is given and nothing in the folder changes."""
    monkeypatch.setattr("silo2d.run.protocol.pour", no_filling)
    monkeypatch.setattr("silo2d.run.protocol.discharge", no_filling)
    before = contents(finished)
    arguments = ["run", write_case(tmp_path), "-o", finished, "--no-figures"]
    table = silo2d(*arguments, "--json").json
    assert table["reused"]
    assert {**table, "reused": None, "run_folder": None} == {
        **the_run(finished).read_summary(), "reused": None, "run_folder": None, "warnings": []
    }  # fmt: skip
    assert "(computed before)" in silo2d(*arguments, "--quiet").out
    assert contents(finished) == before


def test_again_computes_in_a_new_folder_with_the_packing_from_disk(finished, tmp_path, monkeypatch):
    """The same bits in a folder -2; the first one stays as it is."""
    monkeypatch.setattr("silo2d.run.protocol.pour", no_filling)
    before = contents(finished)
    first = the_run(finished)
    arguments = ["-o", finished, "--no-figures", "--again", "--json"]
    table = silo2d("run", write_case(tmp_path), *arguments).json
    assert not table["reused"]
    assert table["run_folder"] == f"{first.path}-2"
    assert table["state_digest"] == first.read_summary()["state_digest"]
    after = contents(finished)
    assert {name: after[name] for name in before} == before


def test_a_packing_is_filled_once_for_all_laws(tmp_path, monkeypatch):
    """`packing` fills; runs of other friction, stiffness and damping open the same packing."""
    case, root = write_case(tmp_path), tmp_path / "runs"
    filled = silo2d("packing", case, "-o", root, "--json", "--quiet")
    assert filled.err == ""
    assert filled.json["n_particles"] > 60
    assert 0.8 < filled.json["packing_fraction"] < 0.95  # without friction, particles lie densely
    before = contents(root)
    monkeypatch.setattr("silo2d.run.protocol.pour", no_filling)
    assert silo2d("packing", case, "-o", root, "--json").json == filled.json
    for options in (["--mu", "0.1"], ["--kn", "2e3 N/mm", "--time-step", "5 us"]):
        arguments = ["-o", root, "--no-figures", "--json", "--max-time", "20 ms"]
        table = silo2d("run", case, *options, *arguments).json
        assert table["n_particles"] == filled.json["n_particles"]
    after = contents(root)
    assert {name: after[name] for name in before} == before


def test_quiet_prints_nothing_but_the_result(runs, tmp_path, reference):
    case = write_case(tmp_path)
    result = silo2d("run", case, "-o", runs, "--quiet", "--no-figures", "--max-time", "20 ms")
    assert (result.code, result.err) == (0, "")
    n = reference.read_summary()["n_particles"]
    assert result.out.startswith(f"small, seed 1: stopped at the time limit, 0 of {n}")
    assert result.out.count("run folder") == 1


def test_a_run_leaves_pictures_and_render_makes_them_again(runs, tmp_path):
    """Eight frames are enough for the four figures and the film."""
    case = write_case(tmp_path)
    result = silo2d("run", case, "-o", runs, "--max-time", "70 ms", "--json")
    folder = resume_run(result.json["run_folder"])
    assert "drawing" in result.err
    pictures = {"silo.png", "discharge.png", "energy.png", "forces.png"}
    drawn = {path.name for path in folder.figures.iterdir()}
    assert pictures < drawn
    assert len(drawn) == 5
    for name in drawn:
        (folder.figures / name).unlink()
    silo2d("run", case, "-o", runs, "--max-time", "70 ms", "--quiet", "--no-figures")
    assert not list(folder.figures.iterdir())
    rendered = silo2d("render", folder.path, "--no-film").out.splitlines()
    assert {path.name for path in folder.figures.iterdir()} == pictures
    assert len(rendered) == 4
