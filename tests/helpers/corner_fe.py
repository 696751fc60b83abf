"""Finite elements of a square prism in plane strain that is loaded on a face, or on a corner.

A body that floats: the load is balanced by body forces like those of a rigid motion, and the
displacement of the load is counted from the mean motion of the body, as in a particle code. The
corner is a rounded one. Quadratic triangles, finest at the load.
"""

import math

import numpy as np
from scipy.sparse import bmat, csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, FacetBasis, LinearForm, MeshTri
from skfem.helpers import ddot, dot, sym_grad, trace


def square_on_its_face(side):
    """A square below the origin, which is the middle of its upper face; nothing is rounded."""
    mesh = MeshTri.init_tensor(np.array([-side / 2, 0, side / 2]), np.array([-side, -side / 2, 0]))
    return mesh, lambda points: points


def square_on_its_corner(side, radius):
    """A square below the origin, which is the top of a corner rounded by a radius."""
    centre = np.array([0.0, -radius])
    angles = np.linspace(math.pi / 4, 3 * math.pi / 4, 9)
    arc = centre[:, None] + radius * np.array([np.cos(angles), np.sin(angles)])
    apex, half = (math.sqrt(2) - 1) * radius, side / math.sqrt(2)
    others = np.array([[-half, 0.0, half], [apex - half, apex - 2 * half, apex - half]])
    points = np.column_stack([centre, arc, others])
    around = 1 + np.arange(points.shape[1] - 1)
    mesh = MeshTri(points, np.array([np.zeros_like(around), around, np.roll(around, -1)]))

    def on_the_arc(points):
        off = points - centre[:, None]
        far = np.hypot(*off)
        angle = np.arctan2(off[1], off[0])
        near = (np.abs(angle - math.pi / 2) <= math.pi / 4 + 1e-9) & (far < 1.2 * radius)
        return np.where(near, centre[:, None] + off * radius / far, points)

    return mesh, on_the_arc


def displacements(body, half_width, poisson):
    """Mean displacements of Hertz's load by itself, weighted by it: across and along the surface.

    For a load of 1 N/m, a modulus of 1 Pa; and the area of the body [m2].
    """
    mesh = _refined(*body, half_width)
    element = ElementVector(ElementTriP2())
    basis = Basis(mesh, element, intorder=4)
    lame = poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = 1 / (2 * (1 + poisson))

    @BilinearForm
    def stiffness(u, v, w):
        strain, other = sym_grad(u), sym_grad(v)
        return lame * trace(strain) * trace(other) + 2 * shear * ddot(strain, other)

    @BilinearForm
    def mass(u, v, w):
        return dot(u, v)

    matrix, weight = stiffness.assemble(basis).tocsc(), mass.assemble(basis).tocsc()
    x, y = (np.concatenate([basis.nodal_dofs[k], basis.facet_dofs[k]]) for k in (0, 1))
    rigid = np.zeros((matrix.shape[0], 3))
    rigid[x, 0] = rigid[y, 1] = 1.0
    rigid[x, 2], rigid[y, 2] = -basis.doflocs[1, x], basis.doflocs[0, y]
    area = float(rigid[:, 0] @ (weight @ rigid[:, 0]))
    rigid = rigid @ np.linalg.inv(np.linalg.cholesky(rigid.T @ (weight @ rigid))).T
    held = csc_matrix(weight @ rigid)
    solved = splu(bmat([[matrix, held], [held.T, None]]).tocsc())
    under = mesh.facets_satisfying(
        lambda p: (np.abs(p[0]) < 1.5 * half_width) & (np.abs(p[1]) < 0.2 * half_width),
        boundaries_only=True,
    )
    surface = FacetBasis(mesh, element, facets=under, intorder=12)
    found = []
    for direction, dofs in ((1, y), (0, x)):

        @LinearForm
        def pressure(v, w, direction=direction):
            return np.sqrt(np.clip(1 - (w.x[0] / half_width) ** 2, 0, None)) * v[direction]

        load = pressure.assemble(surface)
        load /= load[dofs].sum()
        load -= held @ (rigid.T @ load)
        found.append(float(load @ solved.solve(np.append(load, np.zeros(3)))[: len(load)]))
    return found[0], found[1], area


def _refined(mesh, outline, half_width):
    """The mesh with elements of a third of the half-width at the load, and growing from there."""
    while True:
        corners = mesh.p[:, mesh.t]
        size = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
        away = np.linalg.norm(corners, axis=0).min(axis=0)
        coarse = np.flatnonzero(size > np.maximum(half_width / 3, 0.35 * (away - 2 * half_width)))
        if not len(coarse):
            return mesh
        before = mesh.p.shape[1]
        mesh = mesh.refined(coarse)
        added = np.array([n for n in mesh.boundary_nodes() if n >= before], int)
        mesh.p[:, added] = outline(mesh.p[:, added])
