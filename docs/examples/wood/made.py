"""Tables as a laboratory would write them, made with the silo paper's means and scatter.

python docs/examples/wood/made.py FOLDER writes weighed.csv, tilt_wood.csv, tilt_wall.csv,
cubes.csv, slide.csv and drop.csv; those beside this file are what it writes. Alonso-Marroquin et
al., Granular Matter 15 (2013) 811: density sec. 3.5, friction secs 3.1.1 and 3.1.2, modulus sec.
3.2.1, gamma_t sec. 3.4, restitution Table 2 (its single trials are not printed).
"""

import sys
from pathlib import Path

import numpy as np

GRAVITY = 9.81  # [m/s2]


def write(folder: Path, name: str, head: str, columns: np.ndarray) -> None:
    """A table with three to five figures, as instruments give."""
    np.savetxt(folder / name, columns, fmt="%.5g", delimiter=",", header=head, comments="")


def tilts(rng: np.random.Generator, means: list[float], widths: list[float], n: int) -> np.ndarray:
    """Angles of first slip [deg], n for each of three pairings, read to 0.1 deg."""
    rows = [
        (k + 1, round(float(np.degrees(np.arctan(mean * (1 + width * rng.standard_normal())))), 1))
        for k, (mean, width) in enumerate(zip(means, widths, strict=True))
        for _ in range(n)
    ]
    return np.array(rows)


def weighed(rng: np.random.Generator) -> np.ndarray:
    """Mass [g], cross section [mm2] and length [mm] of five prisms of 0.45 g/cm3 +- 6 %."""
    area = rng.uniform(150, 250, 5)
    mass = 0.45e-3 * (1 + 0.06 * rng.standard_normal(5)) * area * 120
    return np.column_stack([mass, area, np.full(5, 120.0)])


def cubes(rng: np.random.Generator) -> np.ndarray:
    """Load [N] and displacement [mm] of five cubes of 10 mm: three cycles, 242 MPa +- 15 %."""
    rows = []
    for trial in range(1, 6):
        slope = 242.0 * (1 + 0.15 * rng.standard_normal()) * 100 / 10  # [N/mm] E A/L
        x, at = [0.0], [0.0]
        for peak in (300.0, 600.0, 900.0):
            for end, stiffness in ((peak, 0.6 * slope), (0.2 * peak, slope)):  # plastic, elastic
                loads = np.linspace(at[-1], end, 30)[1:]
                x += list(x[-1] + (loads - at[-1]) / stiffness)
                at += list(loads)
        noisy = np.array(x) + 2e-4 * rng.standard_normal(len(x))
        rows.append(np.column_stack([np.full(len(x), trial), noisy, at]))
    return np.concatenate(rows)


def slides(rng: np.random.Generator) -> np.ndarray:
    """Time [s] and velocity [m/s] of three blocks on a slope: eq. 3.11b, 3 1/s, 0.43 m/s."""
    time = np.arange(0, 1.5, 0.02)
    rows = []
    for trial in range(1, 4):
        end = 0.43 * (1 + 0.1 * rng.standard_normal())
        v = end * (1 - np.exp(-3.0 * time)) + 0.005 * rng.standard_normal(len(time))
        rows.append(np.column_stack([np.full(len(time), trial), time, v]))
    return np.concatenate(rows)


def drop(rng: np.random.Generator) -> np.ndarray:
    """Frame, x and y [px] of a particle that falls 500 px, 240 frames/s and 0.4 mm/px; e = 0.53."""
    a = GRAVITY / 0.4e-3 / 240**2
    frame = np.arange(230.0)
    contact, speed = 20.5 + np.sqrt(2 * 500 / a), np.sqrt(2 * 500 * a)
    y = np.where(frame < 20.5, 0.0, 0.5 * a * (frame - 20.5) ** 2)
    while 2 * 0.53 * speed / a > 2:
        speed *= 0.53
        s = frame - contact
        y = np.where(s >= 0, 500 - speed * s + 0.5 * a * s**2, y)
        contact += 2 * speed / a
    y = np.where(frame >= contact, 500.0, y)
    shake = 0.1 * rng.standard_normal((2, len(frame)))
    return np.column_stack([frame, 300 + 0.2 * frame + shake[0], 100 + y + shake[1]])


def main() -> None:
    """Write all tables into the folder that is named."""
    folder = Path(sys.argv[1])
    rng = np.random.default_rng(3)
    write(folder, "weighed.csv", "mass [g],area [mm2],length [mm]", weighed(rng))
    angles = "pairing,angle [deg]"
    write(folder, "tilt_wood.csv", angles, tilts(rng, [0.38, 0.40, 0.33], [0.07, 0.07, 0.04], 10))
    write(folder, "tilt_wall.csv", angles, tilts(rng, [0.46, 0.47, 0.40], [0.10, 0.13, 0.23], 12))
    write(folder, "cubes.csv", "trial,displacement [mm],load [N]", cubes(rng))
    write(folder, "slide.csv", "trial,time [s],velocity [m/s]", slides(rng))
    write(folder, "drop.csv", "frame,x,y", drop(rng))


if __name__ == "__main__":
    main()
