"""What lamps, hands, lenses and recorders do to the pictures of a drop test, one function each.

`paint` functions take light and time [s] to light; `taken` functions pictures and rate to pictures.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from made_mp4 import turned_by, with_durations

from calibration.rendered.backdrop import Patch, blend, disc, hand
from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene

BALL = Ball(diameter=0.03, fall=0.2, release=0.1)
SCENE = DropScene((BALL,), width=160, height=280)
CAMERA = Camera(100, moments=3)


def as_it_is(film, *_):
    """Nothing is spoilt."""
    return film


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
    """A lamp near the ball throws its shadow on the wall next to it."""
    ball = scene.balls[0]
    x, y, radius = scene.position(ball, time)
    rows, columns = np.indices(light.shape[:2])
    cover = np.clip(1.05 * radius - np.hypot(columns - x - 45, rows - y - 12) + 0.5, 0, 1)
    light = light * (1 - 0.55 * cover[:, :, None].astype(np.float32))
    blend(light, disc(x, y, radius, ball.colour, ball.texture))
    return light


def hand_that_opens(light, time, scene=SCENE):
    """A hand of the ball's own colour that holds it, and is drawn away upwards."""
    ball = scene.balls[0]
    x, y, radius = scene.position(ball, min(time, ball.release))
    up = 220 * max(time - ball.release, 0.0)
    patch = hand(x + 0.4 * radius, y - 1.0 * radius - up, 1.2 * radius)
    colour = np.broadcast_to(np.array(ball.colour, dtype=np.float32), patch.light.shape)
    blend(light, patch._replace(light=colour))
    return light


def hand_that_waves(light, time, scene=SCENE):
    """A hand next to the ball that waves slowly."""
    blend(light, hand(130 + 8 * math.sin(7 * time), 90 + 30 * math.sin(5 * time), 14))
    return light


def short_plate(light, time, scene=SCENE):
    """The plate ends within the picture; behind it a dark room."""
    edge = round(scene.plate * scene.height)
    light[edge:, 120:] = 0.1
    light[edge + 12 :] = 0.15
    return light


def tilted(degrees: float) -> Callable:
    """The camera is rotated about its axis."""

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
    x, y, radius = scene.position(ball, time)
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
    """Pictures rotated, with nothing in the file that says so."""

    def taken(pictures: Iterable, rate: float) -> Iterator:
        return (cv2.rotate(picture, how) for picture in pictures)

    return taken


def turned_and_flagged(how: int, degrees: int) -> dict:
    """As a phone writes films: rotated pictures, and a header that rotates them back."""
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
        x, y, radius = scene.position(ball, time % period)
        blend(light, disc(x, y, radius, ball.colour, ball.texture))
        return light

    return painted


def two(**other) -> DropScene:
    """A second ball of another colour next to the first, and let go with it."""
    second = replace(BALL, position=0.8, aside=0.0, colour=(0.8, 0.3, 0.2), **other)
    return replace(SCENE, balls=(replace(BALL, position=0.3, aside=0.0), second))


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


class Flown(Ball):
    """A ball in air, whose falls would end at 9 m/s, as a ping-pong ball's; e at the contact."""

    @cached_property
    def _heights(self) -> np.ndarray:
        step, height, speed, heights = 1e-5, self.fall, 0.0, []
        while len(heights) < 200_000:
            heights.append(height)
            speed -= 9.80665 * (1 + speed * abs(speed) / 9.0**2) * step
            height += speed * step
            if height < 0:
                height, speed = 0.0, -self.restitution * speed
        return np.array(heights)

    def height(self, time: float) -> float:
        return float(self._heights[min(max(int((time - self.release) / 1e-5), 0), 199_999)])


def carried_back(light, time, scene=SCENE):
    """After a second the ball is carried back to where it hung, in half a second, and let go."""
    ball, late = scene.balls[0], time % 1.5
    x, y, radius = scene.position(ball, min(late, 0.95))
    if late > 0.95:
        there = scene.position(ball, 0.0)
        share = min((late - 0.95) / 0.45, 1.0)
        share *= share * (3 - 2 * share)
        x, y = x + (there[0] - x) * share, y + (there[1] - y) * share
    light = replace(scene, balls=()).paint(time)
    blend(light, disc(x, y, radius, ball.colour, ball.texture))
    return light


def caught(light, time, scene=SCENE):
    """A hand takes the ball out of its third flight."""
    if time < 0.93:
        return light
    light = replace(scene, balls=()).paint(time)
    x, y, radius = scene.position(scene.balls[0], 0.93)
    away = 300 * (time - 0.93)
    blend(light, disc(x + away, y - away, radius, scene.balls[0].colour, 0.15))
    blend(light, hand(x + away, y - away - 5, 1.1 * radius))
    return light


def barrel(share: float) -> Callable:
    """A lens that draws the edges of the picture in by this share."""

    def painted(light, time):
        h, w = light.shape[:2]
        y, x = np.indices((h, w), dtype=np.float32)
        dx, dy = x - w / 2, y - h / 2
        more = 1 + share * (dx**2 + dy**2) / (h / 2) ** 2
        return cv2.remap(light, w / 2 + dx * more, h / 2 + dy * more, cv2.INTER_LINEAR,
                         borderMode=cv2.BORDER_REFLECT)  # fmt: skip

    return painted


def bands(light, time):
    """Lamps that flicker, read row by row in 8 ms."""
    when = time + 0.008 * np.arange(light.shape[0]) / light.shape[0]
    dark = 1 - 0.3 * np.abs(np.sin(2 * np.pi * 50 * when))
    return light * dark[:, None, None].astype(np.float32)


def row_by_row(light, time, scene=SCENE):
    """A shutter that reads the rows in 8 ms, here in steps of 20 rows."""
    height = light.shape[0]
    for first in range(0, height, 20):
        late = 0.008 * ((first + 10) / height - 0.5)
        light[first : first + 20] = scene.paint(time + late)[first : first + 20]
    return light


def fan(light, time):
    """Three blades rotate next to the ball."""
    for k in range(3):
        angle = 20 * time + 2 * math.pi * k / 3
        end = (round(130 + 25 * math.cos(angle)), round(60 + 25 * math.sin(angle)))
        cv2.line(light, (130, 60), end, (0.2, 0.2, 0.2), 4, cv2.LINE_AA)
    return light


def person(light, time, scene=SCENE):
    """Somebody walks by behind the ball."""
    x = round(-40 + 180 * time)
    cv2.rectangle(light, (x, 60), (x + 50, 250), (0.3, 0.2, 0.5), -1)
    ball = scene.balls[0]
    blend(light, disc(*scene.position(ball, time), ball.colour, ball.texture))
    return light


def clock(pictures: Iterable, rate: float) -> Iterator:
    """The time is written into the pictures."""
    for k, picture in enumerate(pictures):
        where = (5, 15), cv2.FONT_HERSHEY_SIMPLEX, 0.45
        yield cv2.putText(picture.copy(), f"{k / rate:.3f}", *where, (255, 255, 255), 1)


def without(*frames: int) -> Callable:
    """These frames were lost."""

    def taken(pictures: Iterable, rate: float) -> Iterator:
        return (picture for k, picture in enumerate(pictures) if k not in frames)

    return taken


def gamma(pictures: Iterable, rate: float) -> Iterator:
    """Grey levels go as the power 0.45 of the light, as they do in most cameras."""
    table = np.rint(255 * (np.arange(256) / 255) ** 0.45).astype(np.uint8)
    return (table[picture] for picture in pictures)
