"""A reference that shares nothing with the rig: a round punch on a bonded neo-Hookean layer, axisymmetric, Newton.

Nine-node quadrilaterals with full integration; W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 or its linear limit.
"""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

IDENTITY = np.eye(3)


def shapes(x):
    return np.array([x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2]), np.array([x - 0.5, -2 * x, x + 0.5])


def graded(even_to, cells, end, more):
    """Even cells up to a point, then growing ones to the end."""
    growing = np.cumsum(np.geomspace(1.0, 0.3 * (end - even_to) / (even_to / cells), more))
    return np.append(np.linspace(0, even_to, cells + 1), even_to + (end - even_to) * growing / growing[-1])


def with_middles(lines):
    return np.sort(np.append(lines, (lines[1:] + lines[:-1]) / 2))


class AxisymmetricLayer:
    def __init__(self, thickness, shear, lame, r_lines, z_lines, is_linear=False):
        self.shear, self.lame, self.is_linear = shear, lame, is_linear
        r, z = with_middles(r_lines), with_middles(z_lines)
        self.places = np.stack(np.meshgrid(r, z, indexing="ij"), -1).reshape(-1, 2)
        ids = np.arange(len(r) * len(z)).reshape(len(r), len(z))
        cells = [ids[a : len(r) - 2 + a : 2, b : len(z) - 2 + b : 2].ravel() for a in range(3) for b in range(3)]
        self.cells = np.stack(cells, 1)
        self.top = ids[:, -1]
        self.held = np.unique(np.concatenate([2 * ids[:, 0], 2 * ids[:, 0] + 1, 2 * ids[0], 2 * ids[-1]]))
        self.dofs = np.stack([2 * self.cells, 2 * self.cells + 1], -1).reshape(len(self.cells), 18)
        points, weights = np.polynomial.legendre.leggauss(3)
        at = self.places[self.cells]
        self.quadrature = []
        for x, weight_x in zip(points, weights, strict=True):
            for y, weight_y in zip(points, weights, strict=True):
                (n_x, d_x), (n_y, d_y) = shapes(x), shapes(y)
                local = np.stack([np.outer(d_x, n_y).ravel(), np.outer(n_x, d_y).ravel()])
                jacobian = np.einsum("ia,ead->eid", local, at)
                slopes = np.linalg.inv(jacobian) @ local
                values = np.outer(n_x, n_y).ravel()
                radius = at[:, :, 0] @ values
                b = np.zeros((len(at), 3, 3, 9, 2))
                b[:, 0, :2, :, 0] = b[:, 1, :2, :, 1] = slopes
                b[:, 2, 2, :, 0] = values / radius[:, None]
                weight = np.linalg.det(jacobian) * weight_x * weight_y * 2 * np.pi * radius
                self.quadrature.append((b.reshape(-1, 9, 18), weight))

    def response(self, gradient):
        """Stress (n, 3, 3) and its derivative (n, 3, 3, 3, 3)."""
        mixed = np.einsum("ik,jl->ijkl", IDENTITY, IDENTITY)
        if self.is_linear:
            strain = (gradient + gradient.swapaxes(1, 2)) / 2
            trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
            tangent = self.shear * (mixed + np.einsum("il,jk->ijkl", IDENTITY, IDENTITY))
            tangent = tangent + self.lame * np.einsum("ij,kl->ijkl", IDENTITY, IDENTITY)
            stress = 2 * self.shear * strain + self.lame * trace * IDENTITY
            return stress, np.broadcast_to(tangent, (len(gradient), 3, 3, 3, 3))
        f = gradient + IDENTITY
        inverse = np.linalg.inv(f)
        log = np.log(np.linalg.det(f))
        stress = self.shear * (f - inverse.swapaxes(1, 2)) + self.lame * log[:, None, None] * inverse.swapaxes(1, 2)
        tangent = self.shear * mixed + self.lame * np.einsum("eji,elk->eijkl", inverse, inverse)
        return stress, tangent + np.einsum("e,eli,ejk->eijkl", self.shear - self.lame * log, inverse, inverse)

    def assembled(self, u):
        forces, size = np.zeros(len(u)), len(u)
        blocks = np.zeros((len(self.cells), 18, 18))
        for b, weight in self.quadrature:
            stress, tangent = self.response(np.einsum("eij,ej->ei", b, u[self.dofs]).reshape(-1, 3, 3))
            np.add.at(forces, self.dofs, weight[:, None] * np.einsum("eij,ei->ej", b, stress.reshape(-1, 9)))
            blocks += b.swapaxes(1, 2) @ (weight[:, None, None] * tangent.reshape(-1, 9, 9)) @ b
        rows, columns = np.repeat(self.dofs, 18, 1).ravel(), np.tile(self.dofs, (1, 18)).ravel()
        return forces, coo_matrix((blocks.ravel(), (rows, columns)), shape=(size, size)).tocsr()

    def smallest_volume(self, u):
        gradients = (np.einsum("eij,ej->ei", b, u[self.dofs]).reshape(-1, 3, 3) for b, _ in self.quadrature)
        return min(np.linalg.det(gradient + IDENTITY).min() for gradient in gradients)

    def press(self, surface_nodes, moves, is_stuck=True):
        """Normal forces (n,), N, with surface nodes at displacements ``moves`` (n, nodes), m, upwards, one by one."""
        down = 2 * surface_nodes + 1
        held = np.union1d(self.held, np.concatenate([down, 2 * surface_nodes]) if is_stuck else down)
        free = np.setdiff1d(np.arange(2 * len(self.places)), held)
        u, out = np.zeros(2 * len(self.places)), []
        for move in moves:
            step = np.zeros_like(u)
            step[down] = move - u[down]
            for _ in range(40):
                forces, stiffness = self.assembled(u)
                step[free] = splu(stiffness[free][:, free].tocsc()).solve(-(forces + stiffness @ step)[free])
                share = 1.0
                while not self.is_linear and self.smallest_volume(u + share * step) < 0.3:
                    share /= 2
                u = u + share * step
                if np.abs(step).max() < 1e-9:
                    break
                step = (1 - share) * step
                step[free] = 0.0
            out.append(-self.assembled(u)[0][down].sum())
        return np.array(out)
