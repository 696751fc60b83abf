"""A silo case: settings resolved to shapes, outline, laws and time step; text to arrays."""

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from granulab.contact.files.casefile import changed
from granulab.contact.files.datafile import case_names, data_file, find, is_file, is_shipped
from granulab.contact.files.units import both, located, nearest, to_si
from granulab.contact.laws import LinearLaw
from granulab.contact.restitution import linear_restitution
from granulab.errors import InputError
from silo2d.case.beds.elastic import PAIRS, Derived, Solids, solids_of, with_elastic
from silo2d.case.beds.flow import check_flow
from silo2d.case.beds.laws import check_laws, curve_file, with_cohesion, with_curve
from silo2d.case.beds.openings import check_ways, with_inserts, with_outlets
from silo2d.case.disorder import Spread, drawn_laws, spreads, stiffest
from silo2d.case.filling import (
    GRAVITY,
    filling_friction,
    filling_laws,
    filling_time_step,
    particles_below,
    rain_of,
)
from silo2d.case.impulses import Impulses, impulses_of
from silo2d.case.limits import check_contacts, check_softness, check_steps
from silo2d.case.outline import PRESETS, Outline, hopper, outline_from_polygon, preset, preset_sizes
from silo2d.case.parameters import (
    contact_laws,
    shapes_of,
    table_of,
    time_step_of,
    whole_pairs,
)
from silo2d.case.settings import Fill, Flow, Settings, Silo, check_settings, read_settings, to_toml
from silo2d.case.shape import ShapeSet, vertex_list
from silo2d.case.shapefile import files_beside
from silo2d.engine.pair_law import Law
from silo2d.engine.state import MAX_VERTICES


@dataclass(frozen=True, eq=False)
class SiloCase:
    """Everything that a run needs to know, validated; SI."""

    settings: Settings
    outline: Outline
    shapes: ShapeSet
    surface_density: float  # density times prism length [kg/m2]
    particle_law: Law  # LinearLaw, unless a case is given another, see silo2d.register_law
    wall_law: Law
    disorder: tuple[Spread, Spread] | None  # particle-particle, particle-wall, about these laws
    time_step: float  # [s]
    time_step_reason: str
    pour_laws: tuple[LinearLaw, LinearLaw]  # soft, and without friction unless given
    pour_time_step: float  # [s]
    files: dict[str, str]  # name in the run folder -> text, of the shapes and materials used
    impulses: Impulses | None = None  # what pymunk takes, for a case that it runs
    length: float = math.nan  # of the prisms [m]
    derived: tuple[Derived | None, Derived | None] = (None, None)  # see with_elastic
    solids: Solids | None = None  # None: of no materials file
    parts: tuple[str, ...] = ()  # names of its shapes, unless these are shipped

    @classmethod
    def load(cls, name_or_path: str | Path, changes: dict[str, Any] | None = None) -> "SiloCase":
        """A preset ("A4") or a case file (TOML), with changes such as {"law.kn": "1e4 N/mm"}.

        Raises InputError, one line that names file or option, key, value and what would do.
        """
        name = str(name_or_path)
        path = Path(name)
        if name in PRESETS:
            document: dict[str, Any] = {"name": name, "silo": {"preset": name}}
            return cls.resolve(_changed(document, changes), name, Path())
        if not is_file(path):
            known = [*PRESETS, *case_names("silo")]
            shipped = data_file("cases", name)
            if shipped is None and is_file(Path(f"{name}.toml")):
                raise InputError(f"case {name!r}: no such preset; did you mean '{name}.toml'?")
            if shipped is None:
                raise InputError(f"case {name!r}: no such preset or file; {nearest(name, known)}")
            path = shipped
        if path.suffix.lower() in (".svg", ".dxf"):
            raise InputError(
                f"{path}: a drawing, no case; `silo2d init my_silo.toml --outline {path}` makes "
                "one of it"
            )
        return cls.resolve(_changed(read_settings(path), changes), str(path), path.parent)

    @classmethod
    def resolve(cls, document: dict[str, Any], where: str, folder: Path) -> "SiloCase":
        """A case from the tables of a case file; files it names are looked for in `folder`."""
        settings = _with_acting_flow(check_settings(document, where))
        shapes_file = find(settings.particles.shapes, "shapes", folder)
        table_file = find(settings.particles.materials, "materials", folder)
        outline = outline_of(settings, where)
        shapes, (table, settings) = both(
            lambda: shapes_of(shapes_file, settings.particles),
            lambda: table_of(table_file, settings),
        )
        _check_sizes(outline, shapes, settings, where)
        settings = _thinned(settings, outline, shapes)
        names = settings.particles.names
        material = table.material(names[0])
        assert material.length is not None  # table_of has refused that
        surface_density = material.density.value * material.length.value
        mean_mass = surface_density * shapes.mean_area
        own = table.pair(names[0], names[0]), table.pair(*names)
        solids = solids_of(table, settings, shapes)
        own, derived = with_elastic(own, table, solids, settings, mean_mass)
        pairs = whole_pairs(settings, own, mean_mass, where)
        laws = contact_laws(settings, pairs, mean_mass, where)
        check_laws(settings, where)
        curved = with_curve(laws, settings, folder, where)
        if curved is not None:  # the steepest part decides on steps and softness
            laws = (
                laws[0]._replace(kn=curved[0].kn),
                laws[1]._replace(kn=curved[1].kn),
            )
        check_contacts(laws, material.length.value, mean_mass, where)
        disorder = spreads(settings, pairs, laws, where)
        bounds = stiffest(laws, disorder, settings.law.contact_end)
        time_step, reason = time_step_of(
            settings.run.time_step, shapes, surface_density, bounds,
            is_shipped(shapes_file, "shapes") and not any(derived), disorder is not None, where,
        )  # fmt: skip
        rain = rain_of(outline, shapes, surface_density, settings.fill)
        acting = curved or with_cohesion(laws, settings, material.length.value)
        if settings.run.engine == "dem":
            check_softness(acting, rain, settings.fill.level, shapes, where)
        pour_laws = filling_laws(pairs, filling_friction(settings, laws, where), rain)
        pour_time_step = filling_time_step(shapes, surface_density, pour_laws)
        check_steps(settings, time_step, pour_time_step, where)
        check_flow(settings, shapes, time_step, where)
        files = {"shapes.toml": shapes_file, "materials.toml": table_file}
        files |= files_beside(shapes_file) | curve_file(settings, folder)
        return cls(
            settings, outline, shapes, surface_density, *acting, disorder, time_step, reason,
            pour_laws, pour_time_step,
            {name: Path(file).read_text(encoding="utf-8") for name, file in files.items()},
            impulses_of(
                settings, pairs, laws, shapes, math.sqrt(2 * GRAVITY * outline.height), where
            ),
            material.length.value, derived, solids,
            () if is_shipped(shapes_file, "shapes") else shapes.parts,
        )  # fmt: skip

    @property
    def name(self) -> str:
        """Name that the run folder is called after."""
        return self.settings.name

    @property
    def step_source(self) -> str:
        """Source of the time step: "given" by the case, or "chosen"."""
        return "chosen" if self.settings.run.time_step is None else "given"

    @property
    def intervals(self) -> tuple[float, float]:
        """Time between frames, and between those with contacts [s]."""
        output = self.settings.output
        assert output.frame_interval is not None  # see _thinned
        assert output.contact_interval is not None
        return output.frame_interval, output.contact_interval

    @cached_property
    def silo_name(self) -> str | None:
        """The paper's silo that this outline is, or None."""
        own = self.outline
        if own.inserts or own.outlets:
            return None
        rotations = [np.roll(own.polygon, k, axis=0) for k in range(len(own.polygon))]
        for name in PRESETS:
            known = preset(name)
            same = [t for t in rotations if t.shape == known.polygon.shape]
            moved = abs(known.outlet_centre - own.outlet_centre) > 1e-9
            if (
                math.isclose(known.outlet, own.outlet)
                and not moved
                and any(np.allclose(polygon, known.polygon, rtol=0, atol=1e-9) for polygon in same)
            ):
                return name
        return None

    @property
    def label(self) -> str:
        """Name of the silo: the paper's, marked where anything is not the paper's."""
        if self.published_name and self._acts_as(SiloCase.load(self.published_name)):
            return self.published_name
        name = self.silo_name or self.name
        return f"{name} (changed)" if name in PRESETS else name

    @property
    def published_name(self) -> str | None:
        """The paper's silo whose printed times this case may be compared with, or None.

        Outline and fill level are the paper's, and nothing acts after the opening; particles and
        law may differ, as in its own study of sensitivity.
        """
        own = self.settings
        usual = math.isclose(own.fill.level, Fill().level) and own.flow == Flow()
        return self.silo_name if usual else None

    def _acts_as(self, other: "SiloCase") -> bool:
        """True where particles, laws, filling, plates and door are those of another case."""
        mine, theirs = (
            (
                case.particle_law,
                case.wall_law,
                case.disorder,
                [case.settings.disorder.per, case.settings.run.door_speed],
                [case.settings.fill.friction, case.settings.fill.layer],
                [case.settings.law.mu_plates, case.settings.law.plates_ratio],
                case.surface_density,
                [(shape.core.tolist(), shape.spheroradius) for shape in case.shapes.shapes],
                case.shapes.shares,
            )
            for case in (self, other)
        )
        return mine == theirs

    @property
    def mean_mass(self) -> float:
        """Mass of a particle of mean area [kg]."""
        return self.surface_density * self.shapes.mean_area

    def laws(self, n_particles: int) -> tuple[Law, Law]:
        """Laws of the particle-particle and the particle-wall pairs of a world of n_particles."""
        shared = self.particle_law, self.wall_law
        if self.disorder is None:
            return shared
        if not all(isinstance(law, LinearLaw) for law in shared):
            raise InputError("[disorder] draws the constants of the linear law; leave it out")
        return drawn_laws(shared, self.disorder, self.settings, n_particles)

    def restitution(self) -> dict[str, dict[str, float]]:
        """Restitution by the laws, for two particles of mean mass and for one against a wall.

        Through one contact, and face to face: eight contacts in parallel, two at a wall. Impulses
        have for both what they are given; nothing for laws that are not linear.
        """
        if self.impulses:
            return {
                name: {"one_contact": value, "face_to_face": value}
                for name, value in zip(PAIRS, self.impulses.restitution, strict=True)
            }
        if not isinstance(self.particle_law, LinearLaw):
            return {}
        result = {}
        for pair, law, mass, faces in (
            (PAIRS[0], self.particle_law, self.mean_mass / 2, 8),
            (PAIRS[1], self.wall_law, self.mean_mass, 2),
        ):
            end = self.settings.law.contact_end
            result[pair] = {
                "one_contact": linear_restitution(law.gamma_n, law.kn, mass, end=end),
                "face_to_face": linear_restitution(
                    law.gamma_n, law.kn, mass, end=end, contacts=faces
                ),
            }
        return result

    def to_toml(self) -> str:
        """The case as a file for the run folder, next to the copies of the files it names."""
        particles = self.settings.particles.model_copy(
            update={"shapes": "shapes.toml", "materials": "materials.toml"}
        )
        law = self.settings.law
        if law.kn_curve is not None:
            law = law.model_copy(update={"kn_curve": "kn_curve.csv"})
        return to_toml(self.settings.model_copy(update={"particles": particles, "law": law}))

    def identity(self) -> dict[str, Any]:
        """Identity of a run, which names its folder: all that its results depend on."""
        return {
            "settings": _acting(self.settings),
            **({"disorder": self.disorder} if self.disorder else {}),
            "polygon": self.outline.polygon,
            "outlet": [self.outline.outlet, self.outline.outlet_centre],
            "shapes": shapes_identity(self.shapes),
            **({"parts": list(self.parts)} if len(set(self.parts)) > 1 else {}),
            "surface_density": self.surface_density,
            **({"length": self.length} if abs(self.length - _USUAL_LENGTH) > 1e-9 else {}),
            "laws": [law_identity(self.particle_law), law_identity(self.wall_law)],
            "time_step": self.time_step,
            "pour_laws": [list(law) for law in self.pour_laws],
            "pour_time_step": self.pour_time_step,
        }


_USUAL_LENGTH = 0.12  # [m] of the shipped materials; runs of this length are not named by it
# Keys that a packing or a run is not named by while they are off: folders made before there were
# such keys keep their names.
_OFF = {
    ("silo", "inserts"): None,
    ("silo", "outlets"): None,
    ("law", "cohesion"): None,
    ("law", "kn_curve"): None,
    ("law", "mu_plates"): None,
    ("law", "plates_ratio"): None,
    ("fill", "friction"): False,
    ("fill", "layer"): None,
    ("run", "door_speed"): None,
    ("output", "wall_interval"): None,
}


def _acting(settings: Settings) -> dict[str, Any]:
    """The settings that results depend on, but for the engine, which names a run by itself."""
    tables = settings.model_dump(
        exclude={"name": True, "particles": True, "pymunk": True, "run": {"engine"}}
    )
    if settings.disorder.per == "none":
        del tables["disorder"]
    if settings.flow == Flow():
        del tables["flow"]
    for (section, key), off in _OFF.items():
        if tables[section][key] == off:
            del tables[section][key]
    return tables


def law_identity(law: Any) -> list[Any]:
    """The numbers of a law, and its type where that is not the linear one."""
    return [*law] if isinstance(law, LinearLaw) else [type(law).__qualname__, *law]


def shapes_identity(shapes: ShapeSet) -> list[Any]:
    """The numbers of a shape set."""
    rows = zip(shapes.shapes, shapes.shares, strict=True)
    return [[shape.core, shape.spheroradius, share] for shape, share in rows]


def _changed(document: dict[str, Any], changes: dict[str, Any] | None) -> dict[str, Any]:
    """The document with some keys ("section.key") set."""
    return changed(document, changes, Settings)


def _outline(silo: Silo, name: str, where: str) -> Outline:
    if silo.outline is not None:
        given = [
            key for key in ("preset", "angle", "width", "height") if getattr(silo, key) is not None
        ]
        if given:
            raise InputError(
                f"{where}: [silo] {given[0]} goes with a hopper, outline with any polygon; leave "
                "one of them out"
            )
        field = f"{where}: [silo] outline"
        unit = to_si(f"1 {silo.outline_unit}", "m", f"{where}: [silo] outline_unit")
        points = vertex_list(silo.outline, field) * unit
        return outline_from_polygon(points, silo.outlet, silo.outlet_centre, name, field)
    with located(f"{where}: [silo]"):
        to_si(f"1 {silo.outline_unit}", "m", "outline_unit")
        if silo.outlet_centre is not None:
            raise InputError("outlet_centre goes with an outline; leave it out, or give one")
        angle, outlet = preset_sizes(silo.preset) if silo.preset else (None, None)
        angle = angle if silo.angle is None else silo.angle
        outlet = silo.outlet or outlet
        if angle is None or outlet is None:
            raise InputError("needs a preset ('A4'), or angle and outlet, or an outline")
        size = silo.width or 0.3, silo.height or 0.5
        return dataclasses.replace(hopper(angle, outlet, *size, "hopper"), name=name)


def _with_acting_flow(settings: Settings) -> Settings:
    """The settings without what of [flow] never acts: a gate after the end, a bare direction."""
    flow, end = settings.flow, settings.run.max_time
    idle: dict[str, Any] = {}
    if flow.gate_times:
        within = zip(flow.gate_times, flow.gate, strict=True)
        idle["gate_times"] = [text for text, time in within if time < end] or None
    if flow.vibration_amplitude is None:
        idle["vibration_direction"] = Flow().vibration_direction
    return settings.model_copy(update={"flow": flow.model_copy(update=idle)})


USUAL_INTERVALS = 0.01, 0.05  # [s] between frames, and those with contacts, of ...
_MOST_PARTICLES = 10_000_000
_AT_MOST = 20_000  # particles; of more, whole multiples


def _thinned(settings: Settings, outline: Outline, shapes: ShapeSet) -> Settings:
    """The settings with the intervals of the output that they leave out.

    Many particles have fewer frames, so that disk and the memory of pictures stay in bounds: in a
    second no more than two million positions.
    """
    n = particles_below(settings.fill.level, outline, shapes) + settings.flow.refill
    times, output = max(math.ceil(n / _AT_MOST), 1), settings.output
    left_out = {
        key: times * usual
        for key, usual in zip(("frame_interval", "contact_interval"), USUAL_INTERVALS, strict=True)
        if getattr(output, key) is None
    }
    return settings.model_copy(update={"output": output.model_copy(update=left_out)})


def outline_of(settings: Settings, where: str) -> Outline:
    """The silo of a case's settings; InputError where it is none."""
    return _opened(_outline(settings.silo, settings.name, where), settings, where)


def _opened(outline: Outline, settings: Settings, where: str) -> Outline:
    """The silo with its inserts and further outlets."""
    silo, field = settings.silo, f"{where}: [silo]"
    unit = to_si(f"1 {silo.outline_unit}", "m", f"{field} outline_unit")
    if silo.outlets:
        if settings.run.door_speed is not None:
            raise InputError(
                f"{where}: [run] door_speed: further outlets open at once; leave it out, or outlets"
            )
        outline = with_outlets(outline, silo.outlets, unit, f"{field} outlets")
        if settings.run.engine == "pymunk" and any(ends[:, 1].any() for ends in outline.outlets):
            raise InputError(
                f"{field} outlets: one in the side goes with engine = 'dem'; leave one of them out"
            )
    if silo.inserts:
        outline = with_inserts(outline, silo.inserts, unit, f"{field} inserts")
    return outline


def _check_sizes(outline: Outline, shapes: ShapeSet, settings: Settings, where: str) -> None:
    """Check what must hold between the silo, the particles and the fill level."""
    narrowest = min(shape.width for shape in shapes.shapes)
    if outline.outlet < narrowest:
        raise InputError(
            f"{where}: [silo] outlet = {outline.outlet * 1e3:g} mm: smaller than the narrowest "
            f"particle, {narrowest * 1e3:.3g} mm; nothing would come out"
        )
    check_ways(outline, narrowest, where)
    level, largest = settings.fill.level, 2 * shapes.bounding_radius
    if not largest < level <= outline.height:
        raise InputError(
            f"{where}: [fill] level = {level * 1e3:g} mm: must be above the largest particle, "
            f"{largest * 1e3:.3g} mm, and at most the silo's height, {outline.height * 1e3:g} mm"
        )
    n = particles_below(level, outline, shapes)
    if n > _MOST_PARTICLES:
        raise InputError(
            f"{where}: [fill] level = {level * 1e3:g} mm: about {n:,} particles; at most "
            f"{_MOST_PARTICLES:,}; check the units of sizes, or give a lower level"
        )
    layer = settings.fill.layer
    if layer is not None and layer < narrowest:
        raise InputError(
            f"{where}: [fill] layer = {layer * 1e3:g} mm: thinner than the narrowest particle, "
            f"{narrowest * 1e3:.3g} mm; give a thicker one"
        )
    too_many = next((s for s in shapes.shapes if len(s.core) > MAX_VERTICES), None)
    if too_many:
        raise InputError(
            f"{shapes.name}: [shape {too_many.name}] has {len(too_many.core)} vertices; at most "
            f"{MAX_VERTICES} are offered"
        )
