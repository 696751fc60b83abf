"""The same scenes in LAMMPS and here: `compare_lammps.py` prints docs/verification/lammps.md's."""

import numpy as np
from against_lammps import Motion, Scene, disc, here, there
from scenes import LEVEL, block

from granulab.contact.laws import LinearLaw

GRAVITY = 9.81
SPRINGS = LinearLaw(kn=1e5, kt=2.8e4, mu=0.0, gamma_n=0.0, gamma_t=0.0, pulls=True)
LAWS = {
    "springs": SPRINGS,
    "friction": SPRINGS._replace(mu=0.3),
    "damping": SPRINGS._replace(gamma_n=800.0),
    "friction and damping": SPRINGS._replace(mu=0.3, gamma_n=800.0, gamma_t=3.0),
}
SQUARES = ["corner on face", "corner off the middle", "faces, shifted", "faces, aligned"]
_SQUARE = 10e-3


def two_discs(law: LinearLaw, time_step: float = 1e-6) -> Scene:
    """Discs of 8 and 6 mm radius that meet obliquely at about 1 m/s."""
    return Scene(
        shapes=[disc(0.008), disc(0.006)],
        pose=np.array([[0, 0.3, 0], [0.005, 0.3141, 0]]),
        velocity=np.array([[0, 0], [0.2, -1.0]]),
        law=law,
        time_step=time_step,
    )


def two_squares(how: str, law: LinearLaw = SPRINGS, time_step: float = 1e-7) -> Scene:
    """A rounded square of 10 mm that falls at 1 m/s on another one; 1 um between them.

    how: "corner on face" (head-on), "corner off the middle" (1.5 mm off), "faces, shifted"
    (3 mm), "faces, aligned"
    """
    square = block(_SQUARE, _SQUARE)
    on_corner = 0.5 * _SQUARE + np.hypot(*square.core[0]) + square.spheroradius
    offset, height, angle = {
        "corner on face": (0.0, on_corner, np.pi / 4),
        "corner off the middle": (1.5e-3, on_corner, np.pi / 4),
        "faces, shifted": (3e-3, _SQUARE, 0.0),
        "faces, aligned": (0.0, _SQUARE, 0.0),
    }[how]
    return Scene(
        shapes=[square, square],
        pose=np.array([[0, 0.3, 0], [offset, 0.3 + height + 1e-6, angle]]),
        velocity=np.array([[0, 0], [0, -1.0]]),
        law=law,
        time_step=time_step,
    )


def discs_in_a_box(law: LinearLaw, seed: int = 1, n: int = 60) -> Scene:
    """Discs of 5 to 8 mm radius that fall into a box 120 mm wide."""
    rng = np.random.default_rng(seed)
    return Scene(
        shapes=[disc(radius) for radius in rng.uniform(0.005, 0.008, n).tolist()],
        pose=_rows(rng, n, columns=6, pitch=0.0185),
        velocity=rng.uniform(-0.3, 0.3, (n, 2)),
        law=law,
        time_step=2e-5,
        gravity=GRAVITY,
        half_width=0.06,
    )


def _rows(rng: np.random.Generator, n: int, columns: int, pitch: float) -> np.ndarray:
    """Poses (n, 3) in rows above the floor, moved by up to 1 mm."""
    k = np.arange(n)
    x, y = (k % columns - (columns - 1) / 2) * pitch, LEVEL + (k // columns + 1) * pitch
    return np.column_stack([np.column_stack([x, y]) + rng.uniform(-1e-3, 1e-3, (n, 2)), 0 * x])


def colliding_squares(seed: int) -> Scene:
    """A rounded square of 10 mm that flies at 1 m/s at another one; both at any angle."""
    rng = np.random.default_rng(seed)
    square = block(_SQUARE, _SQUARE)
    direction, offset = rng.uniform(0, 2 * np.pi), rng.uniform(-6e-3, 6e-3)
    ahead = np.array([np.cos(direction), np.sin(direction)])
    x, y = 0.0145 * ahead + offset * np.array([-ahead[1], ahead[0]])
    angles = rng.uniform(0, np.pi, 2)
    return Scene(
        shapes=[square, square],
        pose=np.array([[0, 0.3, angles[0]], [x, 0.3 + y, angles[1]]]),
        velocity=np.array([[0, 0], -ahead]),
        law=SPRINGS,
        time_step=1e-6,
    )


def contact_time(motion: Motion) -> float:
    """How long the velocity of the last body changed [s], to the distance of the frames."""
    changes = np.flatnonzero(np.abs(np.diff(motion.velocity[:, -1, 1])) > 1e-9)
    return float((changes[-1] - changes[0]) * (motion.time[1] - motion.time[0]))


def height(scene: Scene, motion: Motion) -> np.ndarray:
    """Of the centre of mass above the floor (F,) [m]."""
    return motion.position[:, :, 1] @ scene.mass / scene.mass.sum() - LEVEL


def kinetic(scene: Scene, motion: Motion) -> np.ndarray:
    """Kinetic energy (F,) [J]."""
    return 0.5 * ((motion.velocity**2).sum(axis=2) @ scene.mass + motion.spin**2 @ scene.inertia)


def apart(one: Motion, other: Motion) -> np.ndarray:
    """The largest distance of a body in one engine from where it is in the other (F,) [m]."""
    return np.hypot(*np.moveaxis(one.position - other.position, 2, 0)).max(axis=1)


def both(scene: Scene, seconds: float, n_frames: int) -> tuple[Motion, Motion]:
    """The scene here and there, for so long."""
    steps = round(seconds / n_frames / scene.time_step)
    return here(scene, n_frames, steps), there(scene, n_frames, steps)


def differences(one: Motion, other: Motion) -> tuple[float, float]:
    """The largest difference of a velocity [m/s] and of a spin [rad/s] at the end."""
    velocity = np.abs(one.velocity[-1] - other.velocity[-1]).max()
    return float(velocity), float(np.abs(one.spin[-1] - other.spin[-1]).max())


def settled(law: LinearLaw, seed: int) -> dict[str, tuple[float, float]]:
    """Of discs that have come to rest in the box, here and there; shares of weight or energy."""
    scene = discs_in_a_box(law, seed)
    motions = both(scene, 0.6, 60)
    energies = [kinetic(scene, motion) for motion in motions]
    calm = [energy < 0.01 * energy.max() for energy in energies]
    weight = GRAVITY * scene.mass.sum()
    return {
        "height [mm]": tuple(1e3 * height(scene, motion)[-1] for motion in motions),
        "energy below 1 % [s]": tuple(
            motion.time[len(rest) - int(np.argmin(rest[::-1])) - 1]
            for motion, rest in zip(motions, calm, strict=True)
        ),
        "floor / weight": tuple(motion.floor[-5:].mean() / weight for motion in motions),
    }


def print_two_bodies() -> None:
    """Differences after an impact of two."""
    print("| two discs | velocity apart [m/s] | spin apart [rad/s] | spin here [rad/s] |")
    print("|---|---|---|---|")
    for name, law in LAWS.items():
        motions = both(two_discs(law), 2.4e-3, 8)
        spin = np.abs(motions[0].spin[-1]).max()
        print("| {} | {:.1e} | {:.1e} | {:.3g} |".format(name, *differences(*motions), spin))
    finer = two_discs(LAWS["damping"], time_step=5e-7)
    print("| damping, half the step | {:.1e} | | |".format(*differences(*both(finer, 2.4e-3, 8))))
    hard = LAWS["friction"]._replace(kn=4 * SPRINGS.kn, kt=4 * SPRINGS.kt)
    line = "| friction, four times as stiff | {:.1e} | {:.1e} | |"
    print(line.format(*differences(*both(two_discs(hard, 5e-7), 2.4e-3, 8))))
    print("\n| two squares | velocity apart [m/s] | contact time here, there [us] |\n|---|---|---|")
    for how in SQUARES:
        one, other = both(two_squares(how), 8e-4, 800)
        times = 1e6 * contact_time(one), 1e6 * contact_time(other)
        print("| {} | {:.1e} | {:.0f}, {:.0f} |".format(how, differences(one, other)[0], *times))


def print_collisions(n: int = 100) -> None:
    """How many random impacts of squares come out alike, and what became of their energy."""
    apart_by, gains = [], []
    for seed in range(n):
        scene = colliding_squares(seed)
        motions = both(scene, 14e-3, 1)
        before = 0.5 * scene.mass[0]
        apart_by.append(differences(*motions)[0])
        gains.append([abs(kinetic(scene, motion)[-1] / before - 1) for motion in motions])
    alike, (here_most, there_most) = np.array(apart_by) < 1e-8, np.max(gains, axis=0)
    print(f"\n{n} impacts of squares at any angle: {alike.sum()} alike to 1e-8 m/s; energy off by "
          f"at most {here_most:.1e} of it here and {there_most:.3g} there, where "
          f"{int((np.array(gains)[:, 1] > 0.01).sum())} gain more than 1 %")  # fmt: skip


def print_assembly(n_seeds: int = 12) -> None:
    """60 discs in a box: how long the engines agree, and what they settle to."""
    print("\n| 60 discs, apart [m] at | 30 ms | 60 ms | 90 ms | 120 ms |\n|---|---|---|---|---|")
    for name, law in LAWS.items():
        off = apart(*both(discs_in_a_box(law), 0.12, 4))
        print(f"| {name} | " + " | ".join(f"{distance:.1e}" for distance in off) + " |")
    print(f"\n| at rest, {n_seeds} seeds | | here | there | difference |\n|---|---|---|---|---|")
    for name in ("damping", "friction", "friction and damping"):
        rows = [settled(LAWS[name], seed) for seed in range(1, n_seeds + 1)]
        for what in rows[0]:
            pairs = np.array([row[what] for row in rows])
            mean, off = pairs.mean(axis=0), pairs[:, 0] - pairs[:, 1]
            error = off.std(ddof=1) / np.sqrt(n_seeds)
            print(f"| {name} | {what} | {mean[0]:.4g} | {mean[1]:.4g} | "
                  f"{off.mean():.2g} ± {error:.2g} |")  # fmt: skip


if __name__ == "__main__":
    print_two_bodies()
    print_collisions()
    print_assembly()
