"""One law for all contacts, or a table of them: laws by kind, with rolling and cohesion.

A world whose spheres are alike has a HertzLaw, and its kernels are compiled for that alone. A
LawTable stands in its place where spheres are of several kinds, or where the law has more than
Hertz, Mindlin and Tsuji: then the numbers of each contact's law are brought to lanes before it is
applied. Each name of the first part stands for the code that goes with the type of the law.
"""

from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.geometry import entry, surface_motion
from damper3d.engine.laws.cohesion import (
    Dmt,
    Jkr,
    dmt_energy,
    dmt_force,
    jkr_contact_radius,
    jkr_energy,
    jkr_force,
    jkr_reach,
)
from damper3d.engine.state import (
    BLOCK,
    DAMPING,
    FRICTION,
    HERTZ,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    NORMAL_DAMPING,
    SPRING_X,
    SPRING_Y,
    SPRING_Z,
    STIFFNESS,
    zeros,
)
from granulab.contact.hertz import NORMAL, HertzLaw, carried_spring, hertz_force, spring_work
from granulab.contact.jit import inlined_inner, inner, specialised
from granulab.contact.vectors import scale

# Columns of LawTable.constants, and rows of its lanes: those of HertzLaw, the energy of a surface
# [J/m2], and the rolling resistance's k [N/m], c [N s/m] and mu [-].
(
    LAW_HERTZ, LAW_TANGENTIAL, LAW_MU, LAW_DAMPING, LAW_TANGENTIAL_DAMPING, LAW_YIELDING, SURFACE,
    ROLLING_STIFFNESS, ROLLING_DAMPING, ROLLING_FRICTION,
) = range(10)  # fmt: skip
N_LAW = 10
# Rows of the lanes besides: the reduced radius [m], the normal force that limits friction [N], the
# overlap of the surfaces themselves [m], and the energy of a neck that tore [J].
SCALED_RADIUS, LOAD, OWN_OVERLAP, TORN = range(N_LAW, N_LAW + 4)
N_LANES = N_LAW + 4


class LawTable(NamedTuple):
    """Laws by the kinds of the two that touch; walls of one material are a kind of their own."""

    constants: np.ndarray  # (laws, N_LAW)
    number: np.ndarray  # (kinds, kinds) which law two kinds have
    kind: np.ndarray  # (m + 1,) of each sphere, then of the wall that is looked at
    walls: np.ndarray  # (walls,) kind of each wall
    lanes: np.ndarray  # (N_LANES BLOCK,) of the contacts that are worked on
    halo: float  # part of the geometry's radii by which JKR's necks reach beyond a sphere [m]
    pulls: bool  # as in HertzLaw
    stored_force: bool  # likewise
    cohesion: Any  # None, Dmt or Jkr


class Contact(NamedTuple):
    """A law of two kinds: plain, with the energy of each surface, and rolling resistance."""

    law: HertzLaw
    surface: float = 0.0  # [J/m2]
    rolling: tuple[float, float, float] = (0.0, 0.0, 0.0)  # k [N/m], c [N s/m], mu [-]


def law_table(
    contacts: list[Contact],
    number: np.ndarray,
    kind: np.ndarray,
    radii: np.ndarray,
    cohesion: Dmt | Jkr | None = None,
    *,
    walls: np.ndarray,
) -> LawTable:
    """A table of laws for m spheres in an enclosure.

    number (kinds, kinds) of the law of each two kinds, symmetrical, in which those of the walls
    come last; kind (m,) and radii (m,) [m] of the spheres; kind of each wall (n_walls,). How
    contacts end and what their springs carry on is that of the first law.
    """
    rows = [[*contact.law[:6], contact.surface, *contact.rolling] for contact in contacts]
    sorts = int(walls.min())
    table = LawTable(
        constants=np.array(rows, float),
        number=np.asarray(number, np.int64),
        kind=np.append(kind, walls[0]).astype(np.uint32),
        walls=np.asarray(walls, np.uint32),
        lanes=zeros(N_LANES * BLOCK),
        halo=0.0,
        pulls=contacts[0].law.pulls,
        stored_force=contacts[0].law.stored_force,
        cohesion=cohesion,
    )
    if not isinstance(cohesion, Jkr):
        return table
    largest = [float(radii[kind == k].max()) for k in range(sorts)]
    flat = [np.inf] * (len(number) - sorts)
    return table._replace(halo=_halo(contacts, number, [*largest, *flat]))


def _halo(contacts: list[Contact], number: np.ndarray, largest: list[float]) -> float:
    """The least h [m] with which all necks are within radii + h: of a pair both have it."""
    halo = 0.0
    for a, first in enumerate(one for one in largest if one < np.inf):
        for b, second in enumerate(largest):
            contact = contacts[number[a, b]]
            radius = first if second == np.inf else first * second / (first + second)
            reach = jkr_reach(0.75 * contact.law.hertz, radius, contact.surface)
            halo = max(halo, reach if second == np.inf else 0.5 * reach)
    return halo


def rolls(law: Any) -> bool:
    """True for a law with rolling resistance."""
    return isinstance(law, LawTable) and bool((law.constants[:, ROLLING_FRICTION] > 0.0).any())


# By the type of the law.


def face_wall(law, w):
    """Let the enclosure's row be of the kind of wall w."""


def halo(law):
    """Part of the geometry's radii that is not the sphere's own [m]."""


def hertz_of(law, i, j):
    """Return (4/3) E of spheres i and j [Pa]; the row after the spheres is the wall looked at."""


def note_laws(law, contacts, begin, n_contacts, block, reach):
    """Bring the laws of a block, whose geometry is known, to their lanes.

    Where a contact may end apart it decides which last: the overlap of others becomes 0. reach:
    the part of the overlaps that is halo [m].
    """


def law_of(law, k):
    """The plain law of contact k of a block."""


def normal_force(law, own, hertz, mass, damping, overlap, rate, k):
    """As hertz_force, and the force that limits friction [N]; own: law_of(law, k)."""


def normal_energy(law, own, stiffness, overlap, k):
    """Energy [J] that contact k holds along its normal."""


def tear(law, spheres, contacts, begin, n_contacts, block, dt):
    """Add what the contacts of a block whose necks tore still held to what is dissipated.

    The neck's energy to normal damping, that of the tangential spring to friction. In a contact
    that ends at overlap 0 the stiffness, and with it the spring's energy, goes to 0 by itself.
    """


def _is_plain(law):
    return law.instance_class is HertzLaw


def _cohesion(law):
    """Return Dmt, Jkr or None for a type of law."""
    if _is_plain(law):
        return None
    return getattr(law[law.fields.index("cohesion")], "instance_class", None)


@specialised(face_wall)
def _face_wall(law, w):
    if _is_plain(law):
        return lambda law, w: None
    return lambda law, w: _turn_to(law, w)


@inlined_inner
def _turn_to(law, w):
    law.kind[len(law.kind) - 1] = law.walls[w]


@specialised(halo)
def _halo_of(law):
    return (lambda law: 0.0) if _is_plain(law) else (lambda law: law.halo)


@specialised(hertz_of)
def _hertz_of(law, i, j):
    if _is_plain(law):
        return lambda law, i, j: law.hertz
    return lambda law, i, j: law.constants[law.number[law.kind[i], law.kind[j]], LAW_HERTZ]


@specialised(law_of)
def _law_of(law, k):
    if _is_plain(law):
        return lambda law, k: law
    return lambda law, k: _law_in_lane(law, k)


@inlined_inner
def _law_in_lane(law, k):
    lanes = law.lanes
    return HertzLaw(
        lanes[entry(LAW_HERTZ, k)], lanes[entry(LAW_TANGENTIAL, k)], lanes[entry(LAW_MU, k)],
        lanes[entry(LAW_DAMPING, k)], lanes[entry(LAW_TANGENTIAL_DAMPING, k)],
        lanes[entry(LAW_YIELDING, k)], law.pulls, law.stored_force,
    )  # fmt: skip


@inner
def without_slip(law, history, k, normal, kt_before, kt, moved):
    """The spring of contact k a step before, and now if it did not slip; see carried_spring."""
    held = history[entry(SPRING_X, k)], history[entry(SPRING_Y, k)], history[entry(SPRING_Z, k)]
    ahead = history[entry(MOVED_X, k)], history[entry(MOVED_Y, k)], history[entry(MOVED_Z, k)]
    return carried_spring(law, held, ahead, normal, kt_before, kt, moved)


@specialised(note_laws)
def _note_laws(law, contacts, begin, n_contacts, block, reach):
    if _is_plain(law):
        return lambda law, contacts, begin, n_contacts, block, reach: None
    if _cohesion(law) is Jkr:
        return lambda law, contacts, begin, n_contacts, block, reach: _note_necks(
            law, contacts, begin, n_contacts, block, reach
        )
    return lambda law, contacts, begin, n_contacts, block, reach: _note_lanes(
        law, contacts, begin, n_contacts, block
    )


@inner
def _note_lanes(law, contacts, begin, n_contacts, block):
    for k in range(np.uintp(n_contacts)):
        n = contacts.touching[np.uintp(begin) + k]
        which = law.number[law.kind[contacts.i[n]], law.kind[contacts.j[n]]]
        for c in range(N_LAW):
            law.lanes[entry(c, k)] = law.constants[which, c]
        root = block.constants[entry(HERTZ, k)] / law.lanes[entry(LAW_HERTZ, k)]
        law.lanes[entry(SCALED_RADIUS, k)] = root * root


@inner
def _note_necks(law, contacts, begin, n_contacts, block, reach):
    """Overlaps become those of the surfaces plus the reach of the neck of each contact.

    They are positive while a contact lasts: a neck ends before its halo does.
    """
    _note_lanes(law, contacts, begin, n_contacts, block)
    lanes = law.lanes
    for k in range(np.uintp(n_contacts)):
        modulus, surface = 0.75 * lanes[entry(LAW_HERTZ, k)], lanes[entry(SURFACE, k)]
        radius, lasts = lanes[entry(SCALED_RADIUS, k)], block.history[entry(DAMPING, k)] >= 0.0
        apart = reach - block.overlap[k]
        farthest = jkr_reach(modulus, radius, surface) if lasts else 0.0
        lanes[entry(OWN_OVERLAP, k)], lanes[entry(TORN, k)] = -apart, 0.0
        if not apart < farthest:
            block.overlap[k] = 0.0
            if lasts:
                neck = (9.0 * np.pi * surface * radius * radius / (4.0 * modulus)) ** (1.0 / 3.0)
                lanes[entry(TORN, k)] = jkr_energy(modulus, radius, surface, neck)


@specialised(normal_force)
def _normal_force(law, own, hertz, mass, damping, overlap, rate, k):
    if _is_plain(law):
        return lambda law, own, hertz, mass, damping, overlap, rate, k: _plain_force(
            own, hertz, mass, damping, overlap, rate
        )
    if _cohesion(law) is Jkr:
        return lambda law, own, hertz, mass, damping, overlap, rate, k: _jkr_contact(
            law, own, mass, damping, overlap, rate, k
        )
    if _cohesion(law) is Dmt:
        return lambda law, own, hertz, mass, damping, overlap, rate, k: _dmt_contact(
            law, own, hertz, mass, damping, overlap, rate, k
        )
    return lambda law, own, hertz, mass, damping, overlap, rate, k: _hertz_contact(
        law, own, hertz, mass, damping, overlap, rate, k
    )


@inlined_inner
def _plain_force(own, hertz, mass, damping, overlap, rate):
    stiffness, dashpot, force, inelastic = hertz_force(own, hertz, mass, damping, overlap, rate)
    return stiffness, dashpot, force, inelastic, force


@inlined_inner
def _hertz_contact(law, own, hertz, mass, damping, overlap, rate, k):
    stiffness, dashpot, force, inelastic = hertz_force(own, hertz, mass, damping, overlap, rate)
    law.lanes[entry(LOAD, k)] = max(force, 0.0)
    return stiffness, dashpot, force, inelastic, force


@inlined_inner
def _dmt_contact(law, own, hertz, mass, damping, overlap, rate, k):
    stiffness, dashpot, _, inelastic = hertz_force(own, hertz, mass, damping, overlap, rate)
    radius, surface = law.lanes[entry(SCALED_RADIUS, k)], law.lanes[entry(SURFACE, k)]
    elastic, pull = dmt_force(stiffness, overlap, radius, surface)
    load = abs(elastic + 2.0 * pull)
    law.lanes[entry(LOAD, k)] = load
    return stiffness, dashpot, elastic + inelastic, inelastic, load


@inlined_inner
def _jkr_contact(law, own, mass, damping, overlap, rate, k):
    """Hertz's secant stiffness is (4/3) E a: the dashpots and the tangential spring take JKR's."""
    lanes = law.lanes
    radius, surface = lanes[entry(SCALED_RADIUS, k)], lanes[entry(SURFACE, k)]
    modulus, a = 0.75 * own.hertz, 0.0
    if overlap > 0.0:
        a = jkr_contact_radius(modulus, radius, surface, lanes[entry(OWN_OVERLAP, k)])
    elastic, pull = jkr_force(modulus, radius, surface, a)
    stiffness = own.hertz * a
    dashpot = damping * np.sqrt(stiffness * mass)
    inelastic = NORMAL * dashpot * rate
    load = abs(elastic + 2.0 * pull)
    lanes[entry(LOAD, k)] = load
    return stiffness, dashpot, elastic + inelastic, inelastic, load


@specialised(normal_energy)
def _normal_energy(law, own, stiffness, overlap, k):
    if _cohesion(law) is Jkr:
        return lambda law, own, stiffness, overlap, k: _jkr_held(law, own, stiffness, k)
    if _cohesion(law) is Dmt:
        return lambda law, own, stiffness, overlap, k: dmt_energy(
            stiffness, overlap, law.lanes[entry(SCALED_RADIUS, k)], law.lanes[entry(SURFACE, k)]
        )
    return lambda law, own, stiffness, overlap, k: 0.4 * stiffness * overlap * overlap


@inlined_inner
def _jkr_held(law, own, stiffness, k):
    radius, surface = law.lanes[entry(SCALED_RADIUS, k)], law.lanes[entry(SURFACE, k)]
    return jkr_energy(0.75 * own.hertz, radius, surface, stiffness / own.hertz)


@specialised(tear)
def _tear(law, spheres, contacts, begin, n_contacts, block, dt):
    if _cohesion(law) is Jkr:
        return lambda law, spheres, contacts, begin, n_contacts, block, dt: _tear_necks(
            law, spheres, contacts, begin, n_contacts, block, dt
        )
    return lambda law, spheres, contacts, begin, n_contacts, block, dt: None


@inner
def _tear_necks(law, spheres, contacts, begin, n_contacts, block, dt):
    for k in range(np.uintp(n_contacts)):
        torn = law.lanes[entry(TORN, k)]
        if torn > 0.0:
            n, slipped = contacts.touching[np.uintp(begin) + k], _let_go(law, block, k, dt)
            spheres.torque[contacts.i[n], 3] -= 0.5 * (torn + slipped)
            spheres.torque[contacts.j[n], 3] -= 0.5 * (torn + slipped)
            block.own_totals[NORMAL_DAMPING] += torn / dt
            block.own_totals[FRICTION] += slipped


@inlined_inner
def _let_go(law, block, k, dt):
    """Return what friction takes [J] as the spring of contact k lets go of all that it held."""
    own, kt = law_of(law, k), block.history[entry(STIFFNESS, k)]
    normal, _, slip_rate = surface_motion(block, k)
    moved = scale(0.5 * dt, slip_rate)
    held, trial = without_slip(own, block.history, k, normal, kt, kt, moved)
    return spring_work(own, kt, kt, held, trial, (0.0, 0.0, 0.0))[0]
