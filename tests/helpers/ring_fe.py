"""Finite elements of a toroid that lies on a rigid flat wall, as a check on the closed form.

Axisymmetric, linear triangles, small strains. Its middle plane keeps its height and is free to
widen, which is also the symmetry plane of a toroid between two walls. Unilateral contact without
friction: the nodes that touch are found by an active set on the compliance of the lowest nodes.
"""

import math

import numpy as np
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP1, ElementVector, MeshTri
from skfem.helpers import grad


def half_disc(finest, reach, growth=0.1):
    """The lower half of the unit disc, with elements of the size `finest` within `reach` of its
    lowest point, and growing by `growth` with the distance from there."""
    angles = np.linspace(-math.pi, 0, 13)
    points = [(0.0, 0.0)] + [(r * math.cos(t), r * math.sin(t)) for r in (0.5, 1.0) for t in angles]
    first, second = 1 + np.arange(13), 14 + np.arange(13)
    cells = [(0, first[k], first[k + 1]) for k in range(12)]
    cells += [(first[k], second[k], second[k + 1]) for k in range(12)]
    cells += [(first[k], second[k + 1], first[k + 1]) for k in range(12)]
    mesh = MeshTri(np.array(points).T, np.array(cells).T)
    while True:
        corners = mesh.p[:, mesh.t]
        size = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
        away = np.linalg.norm(corners - np.array([0.0, -1.0])[:, None, None], axis=0).min(axis=0)
        coarse = np.flatnonzero(size > np.maximum(finest, growth * (away - reach)))
        if not len(coarse):
            return mesh
        before = mesh.p.shape[1]
        mesh = mesh.refined(coarse)
        outline = [n for n in mesh.boundary_nodes() if n >= before and mesh.p[1, n] < -1e-12]
        mesh.p[:, outline] /= np.linalg.norm(mesh.p[:, outline], axis=0)


def press(distance, tube, modulus, poisson, overlap, finest, reach, growth=0.1):
    """The force [N] at an overlap [m]; finest, reach: of the mesh, over the tube's radius."""
    mesh = half_disc(finest, reach, growth)
    mesh = MeshTri(mesh.p * tube + np.array([[distance], [0.0]]), mesh.t)
    basis = Basis(mesh, ElementVector(ElementTriP1()))
    lame = modulus * poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = modulus / (2 * (1 + poisson))

    @BilinearForm
    def stiffness(u, v, w):
        r = w.x[0]
        du, dv = grad(u), grad(v)
        strain = du[0, 0], du[1, 1], u[0] / r
        other = dv[0, 0], dv[1, 1], v[0] / r
        sliding = (du[0, 1] + du[1, 0]) * (dv[0, 1] + dv[1, 0])
        same = sum(a * b for a, b in zip(strain, other, strict=True))
        energy = lame * sum(strain) * sum(other) + 2 * shear * same + shear * sliding
        return 2 * math.pi * r * energy

    matrix = stiffness.assemble(basis).tocsc()
    height = basis.nodal_dofs[1]
    held = height[np.flatnonzero(np.abs(mesh.p[1]) < 1e-9 * tube)]
    free = np.setdiff1d(np.arange(matrix.shape[0]), held)
    solved = splu(matrix[free][:, free])
    nodes = mesh.boundary_nodes()
    nodes = nodes[(np.abs(mesh.p[0, nodes] - distance) < reach * tube) & (mesh.p[1, nodes] < 0.0)]
    rows = np.searchsorted(free, height[nodes])
    loads = np.zeros((len(free), len(nodes)))
    loads[rows, np.arange(len(nodes))] = 1.0
    yielding = solved.solve(loads)[rows]
    needed = overlap - (mesh.p[1, nodes] + tube)  # how far the wall lifts a node that touches
    touching = needed > 0.0
    while True:
        forces = np.zeros(len(nodes))
        forces[touching] = np.linalg.solve(yielding[np.ix_(touching, touching)], needed[touching])
        now = (forces > 0.0) | (~touching & (needed - yielding @ forces > 1e-9 * overlap))
        if np.array_equal(now, touching):
            return float(forces.sum())
        touching = now
