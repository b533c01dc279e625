"""Blocks of gel and touches for the tests."""

import numpy as np

from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.sensors.base import GelGeometry


def block(half, thickness, count, spacing, uniform, levels, touched):
    """A flat block 2 half x 2 half x thickness, m; only the square within ``touched`` of the middle can be touched."""
    plan = GridPlan(count, count, spacing, (uniform, uniform), tuple(levels))
    mesh = structured_pad("block", GelGeometry((2 * half, 2 * half), thickness, thickness), plan)
    near = (np.abs(mesh.vertices[mesh.faces].mean(axis=1)[:, :2]) < touched).all(axis=1)
    return PadMesh(mesh.name, mesh.kind, mesh.vertices, mesh.cells, mesh.base, mesh.faces[near])


def slab(spacing=0.8e-3, count=6, uniform=2.4e-3, levels=(0.0, 0.5, 0.8, 1.0), touched=4.0e-3):
    """A layer of 24 x 24 x 4 mm."""
    return block(12e-3, 4e-3, count, spacing, uniform, levels, touched)


def poses(*places):
    """Poses (n, 4, 4) of indenters that point straight down, from (x, y, z) in millimetres."""
    matrices = np.tile(np.eye(4), (len(places), 1, 1))
    matrices[:, :3, 3] = 1e-3 * np.asarray(places)
    return matrices


def pressed(engine, indenter, at, friction=0.0, modulus=1e6, **options):
    """The history of one touch."""
    material = GelMaterial(modulus, engine.poisson_ratio, friction)
    return dict(engine.play([GelTouch(indenter, at)], material, **options))[0]


def forces_at(mesh, poisson_ratio, fidelity, indenter, depths, friction=0.0):
    """Normal forces (n,), N, at depths, m, for a Young's modulus of 1 MPa; every frame must be solved."""
    engine = FemEngine(mesh, poisson_ratio, fidelity)
    history = pressed(engine, indenter, poses(*[(0, 0, -1e3 * depth) for depth in depths]), friction)
    assert not history.status.any(), history.status
    return history.wrench[:, 2]
