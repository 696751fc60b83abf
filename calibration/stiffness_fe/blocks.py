"""One elastic block by plane finite elements: its mesh, its stiffness, how its surface yields.

The block is held by a platen, y = base; its surface is y = z(x). Small strains, per unit depth:
div sigma = 0, sigma = lambda tr(eps) 1 + 2 mu eps. Bilinear quadrilaterals, in columns over the
surface's points and in layers that grow thicker away from it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_COARSEST = 16  # thickness of a layer a block's width or more below the surface, in columns


@dataclass(frozen=True)
class Elastic:
    """Young's modulus [Pa], Poisson's ratio, and whether strain or stress is plane."""

    youngs_modulus: float
    poisson: float
    plane: str = "strain"

    def lame(self) -> tuple[float, float]:
        """lambda and mu of the plane problem [Pa]."""
        # Not by scikit-fem: what its plane_stress returns is another pair in 12.0.0 than in 12.0.2.
        modulus, nu = self.youngs_modulus, self.poisson
        thinned = 1 - nu if self.plane == "stress" else 1 - 2 * nu
        return modulus * nu / ((1 + nu) * thinned), modulus / (2 * (1 + nu))


class Block:
    """A block whose surface passes through (x, z), (n,) each, with x rising [m].

    base      height of its platen [m], below or above the surface
    sides     "free", or "periodic": one of many alike, side by side; then its first and last
              points are one point, and what the last one does is what the first one does
    """

    def __init__(
        self, x: Array, z: Array, base: float, material: Elastic, sides: str = "free"
    ) -> None:
        from scipy.sparse.linalg import splu
        from skfem import Basis, ElementQuad1, ElementVector
        from skfem.models.elasticity import linear_elasticity

        self.material, self.base, self.sides = material, base, sides
        width = float(np.ptp(x))
        shares = layers(1 / (len(x) - 1), float(np.abs(z - base).mean()) / width)
        mesh = _mesh(x, z, base, shares)
        self.basis = Basis(mesh, ElementVector(ElementQuad1()), intorder=3)  # 2 x 2 points
        self.points: Array = np.column_stack([x, z])
        dofs = self.basis.nodal_dofs.reshape(2, len(x), len(shares))
        self._surface, self._platen = dofs[:, :, -1], dofs[:, :, 0]
        self._spread = _spread(dofs, sides)
        self._stiffness = linear_elasticity(*material.lame()).assemble(self.basis).tocsc()
        inner = (self._spread.T @ self._stiffness @ self._spread).tocsc()
        self._solver = splu(inner, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def flexibility(self) -> Array:
        """Displacements of the surface's points under unit forces there [m2/N], (2, n, 2, n).

        Component and point that moves, component and point of the force. The platen rests.
        """
        dofs = self._surface.ravel()
        at = self._spread[dofs]
        whole: Array = at @ self._solver.solve(at.T.toarray())
        return ((whole + whole.T) / 2).reshape(2, *self._surface.shape[1:], 2, -1)

    def displacements(self, forces: Array) -> Array:
        """Displacements of all degrees of freedom [m] under forces (2, n) [N/m] on the surface."""
        load = np.zeros(self.basis.N)
        load[self._surface] = forces
        moved: Array = self._spread @ self._solver.solve(self._spread.T @ load)
        return moved

    def reaction(self, moved: Array) -> Array:
        """Reaction of the platen, (2,) [N/m], from the stresses in the elements."""
        inner = self._stiffness @ moved
        return np.array([inner[dofs].sum() for dofs in self._platen])

    def stress(self, moved: Array) -> Array:
        """sigma_xx, sigma_yy, sigma_xy at the mesh's points, (3, m) [Pa], by least squares."""
        from skfem import ElementQuad1
        from skfem.helpers import sym_grad
        from skfem.models.elasticity import linear_stress

        strain = sym_grad(self.basis.interpolate(moved))
        sigma = linear_stress(*self.material.lame())(strain)
        scalar = self.basis.with_element(ElementQuad1())
        parts: list[Any] = [sigma[0, 0], sigma[1, 1], sigma[0, 1]]
        return np.stack([scalar.project(part) for part in parts])

    def at(self, values: Array, points: Array) -> Array:
        """Values (k, m) at the mesh's points, read at other points (p, 2) of the block: (k, p)."""
        from skfem import ElementQuad1

        scalar = self.basis.with_element(ElementQuad1())
        return values @ scalar.probes(points.T).T.toarray()

    def holds(self, points: Array) -> bool:
        """True where points (p, 2) lie within the block, away from its surface's roughness."""
        x, z = self.points.T
        sides = (points[:, 0] >= x[0]) & (points[:, 0] <= x[-1])
        near, far = sorted((self.base, z.max() if self.base > z.max() else z.min()))
        return bool(np.all(sides & (points[:, 1] >= near) & (points[:, 1] <= far)))

    def by_point(self, moved: Array) -> Array:
        """Displacements at the mesh's points, (2, m) [m]."""
        return moved[self.basis.nodal_dofs]


def _spread(dofs: NDArray[np.int64], sides: str) -> Any:
    """Matrix from the unknowns to all degrees of freedom (2, columns, layers): the platen's are 0.

    With periodic sides those of the last column are those of the first.
    """
    from scipy.sparse import csr_matrix

    leads = np.arange(dofs.size)
    if sides == "periodic":
        leads[dofs[:, -1]] = dofs[:, 0]
    moves = ~np.isin(np.arange(dofs.size), dofs[:, :, 0])
    unknowns, column = np.unique(leads[moves], return_inverse=True)
    rows = np.flatnonzero(moves)
    return csr_matrix((np.ones(len(rows)), (rows, column)), shape=(dofs.size, len(unknowns)))


def layers(column: float, height: float) -> Array:
    """Heights of the layers' borders in shares of the block's height, from 0 to 1.

    column and height in widths of the block. The layer at the surface, 1, is as thick as a column,
    or a little less, so that they add up; the thickness grows in proportion to the depth. All of
    them halve with the columns, so that the mesh converges.
    """
    borders = [0.0]
    while borders[-1] < height:
        grown = 1 + (_COARSEST - 1) * min(borders[-1], 1.0)
        borders.append(borders[-1] + column * grown)
    shares: Array = 1 - np.array(borders[::-1]) / borders[-1]
    return shares


def _mesh(x: Array, z: Array, base: float, shares: Array) -> Any:
    """Columns over x and layers at shares of the way from the platen to the surface."""
    from skfem import MeshQuad

    mesh = MeshQuad.init_tensor(x, shares)
    height = np.repeat(z - base, len(shares))
    points = np.vstack([mesh.p[0], base + height * mesh.p[1]])
    return MeshQuad(points, mesh.t)
