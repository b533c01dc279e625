"""A yardstick that shares nothing with the engine: an axisymmetric layer of scikit-fem's quadratic cells.

The layer is a disc, bonded below, free around. It is pressed without friction by a rigid ball, held off by a penalty at
the quadrature points of its surface, or by a flat punch, whose displacement is prescribed.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve
from skfem import Basis, ElementQuad2, ElementVector, FacetBasis, MeshQuad

PENALTY = 3e6  # 1/m: pressure over Young's modulus of a metre of overlap

ONSET = 5e-8  # m of overlap over which the springs set in
LONGEST = 1e-4  # m that a node moves in an iteration


@dataclass
class Layer:
    """Cells of a disc of radius and thickness, m, fine at the axis and near the surface z = 0."""

    radius: float
    thickness: float
    spacing: float
    fine: float

    def __post_init__(self):
        inner = np.arange(0, self.fine + self.spacing / 2, self.spacing)
        r = _continued(inner, self.radius)
        z = -_continued(np.arange(0, self.thickness / 8 + self.spacing / 2, self.spacing), self.thickness)[::-1]
        mesh = MeshQuad.init_tensor(r, z)
        self.top = mesh.facets_satisfying(lambda x: np.abs(x[1]) < 1e-9, boundaries_only=True)
        self.basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=4)
        radii = self.basis.global_coordinates()[0]
        fields = [field[0] for field in self.basis.basis]
        rows = [[f.grad[0, 0], f.grad[0, 1], f.grad[1, 0], f.grad[1, 1], f[0] / radii] for f in fields]
        self.gradients = np.array(rows).transpose(2, 1, 0, 3)  # (c, 5, 18, q)
        self.weights = 2 * np.pi * radii * self.basis.dx
        self.surface = FacetBasis(mesh, ElementVector(ElementQuad2()), facets=self.top, intorder=8)
        self.bottom = self.basis.get_dofs(lambda x: np.abs(x[1] + self.thickness) < 1e-9).all()
        self.axis = self.basis.get_dofs(lambda x: np.abs(x[0]) < 1e-9).all("u^1")

    def punched(self, radius, depth, nu, is_linear, is_glued, steps=4):
        """Force over Young's modulus, m^2, of a flat punch; glued, or sliding freely."""
        under = self.basis.get_dofs(lambda x: (np.abs(x[1]) < 1e-9) & (x[0] < radius * (1 + 1e-6)))
        pressed, stuck = under.all("u^2"), under.all("u^1") if is_glued else np.zeros(0, dtype=int)
        held = np.unique(np.concatenate([self.bottom, self.axis, pressed, stuck]))
        u = np.zeros(self.basis.N)
        for share in (np.arange(steps) + 1) / steps:
            u[pressed] = -share * depth
            u = self._equilibrium(u, held, nu, is_linear, None)
        residual, _ = self._elastic(u, nu, is_linear)
        return -float(residual[pressed].sum())

    def balled(self, radius, depths, nu, is_linear):
        """Forces over Young's modulus, m^2, and surface displacements (r, u_r, u_z), m, of a ball at depths."""
        held = np.unique(np.concatenate([self.bottom, self.axis]))
        u, forces, shapes, before = np.zeros(self.basis.N), [], [], 0.0
        for depth in depths:
            u = self._pressed_further(u, held, nu, is_linear, radius, before, depth)
            residual, _ = self._contact(u, radius, depth)
            forces.append(self._total(residual))
            shapes.append(self._shape(u))
            before = depth
        return np.array(forces), shapes

    def _pressed_further(self, u, held, nu, is_linear, radius, before, depth):
        """The solution at a further depth, reached in one step or by halves."""
        if depth - before < 6e-5:
            reached = self._equilibrium(u, held, nu, is_linear, (radius, depth))
            if reached is not None:
                return reached
        assert depth - before > 1e-6, "the yardstick found no equilibrium"
        middle = (before + depth) / 2
        u = self._pressed_further(u, held, nu, is_linear, radius, before, middle)
        return self._pressed_further(u, held, nu, is_linear, radius, middle, depth)

    def _total(self, residual):
        vertical = self.basis.zeros()
        vertical[self.basis.get_dofs(self.top).all("u^2")] = 1.0
        return float(residual @ vertical)

    def _shape(self, u):
        dofs = self.basis.get_dofs(self.top)
        r, z = dofs.all("u^1"), dofs.all("u^2")
        order = np.argsort(self.basis.doflocs[0, r])
        return np.stack([self.basis.doflocs[0, r], u[r], u[z]])[:, order]

    def _equilibrium(self, u, held, nu, is_linear, ball):
        u = u.copy()
        free = np.setdiff1d(np.arange(len(u)), held)
        for _ in range(25):
            residual, tangent = self._elastic(u, nu, is_linear)
            if ball is not None:
                pushed, stiffness = self._contact(u, *ball)
                residual, tangent = residual + pushed, tangent + stiffness
            step = spsolve(tangent[free][:, free].tocsc(), -residual[free])
            whole = np.zeros_like(u)
            whole[free] = step * min(1.0, LONGEST / np.abs(step).max())
            while not is_linear and self._least_volume(u + whole) < 0.3 * self._least_volume(u):
                whole /= 2
            u += whole
            if np.abs(step).max() < 1e-9:
                return u
        return None

    def _contact(self, u, radius, depth):
        """Residual and tangent of the springs that keep the surface under the ball."""
        r = self.surface.global_coordinates()[0]
        moved = self.surface.interpolate(u)
        across = r + moved[0]
        under = np.sqrt(np.maximum(radius**2 - across**2, 1e-12))
        overlap = moved[1] - (radius - under - depth)
        slope = -across / under
        # a spring that sets in smoothly, so that Newton's iterations end
        soft = np.clip(overlap + ONSET, 0, 2 * ONSET)
        force = PENALTY * np.where(overlap > ONSET, overlap, soft**2 / (4 * ONSET))
        rise = PENALTY * soft / (2 * ONSET)
        area = 2 * np.pi * r * self.surface.dx
        shapes = np.stack([slope * field[0][0] + field[0][1] for field in self.surface.basis])
        across_shapes = np.stack([field[0][0] for field in self.surface.basis])
        residual = np.einsum("icq,cq->ci", shapes, area * force)
        bend = -force * radius**2 / under**3
        tangent = np.einsum("icq,jcq,cq->cij", shapes, shapes, area * rise, optimize=True)
        tangent += np.einsum("icq,jcq,cq->cij", across_shapes, across_shapes, area * bend, optimize=True)
        return self._assembled(self.surface, residual, tangent)

    def _least_volume(self, u):
        f = np.array([1.0, 0, 0, 1, 1])[None, :, None] + self._gradient(u)
        return float(((f[:, 0] * f[:, 3] - f[:, 1] * f[:, 2]) * f[:, 4]).min())

    def _gradient(self, u):
        return np.einsum("ckiq,ci->ckq", self.gradients, u[self.basis.element_dofs.T], optimize=True)

    def _elastic(self, u, nu, is_linear):
        """Residual and tangent of the layer, Young's modulus 1; gradients as (rr, rz, zr, zz, round)."""
        shear, lame = 1 / (2 * (1 + nu)), nu / ((1 + nu) * (1 - 2 * nu))
        gradient = self._gradient(u)
        unit = np.array([1.0, 0, 0, 1, 1])[None, :, None]
        transpose = [0, 2, 1, 3, 4]
        if is_linear:
            f, back, log_ratio = unit + gradient, np.broadcast_to(unit, gradient.shape), 0.0 * gradient[:, 0]
            stress = (
                shear * (gradient + gradient[:, transpose]) + lame * gradient[:, [0, 3, 4]].sum(axis=1)[:, None] * unit
            )
        else:
            f = unit + gradient
            plane = f[:, 0] * f[:, 3] - f[:, 1] * f[:, 2]
            # the inverse's transpose
            back = np.stack([f[:, 3] / plane, -f[:, 2] / plane, -f[:, 1] / plane, f[:, 0] / plane, 1 / f[:, 4]], axis=1)
            log_ratio = np.log(plane * f[:, 4])
            stress = shear * (f - back) + lame * log_ratio[:, None] * back
        law = lame * np.einsum("ckq,clq->cqkl", back, back) + shear * np.eye(5)
        # change of the inverse's transpose B is -B dF^T B: entry (i, l) by dF (k, j) is B (i, j) B (k, l)
        places = [(0, 0), (0, 1), (1, 0), (1, 1)]
        number = {place: row for row, place in enumerate(places)}
        for row, (i, m) in enumerate(places):
            for column, (k, j) in enumerate(places):
                law[..., row, column] += (shear - lame * log_ratio) * back[:, number[i, j]] * back[:, number[k, m]]
        law[..., 4, 4] += (shear - lame * log_ratio) * back[:, 4] ** 2
        residual = np.einsum("ckiq,ckq,cq->ci", self.gradients, stress, self.weights, optimize=True)
        turned = self.gradients.transpose(0, 3, 1, 2)
        tangent = (turned.transpose(0, 1, 3, 2) @ (law * self.weights[..., None, None]) @ turned).sum(axis=1)
        return self._assembled(self.basis, residual, tangent)

    def _assembled(self, basis, residual, tangent):
        dofs = basis.element_dofs.T
        rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
        shape = (self.basis.N, self.basis.N)
        matrix = coo_array((tangent.ravel(), (rows.ravel(), columns.ravel())), shape=shape).tocsr()
        return np.bincount(dofs.ravel(), residual.ravel(), minlength=self.basis.N), matrix


def _continued(fine, end):
    """Positions that go on from evenly spaced ones to an end, each interval a quarter longer than the last."""
    step, places = fine[-1] - fine[-2], list(fine)
    while places[-1] + 1.6 * step * 1.25 < end:
        step *= 1.25
        places.append(places[-1] + step)
    return np.array([*places, end])
