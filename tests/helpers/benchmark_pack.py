"""Cases of the benchmark pack in our engines, from their files alone, as another code has them."""

import copy
import csv
import dataclasses
import math
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from damper3d.engine.enclosures import box
from damper3d.engine.motions import Sines, at_rest
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from damper3d.shapes.multisphere import sphere
from damper3d.shapes.surfaces import union
from granulab.contact.laws import LinearLaw
from granulab.contact.material import Material, Measured
from granulab.contact.sphere_law import sphere_law
from silo2d.case.outline import Walls
from silo2d.case.shape import disc, shape_from_outline
from silo2d.engine import simulation as plane
from silo2d.engine import state
from silo2d.engine.world import build_world as build_plane
from silo2d.loads.janssen import janssen_stress

PACK = Path(__file__).parents[2] / "docs" / "pack"
SIDE = 100  # of the box that stands for open space, over the largest radius
LEVEL = 10.0  # of the floor in the plane [m]: what is below 0 counts as out of the silo


def variants(name: str) -> Iterator[tuple[str, dict, list[dict[str, str]]]]:
    """Name, set-up and expected rows of each variant of a case."""
    folder = PACK / "cases" / name
    case = tomllib.loads((folder / "case.toml").read_text(encoding="utf-8"))
    with (folder / "expected.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for changes in case.get("variant") or [{"name": ""}]:
        made = copy.deepcopy(case)
        for key, value in changes.items():
            *path, last = key.split(".")
            inner = made
            for part in path:
                inner = inner[int(part) - 1] if part.isdigit() else inner[part]
            inner[last] = value
        yield changes["name"], made, [row for row in rows if row["variant"] == changes["name"]]


def results(case: dict, rows: list[dict[str, str]]) -> list[float]:
    """Our result for each row."""
    if "silo" in case:
        silo = case["silo"]
        ratio = silo["lateral_pressure_ratio"]
        stress = janssen_stress(
            silo["depth_m"],
            silo["unit_weight_n_m3"],
            silo["wall_friction"] * ratio,
            2 * silo["area_over_perimeter_m"],
        )
        return [float(stress)] * len(rows)
    (shape, *_) = (body["shape"] for body in case["body"])
    if "time_step_s" not in case:
        return _of_shape(case["body"][0], rows)
    if "motion" in case:
        return [_shaken(case, row["quantity"]) for row in rows]
    if shape == "rigid body":
        return _rotating(case, rows)
    return _moving(InPlane(case) if case["law"]["kind"] == "linear" else InSpace(case), case, rows)


def _of_shape(body: dict, rows: list[dict[str, str]]) -> list[float]:
    if body["shape"] == "spheropolygon":
        shape = shape_from_outline("it", body["outline_m"], body["corner_radius_m"], "pack")
        known = {"area": shape.area, "polar moment of area": shape.polar_moment}
    else:
        volume, _ = union.of_any(np.array(body["centres_m"]), np.array(body["radii_m"]))
        known = {"volume": volume}
    return [known[row["quantity"]] for row in rows]


class InSpace:
    """Spheres by Hertz's law in the damper's engine."""

    def __init__(self, case: dict, samples: int = 1):
        bodies, radii = case["body"], [body["radius_m"] for body in case["body"]]
        side, walls = SIDE * max(radii), {wall["name"]: wall for wall in case.get("wall", [])}
        floor = walls["floor"]["point_m"][2] if walls else -side / 2
        self.floor, height = floor, (walls["lid"]["point_m"][2] - floor if "lid" in walls else side)
        own = [_material(one) for one in case["material"]]
        used = [own[body["material"] - 1] for body in bodies]
        other = walls["floor"].get("material", "rigid") if walls else "rigid"
        motion, shaker = case.get("motion"), at_rest()
        if motion:
            shaker = Sines(np.array([motion["amplitude_m"]]),
                           np.array([2 * math.pi * motion["frequency_hz"]]),
                           np.array([motion["phase_rad"]]), 0.0)  # fmt: skip
        world = build_world(
            np.array([body["position_m"] for body in bodies]) - [0.0, 0.0, floor], np.array(radii),
            density=np.array([one.density.value for one in used]),
            enclosure=box(side, side, height), pair_law=_hertz(case["law"], used[0], used[-1]),
            wall_law=_hertz(case["law"], used[0], None if other == "rigid" else own[other - 1]),
            shaker=shaker, direction=np.array([0.0, 0.0, 1.0]),
            gravity=np.array(case["gravity_m_s2"], float), time_step=case["time_step_s"],
        )  # fmt: skip
        self.sim = Simulation(world, samples)
        self.sim.set_velocity(*(np.array([body[key] for body in bodies], float)
                                for key in ("velocity_m_s", "angular_velocity_rad_s")))  # fmt: skip

    def step(self, n: int) -> None:
        self.sim.step(n)

    def contacts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Bodies (n, 2), overlaps [m] and normal forces [N] of all contacts."""
        found = self.sim.contacts()
        return found["bodies"], found["overlap"], np.abs((found["force"] * found["normal"]).sum(1))

    def state(self) -> dict[str, np.ndarray]:
        frame = self.sim.frame()
        return {"height": frame["x"][:, 2] + self.floor, "normal velocity": frame["v"][:, 2],
                "tangential velocity": frame["v"][:, 0],
                "angular velocity": frame["spin"][:, 1]}  # fmt: skip

    def kinetic(self) -> float:
        return float(self.sim.sample()["kinetic"][0])


def _material(constants: dict) -> Material:
    named = {key: Measured(constants[name]) for key, name in (
        ("density", "density_kg_m3"), ("youngs_modulus", "youngs_modulus_pa"),
        ("poisson", "poisson"))}  # fmt: skip
    return Material("it", **named)


def _hertz(law: dict, first: Material, second: Material | None):
    return sphere_law(first, second, friction=law["friction"], restitution=law["restitution"],
                      end=law["ends_at_zero"])  # fmt: skip


class InPlane:
    """Bodies by the linear law in the silo's engine, x and z in its plane; a tilted floor.

    Gravity acts downwards there, so that the floor is what is inclined; downhill is to the left.
    """

    def __init__(self, case: dict):
        bodies, gravity = case["body"], case["gravity_m_s2"]
        self.angle = math.atan2(gravity[0], -gravity[2])
        self.down = np.array([-math.cos(self.angle), -math.sin(self.angle)])  # along x of the case
        self.up = np.array([-math.sin(self.angle), math.cos(self.angle)])
        shapes = [self._shape(body) for body in bodies]
        segments = [self._wall(wall) for wall in case["wall"]]
        names = [wall["name"] for wall in case["wall"]]
        law = case["law"]
        made = LinearLaw(law["stiffness_n_m"], law["tangential_stiffness_n_m"], law["friction"],
                         law["damping_1_s"], law["tangential_damping_1_s"],
                         law["ends_at_zero"] == "overlap")  # fmt: skip
        places = [self._at(body["position_m"]) for body in bodies]
        world = build_plane(
            shapes, np.arange(len(shapes)),
            np.array([[*place, self.angle] for place in places]),
            Walls(np.array(segments), names, np.full(len(names), 2)),
            surface_density=bodies[0].get("surface_density_kg_m2", 1.0), particle_law=made,
            wall_law=made, gravity=math.hypot(gravity[0], gravity[2]),
            time_step=case["time_step_s"],
        )  # fmt: skip
        self.sim, rows = plane.Simulation(world), world.bodies.row
        for k, body in enumerate(bodies):
            if "mass_kg" in body:
                rows[k, state.INV_MASS] = 1 / body["mass_kg"]
                rows[k, state.INV_INERTIA] = 1 / body["moment_kg_m2"]
            v = body["velocity_m_s"][0] * self.down + body["velocity_m_s"][2] * self.up
            moves = *v, body["angular_velocity_rad_s"][1]
            rows[k, [state.VX, state.VY, state.OMEGA]] = moves
            rows[k, [state.UX, state.UY, state.UOMEGA]] = moves

    @staticmethod
    def _shape(body: dict):
        if body["shape"] == "sphere":
            return disc("it", 2 * body["radius_m"])
        return shape_from_outline("it", body["outline_m"], body["corner_radius_m"], "pack")

    def _at(self, point: list[float]) -> np.ndarray:
        return point[0] * self.down + point[2] * self.up + [0.0, LEVEL]

    def _wall(self, wall: dict) -> np.ndarray:
        """A segment with its inside on the left."""
        along = -self.down * wall["normal"][2]
        return np.array([self._at(wall["point_m"]) - along, self._at(wall["point_m"]) + along])

    def step(self, n: int) -> None:
        self.sim.run(n)

    def state(self) -> dict[str, np.ndarray]:
        rows = self.sim.rows
        place, v = rows[:, [state.X, state.Y]] - [0.0, LEVEL], rows[:, [state.UX, state.UY]]
        return {
            "height": place @ self.up,
            "normal velocity": v @ self.up,
            "tangential velocity": v @ self.down,
            "angular velocity": rows[:, state.UOMEGA],
        }


IMPACTS = ("deepest overlap", "largest normal force", "contact time")


def _moving(run, case: dict, rows: list[dict[str, str]]) -> list[float]:
    """Step to each time that is asked for; watch the contact where an impact is measured."""
    dt, seen = case["time_step_s"], dict.fromkeys(IMPACTS, 0.0)
    before = run.kinetic() if isinstance(run, InSpace) else 0.0
    if any(row["quantity"] in IMPACTS for row in rows):
        _watch(run, seen, dt, round(case["duration_s"] / dt))
    done, found = 0, []
    for row in sorted(rows, key=lambda row: float(row["time_s"] or math.inf)):
        at = round(float(row["time_s"] or case["duration_s"]) / dt)
        if row["quantity"] not in IMPACTS and at > done:
            run.step(at - done)
            done = at
        found.append((rows.index(row), _reads(run, row, seen, before)))
    return [value for _, value in sorted(found)]


def _watch(run: InSpace, seen: dict[str, float], dt: float, steps: int) -> None:
    """Follow the only contact from its first touch to its end; AssertionError without an end."""
    touched = False
    for _ in range(steps):
        run.step(1)
        _, overlaps, forces = run.contacts()
        if len(overlaps) == 0:
            if touched:
                return
            continue
        touched = True
        seen["contact time"] += dt
        seen["deepest overlap"] = max(seen["deepest overlap"], float(overlaps[0]))
        seen["largest normal force"] = max(seen["largest normal force"], float(forces[0]))
    raise AssertionError(f"no impact that ends in {steps} steps")


def _reads(run, row: dict[str, str], seen: dict[str, float], before: float) -> float:
    quantity, body = row["quantity"], int(row["body"] or 1)
    if quantity in seen:
        return seen[quantity]
    if quantity == "energy lost":
        return before - run.kinetic()
    if quantity in ("force on the floor", "overlap below"):
        who, overlaps, forces = run.contacts()
        n = run.sim.n_particles
        lowest = [k for k, pair in enumerate(who) if max(pair) >= n]
        if quantity == "force on the floor":
            return float(forces[lowest].sum())
        pair = {body - 2, body - 1}
        own = lowest if body == 1 else [k for k, two in enumerate(who) if set(two) == pair]
        return float(overlaps[own[0]])
    return float(run.state()[quantity][body - 1])


def _shaken(case: dict, quantity: str) -> float:
    """Mean energy that a counted cycle dissipates, or the efficiency."""
    motion = case["motion"]
    steps = round(1 / (motion["frequency_hz"] * case["time_step_s"]))
    run = InSpace(case, steps)
    skipped = case["cycles_not_counted"]
    run.sim.run(skipped)
    rows = run.sim.run(case["cycles"] - skipped + 1)
    lost = float(np.diff(rows["normal_damping_particle_wall"]).mean())
    if quantity == "energy lost a cycle":
        return lost
    speed = motion["amplitude_m"] * 2 * math.pi * motion["frequency_hz"]
    return lost / (4 * speed**2 * float(run.sim.mass.sum()))


def _rotating(case: dict, rows: list[dict[str, str]]) -> list[float]:
    """A rigid body far from any wall, in its own axes."""
    (body,) = case["body"]
    ball = sphere(1e-3)
    density = body["mass_kg"] / ball.volume
    moments = np.array(body["principal_moments_kg_m2"]) / density
    material = Material(
        "it", Measured(density), youngs_modulus=Measured(1e9), poisson=Measured(0.3)
    )
    law = sphere_law(material, None, friction=0.0, restitution=1.0)
    world = build_world(
        np.array([[0.0, 0.0, 0.5]]), dataclasses.replace(ball, inertia=moments),
        np.array([[1.0, 0.0, 0.0, 0.0]]), density=density, enclosure=box(1.0, 1.0, 1.0),
        pair_law=law, wall_law=law, shaker=at_rest(), direction=np.array([0.0, 0.0, 1.0]),
        gravity=np.zeros(3), time_step=case["time_step_s"],
    )  # fmt: skip
    sim = Simulation(world)
    sim.set_velocity(np.zeros((1, 3)), np.array([body["own_angular_velocity_rad_s"]]))
    found = []
    for row in rows:
        sim.step(round(float(row["time_s"]) / case["time_step_s"]) - sim.steps)
        now = sim.frame()
        own = _own(now["orientation"][0], now["spin"][0])
        found.append(float(own["xyz".index(row["quantity"][-1])]))
    return found


def _own(q: np.ndarray, w: np.ndarray) -> np.ndarray:
    """A vector in the axes of a body of orientation q: q* w q."""
    s, v = q[0], -q[1:]
    return w + 2 * np.cross(v, np.cross(v, w) + s * w)
