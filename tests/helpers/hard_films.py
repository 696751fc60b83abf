"""Films of drop tests as laboratories make them: `CASES`, with what is known of each."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
from spoilt_films import (
    BALL,
    CAMERA,
    SCENE,
    Flown,
    again_and_again,
    as_it_is,
    bands,
    barrel,
    block,
    carried_back,
    caught,
    clock,
    comb,
    cube,
    exposure_steps,
    fan,
    flicker,
    fog,
    gamma,
    glossy,
    grey,
    hand_that_opens,
    hand_that_waves,
    jpeg,
    person,
    pulldown,
    row_by_row,
    shadow_on_the_wall,
    shaken,
    short_plate,
    stamped,
    tilted,
    turned,
    turned_and_flagged,
    two,
    uneven_times,
    without,
)

from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera, write_film
from calibration.rendered.drop import Ball, DropScene


@dataclass(frozen=True)
class Case:
    """A film, and what `calibrate drop` should make of it.

    paint     light of the scene at a time, and the time, to light
    taken     pictures of the camera to those of the file
    times     of the exposures [s]; None: evenly from `start` on
    finish    done to the file that is written
    options   of measure_drop
    truth     restitution; None where no one number is right: it must be refused
    said      words that the refusal or a warning must have
    """

    scene: DropScene = SCENE
    camera: Camera = CAMERA
    duration: float = 1.1
    start: float = 0.0
    paint: Callable = as_it_is
    taken: Callable = as_it_is
    times: tuple[float, ...] | None = None
    finish: Callable = as_it_is
    codec: str = "mp4v"
    header: float | None = None
    options: dict = field(default_factory=dict)
    truth: float | None = 0.8
    said: str = ""

    def film(self, path: Path) -> Path:
        """Write it."""
        rate = self.camera.rate
        times = self.times or [self.start + k / rate for k in range(int(self.duration * rate))]
        seen = self.camera.film(
            lambda time: np.clip(self.paint(self.scene.paint(time), time), 0, 1), times, 1
        )
        write_film(self.taken(seen, rate), path, self.header or rate, self.codec)
        self.finish(path)
        return path


FAST = replace(SCENE, balls=(Ball(diameter=0.004, fall=0.02, release=0.04),), scale=1e-4)
TALL = replace(SCENE, balls=(replace(BALL, fall=0.6, diameter=0.09),), scale=3e-3)
DARK = Backdrop(wall=(0.08, 0.07, 0.07), plate=(0.15, 0.15, 0.15), texture=0.02)
SOFT = Backdrop(texture=0.02, grain=20.0)
PALE = replace(BALL, colour=(0.6, 0.62, 0.68))
LARGE = DropScene((Ball(diameter=0.3, fall=0.75, release=0.1),), width=720, height=1280, scale=1e-3)


def with_ball(**changes) -> DropScene:
    return replace(SCENE, balls=(replace(BALL, **changes),))


FALLEN = {"diameter": 0.03, "fall": 0.2, "release": 0.1}

CASES = {
    "24 frames/s, high fall": Case(TALL, replace(CAMERA, rate=24, moments=5), 2.2),
    "30 frames/s, e 0.55": Case(
        replace(TALL, balls=(replace(TALL.balls[0], restitution=0.55),)),
        replace(CAMERA, rate=30, moments=5), 1.6, truth=0.55),
    "1000 frames/s": Case(FAST, replace(CAMERA, rate=1000), 0.3),
    "240 frames/s, bright on dark": Case(
        replace(with_ball(colour=(0.9, 0.9, 0.9)), backdrop=DARK), replace(CAMERA, rate=240)),
    "dark on bright": Case(
        replace(with_ball(colour=(0.1, 0.1, 0.1)), backdrop=Backdrop(wall=(0.9, 0.9, 0.9)))),
    "colour of the wall": Case(replace(SCENE, balls=(PALE,)), replace(CAMERA, noise=1.0)),
    "lamps of 50 Hz, 25 %, 240 frames/s": Case(
        camera=replace(CAMERA, rate=240), paint=flicker(50, 0.25)),
    "lamps of 50 Hz, 25 %, 120 frames/s": Case(
        camera=replace(CAMERA, rate=120), paint=flicker(50, 0.25)),
    "lamps of 60 Hz, 60 %, 1000 frames/s": Case(
        FAST, replace(CAMERA, rate=1000), 0.3, paint=flicker(60, 0.6)),
    "automatic exposure, a fifth": Case(paint=exposure_steps),
    "glossy plate and shadow": Case(replace(SCENE, shadow=0.7), paint=glossy),
    "shadow on the wall": Case(replace(SCENE, shadow=0.0), paint=shadow_on_the_wall),
    "hand of the ball's colour": Case(paint=hand_that_opens),
    "hand that waves next to it": Case(paint=hand_that_waves),
    "plate at the lower edge": Case(replace(SCENE, plate=0.995)),
    "plate with an end, dark room": Case(paint=short_plate),
    "camera tilted by 3 degrees": Case(with_ball(aside=0.0), paint=tilted(3)),
    "camera tilted by 10 degrees": Case(with_ball(aside=0.05, position=0.4), paint=tilted(10)),
    "held by hand, 1 px": Case(paint=shaken(1.0)),
    "held by hand, 4 px": Case(paint=shaken(4.0)),
    "held by hand, 4 px, soft wall": Case(
        replace(SCENE, backdrop=SOFT), paint=shaken(4.0), said="camera moves"),
    "softly textured wall": Case(replace(SCENE, backdrop=SOFT)),
    "wall without texture": Case(replace(SCENE, backdrop=Backdrop(texture=0.0))),
    "squeezed hard": Case(taken=jpeg(8)),
    "blur of a whole frame, 60 frames/s": Case(
        camera=replace(CAMERA, rate=60, exposure=1.0, moments=12), duration=1.2),
    "ball of 4 px": Case(with_ball(diameter=0.004)),
    "ball of 300 px": Case(LARGE, replace(CAMERA, rate=60), 1.8),
    "ball of a quarter of the picture": Case(
        with_ball(diameter=0.13, fall=0.1), replace(CAMERA, rate=120), 0.9),
    "slowly sideways": Case(with_ball(aside=0.1, position=0.12)),
    "half black, half white, rotating": Case(with_ball(texture=0.9, rotation=9.0)),
    "block that tumbles": Case(**cube(paint=block)),
    "interlaced": Case(camera=replace(CAMERA, rate=120), taken=comb, header=60, codec="FFV1"),
    "grey": Case(taken=grey),
    "noise of 12 grey levels": Case(camera=replace(CAMERA, noise=12.0)),
    "contrast of a tenth": Case(camera=replace(CAMERA, noise=1.0), taken=fog, codec="FFV1"),
    "turned, header says so": Case(**turned_and_flagged(cv2.ROTATE_90_COUNTERCLOCKWISE, 90)),
    "upside down, header says so": Case(**turned_and_flagged(cv2.ROTATE_180, 180)),
    "turned, header silent": Case(
        taken=turned(cv2.ROTATE_90_CLOCKWISE), truth=None, said="rotated"),
    "upside down, header silent": Case(taken=turned(cv2.ROTATE_180), said="up"),
    "variable time stamps": Case(times=uneven_times(), finish=stamped, said="stamps"),
    "stamps that vary, camera that does not": Case(
        times=tuple(np.arange(91) / 100), finish=stamped, said="stamps"),
    "24 frames/s made to 30": Case(
        TALL, replace(CAMERA, rate=24, moments=5), 2.2, taken=pulldown, header=30),
    "three drops in one clip": Case(
        duration=3.0, paint=again_and_again(1.0), truth=None, said="3 objects"),
    "begins in the middle of a flight": Case(start=0.36, duration=0.9),
    "begins at the top of a flight, two bounces": Case(start=0.47, duration=0.55),
    "slow motion header": Case(camera=replace(CAMERA, rate=240), header=30, said="--fps"),
    "slow motion header, scale known": Case(
        camera=replace(CAMERA, rate=240), header=30, options={"scale": "1 mm/px"}, said="rate"),
    "time lapse, 8 frames/s": Case(camera=replace(CAMERA, rate=8), truth=None),
    "two alike, together": Case(two(), truth=None, said="--at"),
    "two, together, e 0.8 and 0.7": Case(two(restitution=0.7), truth=None, said="--at"),
    "two together, --at": Case(
        two(restitution=0.7), options={"hint": (5, 48, 37)}, truth=0.8),
    "leaves at the top and comes back": Case(
        replace(SCENE, balls=(replace(BALL, fall=0.4),)), duration=1.5),
    "leaves at the side, after one bounce from rest": Case(with_ball(aside=0.25, position=0.3)),
    "comes nearer by a fifth": Case(replace(SCENE, approach=0.15), said="nearer"),
    "--at beyond the end": Case(options={"hint": (5000, 72, 100)}, truth=None, said="0 to 109"),
    "air drag of a ping-pong ball": Case(replace(SCENE, balls=(Flown(**FALLEN),)),
        replace(CAMERA, rate=120), said="drag"),
    "lens that draws in by 5 %": Case(paint=barrel(0.05)),
    "shutter that reads row by row": Case(replace(SCENE, shadow=0.0), paint=lambda l, t:
        row_by_row(l, t, replace(SCENE, shadow=0.0))),
    "lamps in bands": Case(camera=replace(CAMERA, rate=120), paint=bands),
    "fan next to it": Case(paint=fan),
    "person walks behind": Case(paint=person, truth=None, said="one bounce"),
    "time written into the picture": Case(taken=clock),
    "caught after three bounces": Case(paint=caught),
    "carried back and dropped again": Case(camera=replace(CAMERA, rate=60), duration=3.0,
        paint=carried_back, said="another drop"),
    "four frames lost": Case(taken=without(40, 41, 60, 75), said="left out before"),
    "levels as the power 0.45 of light": Case(taken=gamma),
    "plate below the picture": Case(replace(SCENE, plate=1.05, shadow=0.0)),
    "colour of the plate": Case(with_ball(colour=(0.35, 0.4, 0.45), texture=0.05)),
    "e 0.3": Case(with_ball(restitution=0.3), replace(CAMERA, rate=240), 0.7, truth=0.3),
    "e 0.95, twenty bounces": Case(with_ball(restitution=0.95, fall=0.15, aside=0.0),
        replace(CAMERA, rate=60), 6.0, truth=0.95),
    "falls less than its diameter": Case(with_ball(diameter=0.07, fall=0.05),
        replace(CAMERA, rate=240), 0.6),
    "25 frames/s, small fall": Case(camera=replace(CAMERA, rate=25)),
    "noise of 25 grey levels": Case(camera=replace(CAMERA, noise=25.0)),
}  # fmt: skip
