"""The sample of a drop test: a small film and its truth."""

from pathlib import Path

from calibration.rendered.camera import Camera
from calibration.rendered.drop import Array, Ball, DropScene, Truth, film_drop

SCENE = DropScene((Ball(diameter=0.03, fall=0.25, restitution=0.75),), width=160, height=320)
CAMERA = Camera(rate=100, exposure=0.3, blur=0.8, noise=2.0)


def write(folder: Path) -> list[Path]:
    """Write drop.mp4 and drop.toml."""
    clip, facts = folder / "drop.mp4", folder / "drop.toml"
    truth = film_drop(SCENE, CAMERA, clip, duration=1.3, seed=1)
    facts.write_text(_facts(truth), encoding="utf-8")
    return [clip, facts]


def _facts(truth: Truth) -> str:
    """What the film shows, as TOML."""

    def listed(values: Array) -> str:
        return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"

    ball = SCENE.balls[0]
    return (
        "# python -m calibration.rendered drop data/media\n"
        "schema = 1\n"
        f'rate = "{truth.rate:g} 1/s"\n'
        f'scale = "{truth.scale * 1e3:g} mm/px"\n'
        f'diameter = "{ball.diameter * 1e3:g} mm"\n'
        f"restitution = {ball.restitution:g}\n"
        f"contact_frames = {listed(truth.frame)}\n"
        f"contact_times_s = {listed(truth.contacts)}\n"
        f"impact_speeds_m_s = {listed(truth.speeds)}\n"
    )
