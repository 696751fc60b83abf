"""Rendered discharge films of known truth through `calibrate flow`: bias, scatter and coverage.

python benchmarks/flow_coverage.py RUN FOLDER FILM ... renders a run folder as each FILM's camera
sees it, measures the film, and adds a line to FOLDER/flow.jsonl; without FILM it prints the table
of all lines. A 68 % interval covers where |line of the film - line of the run| is below the stated
sigma, counted over all layers, columns and times after the opening at which both have a line.
"""

import json
import sys
from pathlib import Path

import numpy as np

from calibration.flow.measure import measure_flow
from calibration.flow.silo import Settings
from calibration.rendered.camera import Camera, write_film
from calibration.rendered.flow import Look, Stage, film_of_run, truth

# name: camera, look in units of a silo's width over 300, interval [s]
FILMS = {
    "plain": (Camera(100, moments=3), {}),
    "fast": (Camera(240, noise=3.0, blur=1.0, moments=2), {"lead": 0.05}),
    "slow": (Camera(60, exposure=0.1, noise=1.0, moments=3), {"lead": 0.2}),
    "uneven light": (Camera(150, falloff=0.4, noise=4.0, moments=2), {"lead": 0.07}),
    "white backing": (
        Camera(120, moments=2),
        {"backing": (0.9, 0.9, 0.88), "paint": (0.5, 0.2, 0.1), "bare": (0.35, 0.5, 0.6)},
    ),
    "coarse": (Camera(120, blur=0.5, moments=2), {"lead": 0.08, "pixels": 220}),
    "dim": (Camera(90, exposure=0.5, blur=1.2, noise=6.0, moments=5), {"lead": 0.11}),
    "sharp": (Camera(300, exposure=0.1, blur=0.4, noise=1.0, moments=2), {"lead": 0.04}),
    "fine": (Camera(200, noise=2.0, moments=2), {"lead": 0.06, "pixels": 380}),
}
PIXELS = 290  # across the silo


def rendered(run: Path, folder: Path, name: str) -> tuple[Stage, Camera, np.ndarray, Path]:
    """A run as a film's camera sees it: stage, camera, times of the pictures [s], and the film."""
    camera, changes = FILMS[name]
    changes = dict(changes)
    pixels = float(changes.pop("pixels", PIXELS)) + 0.37  # sides fall between pixels
    left, right, _, _ = Stage(run, Look()).scene.window
    look = Look(scale=(right - left) / pixels, texture_size=1.5e-3 * (right - left) / 0.3, rest=0.3,
                **changes)  # fmt: skip
    seed = sum(map(ord, name + run.name))
    stage = Stage(run, look, seed)
    times, pictures = film_of_run(stage, camera, seed)
    film = write_film(pictures, folder / f"{name.replace(' ', '-')}-{run.name}.mp4", camera.rate)
    return stage, camera, times, film


def row(run: Path, folder: Path, name: str) -> dict[str, object]:
    """Render, measure and compare one film."""
    stage, camera, times, film = rendered(run, folder, name)
    left, right, _, _ = stage.scene.window
    length = 0.05 if right - left < 0.2 else 0.25
    known = truth(run, stage, times, camera, length)
    columns = len(known["column_edges_m"]) - 1
    settings = Settings(width=f"{1e3 * (right - left)} mm", interval=f"{length} s", columns=columns,
                        velocity=False)  # fmt: skip
    flow = measure_flow(film, settings)
    lines = np.array([[[np.nan if v is None else v for v in r] for r in layer["lines_m"]]
                      for layer in known["layers"]]).swapaxes(0, 1)  # fmt: skip
    seen = np.array([p.lines for p in flow.profiles])
    sigma = np.array([p.sigma for p in flow.profiles])
    t, layers = (min(a, b) for a, b in zip(lines.shape[:2], seen.shape[:2], strict=True))
    off = (seen[:t, :layers] - lines[:t, :layers])[1:]
    z = off / sigma[1:t, :layers]
    both = np.isfinite(z)
    end = flow.discharge
    return {
        "film": name, "run": run.name.split("-")[0] + " " + run.name.split("-")[1],
        "layers": f"{seen.shape[1]} of {lines.shape[1]}", "lines": int(both.sum()),
        "bias_mm": 1e3 * off[both].mean(), "rms_mm": 1e3 * np.sqrt(np.mean(off[both] ** 2)),
        "sigma_mm": 1e3 * np.sqrt(np.mean(sigma[1:t, :layers][both] ** 2)),
        "within": int((np.abs(z[both]) < 1).sum()),
        "opening_off_frames": flow.opening.value - known["opening_frame"],
        "opening_sigma": flow.opening.sigma,
        "time_off_ms": None if end is None else 1e3 * (end.value - known["last_out_s"]),
        "time_sigma_ms": None if end is None else 1e3 * end.sigma,
        "frame_ms": 1e3 / camera.rate,
        "outcome": f"{flow.outcome} ({known['outcome']})",
    }  # fmt: skip


def table(rows: list[dict]) -> str:
    """All films as a table in Markdown."""
    lines = [
        "| film | run | layers | lines | bias [mm] | rms [mm] | sigma [mm] | within one sigma | "
        "opening off [frames] | last particle off [ms] | outcome (truth) |",
        "|" + "---|" * 11,
    ]
    for r in rows:
        end = "-" if r["time_off_ms"] is None else (
            f"{r['time_off_ms']:+.1f} +- {r['time_sigma_ms']:.1f}, frame {r['frame_ms']:.1f}"
        )  # fmt: skip
        lines.append(
            f"| {r['film']} | {r['run']} | {r['layers']} | {r['lines']} | {r['bias_mm']:+.2f} | "
            f"{r['rms_mm']:.2f} | {r['sigma_mm']:.2f} | {r['within'] / max(r['lines'], 1):.0%} | "
            f"{r['opening_off_frames']:+.2f} +- {r['opening_sigma']:.2f} | {end} | {r['outcome']} |"
        )
    n, within = (sum(r[key] for r in rows) for key in ("lines", "within"))
    return "\n".join(
        [*lines, "", f"All: {within} of {n} lines within one sigma, {within / n:.0%}."]
    )


def main() -> None:
    """Add the films named on the command line, or print what is there."""
    run, folder, *names = sys.argv[1:]
    Path(folder).mkdir(parents=True, exist_ok=True)
    kept = Path(folder) / "flow.jsonl"
    for name in names:
        found = row(Path(run), Path(folder), name)
        with kept.open("a", encoding="utf-8") as file:
            file.write(json.dumps(found, default=float) + "\n")
    if not names:
        print(table([json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines()]))


if __name__ == "__main__":
    main()
