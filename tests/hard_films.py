"""Films of drop tests as laboratories make them, with what is known of each: lamps, hands, shake.

Each is painted by calibration.rendered and spoilt here. `CASES` has them by name.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
from made_mp4 import turned_by, with_durations

from calibration.rendered.backdrop import Backdrop, Patch, blend, disc, hand
from calibration.rendered.camera import Camera, write_film
from calibration.rendered.drop import Ball, DropScene

BALL = Ball(diameter=0.03, fall=0.2, release=0.1)
SCENE = DropScene((BALL,), width=160, height=280)
CAMERA = Camera(100, moments=3)
WALL = (0.7, 0.68, 0.66)


def as_it_is(thing, *_):
    """Nothing is spoilt."""
    return thing


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


def flicker(frequency: float, depth: float) -> Callable:
    """Lamps on mains: |sin| in brightness, as short exposures see it."""

    def painted(light, time):
        return light * (1 - depth * abs(math.sin(2 * math.pi * frequency * time)))

    return painted


def exposure_steps(light, time):
    """Automatic exposure: the picture becomes a fifth darker while the ball is in flight."""
    return light * (1 - 0.2 / (1 + math.exp(-(time - 0.45) / 0.03)))


def glossy(light, time, scene=SCENE, share=0.5):
    """The plate mirrors what is above it."""
    edge = round(scene.plate * scene.height)
    rows = light.shape[0] - edge
    mirrored = light[edge - rows : edge][::-1]
    light[edge:] += share * (mirrored - light[edge:])
    return light


def shadow_on_the_wall(light, time, scene=SCENE):
    """A lamp near the ball throws its shadow on the wall beside it."""
    ball = scene.balls[0]
    x, y, radius = scene.place(ball, time)
    rows, columns = np.indices(light.shape[:2])
    cover = np.clip(1.05 * radius - np.hypot(columns - x - 45, rows - y - 12) + 0.5, 0, 1)
    light = light * (1 - 0.55 * cover[:, :, None].astype(np.float32))
    blend(light, disc(x, y, radius, ball.colour, ball.texture))
    return light


def hand_that_opens(light, time, scene=SCENE):
    """A hand of the ball's own colour that holds it, and is drawn away upwards."""
    ball = scene.balls[0]
    x, y, radius = scene.place(ball, min(time, ball.release))
    up = 220 * max(time - ball.release, 0.0)
    patch = hand(x + 0.4 * radius, y - 1.0 * radius - up, 1.2 * radius)
    colour = np.broadcast_to(np.array(ball.colour, dtype=np.float32), patch.light.shape)
    blend(light, patch._replace(light=colour))
    return light


def hand_that_waves(light, time, scene=SCENE):
    """A hand beside the ball that waves slowly."""
    blend(light, hand(130 + 8 * math.sin(7 * time), 90 + 30 * math.sin(5 * time), 14))
    return light


def short_plate(light, time, scene=SCENE):
    """The plate ends within the picture; behind it a dark room."""
    edge = round(scene.plate * scene.height)
    light[edge:, 120:] = 0.1
    light[edge + 12 :] = 0.15
    return light


def tilted(degrees: float) -> Callable:
    """The camera is turned about its axis."""

    def painted(light, time):
        h, w = light.shape[:2]
        turn = cv2.getRotationMatrix2D((w / 2, h / 2), degrees, 1)
        return cv2.warpAffine(light, turn, (w, h), borderMode=cv2.BORDER_REFLECT)

    return painted


def shaken(size: float, seed: int = 3) -> Callable:
    """A camera held by hand: sways at 0.5 to 8 Hz, standard deviation `size` [px]."""
    random = np.random.default_rng(seed)
    frequency = random.uniform(0.5, 8, (2, 6))
    phase = random.uniform(0, 2 * np.pi, (2, 6))

    def painted(light, time):
        dx, dy = size / math.sqrt(3) * np.sin(2 * np.pi * frequency * time + phase).sum(axis=1)
        matrix = np.array([[1, 0, dx], [0, 1, dy]])
        h, w = light.shape[:2]
        return cv2.warpAffine(light, matrix, (w, h), flags=cv2.INTER_CUBIC,
                              borderMode=cv2.BORDER_REFLECT)  # fmt: skip

    return painted


def block(light, time, scene=SCENE):
    """A square of wood that tumbles, in the place of a ball."""
    ball = scene.balls[0]
    x, y, radius = scene.place(ball, time)
    angle = 5.0 * max(time - ball.release, 0.0)
    corner = radius * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * 0.9
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    corners = np.rint((corner @ turn.T + [x, y]) * 16).astype(np.int32)
    cover = np.zeros(light.shape[:2], np.uint8)
    cv2.fillConvexPoly(cover, corners, 255, cv2.LINE_AA, 4)
    wood = np.broadcast_to(np.array([0.2, 0.4, 0.6], np.float32), light.shape)
    blend(light, Patch(0, 0, wood, cover.astype(np.float32) / 255))
    return light


def jpeg(quality: int) -> Callable:
    """Pictures squeezed hard before they are stored."""

    def taken(pictures: Iterable, rate: float) -> Iterator:
        for picture in pictures:
            _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
            yield cv2.imdecode(data, cv2.IMREAD_COLOR)

    return taken


def comb(pictures: Iterable, rate: float) -> Iterator:
    """Interlaced: every second line was seen half a frame of the file later."""
    for first, second in zip(*[iter(pictures)] * 2, strict=False):
        woven = first.copy()
        woven[1::2] = second[1::2]
        yield woven


def grey(pictures: Iterable, rate: float) -> Iterator:
    """A film without colours."""
    for picture in pictures:
        yield cv2.cvtColor(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)


def turned(how: int) -> Callable:
    """Pictures turned, with nothing in the file that says so."""

    def taken(pictures: Iterable, rate: float) -> Iterator:
        return (cv2.rotate(picture, how) for picture in pictures)

    return taken


def turned_and_flagged(how: int, degrees: int) -> dict:
    """As a phone writes films: turned pictures, and a header that turns them back."""
    return {"taken": turned(how), "finish": lambda path: turned_by(path, degrees)}


def pulldown(pictures: Iterable, rate: float) -> Iterator:
    """Every fourth picture twice: films of 24 frames/s made to 30."""
    for k, picture in enumerate(pictures):
        yield picture
        if k % 4 == 3:
            yield picture


def fog(pictures: Iterable, rate: float) -> Iterator:
    """Contrast of a tenth: near the noise and the rounding of grey levels."""
    for picture in pictures:
        yield np.rint(110 + 0.08 * (picture.astype(float) - 110)).astype(np.uint8)


def again_and_again(period: float) -> Callable:
    """The drop is done again and again: the ball is back where it hung after each period [s]."""

    def painted(light, time, scene=SCENE):
        light = replace(scene, balls=()).paint(time)
        ball = scene.balls[0]
        x, y, radius = scene.place(ball, time % period)
        blend(light, disc(x, y, radius, ball.colour, ball.texture))
        return light

    return painted


def two(**other) -> DropScene:
    """A second ball of another colour beside the first, and let go with it."""
    second = replace(BALL, place=0.8, aside=0.0, colour=(0.8, 0.3, 0.2), **other)
    return replace(SCENE, balls=(replace(BALL, place=0.3, aside=0.0), second))


def uneven_times() -> tuple[float, ...]:
    """Exposures of a phone in poor light: 10 or 15 ms apart, as it falls out."""
    steps = np.where(np.random.default_rng(5).random(90) < 0.4, 15, 10)
    return tuple(float(t) for t in np.concatenate([[0], np.cumsum(steps)]) / 1e3)


def stamped(path: Path) -> None:
    """The file says when its pictures were exposed."""
    with_durations(path, np.diff([*uneven_times(), uneven_times()[-1] + 0.01]))


def cube(**changes) -> dict:
    """No ball is painted; something else is in its place."""
    return {"scene": replace(SCENE, balls=()), **changes}


FAST = replace(SCENE, balls=(Ball(diameter=0.004, fall=0.02, release=0.04),), scale=1e-4)
TALL = replace(SCENE, balls=(replace(BALL, fall=0.6, diameter=0.09),), scale=3e-3)
DARK = Backdrop(wall=(0.08, 0.07, 0.07), plate=(0.15, 0.15, 0.15), texture=0.02)
SOFT = Backdrop(texture=0.02, grain=20.0)
PALE = replace(BALL, colour=(0.6, 0.62, 0.68))
LARGE = DropScene((Ball(diameter=0.3, fall=0.75, release=0.1),), width=720, height=1280, scale=1e-3)


def with_ball(**changes) -> DropScene:
    return replace(SCENE, balls=(replace(BALL, **changes),))


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
    "hand that waves beside": Case(paint=hand_that_waves),
    "plate at the lower edge": Case(replace(SCENE, plate=0.995)),
    "plate with an end, dark room": Case(paint=short_plate),
    "camera tilted by 3 degrees": Case(with_ball(aside=0.0), paint=tilted(3)),
    "camera tilted by 10 degrees": Case(with_ball(aside=0.05, place=0.4), paint=tilted(10)),
    "held by hand, 1 px": Case(paint=shaken(1.0)),
    "held by hand, 4 px": Case(paint=shaken(4.0)),
    "held by hand, 4 px, soft wall": Case(replace(SCENE, backdrop=SOFT), paint=shaken(4.0)),
    "softly textured wall": Case(replace(SCENE, backdrop=SOFT)),
    "wall without texture": Case(replace(SCENE, backdrop=Backdrop(texture=0.0))),
    "squeezed hard": Case(taken=jpeg(8)),
    "blur of a whole frame, 60 frames/s": Case(
        camera=replace(CAMERA, rate=60, exposure=1.0, moments=12), duration=1.2),
    "ball of 4 px": Case(with_ball(diameter=0.004)),
    "ball of 300 px": Case(LARGE, replace(CAMERA, rate=60), 1.8),
    "ball of a quarter of the picture": Case(
        with_ball(diameter=0.13, fall=0.1), replace(CAMERA, rate=120), 0.9),
    "slowly sideways": Case(with_ball(aside=0.1, place=0.12)),
    "half black, half white, turning": Case(with_ball(texture=0.9, spin=9.0)),
    "block that tumbles": Case(**cube(paint=lambda l, t: block(l, t, SCENE))),
    "interlaced": Case(camera=replace(CAMERA, rate=120), taken=comb, header=60, codec="FFV1"),
    "grey": Case(taken=grey),
    "noise of 12 grey levels": Case(camera=replace(CAMERA, noise=12.0)),
    "contrast of a tenth": Case(camera=replace(CAMERA, noise=1.0), taken=fog, codec="FFV1"),
    "turned, header says so": Case(**turned_and_flagged(cv2.ROTATE_90_COUNTERCLOCKWISE, 90)),
    "upside down, header says so": Case(**turned_and_flagged(cv2.ROTATE_180, 180)),
    "turned, header silent": Case(
        taken=turned(cv2.ROTATE_90_CLOCKWISE), said="turned"),
    "upside down, header silent": Case(taken=turned(cv2.ROTATE_180), said="up"),
    "variable time stamps": Case(times=uneven_times(), finish=stamped, said="stamps"),
    "stamps that vary, camera that does not": Case(
        times=tuple(np.arange(91) / 100), finish=stamped, said="stamps"),
    "24 frames/s made to 30": Case(
        TALL, replace(CAMERA, rate=24, moments=5), 2.2, taken=pulldown, header=30),
    "three drops in one clip": Case(
        duration=3.0, paint=lambda l, t: again_and_again(1.0)(l, t), said="drop"),
    "begins in the middle of a flight": Case(start=0.36, duration=0.9),
    "begins at the top of a flight, two bounces": Case(start=0.47, duration=0.55),
    "slow motion header": Case(camera=replace(CAMERA, rate=240), header=30),
    "slow motion header, scale known": Case(
        camera=replace(CAMERA, rate=240), header=30, options={"scale": "1 mm/px"}, said="rate"),
    "time lapse, 8 frames/s": Case(camera=replace(CAMERA, rate=8), truth=None),
    "two alike, together": Case(two(), truth=None, said="--at"),
    "two, together, e 0.8 and 0.7": Case(two(restitution=0.7), truth=None, said="--at"),
    "two together, --at": Case(
        two(restitution=0.7), options={"hint": (5, 48, 37)}, truth=0.8),
    "leaves at the top and comes back": Case(
        replace(SCENE, balls=(replace(BALL, fall=0.4),)), duration=1.5),
    "leaves at the side": Case(with_ball(aside=0.25, place=0.3), said=""),
    "comes nearer by a fifth": Case(replace(SCENE, approach=0.15), said="nearer"),
    "--at beyond the end": Case(options={"hint": (5000, 72, 100)}, truth=None, said="110"),
}  # fmt: skip
