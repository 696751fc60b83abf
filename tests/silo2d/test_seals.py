"""Flipped bits in the files of runs: each is found, and a run that goes on ends with its bits."""

import random
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from refusals import assert_refused
from resealed import resealed
from same_run import assert_same_run
from small_silo import DischargeStop, silo2d, the_run, write_case

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.verify import verify
from granulab.errors import Stopped
from silo2d.case.case import SiloCase
from silo2d.run import discharge, protocol

# Ten parts in a tenth of the discharge, and a contact table in every one.
BRIEF = {
    "run.max_time": "50 ms",
    "output.checkpoint_interval": "5 ms",
    "output.frame_interval": "5 ms",
    "output.contact_interval": "5 ms",
}
FLIPS = 4  # of each file


def flip(path: Path, offset: int, bit: int = 0) -> None:
    data = bytearray(path.read_bytes())
    data[offset] ^= 1 << bit
    path.write_bytes(data)


def files_of(folder: Path) -> list[Path]:
    return [
        path
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.endswith(".lock")
    ]


@pytest.fixture(scope="module")
def brief_root(_finished_root, tmp_path_factory) -> Path:
    """A folder with the brief run in whole/, and what it was when it was stopped in unfinished/."""
    root = tmp_path_factory.mktemp("brief")
    case = SiloCase.load(write_case(root, BRIEF))
    for name in ("unfinished", "whole"):
        packings = _finished_root / "runs" / "packings"
        shutil.copytree(packings, root / name / "packings")
    protocol.run(case, out=root / "whole")
    looks = iter([False] * 8)
    stop = DischargeStop(lambda: next(looks, True))
    with pytest.raises(Stopped):
        protocol.run(case, out=root / "unfinished", progress=stop.progress, stop=stop)
    return root


@pytest.fixture
def unfinished(brief_root, tmp_path) -> RunFolder:
    """A copy of the run that was stopped with ten parts."""
    run = the_run(shutil.copytree(brief_root / "unfinished", tmp_path / "copy"))
    assert len(list((run.path / "parts").glob("[0-9]*.h5"))) == 10
    return run


@pytest.mark.parametrize("state", ["unfinished", "whole"])
def test_every_flipped_bit_is_found(brief_root, tmp_path, state):
    """In every file, at random places; but for a JSON file's seal itself, which then is none."""
    copy = shutil.copytree(brief_root / state, tmp_path / "copy")
    assert not verify(copy).damaged
    chance = random.Random(5)
    harmless = 0
    for path in files_of(copy):
        whole = path.read_bytes()
        for _ in range(FLIPS):
            flip(path, chance.randrange(len(whole)), chance.randrange(8))
            by_itself = path.parent.name in ("parts", "checkpoints")  # else the provenance counts
            damaged = verify(path.parent if by_itself else copy).damaged
            if path.suffix == ".json" and not damaged:
                harmless += 1
                assert path in verify(copy).unsealed
            else:
                assert any(str(path) in line for line in damaged), path
            path.write_bytes(whole)
    assert harmless <= 2
    result = silo2d("list", "--verify", "-o", copy)
    assert (result.code, result.err) == (0, "")
    assert " 0 damaged, 0 without a seal" in result.out


# The file that is damaged, and from which part on the run is computed again.
DAMAGED = {
    "parts/00000.h5": 0,
    "parts/00005.h5": 4,
    "parts/00009.h5": 9,
    "parts/static.h5": 10,
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_run_goes_on_from_before_the_damage_to_the_same_bits(unfinished, brief_root, name):
    """It says which file is damaged, and from where it goes on."""
    path = unfinished.path / name
    flip(path, path.stat().st_size * 2 // 3)
    result = silo2d("run", "--resume", unfinished.path, "--quiet", "--no-figures")
    assert result.code == 0
    part = DAMAGED[name]
    if part == 10:
        assert result.err == ""
    else:
        assert result.err.startswith(f"warning: {path}: damaged")
        assert result.err.count("\n") == 1
        words = f"computes {10 - part} of its 10 parts again" if part else "starts from its opening"
        assert words in result.err
    assert_same_run(unfinished, the_run(brief_root / "whole"))
    assert not verify(unfinished.path).damaged


def test_a_run_goes_on_from_the_newest_checkpoint_that_is_whole(unfinished, brief_root):
    """The one before it, and those that are not needed are not looked at."""
    for name in ("checkpoint.h5", "checkpoints/00010.h5", "checkpoints/00004.h5"):
        flip(unfinished.path / name, 600)
    result = silo2d("run", "--resume", unfinished.path, "--quiet", "--no-figures")
    assert result.err.startswith(f"warning: {unfinished.checkpoint}: damaged")
    assert "00009.h5 and computes 1 of its 10 parts again" in result.err
    assert_same_run(unfinished, the_run(brief_root / "whole"))


def test_a_run_without_any_whole_checkpoint_starts_from_its_opening(unfinished, brief_root):
    for path in [unfinished.checkpoint, *unfinished.checkpoints.iterdir()]:
        path.write_bytes(path.read_bytes()[:1000])
    result = silo2d("run", "--resume", unfinished.path, "--quiet", "--no-figures")
    assert (result.code, result.err.count("\n")) == (0, 1)
    assert "no checkpoint before it is left, so that the run starts from its opening" in result.err
    assert_same_run(unfinished, the_run(brief_root / "whole"))


def test_a_last_part_that_is_missing_is_said(unfinished, brief_root):
    (unfinished.path / "parts" / "00009.h5").unlink()
    result = silo2d("run", "--resume", unfinished.path, "--quiet", "--no-figures")
    assert result.err.startswith(f"warning: {unfinished.path / 'parts' / '00009.h5'}: missing")
    assert_same_run(unfinished, the_run(brief_root / "whole"))


def test_checkpoints_after_one_that_is_gone_back_to_do_not_count_again(
    unfinished, brief_root, monkeypatch
):
    """Part 5 is computed again, cut off elsewhere, and the process dies before its checkpoint."""
    flip(unfinished.path / "parts" / "00005.h5", 3000)
    looks = iter([False])
    stop = DischargeStop(lambda: next(looks, True))
    monkeypatch.setattr(discharge, "keep_checkpoint", _dies)
    with pytest.raises(KeyboardInterrupt):
        protocol.resume(unfinished.path, progress=stop.progress, stop=stop)
    monkeypatch.undo()
    assert not [path for path in unfinished.checkpoints.iterdir() if int(path.stem) > 4]
    result = silo2d("run", "--resume", unfinished.path, "--quiet", "--no-figures")
    assert result.code == 0
    assert_same_run(unfinished, the_run(brief_root / "whole"))


def _dies(*_: object) -> None:
    raise KeyboardInterrupt


def test_verify_leaves_alone_what_is_not_of_a_run_and_what_goes_on(unfinished, brief_root):
    """A stranger's files have no seal, and an unfinished run has no results to be missing."""
    (unfinished.path / "notes.json").write_text("[1, 2]")
    (unfinished.path / "own.h5").write_bytes(b"own")
    seals = the_run(brief_root / "whole").read_provenance()["sealed_files"]
    assert "trajectory.h5" in seals
    unfinished.write_provenance({**unfinished.read_provenance(), "sealed_files": seals})
    assert not verify(unfinished.path).damaged


def test_damage_is_listed_with_its_files_and_an_exit_code(brief_root, tmp_path):
    root = shutil.copytree(brief_root / "whole", tmp_path / "copy")
    run = the_run(root)
    flip(run.path / "trajectory.h5", 3000)
    (run.path / "records.csv").unlink()
    result = silo2d("list", "--verify", "-o", root)
    assert result.code == 2
    assert result.err.count("\n") == 1
    assert result.out.count("damaged    ") == 2
    assert f"{run.path / 'trajectory.h5'}: changed since the run began, or damaged" in result.out
    assert f"{run.path / 'records.csv'}: missing" in result.out
    assert_refused(silo2d("observe", run.path, "curve"), "trajectory.h5", "damaged", "--again")


def test_a_finished_trajectory_that_is_damaged_before_its_results_is_computed_again(
    unfinished, brief_root
):
    """A run cut off between its last frame and its results has trajectory.h5 and no parts."""
    whole = the_run(brief_root / "whole")
    shutil.copy(whole.path / "trajectory.h5", unfinished.path)
    shutil.rmtree(unfinished.path / "parts")
    flip(unfinished.path / "trajectory.h5", 5000)
    result = silo2d("run", "--resume", unfinished.path, "--quiet", "--no-figures")
    assert result.code == 0
    assert "trajectory.h5: damaged" in result.err
    assert "starts from its opening" in result.err
    assert_same_run(unfinished, whole)


# What a stranger's run folder may hold


def _external_link(file: h5py.File, secret: Path) -> None:
    del file["frames/x"]
    file["frames/x"] = h5py.ExternalLink(str(secret), "x")


def _soft_link(file: h5py.File, secret: Path) -> None:
    del file["frames/x"]
    file["frames/x"] = h5py.SoftLink("/frames/y")


def _virtual(file: h5py.File, secret: Path) -> None:
    layout = h5py.VirtualLayout(shape=(4,), dtype=float)
    layout[:] = h5py.VirtualSource(str(secret), "x", shape=(4,))
    del file["static/mass"]
    file["static"].create_virtual_dataset("mass", layout)


def _raw_bytes(file: h5py.File, secret: Path) -> None:
    del file["static/mass"]
    outside = [(str(secret), 0, 32)]
    file["static"].create_dataset("mass", shape=(4,), dtype=float, external=outside)


def _bomb(file: h5py.File, secret: Path) -> None:
    del file["static/mass"]
    file["static"].create_dataset("mass", shape=(10**12,), dtype=float, chunks=(10**6,))


@pytest.mark.parametrize(
    ("harm", "words"),
    [
        (_external_link, "link to elsewhere"),
        (_soft_link, "link to elsewhere"),
        (_virtual, "array of another file"),
        (_raw_bytes, "array of another file"),
        (_bomb, "larger than what is stored"),
    ],
)
def test_hdf5_that_leads_out_of_its_file_is_refused(brief_root, tmp_path, harm, words):
    root = shutil.copytree(brief_root / "whole", tmp_path / "copy")
    secret, run = tmp_path / "secret.h5", the_run(root)
    with h5py.File(secret, "w") as file:
        file["x"] = np.arange(4.0)
    with resealed(run.path / "trajectory.h5") as file:
        harm(file, secret)
    for command in ("observe", "export", "render"):
        what = {"observe": ["curve"], "export": ["--to", "csv"], "render": ["--no-film"]}[command]
        assert_refused(silo2d(command, run.path, *what), "trajectory.h5", words)
    if harm in (_external_link, _bomb):
        (packing,) = root.glob("packings/*/packing.h5")
        with resealed(packing, "checkpoint") as file:
            file["arrays"].create_group("x")
            file["arrays/link"] = h5py.ExternalLink(str(secret), "x")
        result = silo2d("run", write_case(tmp_path, BRIEF), "-o", root, "--again", "--quiet")
        assert_refused(result, "packing.h5")


@pytest.mark.parametrize("name", ["summary.json", "case.toml", "trajectory.h5", "parts"])
def test_links_out_of_a_run_folder_are_refused(brief_root, tmp_path, name):
    """Also to a file that is whole; and nothing is removed where a link leads."""
    root = shutil.copytree(brief_root / "whole", tmp_path / "copy")
    path, outside = the_run(root).path / name, tmp_path / "outside"
    outside.mkdir()
    if name == "parts":
        (outside / "00000.h5").touch()
        path.symlink_to(outside)
        command = ["observe", path.parent, "curve"]
    else:
        path.rename(outside / name)
        path.symlink_to(outside / name)
        by_file = {"summary.json": ["show", path.parent], "case.toml": ["run", "--resume",
                   path.parent], "trajectory.h5": ["observe", path.parent, "curve"]}  # fmt: skip
        command = by_file[name]
    assert_refused(silo2d(*command), str(path), "link that leads out")
    assert len(list(outside.iterdir())) == 1
