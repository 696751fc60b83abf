"""Make tests/data/kept: a small run folder of each kind, which later versions must read.

`python tests/data/make_kept.py`, once for a version that is released; test_kept_runs.py opens them.
"""

import shutil
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "helpers"))

from small_damper import damper3d, write_damper  # noqa: E402
from small_silo import Completed, DischargeStop, silo2d, write_case  # noqa: E402

from damper3d.case.case import DamperCase  # noqa: E402
from damper3d.run import protocol as damper  # noqa: E402
from granulab.errors import Stopped  # noqa: E402
from silo2d.case.case import SiloCase  # noqa: E402
from silo2d.run import protocol as silo  # noqa: E402

SILO = {
    "run.max_time": "40 ms",
    "output.checkpoint_interval": "10 ms",
    "output.frame_interval": "10 ms",
    "output.contact_interval": "20 ms",
}
DAMPER = {"output.samples": 20, "output.frames": 2}
SPHEROIDS = {"particles.shape": "prolate:1.5", "particles.equal_volume_radius": "2.5 mm"}
STUDY = (
    'schema = 1\nname = "walls"\ncase = "finished.toml"\nseeds = [1]\n[vary]\nlaw.mu_wall = [0.1]'
)


def make(root: Path) -> None:
    """Compute the runs, a study and a map below a folder, in silo/ and damper/."""
    make_runs(root)
    study = root / "walls.toml"
    study.write_text(STUDY, encoding="utf-8")
    said = [silo2d("sweep", study, "-o", root / "silo", "--workers", 1, "--quiet")]
    grid = ["--frequencies", "80,100", "--gammas", "5,10", "--packings", 1, "--refine", 0]
    options = ["-o", root / "damper", "--no-figures", "--quiet"]
    said += [damper3d("map", root / "spheres.toml", *grid, *options)]
    _all_well(said)


def make_runs(root: Path) -> None:
    """Compute finished and unfinished runs of either engine, of spheres and of spheroids."""
    finished = write_case(root, SILO, "finished")
    said = [silo2d("run", finished, "-o", root / "silo", "--no-figures")]
    pymunk = write_case(root, SILO, "pymunk")
    said += [silo2d("run", pymunk, "--engine", "pymunk", "-o", root / "silo", "--no-figures")]
    begun = SiloCase.load(write_case(root, SILO, "begun"))
    looks = iter([False, False])
    stop = DischargeStop(lambda: next(looks, True))
    _stopped(lambda: silo.run(begun, out=root / "silo", progress=stop.progress, stop=stop))

    spheres = write_damper(root, DAMPER, "spheres")
    said += [damper3d("run", spheres, "-o", root / "damper", "--no-figures")]
    spheroids = write_damper(root, DAMPER | SPHEROIDS, "spheroids")
    said += [damper3d("run", spheroids, "-o", root / "damper", "--no-figures")]
    half = DamperCase.load(write_damper(root, DAMPER, "begun"))
    looks = iter([False] * 3)
    _stopped(lambda: damper.run(half, out=root / "damper", stop=lambda: next(looks, True)))
    _all_well(said)


def _all_well(said: list[Completed]) -> None:
    for done in said:
        if done.code:
            raise SystemExit(done.err)


def _stopped(run) -> None:
    try:
        run()
    except Stopped:
        return
    raise SystemExit("a run that was to be stopped came to its end")


def keep(root: Path, to: Path) -> None:
    """Copy what is kept: of the study and the map their own folders only."""
    shutil.rmtree(to, ignore_errors=True)
    for kind in ("silo", "damper"):
        shutil.copytree(root / kind, to / kind, ignore=shutil.ignore_patterns(".*lock", "*.png"))
    for folder in [*(to / "silo").glob("finished-*"), *(to / "damper").glob("spheres-*")]:
        if (folder / "trajectory.h5").exists() and _is_of_many(folder):
            shutil.rmtree(folder)


def _is_of_many(folder: Path) -> bool:
    """True for a run of the study, which has another friction of the walls, or of the map."""
    text = (folder / "case.toml").read_text(encoding="utf-8")
    return "mu_wall = 0.1" in text or "gamma = 5.0" in text or "frequency = 100.0" in text


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder))
        keep(Path(folder), HERE / "kept")
