"""A run folder of a damper made without a simulation: a bed that hovers between floor and lid.

The enclosure moves by u = A sin(w t) (eq. 6.2) and the bed, as one, by s = (c/2)(1 - cos(w t))
in it: on the floor at the start of a cycle and at the lid in its middle. Every sphere also goes
round a small circle across the axis. What a cycle dissipates is given, in two steps a cycle:
D(p) = E (p - 0.9 sin(4 pi p)/(4 pi)) of its part p. The wall work is what closes the energy
balance.
"""

import json
from pathlib import Path

import numpy as np

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.trajectory import TrajectoryWriter

G = 9.81  # m/s2
GRAVITY = {"vertical": [0.0, 0.0, -G], "horizontal": [-G, 0.0, 0.0], "none": [0.0, 0.0, 0.0]}
DENSITY = 1190.0  # kg/m3
SHARES = {  # of what is dissipated
    "friction_particle_particle": 0.5,
    "normal_damping_particle_particle": 0.2,
    "tangential_damping_particle_particle": 0.05,
    "friction_particle_wall": 0.15,
    "normal_damping_particle_wall": 0.08,
    "tangential_damping_particle_wall": 0.02,
}
# Dissipated in the cycles in turn, over 4 (Gamma g/w)^2 M; the last holds from then on.
EFFICIENCY = [0.2, 0.3, 0.42, 0.5, 0.52]
LAW_GAIN = 0.04  # of what is dissipated, gained by the springs without work
CIRCLE = 0.2e-3  # m
OFFSETS = 1e-3 * np.array([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.25, 0.0]])  # m
RADII = np.array([0.9e-3, 0.9e-3, 0.7e-3])  # m

_CYLINDER = 'shape = "cylinder"\ndiameter = "20 mm"\nheight = "20 mm"'
_BOX = 'shape = "box"\nwidth = "20 mm"\ndepth = "14 mm"\nheight = "20 mm"'


def write_fake_damper_run(
    folder: Path,
    *,
    shape: str = "cylinder",
    orientation: str = "vertical",
    frequency: float = 40.0,
    gamma: float = 20.0,
    cycles: int = 5,
    discard: int = 3,
    samples: int = 40,
    frames: int = 8,
    finished: bool = True,
    keep: str = "all",
    diameter: float = 3e-3,
    until: int | None = None,
    clusters: bool = False,
    unlike: bool = False,
) -> RunFolder:
    """Write a run of some dozens of spheres; `samples` and `frames` (0: none) of each cycle.

    One that is not `finished` may have come to sample `until` only. As `clusters` the particles
    are OFFSETS and RADII of them, which turn about (1, 2, 2)/3; `unlike`: see _unlike.
    """
    height, clearance = 20e-3, 6e-3
    discard = min(discard, cycles - 1)
    start = _lattice(diameter, 10e-3, 10e-3 if shape == "cylinder" else 7e-3, height - clearance)
    if orientation == "horizontal":
        start = start[start[:, 0] < 2e-3]  # gravity is along -x
    mass = np.full(len(start), DENSITY * np.pi / 6 * diameter**3)
    names = ["bottom", "top", "side"] if shape == "cylinder" else [
        "bottom", "top", "left", "right", "front", "back"
    ]  # fmt: skip
    omega, period = 2 * np.pi * frequency, 1 / frequency
    time = period * np.arange(cycles * samples + 1) / samples
    moving = _motion(time, omega, gamma * G / omega**2, clearance, len(names), mass.sum())
    moving |= _books(time / period, moving, gamma * G / omega, mass.sum())
    run = RunFolder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    run.write_case(_case(shape, orientation, diameter, len(start), frequency, gamma, cycles,
                         discard, samples, frames, keep))  # fmt: skip
    static = {"radius": np.full(len(start), diameter / 2), "mass": mass}
    if clusters:
        static |= _unlike(static["radius"]) if unlike else _ALIKE
    fill = len(start) * np.pi / 6 * diameter**3 / (np.pi / 4 * 20e-3**2 * height)
    attributes = {
        "wall_names": json.dumps(names), "fill_ratio": fill, "frequency": frequency,
        "gamma": gamma, "period": period, "direction": np.array([0.0, 0.0, 1.0]),
        "gravity": np.array(GRAVITY[orientation]), "samples_per_cycle": samples,
        "frames_per_cycle": frames,
    }  # fmt: skip
    writer = TrajectoryWriter(folder)
    writer.write_static(static, attributes)
    for k in range(len(time)):
        sample = {key: array[k] for key, array in moving.items()}
        here = frames and k % (samples // frames) == 0
        table = _particles(start, sample, omega) if here else {}
        if here and clusters:
            table |= _turns(len(start), k / samples)
        writer.append(sample, {"particles": table} if here else None)
        if k == len(time) // 2:
            writer.flush()
        if k == until:
            break
    writer.flush()
    if finished:
        writer.finish(static, attributes)
        run.write_summary(_summary(moving, len(start), fill, mass[0], frequency, gamma, orientation,
                                   cycles, discard, diameter))  # fmt: skip
        if keep == "summary":
            (folder / "trajectory.h5").unlink()
    return run


_ALIKE = {"sphere_offset": OFFSETS, "sphere_radius": RADII}
_PAIR = np.array([[0.0, 0.8e-3, 0.0], [0.0, -0.8e-3, 0.0]]), np.array([0.7e-3, 0.6e-3])  # m
_SMALLER = 0.8


def _unlike(radius: np.ndarray) -> dict[str, np.ndarray]:
    """Of a mixture: the first half as above, the others of two spheres, each second one smaller."""
    later = np.arange(len(radius)) >= len(radius) // 2
    small = later & (np.arange(len(radius)) % 2 == 0)
    offset, own = _PAIR
    return {
        "radius": np.where(small, _SMALLER, 1.0) * radius,
        "kind": later.astype(np.int64),
        "sphere_offset": np.concatenate([OFFSETS, offset, _SMALLER * offset]),
        "sphere_radius": np.concatenate([RADII, own, _SMALLER * own]),
        "sphere_row": np.where(small, 5, np.where(later, 3, 0)),
        "sphere_count": np.where(later, 2, 3),
    }


def _lattice(diameter: float, across: float, deep: float, high: float) -> np.ndarray:
    """Centres (n, 3) [m] on a cubic lattice that touch neither a wall nor each other."""
    pitch = 1.06 * diameter
    reach = {"x": across, "y": deep}
    x, y = (np.arange(-reach[a] // pitch, reach[a] // pitch + 1) * pitch for a in "xy")
    z = np.arange(0.5 * diameter, high - 0.49 * diameter, pitch)
    points = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    room = across - diameter / 2 - CIRCLE
    inside = np.hypot(points[:, 0], points[:, 1]) <= room
    if deep != across:
        inside = (np.abs(points[:, 0]) <= room) & (
            np.abs(points[:, 1]) <= deep - diameter / 2 - CIRCLE
        )
    return points[inside]


def _motion(time, omega, amplitude, clearance, n_walls, mass) -> dict[str, np.ndarray]:
    """Of enclosure and bed; the force of the bed on floor and lid is its inertia and weight."""
    rise = clearance / 2 * (1 - np.cos(omega * time))
    velocity = amplitude * omega * np.cos(omega * time)
    bed = velocity + clearance / 2 * omega * np.sin(omega * time)
    gained = -amplitude * omega**2 * np.sin(omega * time)
    gained += clearance / 2 * omega**2 * np.cos(omega * time)
    pressing = -mass * (gained + G)  # on the enclosure
    force = np.zeros((len(time), n_walls, 3))
    force[:, 0, 2], force[:, 1, 2] = np.minimum(pressing, 0), np.maximum(pressing, 0)
    zero = np.zeros_like(time)
    return {
        "time": time,
        "displacement": amplitude * np.sin(omega * time),
        "velocity": velocity,
        "mean_position": np.stack([zero, zero, 7e-3 + rise], axis=1),
        "mean_velocity": np.stack([zero, zero, bed], axis=1),
        "wall_force": force,
    }


def _books(cycle, moving, peak_speed, mass) -> dict[str, np.ndarray]:
    """Energies [J] at `cycle` (S,), the time in periods."""
    part = cycle % 1.0
    per_cycle = np.array([EFFICIENCY[min(k, len(EFFICIENCY) - 1)] for k in range(1000)])
    k = np.floor(cycle + 1e-9).astype(int)
    part = np.where(part > 1 - 1e-9, 0.0, part)
    done = np.concatenate([[0], np.cumsum(per_cycle)])[k]
    now = per_cycle[k] * (part - 0.9 * np.sin(4 * np.pi * part) / (4 * np.pi))
    lost = (done + now) * 4 * peak_speed**2 * mass  # eq. 6.10
    held = {
        "kinetic": 0.5 * mass * moving["mean_velocity"][:, 2] ** 2,
        "potential": mass * G * (moving["mean_position"][:, 2] + moving["displacement"]),
        "elastic_normal": np.full_like(lost, 1e-7),
        "elastic_tangential": np.full_like(lost, 2e-8),
    }
    law = {
        "law_term_particle_particle": 0.75 * LAW_GAIN * lost,
        "law_term_particle_wall": 0.25 * LAW_GAIN * lost,
    }
    total = sum(held.values())
    counts = {}
    for c in ("particle_particle", "particle_wall"):
        counts[f"slip_count_{c}"] = 1.07 * SHARES[f"friction_{c}"] * lost
        counts[f"impact_speed_{c}"] = np.full_like(lost, 1.5)
        counts[f"contacts_{c}"] = np.full(len(lost), 60)
    return {
        **held,
        **law,
        **counts,
        **{name: share * lost for name, share in SHARES.items()},
        "wall_work": (1 - LAW_GAIN) * lost + total - total[0],
    }


def _particles(start, sample, omega) -> dict[str, np.ndarray]:
    """The table of a frame: positions relative to the enclosure, velocities in the lab."""
    n, phase = len(start), omega * sample["time"] + np.arange(len(start))
    x = start[:, 0] + CIRCLE * np.cos(phase)
    y = start[:, 1] + CIRCLE * np.sin(phase)
    rise = sample["mean_position"][2] - 7e-3
    lost = sum(sample[name] for name in SHARES)
    weight = 1 + np.arange(n)  # later spheres, which lie higher, dissipate more
    table = {
        "x": x, "y": y, "z": start[:, 2] + rise,
        "vx": -CIRCLE * omega * np.sin(phase), "vy": CIRCLE * omega * np.cos(phase),
        "vz": np.full(n, sample["mean_velocity"][2]),
        "spin_x": np.full(n, 1.0), "spin_y": np.full(n, 2.0), "spin_z": np.arange(n) * 3.0,
        "heat": lost * weight / weight.sum(),
    }  # fmt: skip
    return {name: column.astype(np.float32) for name, column in table.items()}


def _turns(n: int, cycle: float) -> dict[str, np.ndarray]:
    """Quaternions of a turn about (1, 2, 2)/3, each particle by another angle."""
    half = 0.5 * (cycle + np.arange(n))
    sine = np.sin(half) / 3
    parts = {"w": np.cos(half), "x": sine, "y": 2 * sine, "z": 2 * sine}
    return {f"turn_{c}": part.astype(np.float32) for c, part in parts.items()}


def _case(shape, orientation, diameter, count, frequency, gamma, cycles, discard, samples, frames,
          keep) -> str:  # fmt: skip
    return f"""schema = 1
name = "fake"
[enclosure]
{_CYLINDER if shape == "cylinder" else _BOX}
material = "acrylic"
[particles]
shape = "sphere:{1e3 * diameter:g}mm"
count = {count}
[motion]
orientation = "{orientation}"
frequency = {frequency}
gamma = {gamma}
[run]
seed = 1
cycles = {cycles}
discard = {discard}
[output]
samples = {samples}
frames = {frames}
keep = "{keep}"
"""


def _summary(
    moving, n, fill, mass, frequency, gamma, orientation, cycles, discard, diameter
) -> dict:
    etas = [(1 - LAW_GAIN) * EFFICIENCY[min(k, len(EFFICIENCY) - 1)] for k in range(cycles)]
    eta = float(np.mean(etas[discard:]))
    energy = eta * 4 * (gamma * G / (2 * np.pi * frequency)) ** 2 * n * mass
    shares: dict[str, dict[str, float]] = {}
    for c in ("particle_particle", "particle_wall"):
        kinds = ("friction", "normal_damping", "tangential_damping")
        shares[c] = {kind: SHARES[f"{kind}_{c}"] for kind in kinds}
    return {
        "frequency_hz": frequency, "gamma": gamma, "orientation": orientation,
        "particles": f"sphere:{1e3 * diameter:g}mm", "n_particles": n, "fill_ratio": fill,
        "particle_mass_kg": n * mass, "seed": 1, "cycles": cycles,
        "discarded": discard, "efficiency": eta,
        "efficiency_interval": [eta - 0.02, eta + 0.02], "efficiency_contact_count": 1.06 * eta,
        "efficiency_wall_work": eta, "efficiency_per_cycle": etas, "shares": shares,
        "law_term": LAW_GAIN, "dissipated_power_w": energy * frequency, "loss_factor": 0.3,
        "effective_mass": {"in_phase_kg": 0.01, "out_of_phase_kg": -0.02},
        "peak_wall_force_n": float(np.abs(moving["wall_force"].sum(axis=1)).max()),
        "bed_height_m": 0.01, "energy_closure": 1e-3,
        "max_impact_over_yield_velocity": {"particle_particle": 0.4, "particle_wall": 0.2},
        "phase": "bouncing bed", "steady": None, "time_step_s": 1e-6, "steps": 125000,
        "cpu_us_per_step": 6.0, "cpu_s": 0.75, "state_digest": "0" * 12, "reused": False,
    }  # fmt: skip
