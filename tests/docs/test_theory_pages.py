"""Theory pages: modules, functions, links, equation numbers; printed equations hold of the code.

The LaTeX of an equation is evaluated as it stands on its page, with numbers for its symbols, some
of which the code has computed: a misprint of the page fails as a mistake of the code does. Both are
closed forms of the same numbers, equal to rounding.
"""

import ast
import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from calibration.statistics.uncertainty import of_trials, student
from damper3d.case import closed_forms as damper
from damper3d.engine.laws import cohesion
from damper3d.measures import response
from damper3d.measures.efficiency import reference_energy
from damper3d.shapes.prolate import axes, centres
from damper3d.studies.field.balance import respond
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Field
from granulab.contact import hertz, reduced, restitution, sphere_law, timestep
from granulab.contact.files.datafile import data_file
from granulab.contact.files.table import load_table
from granulab.contact.laws import LinearLaw, normal_force, slip_limit, tangential_force
from granulab.contact.mindlin_deresiewicz import loading_force
from granulab.contact.prisms.line import LineContact, line_stiffness
from silo2d.case.shape import mass_integrals, regular_outline
from silo2d.engine.beds.laws import CohesiveLaw, cohesive_force
from silo2d.loads import bottom, janssen, jenike, walls
from silo2d.loads.solid import Values
from silo2d.loads.vessel import Vessel
from silo2d.measures.clogging.laws import Estimate, Law
from silo2d.measures.clogging.sizes import Mean, empties, form, mean_avalanche
from silo2d.reproduce.quantities.beverloo_law import law as beverloo
from silo2d.run.numbers import discharge_measures

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs" / "theory").glob("*.md"))
TEXT = {page.stem: page.read_text(encoding="utf-8") for page in PAGES}
EQUATION = re.compile(r"^\$\$\n(.*?)\n\$\$ \((\S+)\)$", re.S | re.M)
LATEX = {label: body for text in TEXT.values() for body, label in EQUATION.findall(text)}
MODULE = re.compile(r"`([\w/]+\.py)`(?:\s\(((?:`\w+`(?:,\s)?)+)\))?")
NUMBER = r"[2-8]\.\d+"  # of an equation: chapter or section, and its number there
AND = r"(?:,\s|\sand\s|\sto\s|-)"
ROUNDING = 1e-9  # of sums and powers that both sides round; a misprint is off by more
CITED = re.compile(rf"\b[Ee]qs?\.?\s({NUMBER}[a-c]?(?:{AND}(?:{NUMBER}|[a-c]\b)[a-c]?)*)")
# Equations of the sources that no module computes, since they do not hold: named as deviations.
DEVIATIONS = {"motion": {"4.5", "3.24"}}


def cited(text: str) -> set[str]:
    """Numbers of the equations that a text cites, with those between the ends of a range."""
    found = set()
    for group in CITED.findall(text):
        parts = re.findall(rf"({NUMBER})|(\sto\s|-)", group)
        for k, (number, way) in enumerate(parts):
            found.add(number) if number else None
            if way and k + 1 < len(parts):
                (chapter, first), (_, last) = (parts[n][0].split(".") for n in (k - 1, k + 1))
                found |= {f"{chapter}.{n}" for n in range(int(first), int(last) + 1)}
    return found


@cache
def source(module: str) -> str:
    return (ROOT / module).read_text(encoding="utf-8")


@cache
def names(module: str) -> set[str]:
    """Names that a module defines: functions, classes, methods and constants."""
    found = set()
    for node in ast.walk(ast.parse(source(module))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign):
            targets = (n for target in node.targets for n in ast.walk(target))
            found |= {n.id for n in targets if isinstance(n, ast.Name)}
    return found


@pytest.mark.parametrize("page", TEXT)
def test_modules_and_functions_named_on_a_page_exist(page):
    named = MODULE.findall(TEXT[page])
    assert named
    for module, functions in named:
        lacking = set(re.findall(r"\w+", functions)) - names(module)
        assert not lacking, f"{module} has no {lacking}"


@pytest.mark.parametrize("page", TEXT)
def test_equations_cited_in_a_section_are_cited_by_a_module_that_it_names(page):
    for section in re.split(r"^#+ ", TEXT[page], flags=re.M):
        known = set().union(*(cited(source(module)) for module, _ in MODULE.findall(section)))
        lacking = cited(section) - known - DEVIATIONS.get(page, set())
        assert not lacking, f"{section.splitlines()[0]}: {lacking}"


@pytest.mark.parametrize("page", TEXT)
def test_links_of_a_page_lead_to_files_and_headings(page):
    for target in re.findall(r"\]\(([^)]+)\)", TEXT[page]):
        path, _, anchor = target.partition("#")
        linked = ROOT / "docs" / "theory" / path
        assert linked.is_file(), target
        heads = re.findall(r"^#+ (.*)", linked.read_text(encoding="utf-8"), re.M)
        slugs = {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
        assert not anchor or anchor in slugs, target


def test_labels_are_used_once_and_the_index_lists_every_page():
    labels = [label for text in TEXT.values() for _, label in EQUATION.findall(text)]
    assert len(labels) == len(set(labels))
    assert len(labels) == sum(len(re.findall(r"^\$\$", text, re.M)) for text in TEXT.values()) / 2
    listed = re.search(r"```\{toctree\}.*?\n\n(.*?)```", TEXT["index"], re.S)
    assert listed is not None
    assert {"index", *listed.group(1).split()} == set(TEXT)


@pytest.mark.docs
@pytest.mark.parametrize("page", TEXT)
def test_equations_are_what_the_site_can_show(page):
    """As MathML: what is not known there leaves a raw ampersand or backslash."""
    from xml.etree import ElementTree

    from latex2mathml.converter import convert

    inline = re.findall(r"(?<!\$)\$([^$]+)\$(?!\$)", EQUATION.sub("", TEXT[page]))
    for latex in [*inline, *(body for body, _ in EQUATION.findall(TEXT[page]))]:
        assert "\\" not in "".join(ElementTree.fromstring(convert(latex)).itertext()), latex


class Printed:
    """Evaluation of an expression in LaTeX: products have no sign, functions take one factor."""

    FUNCTIONS: ClassVar = {
        "exp": np.exp, "ln": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
        "cot": lambda x: 1 / np.tan(x), "arcsin": np.arcsin, "arccos": np.arccos,
        "sqrt": np.sqrt, "min": min, "max": max,
    }  # fmt: skip
    TOKEN = re.compile(r"\\[A-Za-z]+|\d+(?:\.\d+)?|[A-Za-z]'*|\S")

    def __init__(self, latex: str, values: Mapping[str, Any]) -> None:
        self.tokens = self.TOKEN.findall(re.sub(r"\\[,;]|\\(?:left|right)\b|\\sum_r", " ", latex))
        self.values, self.used = {r"\pi": math.pi, **values}, set[str]()

    @property
    def next(self) -> str:
        return self.tokens[0] if self.tokens else ""

    def take(self, *wanted: str) -> str:
        token = self.tokens.pop(0)
        assert not wanted or token in wanted, f"{token} where {wanted} is expected"
        return token

    def sum(self) -> Any:
        total = -self.product() if self.next == "-" and self.take() else self.product()
        while self.next in ("+", "-"):
            total = total + self.product() if self.take() == "+" else total - self.product()
        return total

    def product(self) -> Any:
        total = self.factor()
        while self.next not in ("", "+", "-", ")", "}", ",", r"\rvert"):
            if self.next == "/":
                self.take()
                total = total / self.factor()
            else:
                if self.next == r"\cdot":
                    self.take()
                total = total * self.factor()
        return total

    def factor(self) -> Any:
        base = self.base()
        while self.next == "^":
            self.take()
            base = base ** self.argument()
        return base

    def argument(self) -> Any:
        """A group in braces, or a digit or symbol."""
        if self.next == "{":
            return self.within("{", "}")
        if self.next.isdigit() and len(self.next) > 1:  # \tfrac12
            self.tokens[:1] = list(self.next)
        return self.base()

    def within(self, opening: str, closing: str) -> Any:
        self.take(opening)
        values = [self.sum()]
        while self.next == ",":
            self.take()
            values.append(self.sum())
        self.take(closing)
        return values[0] if len(values) == 1 else values

    def base(self) -> Any:
        name = self.next.removeprefix("\\")
        if name in ("frac", "tfrac"):
            self.take()
            return self.argument() / self.argument()
        if name in self.FUNCTIONS:
            return self.function(self.take()[1:])
        if self.next in ("(", "{"):
            return self.within(self.next, {"(": ")", "{": "}"}[self.next])
        if name == "lvert":
            return abs(self.within(r"\lvert", r"\rvert"))
        if self.next[0].isdigit():
            return float(self.take())
        return self.symbol()

    def function(self, name: str) -> Any:
        power = 1
        if self.next == "^":
            self.take()
            power = self.argument()
        given = self.within("(", ")") if self.next == "(" else self.argument_of(name)
        value = (
            self.FUNCTIONS[name](*given) if isinstance(given, list) else self.FUNCTIONS[name](given)
        )
        return value**power

    def argument_of(self, name: str) -> Any:
        return self.argument() if name == "sqrt" else self.factor()

    def symbol(self) -> Any:
        name = self.name()
        if name not in self.values and name == "e":
            return math.e
        self.used.add(name)
        return self.values[name]

    def name(self) -> str:
        """A letter with its marks, subscript and star."""
        name = self.take()
        if name in (r"\dot", r"\Delta", r"\langle"):
            name += self.take()
        if name.startswith(r"\langle"):
            name += self.take(r"\rangle")
        if self.next == "_":
            self.take()
            name += "_" + self.subscript()
        if self.tokens[:4] == ["^", "{", "*", "}"]:
            del self.tokens[:4]
            name += "*"
        return name

    def subscript(self) -> str:
        text = self.take() if self.next != "{" else ""
        if text not in ("", r"\mathrm"):
            return text
        end = self.tokens.index("}")
        text += "".join(self.tokens[1:end])
        del self.tokens[: end + 1]
        return text


def evaluated(latex: str, values: Mapping[str, Any]) -> tuple[Any, set[str]] | None:
    """Value of an expression and the names in it; None where one of them is not known."""
    expression = Printed(latex, values)
    try:
        value = expression.sum()
    except KeyError:
        return None
    assert not expression.tokens, f"{latex}: {expression.tokens} is left"
    return value, expression.used


def checked(latex: str, given: Mapping[str, Any]) -> tuple[int, set[str]]:
    """How many of the equations were found to hold, and the names that stand in them.

    What stands alone on a left side and is not given is defined by the right; equations with names
    that are neither are not looked at.
    """
    parts = [re.split("=", part.strip(" ,.:\n")) for part in re.split(r"\\q?quad", latex)]
    left = [(a.strip(), b.strip()) for one in parts for a, b in pairwise(one)]
    values, held, seen = dict(given), 0, set[str]()
    while known := [(a, b, found) for a, b in left if (found := evaluated(b, values)) is not None]:
        for a, b, (value, used) in known:
            left.remove((a, b))
            a = a.removesuffix("(s)")  # a function's argument
            other = evaluated(a, values)
            if other is None:
                values[Printed(a, {}).name()] = value
            else:
                assert other[0] == pytest.approx(value, rel=ROUNDING, abs=0), f"{a} = {b}"
                held, used = held + 1, used | other[1]
            seen |= used
    return held, seen


LINEAR = LinearLaw(kn=1e7, kt=6.5e5, mu=0.38, gamma_n=6085.0, gamma_t=3.0, pulls=True)
SPHERES = hertz.HertzLaw(2.5e9, 1.16, 0.52, 0.05, 1.9, math.inf, True, False)
ACRYLIC = (3.3e9, 0.37)
E = reduced.reduced_modulus(*ACRYLIC, *ACRYLIC)
SILO = Vessel("circular", 5.0, 5.0, 8.0, math.radians(20))  # of intermediate slenderness
SOLID = Values(0.458, 0.45, math.radians(30))
WALL = walls.Wall(SILO, SOLID, 16e3, 0.6, math.radians(36))
STEEP = Values(0.3, 0.45, math.radians(30))
OMEGA = 2 * math.pi * 20.0
BED = 0.1 - 0.02j  # m of a field [kg]


def contact() -> dict[str, Any]:
    """A step of a sliding contact of the linear law."""
    (f_t,), (s,), lost = tangential_force(LINEAR, 5e-3, 2e-5, (1e-4,), (3e-5,), (0.2,))
    return {"k_t": 6.5e5, "s": s, "s_0": 1e-4, r"\Deltas": 3e-5, "m": 5e-3, r"\gamma_t": 3.0,
            r"\dots": 0.2, "f_t": f_t, "D_f": lost, "d": 2e-5, "k_n": 1e7, r"\mu": 0.38,
            r"s_\max": slip_limit(LINEAR, 2e-5)}  # fmt: skip


def line() -> dict[str, Any]:
    """A line contact of two like bodies."""
    k_n, k_t = line_stiffness(LineContact(0.12, 1e-3, 5e-3, 500.0), (10e9, 0.3), (10e9, 0.3))
    modulus = reduced.reduced_modulus(10e9, 0.3, 10e9, 0.3)
    a = math.sqrt(4 * 500.0 * 1e-3 / (math.pi * modulus * 0.12))
    return {"E": modulus, "L": 0.12, "D": 5e-3, r"\nu": 0.3, "a": a, "k_n": k_n, "k_t": k_t}


def yielding() -> dict[str, Any]:
    """An impact of two spheres of acrylic at twice their yield velocity."""
    acrylic = load_table(data_file("materials", "acrylic")).material("acrylic")
    modulus, nu = sphere_law.elastic(acrylic)
    strength = acrylic.yield_strength.value
    reduced_modulus = reduced.reduced_modulus(modulus, nu, modulus, nu)
    v_y = sphere_law.yield_velocity(acrylic, acrylic, radius=1.25e-3, mass=4e-5)
    law = sphere_law.sphere_law(acrylic, acrylic, friction=0.5, restitution=0.86, yielding=True)
    b = hertz.damping_of_impact(law, law.hertz * math.sqrt(1.25e-3), 4e-5, 2 * v_y)
    return {"Y": strength, "R": 1.25e-3, "m": 4e-5, "E": reduced_modulus, "v_y": v_y,
            "v": 2 * v_y, "e_0": 0.86, "e": restitution.restitution_of_ratio(b)}  # fmt: skip


def jkr() -> dict[str, Any]:
    """A neck of a radius, from the overlap, and its force."""
    a = float(cohesion.jkr_contact_radius(E, 3e-3, 0.05, 1e-6))
    force, _ = cohesion.jkr_force(E, 3e-3, 0.05, a)
    return {"E": E, "R": 3e-3, "g": 0.05, "d": 1e-6, "a": a, r"F_\mathrmJKR": force}


def spring() -> dict[str, Any]:
    """A step of a tangential spring in which stiffness and slip change, along one direction."""
    held = [(s, 0.0, 0.0) for s in (1e-6, 2.5e-6, 1.7e-6)]
    friction, _ = hertz.spring_work(SPHERES, 1e6, 1.3e6, *held)
    return {"k_0": 1e6, "k_1": 1.3e6, "s_0": 1e-6, "s*": 2.5e-6, "s_1": 1.7e-6, "D_f": friction}


def hopper() -> dict[str, Any]:
    """Filling of a steep cone, at 0.4 of its height."""
    found = bottom.hopper_filling(SILO, 16e3, 7e4, STEEP)
    k = int(np.argmin(abs(found.height / SILO.hopper_height - 0.4)))
    return {r"\gamma": 16e3, "h_h": SILO.hopper_height, "x": found.height[k], "p_vft": 7e4,
            "m": 2.0, "S": 2.0, "F": found.factor, r"\mu_e": 0.3, r"\beta": SILO.half_angle,
            "p_v": found.vertical[k], "n": found.exponent}  # fmt: skip


def discharged(silo: Vessel) -> dict[str, Any]:
    factors = walls.discharge_factors(silo, 0.5, 2, 0.0, from_top=False)
    return {"h_c": silo.height, "d_c": silo.width, "C_h": factors.horizontal,
            "C_w": factors.friction}  # fmt: skip


def hopper_factors() -> dict[str, Any]:
    filling, flow = (
        f(SILO, 16e3, 7e4, STEEP) for f in (bottom.hopper_filling, bottom.hopper_discharge)
    )
    return {r"\beta": SILO.half_angle, r"\mu_e": 0.3, r"\phi_i": STEEP.internal_friction,
            r"\phi_wh": math.atan(0.3), "F_f": filling.factor, "F_e": flow.factor}  # fmt: skip


def cell() -> dict[str, Any]:
    """A structure of one mode with a bed, at 20 Hz."""
    one = Structure.single(2.0, 21.0, 0.01, force=0.5, base_displacement=1e-3)
    field = Field.of([20.0, 20.0], [0.1, 50.0], [BED, BED], 0.1)
    product, receptance, bare = (x[0] for x in one.products([20.0]))
    return {r"\phi_r": 2.0**-0.5, "s_r": 2.0**-0.5, "p_r": 2.0**0.5, "F_0": 0.5, "B": 1e-3,
            r"\omega_r": one.omega[0], r"\omega": OMEGA, r"\zeta_r": 0.01, "i": 1j,
            "H": receptance / product, "X_b": bare / product, "m": BED,
            "A": respond(one, field, [20.0]).amplitude[0, 0, 0]}  # fmt: skip


def flight() -> dict[str, Any]:
    tau = float(damper.inelastic_flight(2.0))
    return {r"\Gamma": 2.0, r"\varphi_0": math.asin(0.5), r"\tau": tau,
            r"\eta": float(damper.inelastic_block(2.0))}  # fmt: skip


def prolate() -> dict[str, Any]:
    """The last sphere of a spheroid of ratio 2, and the one half way to it."""
    x, radii = centres(2.0, 51)
    a, b = axes(2.0)
    return {"a": a, "b": b, "x_i": x[12], "R_i": radii[12], "x_n": x[25], "R_n": radii[25]}


def avalanche(name: str, **parameters: float) -> float:
    """Mean avalanche of a law at an outlet of four diameters."""
    known = {key: Estimate(value, None, None) for key, value in parameters.items()}
    return float(Law(name, known, 0.0, None).mean(np.array(4.0)))


RATIO = {"b": 0.21, "e": restitution.restitution_of_ratio(0.21)}
CORE = regular_outline(4, 0.01)
OUT = np.arange(1.0, 101.0)
PINS: list[tuple[str, Callable[[], dict[str, Any]]]] = [
    ("linear-law", lambda: {
        "k_n": 1e7, "d": 2e-5, "m": 5e-3, r"\gamma_n": 6085.0, r"\dotd": 0.1,
        "f_n": normal_force(LINEAR, 5e-3, 2e-5, 0.1)[0],
    }),
    ("linear-law", lambda: {"m_i": 0.2, "m_j": 0.3, "m": reduced.reduced_mass(1 / 0.2, 1 / 0.3)}),
    ("linear-law coulomb-plane friction-plane", contact),
    ("damping-ratio", lambda: {
        r"\gamma_n": 6085.0, "m": 5e-3, "k_n": 1e7,
        "b": restitution.ratio_of_restitution(restitution.linear_restitution(6085.0, 1e7, 5e-3)),
    }),
    ("restitution-overlap", lambda: RATIO),
    ("restitution-force", lambda: {
        "b": 0.21, "e": restitution.restitution_of_ratio(0.21, "force"),
    }),
    ("cohesive-law", lambda: {
        "k_n": 1e7, "d": 2e-5, "m": 5e-3, r"\gamma_n": 6085.0, r"\dotd": 0.1, "c": 0.5,
        "f_n": cohesive_force(CohesiveLaw(*LINEAR, 0.5), 5e-3, 2e-5, 0.1)[0],
    }),
    ("line-contact", line),
    ("reduced", lambda: {
        r"\nu_i": 0.37, r"\nu_j": 0.3, "E_i": 3.3e9, "E_j": 2e11,
        "E": reduced.reduced_modulus(3.3e9, 0.37, 2e11, 0.3),
    }),
    ("reduced", lambda: {
        r"\nu_i": 0.37, r"\nu_j": 0.3, "G_i": reduced.shear_modulus(3.3e9, 0.37),
        "G_j": reduced.shear_modulus(2e11, 0.3),
        "G": reduced.reduced_shear_modulus(3.3e9, 0.37, 2e11, 0.3),
    }),
    ("reduced", lambda: {
        "R_i": 2e-3, "R_j": 3e-3, "R": reduced.reduced_radius(1 / 2e-3, 1 / 3e-3),
        "m_i": 0.2, "m_j": 0.3, "m": reduced.reduced_mass(1 / 0.2, 1 / 0.3),
    }),
    ("hertz", lambda: {
        "E": 0.75 * 2.5e9, "R": 3e-3, "d": 2e-5, "b": 0.05, "m": 5e-3, r"\dotd": 0.1,
        "f_n": hertz.hertz_force(SPHERES, 2.5e9 * math.sqrt(3e-3), 5e-3, 0.05, 2e-5, 0.1)[2],
    }),
    ("tsuji-ratio", lambda: {"e": 0.86, "b": sphere_law.damping_ratio(0.86)}),
    ("mindlin-deresiewicz", lambda: {
        r"\mu": 0.5, "N": 8.0, "k_t": 1e6, "s": 3e-6,
        "T": float(loading_force(1e6, 4.0, np.array(3e-6))),
    }),
    ("yielding", yielding),
    ("dmt", lambda: {
        "E": E, "R": 3e-3, "d": 1e-6, "g": 0.05,
        r"F_\mathrmDMT": cohesion.dmt_force(
            4 / 3 * E * math.sqrt(3e-3 * 1e-6), 1e-6, 3e-3, 0.05
        )[0],
    }),
    ("jkr", jkr),
    ("steiner", lambda: {"A_0": 1e-4, "P": 0.04, "r": 1e-3, "A": mass_integrals(CORE, 1e-3)[0]}),
    ("prolate", prolate),
    ("stable-step", lambda: {
        r"\omega": 1e5, r"\gamma": 2e4, r"\Deltat": timestep.stable_time_step(1e10, 2e4),
    }),
    ("rayleigh", lambda: {
        "R": 2.5e-3, r"\rho": 1190.0, r"\nu": 0.37, "G": reduced.shear_modulus(*ACRYLIC),
        r"\Deltat_R": timestep.rayleigh_time_step(2.5e-3, 1190.0, *ACRYLIC),
    }),
    ("spring-identity friction-space", spring),
    ("discharge", lambda: {
        "n": 100.0, "T_10": 10.0, "T_90": 90.0,
        r"\dotn": discharge_measures(OUT, OUT)["mean_rate_per_s"],
    }),
    ("beverloo", lambda: {
        r"\rho_b": 45.0, "g": 9.81, "C": 0.9, "D": 0.15, "k": 1.3, "d": 0.0157,
        "W": float(beverloo(0.15, 0.9, 1.3, 45.0, 0.0157)),
    }),
    ("garwood", lambda: {"S": 900.0, "k": 12.0, r"\langles\rangle": mean_avalanche(900, 12).value}),
    ("empties", lambda: {
        r"\langles\rangle": 75.0, "n": 100.0,
        "P": empties(Mean(75.0, 40.0, 140.0, 12, 900), 100)[0],
    }),
    ("two-laws", lambda: {
        "A": 3.0, "C": 0.15, r"\varrho": 4.0, "m": avalanche("exponential", A=3.0, C=0.15),
    }),
    ("two-laws", lambda: {
        "A": 3.0, r"\varrho_c": 9.0, r"\gamma": 2.5, r"\varrho": 4.0,
        "m": avalanche("power", A=3.0, critical=9.0, g=2.5),
    }),
    ("janssen", lambda: {
        r"\gamma": 16e3, "z": 5.0, "A": 2.5, "U": 1.0, r"\mu": 0.4, "K": 0.45,
        "p_v": float(janssen.janssen_stress(5.0, 16e3, 0.4 * 0.45, 5.0)),
    }),
    ("reimbert", lambda: {
        r"\gamma": 16e3, "K": 0.45, "z_o": WALL.length, "z": 5.0, "h_o": 0.6,
        r"\phi_r": math.radians(36), "p_h": float(WALL.horizontal(5.0)),
    }),
    ("squat-vertical", lambda: {
        r"\gamma": 16e3, "z_o": WALL.length, "z": 5.0, "h_o": 0.6, "n": WALL._exponent,
        "p_v": float(WALL.vertical(5.0)),
    }),
    ("discharge-factors", lambda: discharged(SILO)),
    ("discharge-factors", lambda: discharged(dataclasses.replace(SILO, height=15.0))),
    ("patch", lambda: {
        "C_op": 0.5, "e_f": 0.4, "h_c": 8.0, "d_c": 5.0,
        "C_pf": walls.filling_patch(SILO, 0.5, 0.4),
    }),
    ("hopper", hopper),
    ("hopper-factors", hopper_factors),
    ("mass-flow", lambda: {
        r"\delta": 0.7, r"\beta_w": jenike.wall_angle(0.7, 0.35),
        r"\theta": jenike.mass_flow_limit(0.7, 0.35, plane=False),
    }),
    ("jenike-outlet", lambda: {
        r"\phi": 0.6, "f_c": 900.0, r"\gamma": 9e3, "D": jenike.rathole(0.6, 900.0, 9e3),
    }),
    ("efficiency", lambda: {"V": 0.8, "M": 0.028, r"E_\max": reference_energy(0.8, 0.028)}),
    ("design-numbers", lambda: {
        "E_c": 0.05, "M": 0.028, "V": 0.8, r"\omega": OMEGA,
        r"\eta": math.pi / 4 * response.loss_factor(0.05, 0.8, 0.028),
        "c": response.equivalent_damping(0.05, 0.8, OMEGA),
    }),
    ("motion", lambda: {
        r"\Gamma": 20.0, "g": 9.81, r"\omega": OMEGA,
        "A": float(damper.excitation_amplitude(20.0, 20.0)),
    }),
    ("onset", lambda: {
        r"\omega": OMEGA, "h": 0.011, "g": 9.81,
        r"\Gamma": float(damper.bouncing_bed_onset(20.0, 0.011)),
    }),
    ("clearance", lambda: {
        r"\nu": 0.466, r"\nu_\max": 0.64, "L": 0.04,
        "h": damper.effective_clearance(0.466, 0.04, 0.64),
    }),
    ("clearance", lambda: {
        "N": 358, r"N_\max": 500, "L": 0.04, "h": damper.relative_clearance(358, 500, 0.04),
    }),
    ("collect-and-collide", lambda: {
        "A_0": 1.0, "A": 1.5, r"\varphi": float(damper.meeting_phase(1.5)),
        r"\eta": float(damper.collect_and_collide(1.5)),
    }),
    ("flight block", flight),
    ("receptance harmonic-balance", cell),
    ("trials", lambda: {
        "s": 0.5 * math.sqrt(2), "n": 2, "t_n-1": student(1),
        r"\sigma": of_trials([1.0, 2.0]).sigma,
    }),
]  # fmt: skip


@pytest.mark.parametrize(("labels", "numbers"), PINS, ids=[labels for labels, _ in PINS])
def test_a_printed_equation_holds_of_what_the_code_computes(labels, numbers):
    """With every number that is given; each of the equations has some that no page defines."""
    given, stands = numbers(), set()
    for label in labels.split():
        held, seen = checked(LATEX[label], given)
        assert held
        stands |= seen
    assert set(given) <= stands


def test_every_page_but_the_index_has_equations_that_are_checked():
    pinned = {label for labels, _ in PINS for label in labels.split()}
    pages = {page for page, text in TEXT.items() if pinned & {x for _, x in EQUATION.findall(text)}}
    assert pages == set(TEXT) - {"index"}


def test_the_form_of_sizes_from_the_printed_tail_is_found_again():
    """Sizes at even quantiles of P(s > x): beta within its interval, and 1 outside of it."""
    (printed,) = re.findall(r"P\(s > x\) = (.*) ,\n\$\$ \(weibull-tail\)", TEXT["silos"])
    x, share = np.arange(1, 2000), (np.arange(400) + 0.5) / 400
    beyond = evaluated(printed, {r"\lambda": 0.1, r"\beta": 0.6, "x": x})
    assert beyond is not None
    found = form((1 + np.searchsorted(1 - beyond[0], share)).tolist(), [0] * 400)
    assert found is not None
    assert found.low < 0.6 < found.high < 1


@pytest.mark.parametrize(("latex", "value"), [
    (r"\frac{a + 1}{2} b", 8.0), (r"-a^2 \sqrt{b}", -18.0), (r"\tfrac12 \ln^2 e", 0.5),
    (r"a/b\, a", 2.25), (r"\left\lvert 1 - a \right\rvert \cos 0", 2.0), ("q", None),
])  # fmt: skip
def test_latex_is_evaluated_as_it_reads(latex, value):
    found = evaluated(latex, {"a": 3.0, "b": 4.0})
    assert (found and found[0]) == (value if value is None else pytest.approx(value, rel=1e-12))


def test_a_misprint_is_noticed():
    with pytest.raises(AssertionError):
        checked(r"e = \exp\left(-\frac{\pi b}{\sqrt{1 + b^2}}\right)", RATIO)
