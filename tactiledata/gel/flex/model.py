"""Pad and indenter as a MuJoCo model: the pad is a flex of tetrahedra, the indenter a body with a prescribed motion."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.gel.mesh.pad import Indices, PadMesh
from tactiledata.gel.scene.mujoco_package import load_mujoco
from tactiledata.indenters.base import Indenter
from tactiledata.indenters.sphere import Sphere

MILLIMETRES = 1e3
"""Model units per metre: lengths are in mm with Young's modulus 1, because MuJoCo's tolerances suit numbers near 1."""
SPLIT = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
"""Six tetrahedra around the diagonal of a hexahedron; in a grid, the faces of neighbours are cut in the same way."""
TIME_STEP = 1e-2
"""Time step, s, small enough that accelerations are far above the solver's tolerance; nothing else depends on it."""
DAMPING = 3.0
"""Stiffness-proportional damping in time steps: with less the pad oscillates, with more it creeps."""
LEADING_MASS = 1e2
"""Mass of the indenter, a million times that of a vertex, so that contact does not move it."""
CONVEX = 2e-3
"""Largest difference of a convex indenter's volume from that of its convex hull, as a share."""
HARMLESS_WARNING = "has no equality constraints or passive forces"
"""Text of a harmless warning of MuJoCo 4.0 about every flex that only its elasticity holds."""


def tetrahedra_of(mesh: PadMesh) -> Indices:
    """Return four-node cells (c, 4) on the pad's own vertices.

    Raises
    ------
    UsageError
        A pad that is not made of hexahedra.
    """
    if mesh.kind != "hexahedron8":
        raise UsageError(
            f"pad {mesh.name!r} is made of {mesh.kind}",
            "hexahedron8: mujoco-flex plays structured pads",
            "Take the engine fem.",
        )
    return mesh.cells[:, SPLIT].reshape(-1, 4)


def is_convex(indenter: Indenter) -> bool:
    """Whether an indenter is convex within ``CONVEX``; MuJoCo replaces any other by its hull."""
    solid = indenter.mesh()
    return bool(abs(solid.convex_hull.volume / solid.volume - 1) <= CONVEX)


def require_convex(indenter: Indenter) -> None:
    """Refuse an indenter that is not convex.

    Raises
    ------
    UsageError
        The indenter is not convex.
    """
    if not is_convex(indenter):
        raise UsageError(
            f"indenter {indenter.shape!r} is not convex",
            "a convex one: mujoco-flex would press the convex hull",
            "Take the engine fem.",
            indenter=indenter.shape,
        )


class FlexModel:
    """Compiled MuJoCo model of pad and indenter, with its state.

    Parameters
    ----------
    mesh : PadMesh
        Vertices and base.
    cells : (c, 4)
        Four-node cells on the same vertices.
    indenter : Indenter
        A convex one: MuJoCo presses the hull of any other.
    poisson_ratio, friction : float
        Of the gel, and between indenter and gel.
    """

    def __init__(
        self, mesh: PadMesh, cells: Indices, indenter: Indenter, poisson_ratio: float, friction: float
    ) -> None:
        self._mujoco = load_mujoco("engine mujoco-flex")
        spec = self._mujoco.MjSpec.from_string(_document(mesh, cells, indenter, poisson_ratio, friction))
        # stable neo-Hookean; the default, Saint Venant-Kirchhoff, softens under pressure
        spec.flexes[0].elastic3d = 1
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=f".*{HARMLESS_WARNING}")
            self._model = spec.compile()
        self._state = self._mujoco.MjData(self._model)
        self._nodes = len(mesh.vertices)
        self._moving = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.base)

    def reset(self) -> None:
        """Set the pad to rest."""
        self._mujoco.mj_resetData(self._model, self._state)

    def step(self, pose: Array, towards: Array) -> None:
        """Make one time step in which the indenter moves from ``pose`` to ``towards``, (4, 4), gel_from_indenter."""
        state = self._state
        turn = Rotation.from_matrix(pose[:3, :3])
        state.qpos[:3] = MILLIMETRES * pose[:3, 3]
        state.qpos[3:7] = turn.as_quat(scalar_first=True)
        state.qvel[:3] = MILLIMETRES * (towards[:3, 3] - pose[:3, 3]) / TIME_STEP
        state.qvel[3:6] = (turn.inv() * Rotation.from_matrix(towards[:3, :3])).as_rotvec() / TIME_STEP
        with self._without_a_log():
            self._mujoco.mj_step(self._model, state)

    @contextmanager
    def _without_a_log(self) -> Iterator[None]:
        """Silence MuJoCo's warnings, which it would write to a file in the working folder."""
        before = self._mujoco.get_mju_user_warning()
        self._mujoco.set_mju_user_warning(lambda message: None)
        try:
            yield
        finally:
            self._mujoco.set_mju_user_warning(before)

    @property
    def is_sound(self) -> bool:
        """Whether all positions and forces are finite."""
        return bool(np.isfinite(self._state.qpos).all() and np.isfinite(self._state.qfrc_constraint).all())

    def displacement(self) -> Array:
        """Displacements of all nodes (v, 3), m."""
        return self._on_nodes(self._state.qpos[7:]) / MILLIMETRES

    def contact_forces(self) -> Array:
        """Force of the indenter on each node (v, 3) in the last step, m^2: N over Young's modulus."""
        return self._on_nodes(self._state.qfrc_constraint[6:]) / MILLIMETRES**2

    def elastic_forces(self) -> Array:
        """Elastic and damping force of the pad on each node (v, 3) in the last step, m^2."""
        return self._on_nodes(self._state.qfrc_passive[6:]) / MILLIMETRES**2

    def _on_nodes(self, moving_values: Array) -> Array:
        """Values of all nodes (v, 3), from those of the nodes that are not held; 0 on the base."""
        values = np.zeros((self._nodes, 3))
        values[self._moving] = moving_values.reshape(-1, 3)
        return values


def _document(mesh: PadMesh, cells: Indices, indenter: Indenter, poisson_ratio: float, friction: float) -> str:
    """Return the MJCF document of the model."""
    root = ElementTree.Element("mujoco", model="flex")
    option = ElementTree.SubElement(
        root, "option", timestep=str(TIME_STEP), integrator="discrete", solver="Newton", gravity="0 0 0",
        cone="elliptic", impratio="10", iterations="500", tolerance="1e-9",
    )  # fmt: skip
    ElementTree.SubElement(option, "flag", autoreset="disable")
    # contact as hard as the solver allows; a time constant of two steps removes overlaps without a rebound
    contact = {
        "condim": "3",
        "friction": f"{friction:.9g} 0 0",
        "solref": f"{2 * TIME_STEP} 1",
        "solimp": "0.9999 0.9999 1",
    }
    # the indenter: a free body whose position and velocity are set at each step
    world = ElementTree.SubElement(root, "worldbody")
    body = ElementTree.SubElement(world, "body", name="indenter")
    ElementTree.SubElement(body, "freejoint")
    mass = str(LEADING_MASS)
    ElementTree.SubElement(body, "inertial", pos="0 0 0", mass=mass, diaginertia=f"{mass} {mass} {mass}")
    _add_shape(root, body, indenter, contact)
    # masses as large as the stiffness: MuJoCo's contact is as hard as masses are, and damping still ends the motion
    spacing = MILLIMETRES * float(np.cbrt(_mean_volume(mesh.vertices, cells) * 6))
    weight = spacing * TIME_STEP**2 * len(mesh.vertices)
    flex = ElementTree.SubElement(
        world, "flexcomp", name="gel", type="direct", dim="3", radius="0", mass=f"{weight:.9g}",
        point=_numbers(MILLIMETRES * mesh.vertices), element=" ".join(map(str, cells.ravel())),
    )  # fmt: skip
    ElementTree.SubElement(flex, "contact", {**contact, "selfcollide": "none"})
    ElementTree.SubElement(flex, "elasticity", young="1", poisson=str(poisson_ratio), damping=str(DAMPING * TIME_STEP))
    ElementTree.SubElement(flex, "pin", id=" ".join(map(str, mesh.base)))
    return ElementTree.tostring(root, encoding="unicode")


def _add_shape(
    root: ElementTree.Element, body: ElementTree.Element, indenter: Indenter, contact: dict[str, str]
) -> None:
    """Add the indenter's shape to its body: an exact sphere, or the convex hull of its mesh."""
    if isinstance(indenter, Sphere):
        radius = MILLIMETRES * indenter.radius
        ElementTree.SubElement(body, "geom", {**contact, "type": "sphere", "size": str(radius), "pos": f"0 0 {radius}"})
        return
    asset = ElementTree.SubElement(root, "asset")
    hull = indenter.mesh().convex_hull
    ElementTree.SubElement(asset, "mesh", name="solid", vertex=_numbers(MILLIMETRES * hull.vertices))
    ElementTree.SubElement(body, "geom", {**contact, "type": "mesh", "mesh": "solid"})


def _mean_volume(vertices: Array, cells: Indices) -> float:
    """Mean volume of four-node cells, m^3."""
    edges = vertices[cells[:, 1:]] - vertices[cells[:, :1]]
    return float(np.abs(np.linalg.det(edges)).mean() / 6)


def _numbers(values: Any) -> str:
    """Text of numbers for an attribute of the document."""
    return " ".join(f"{value:.9g}" for value in np.asarray(values, dtype=float).ravel())
