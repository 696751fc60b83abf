"""Finite elements of axisymmetric bodies under loads that vary round the axis by one harmonic.

With cylindrical coordinates r, t, z a load f_r cos(m t), f_t sin(m t), f_z cos(m t) moves a body by
u cos(m t), v sin(m t), w cos(m t), where (u, v, w) depends on r and z alone; the strains are

    e_rr = u,r   e_tt = (u + m v)/r   e_zz = w,z
    g_rz = u,z + w,r   g_rt = v,r - (m u + v)/r   g_tz = v,z - m w/r

(O. C. Zienkiewicz and R. L. Taylor, The Finite Element Method, vol. 2, 5th ed. 2000, ch. 9: the
semi-analytical method). A shift along x is m = 1 with u = 1, v = -1. So a body in space is a mesh
in the plane for each harmonic, without an error round the axis. Linear triangles, small strains.
Loads are in newton per radian, so that the integral of cos^2 round the axis drops out.
"""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from damper3d.studies.single_contact.particles.smooth_body import Elastic

if TYPE_CHECKING:
    from skfem import MeshTri

_GROWTH = 1.15  # of a wall's mesh, from one line to the next
_FAR = 300.0  # distance to a wall's held end over the contact's outer radius: see `wall`


class Body(NamedTuple):
    """A body, the points of its surface that may touch, and the points that are held.

    u, v and w of the `held` points are 0; of the `level` points, and of all in harmonic 0, w alone.
    """

    mesh: "MeshTri"  # r and z [m]
    material: Elastic
    surface: np.ndarray  # (n,) point numbers, outwards
    held: np.ndarray
    level: np.ndarray

    @property
    def places(self) -> np.ndarray:
        """r and z of the surface's points, (2, n) [m]."""
        found: np.ndarray = self.mesh.p[:, self.surface]
        return found


def half_disc(finest: float, reach: float, growth: float = 0.1, whole: bool = True) -> "MeshTri":
    """The lower half of the unit disc, or the right half of that.

    Elements are of the size `finest` within `reach` of the lowest point, and grow by `growth` with
    the distance from there; all over the radius.
    """
    from skfem import MeshTri

    n = 13 if whole else 7
    angles = np.linspace(-math.pi if whole else -0.5 * math.pi, 0, n)
    points = [(0.0, 0.0)] + [(r * math.cos(t), r * math.sin(t)) for r in (0.5, 1.0) for t in angles]
    first, second = 1 + np.arange(n), 1 + n + np.arange(n)
    cells = [(0, first[k], first[k + 1]) for k in range(n - 1)]
    cells += [(first[k], second[k], second[k + 1]) for k in range(n - 1)]
    cells += [(first[k], second[k + 1], first[k + 1]) for k in range(n - 1)]
    mesh = MeshTri(np.array(points).T, np.array(cells).T)
    if not whole:
        mesh.p[0, np.abs(mesh.p[0]) < 1e-12] = 0.0
    while True:
        corners = mesh.p[:, mesh.t]
        size = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
        away = np.linalg.norm(corners - np.array([0.0, -1.0])[:, None, None], axis=0).min(axis=0)
        coarse = np.flatnonzero(size > np.maximum(finest, growth * (away - reach)))
        if not len(coarse):
            return mesh
        before = mesh.p.shape[1]
        mesh = mesh.refined(coarse)
        rim = np.array([n for n in mesh.boundary_nodes() if n >= before], dtype=int)
        rim = rim[(mesh.p[1, rim] < -1e-12) & (np.abs(mesh.p[0, rim]) > (0.0 if whole else 1e-12))]
        mesh.p[:, rim] /= np.linalg.norm(mesh.p[:, rim], axis=0)


def tube(
    material: Elastic, distance: float, radius: float, finest: float, reach: float,
    growth: float = 0.1, rigid: bool = True,
) -> Body:  # fmt: skip
    """The lower half of a lying toroid; of a sphere where the distance is 0; lengths in [m].

    distance, radius: a and b of the toroid; finest, reach, growth: of `half_disc`. Its middle plane
    keeps its height under a normal load (and is free to widen) as by symmetry between two walls; in
    other harmonics all of it is held where `rigid`, else its height alone.
    """
    from skfem import MeshTri

    flat = half_disc(finest, reach, growth, whole=distance > 0.0)
    mesh = MeshTri(flat.p * radius + np.array([[distance], [0.0]]), flat.t)
    points = mesh.boundary_nodes()
    near = np.abs(mesh.p[0, points] - distance) < (reach + finest) * radius
    low = points[near & (mesh.p[1, points] < -1e-9 * radius)]
    low = low[mesh.p[1, low] < -math.sqrt(1 - (reach + finest) ** 2) * radius]
    middle = np.flatnonzero(np.abs(mesh.p[1]) < 1e-9 * radius)
    surface = low[np.argsort(mesh.p[0, low])]
    return Body(mesh, material, surface, middle if rigid else middle[:0], middle)


def wall(material: Elastic, places: np.ndarray) -> Body:
    """A half-space z < 0 whose surface has points at the radii (n,) [m], rising.

    It ends, and is held, at 300 times the largest of them. What lies beyond would yield by less
    than (2 - nu)/(4 pi G) over that distance to a force along x, as a point load says (Johnson, eq.
    3.91): 0.1 % of what a ring of contact yields, 1.3/300 of what a circle does.
    """
    from skfem import MeshTri

    far, fine = _FAR * places[-1], float(np.diff(places).min())
    outwards = places[-1] + _graded(places[-1] - places[-2], far - places[-1])
    inwards = places[0] - _graded(places[1] - places[0], places[0])[::-1]
    across = np.concatenate([inwards, places, outwards])
    across[0] = 0.0
    down = np.concatenate([-_graded(fine, far)[::-1], [0.0]])
    mesh = MeshTri.init_tensor(across, down)
    ends = np.flatnonzero((mesh.p[0] == across[-1]) | (mesh.p[1] == down[0]))
    top = np.flatnonzero(mesh.p[1] == 0.0)
    top = top[np.argsort(mesh.p[0, top])]
    surface = top[len(inwards) : len(inwards) + len(places)]
    return Body(mesh, material, surface, ends, ends)


def _graded(first: float, length: float) -> np.ndarray:
    """Steps that grow from `first`, summed up to just `length`; nothing for no length."""
    if length < 1e-9 * first:
        return np.zeros(0)
    n = max(1, math.ceil(math.log1p(length / first * (_GROWTH - 1.0)) / math.log(_GROWTH)))
    sums = np.cumsum(first * _GROWTH ** np.arange(n))
    return sums * length / sums[-1]


def yielding(body: Body, harmonic: int) -> np.ndarray:
    """Displacements (u, v, w) of the surface's points by forces on them, (3, n, 3, n) [m rad/N].

    Component and point that moves, component and point of the force. With a middle plane that is
    not held, the load of the first harmonic is balanced by an even force on each unit of volume,
    and displacements count from the mean of the body.
    """
    from scipy.sparse.linalg import splu
    from skfem import Basis, ElementTriP1, ElementVector

    basis = Basis(body.mesh, ElementVector(ElementTriP1(), 3))
    matrix = stiffness(body.material, harmonic).assemble(basis).tocsc()
    dofs = basis.nodal_dofs
    still = [dofs[:, body.held].ravel(), dofs[2, body.level]]
    if harmonic == 0:  # no rotation about the axis; the middle is free to widen
        still = [dofs[2, body.held], dofs[2, body.level], dofs[1]]
    floats = harmonic == 1 and not len(body.held)
    if floats:
        still.append(dofs[0, body.surface[:1]])  # bears nothing, as the load is balanced
    free = np.setdiff1d(np.arange(matrix.shape[0]), np.concatenate(still))
    loads = np.zeros((matrix.shape[0], 3 * len(body.surface)))
    loads[dofs[:, body.surface].ravel(), np.arange(loads.shape[1])] = 1.0
    if floats:
        shift = np.zeros(matrix.shape[0])
        shift[dofs[0]], shift[dofs[1]] = 1.0, -1.0
        even = _volume().assemble(basis) @ shift
        loads -= np.outer(even, shift @ loads) / (shift @ even)
    moved = np.zeros_like(loads)
    solver = splu(
        matrix[free][:, free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
    )
    moved[free] = solver.solve(loads[free])
    if floats:
        moved -= np.outer(shift, even @ moved) / (shift @ even)
    found: np.ndarray = moved[dofs[:, body.surface].ravel()]
    return ((found + found.T) / 2).reshape(3, len(body.surface), 3, -1)


def stiffness(material: Elastic, m: int) -> Any:
    """The bilinear form of the strain energy of harmonic m, twice the energy a radian [N m/rad]."""
    from skfem import BilinearForm
    from skfem.helpers import grad

    lame = material.modulus * material.poisson / (
        (1 + material.poisson) * (1 - 2 * material.poisson)
    )  # fmt: skip

    def strains(u: Any, r: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
        du = grad(u)
        stretch = [du[0, 0], (u[0] + m * u[1]) / r, du[2, 1]]
        shear = [du[0, 1] + du[2, 0], du[1, 0] - (m * u[0] + u[1]) / r, du[1, 1] - m * u[2] / r]
        return stretch, shear

    @BilinearForm
    def form(u: Any, v: Any, w: Any) -> np.ndarray:
        r = w.x[0]
        (e, g), (f, h) = strains(u, r), strains(v, r)
        stretch = 2 * material.shear * sum(a * b for a, b in zip(e, f, strict=True))
        shear = material.shear * sum(a * b for a, b in zip(g, h, strict=True))
        return np.asarray(r * (lame * sum(e) * sum(f) + stretch + shear))

    return form


def _volume() -> Any:
    from skfem import BilinearForm
    from skfem.helpers import dot

    return BilinearForm(lambda u, v, w: w.x[0] * dot(u, v))
