"""The sample of a pendulum test: a small film of two equal blocks and its truth."""

from pathlib import Path

from calibration.rendered.camera import Camera
from calibration.rendered.pendulum import Array, PendulumScene, Truth, film_pendulum
from calibration.rendered.strings import Strings

SCENE = PendulumScene(
    Strings(restitution=0.45, mass_ratio=1.0, beta=0.03, contacts=4),
    width=280, height=160, scale=1.7e-3, pivot=-160.0,
)  # fmt: skip
CAMERA = Camera(rate=60, noise=1.5)


def write(folder: Path) -> list[Path]:
    """Write pendulum.mp4 and pendulum.toml."""
    clip, facts = folder / "pendulum.mp4", folder / "pendulum.toml"
    facts.write_text(_facts(film_pendulum(SCENE, CAMERA, clip)), encoding="utf-8")
    return [clip, facts]


def _facts(truth: Truth) -> str:
    """What the film shows, as TOML."""

    def listed(values: Array) -> str:
        return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"

    strings = SCENE.strings
    return (
        "# python -m calibration.rendered pendulum data/media\n"
        "schema = 1\n"
        f'rate = "{truth.rate:g} 1/s"\n'
        f'scale = "{SCENE.scale * 1e3:g} mm/px"\n'
        f'string = "{strings.length * 1e3:g} mm"\n'
        f'release = "{strings.angle:g} deg"\n'
        f"restitution = {truth.restitution:g}\n"
        f"mass_ratio = {strings.mass_ratio:g}\n"
        f'damping = "{strings.beta:g} 1/s"\n'
        f"contact_frames = {listed(truth.frame)}\n"
        f"contact_times_s = {listed(truth.contacts)}\n"
    )
