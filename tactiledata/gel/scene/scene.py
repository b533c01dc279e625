"""A moment of a touch as a MuJoCo scene: arm, sensor and indenter; distances, pictures, MJCF."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any
from xml.etree import ElementTree

import numpy as np
import trimesh
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.gel.scene.arm import UR5E_LINKS
from tactiledata.gel.scene.mujoco_package import load_mujoco
from tactiledata.transforms import matrix_poses

ARM_RADIUS = 0.045
TOOL_RADIUS = 0.012
FARTHEST = 1.0
"""m: distances beyond it are not measured."""
COLOURS = {
    "arm": "0.55 0.6 0.66 1",
    "tool": "0.3 0.32 0.36 1",
    "gel": "0.95 0.62 0.25 1",
    "indenter": "0.3 0.5 0.85 1",
    "floor": "0.85 0.86 0.88 1",
}
PICTURE = (720, 960)
"""Rows and columns of each of the two views of a picture."""


@dataclass(frozen=True)
class SceneParts:
    """What stands in the scene, all poses 4 x 4, m.

    Parameters
    ----------
    base_from_tcp, tcp_from_gel : (4, 4)
    gel : trimesh.Trimesh
        The pad in the gel frame.
    indenter : trimesh.Trimesh
        In its own frame.
    base_from_indenter : (4, 4)
    joints : (6,) rad, optional
        The arm is drawn where they are known.
    flange_from_tcp : (4, 4), optional
        Needed with joints.
    """

    base_from_tcp: Array
    tcp_from_gel: Array
    gel: trimesh.Trimesh
    indenter: trimesh.Trimesh
    base_from_indenter: Array
    joints: Array | None = None
    flange_from_tcp: Array | None = None


class GelScene:
    """The scene, compiled by MuJoCo.

    Convex hulls stand for pad and indenter in distances, as everywhere in MuJoCo; pictures show the true shapes.
    """

    def __init__(self, parts: SceneParts) -> None:
        self.parts = parts

    @cached_property
    def mjcf(self) -> str:
        """The scene as one MJCF document; meshes are in it."""
        return _document(self.parts)

    @cached_property
    def _compiled(self) -> tuple[Any, Any]:
        mujoco = load_mujoco("the scene")
        model = mujoco.MjModel.from_xml_string(self.mjcf)
        data = mujoco.MjData(model)
        if self.parts.joints is not None:
            data.qpos[:6] = self.parts.joints
        mujoco.mj_forward(model, data)
        return model, data

    def pose(self, body: str) -> Array:
        """Pose (4, 4), m, of a body (``gel``, ``indenter``, ``tcp``) in the base's frame, as MuJoCo places it."""
        _, data = self._compiled
        placed = data.body(body)
        pose = np.eye(4)
        pose[:3, :3] = placed.xmat.reshape(3, 3)
        pose[:3, 3] = placed.xpos
        return pose

    def distance(self) -> tuple[float, Array]:
        """Least distance of gel and indenter, m, negative where they overlap, and the points (2, 3) it lies between."""
        model, data = self._compiled
        ends = np.zeros(6)
        mujoco = load_mujoco("the scene")
        found = mujoco.mj_geomDistance(model, data, model.geom("gel").id, model.geom("indenter").id, FARTHEST, ends)
        return float(found), ends.reshape(2, 3)

    def picture(self) -> NDArray[np.uint8]:
        """RGB (rows, 2 columns, 3): the whole arm on the left, the touch from nearby on the right.

        Raises
        ------
        TactileDataError
            A machine without OpenGL.
        """
        model, data = self._compiled
        mujoco = load_mujoco("the scene")
        try:
            with mujoco.Renderer(model, *PICTURE) as renderer:
                views = []
                for camera in self._cameras(mujoco):
                    renderer.update_scene(data, camera)
                    views.append(renderer.render().copy())
        except (ImportError, AttributeError, OSError, RuntimeError, mujoco.FatalError) as error:
            raise TactileDataError(
                f"no picture can be drawn here: {error}",
                "OpenGL by EGL, OSMesa or a window system",
                "Install libegl1 and Mesa's drivers, set MUJOCO_GL=egl or osmesa, or write the scene as .xml instead.",
            ) from error
        return np.concatenate(views, axis=1)

    def _cameras(self, mujoco: Any) -> list[Any]:
        """The whole arm, and the touch as seen along the surface of the gel."""
        gel = self.pose("gel")
        cameras = []
        for target, distance, azimuth, elevation in (
            (gel[:3, 3] / 2 + [0, 0, 0.15], 1.5, 160.0, -20.0),
            (gel[:3, 3], 0.07, 150.0, -8.0),
        ):
            camera = mujoco.MjvCamera()
            camera.lookat[:], camera.distance = target, distance
            camera.azimuth, camera.elevation = azimuth, elevation
            cameras.append(camera)
        return cameras


def _document(parts: SceneParts) -> str:
    if parts.joints is not None and parts.flange_from_tcp is None:
        raise UsageError("joints without flange_from_tcp", "the tool between flange and tcp", "See fit_tool.")
    root = ElementTree.Element("mujoco", model="touch")
    ElementTree.SubElement(root, "compiler", angle="radian")
    ElementTree.SubElement(root, "statistic", extent="0.5", center="0 0 0.2")
    visual = ElementTree.SubElement(root, "visual")
    ElementTree.SubElement(visual, "global", offwidth=str(PICTURE[1]), offheight=str(PICTURE[0]))
    ElementTree.SubElement(visual, "map", znear="0.01")
    ElementTree.SubElement(visual, "headlight", ambient="0.4 0.4 0.4", diffuse="0.5 0.5 0.5")
    asset = ElementTree.SubElement(root, "asset")
    sky = {"type": "skybox", "builtin": "gradient", "rgb1": "0.93 0.95 0.97", "rgb2": "0.7 0.75 0.8"}
    ElementTree.SubElement(asset, "texture", {**sky, "width": "64", "height": "64"})
    for name, mesh in (("gel", parts.gel), ("indenter", parts.indenter)):
        ElementTree.SubElement(
            asset,
            "mesh",
            name=name,
            inertia="shell",
            vertex=_numbers(mesh.vertices),
            face=" ".join(map(str, np.asarray(mesh.faces).ravel())),
        )
    world = ElementTree.SubElement(root, "worldbody")
    _geom(world, "floor", "floor", type="plane", size="1 1 0.1", pos="0 0 -0.05")
    holder = world if parts.joints is None else _arm(world)
    tcp_at = parts.base_from_tcp if parts.flange_from_tcp is None or parts.joints is None else parts.flange_from_tcp
    tcp = _body(holder, "tcp", tcp_at)
    gel = _body(tcp, "gel", parts.tcp_from_gel)
    _geom(gel, "gel", "gel", type="mesh", mesh="gel")
    if parts.joints is not None:
        flange_from_gel = tcp_at @ parts.tcp_from_gel
        back = flange_from_gel @ [0, 0, float(parts.gel.bounds[0, 2]) - TOOL_RADIUS, 1]
        ends = _numbers([*np.zeros(3), *back[:3]])
        if np.linalg.norm(back[:3]) > 1e-3:
            _geom(holder, "tool", "tool", type="capsule", size=str(TOOL_RADIUS), fromto=ends)
    _geom(_body(world, "indenter", parts.base_from_indenter), "indenter", "indenter", type="mesh", mesh="indenter")
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _arm(world: ElementTree.Element) -> ElementTree.Element:
    """A UR5e of plain capsules; its last body is the flange."""
    body = world
    tail = np.eye(4)
    for joint, (a, d, alpha) in enumerate(UR5E_LINKS):
        body = _body(body, f"link{joint}", tail)
        ElementTree.SubElement(body, "joint", name=f"q{joint}", type="hinge", axis="0 0 1")
        ElementTree.SubElement(body, "inertial", pos="0 0 0", mass="1", diaginertia="0.01 0.01 0.01")
        for part, ends in (("rise", (0, 0, 0, 0, 0, d)), ("reach", (0, 0, d, a, 0, d))):
            if ends[:3] != ends[3:]:
                radius = str(ARM_RADIUS if joint < 3 else 0.8 * ARM_RADIUS)
                _geom(body, f"link{joint}-{part}", "arm", type="capsule", size=radius, fromto=_numbers(ends))
        tail = np.eye(4)
        tail[:3, :3] = [[1, 0, 0], [0, np.cos(alpha), -np.sin(alpha)], [0, np.sin(alpha), np.cos(alpha)]]
        tail[:3, 3] = (a, 0, d)
    return _body(body, "flange", tail)


def _body(parent: ElementTree.Element, name: str, pose: Array) -> ElementTree.Element:
    x, y, z, qx, qy, qz, qw = matrix_poses(pose)[0]
    return ElementTree.SubElement(parent, "body", name=name, pos=_numbers((x, y, z)), quat=_numbers((qw, qx, qy, qz)))


def _geom(parent: ElementTree.Element, name: str, colour: str, **attributes: str) -> None:
    fixed = {"name": name, "rgba": COLOURS[colour], "contype": "0", "conaffinity": "0"}
    ElementTree.SubElement(parent, "geom", {**attributes, **fixed})


def _numbers(values: Any) -> str:
    return " ".join(f"{value:.9g}" for value in np.asarray(values, dtype=float).ravel())
