"""A pad and an indenter as a MuJoCo model: the pad a flex of tetrahedra, the indenter a body that is led by hand."""

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
"""The model is in mm and N/mm^2 with Young's modulus 1: MuJoCo's tolerances are made for numbers near one."""
SPLIT = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
"""Six tetrahedra around the diagonal of a hexahedron; in a grid, neighbours' faces are cut alike."""
TIME_STEP = 1e-2
"""s: so that accelerations are far above the solver's tolerance; nothing else depends on it."""
DAMPING = 3.0
"""Time steps, of the stiffness-proportional damping: without it the pad swings, with more it creeps."""
LEADING_MASS = 1e2
"""Of the indenter, a million times a vertex': contact does not move it."""
CONVEX = 2e-3
"""Share of its volume by which a body may differ from its convex hull."""
NOT_A_FAULT = "has no equality constraints or passive forces"
"""MuJoCo 4.0 says so of every flex that is held by its elasticity alone."""


def tetrahedra_of(mesh: PadMesh) -> Indices:
    """Four-node cells (c, 4) on the pad's own vertices.

    Raises
    ------
    UsageError
        A pad of ten-node cells, which a flex does not know.
    """
    if mesh.kind != "hexahedron8":
        raise UsageError(
            f"pad {mesh.name!r} is made of {mesh.kind}",
            "hexahedron8: mujoco-flex plays structured pads",
            "Take the engine fem.",
        )
    return mesh.cells[:, SPLIT].reshape(-1, 4)


def is_convex(indenter: Indenter) -> bool:
    """Whether an indenter is one that MuJoCo presses as it is."""
    solid = indenter.mesh()
    return bool(abs(solid.convex_hull.volume / solid.volume - 1) <= CONVEX)


def require_convex(indenter: Indenter) -> None:
    """Nothing, for an indenter that MuJoCo presses as it is.

    Raises
    ------
    UsageError
        One that is not convex.
    """
    if not is_convex(indenter):
        raise UsageError(
            f"indenter {indenter.shape!r} is not convex",
            "a convex one: mujoco-flex would press the convex hull",
            "Take the engine fem.",
            indenter=indenter.shape,
        )


class FlexModel:
    """The compiled model and its state.

    Parameters
    ----------
    mesh : PadMesh
    cells : (c, 4)
    indenter : Indenter
        A convex one: MuJoCo presses the hull of any other.
    poisson_ratio, friction : float
    """

    def __init__(
        self, mesh: PadMesh, cells: Indices, indenter: Indenter, poisson_ratio: float, friction: float
    ) -> None:
        self._mujoco = load_mujoco("engine mujoco-flex")
        spec = self._mujoco.MjSpec.from_string(_document(mesh, cells, indenter, poisson_ratio, friction))
        # stable neo-Hookean; the default, Saint Venant-Kirchhoff, softens under pressure
        spec.flexes[0].elastic3d = 1
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=f".*{NOT_A_FAULT}")
            self._model = spec.compile()
        self._state = self._mujoco.MjData(self._model)
        self._nodes = len(mesh.vertices)
        self._moving = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.base)

    def reset(self) -> None:
        """The pad at rest."""
        self._mujoco.mj_resetData(self._model, self._state)

    def step(self, pose: Array, towards: Array) -> None:
        """One time step in which the indenter goes from a pose (4, 4) to another, m."""
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
        """MuJoCo writes its warnings into a file where the user works; whether a frame is at rest is judged here."""
        before = self._mujoco.get_mju_user_warning()
        self._mujoco.set_mju_user_warning(lambda message: None)
        try:
            yield
        finally:
            self._mujoco.set_mju_user_warning(before)

    @property
    def is_sound(self) -> bool:
        """Whether all numbers are finite."""
        return bool(np.isfinite(self._state.qpos).all() and np.isfinite(self._state.qfrc_constraint).all())

    def displacement(self) -> Array:
        """Of all nodes (v, 3), m."""
        return self._on_nodes(self._state.qpos[7:]) / MILLIMETRES

    def contact_forces(self) -> Array:
        """What the indenter exerted on each node (v, 3) in the last step, m^2: N over Young's modulus."""
        return self._on_nodes(self._state.qfrc_constraint[6:]) / MILLIMETRES**2

    def elastic_forces(self) -> Array:
        """What the pad itself exerted on each node (v, 3) in the last step, m^2."""
        return self._on_nodes(self._state.qfrc_passive[6:]) / MILLIMETRES**2

    def _on_nodes(self, of_moving: Array) -> Array:
        spread = np.zeros((self._nodes, 3))
        spread[self._moving] = of_moving.reshape(-1, 3)
        return spread


def _document(mesh: PadMesh, cells: Indices, indenter: Indenter, poisson_ratio: float, friction: float) -> str:
    root = ElementTree.Element("mujoco", model="flex")
    option = ElementTree.SubElement(
        root, "option", timestep=str(TIME_STEP), integrator="discrete", solver="Newton", gravity="0 0 0",
        cone="elliptic", impratio="10", iterations="500", tolerance="1e-9",
    )  # fmt: skip
    ElementTree.SubElement(option, "flag", autoreset="disable")
    # as hard as the solver allows; the constant of two time steps lets overlaps go without a rebound
    contact = {
        "condim": "3",
        "friction": f"{friction:.9g} 0 0",
        "solref": f"{2 * TIME_STEP} 1",
        "solimp": "0.9999 0.9999 1",
    }
    world = ElementTree.SubElement(root, "worldbody")
    body = ElementTree.SubElement(world, "body", name="indenter")
    ElementTree.SubElement(body, "freejoint")
    mass = str(LEADING_MASS)
    ElementTree.SubElement(body, "inertial", pos="0 0 0", mass=mass, diaginertia=f"{mass} {mass} {mass}")
    _add_shape(root, body, indenter, contact)
    # masses as large as the stiffness: contact is as hard as they are, and the damping still brings the pad to rest
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
    if isinstance(indenter, Sphere):
        radius = MILLIMETRES * indenter.radius
        ElementTree.SubElement(body, "geom", {**contact, "type": "sphere", "size": str(radius), "pos": f"0 0 {radius}"})
        return
    asset = ElementTree.SubElement(root, "asset")
    hull = indenter.mesh().convex_hull
    ElementTree.SubElement(asset, "mesh", name="solid", vertex=_numbers(MILLIMETRES * hull.vertices))
    ElementTree.SubElement(body, "geom", {**contact, "type": "mesh", "mesh": "solid"})


def _mean_volume(vertices: Array, cells: Indices) -> float:
    edges = vertices[cells[:, 1:]] - vertices[cells[:, :1]]
    return float(np.abs(np.linalg.det(edges)).mean() / 6)


def _numbers(values: Any) -> str:
    return " ".join(f"{value:.9g}" for value in np.asarray(values, dtype=float).ravel())
