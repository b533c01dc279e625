"""MuJoCo scene of one moment of a touch, with arm, sensor and indenter: distances, pictures, MJCF document."""

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
"""Radius of the drawn links, m."""
TOOL_RADIUS = 0.012
"""Radius of the drawn tool, m."""
FARTHEST = 1.0
"""Largest distance that is measured, m."""
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
    """Shapes and poses of all that the scene shows; poses are (4, 4), metres.

    Parameters
    ----------
    base_from_tcp, tcp_from_gel : (4, 4)
        Places of the tool's centre point and of the gel.
    gel : trimesh.Trimesh
        The pad in the gel frame, m.
    indenter : trimesh.Trimesh
        The indenter in its own frame, m.
    base_from_indenter : (4, 4)
        Place of the indenter.
    joints : (6,) rad, optional
        Joint angles; without them the arm is not drawn.
    flange_from_tcp : (4, 4), optional
        The tool; required with ``joints``.
    """

    base_from_tcp: Array
    tcp_from_gel: Array
    gel: trimesh.Trimesh
    indenter: trimesh.Trimesh
    base_from_indenter: Array
    joints: Array | None = None
    flange_from_tcp: Array | None = None


class GelScene:
    """Scene compiled by MuJoCo when a pose, a distance or a picture is asked for.

    Distances are those of the convex hulls of pad and indenter, as everywhere in MuJoCo; pictures show true shapes.
    """

    def __init__(self, parts: SceneParts) -> None:
        self.parts = parts

    @cached_property
    def mjcf(self) -> str:
        """The scene as one MJCF document that contains its meshes."""
        return _document(self.parts)

    @cached_property
    def _compiled(self) -> tuple[Any, Any]:
        """MuJoCo's model and data, with the bodies placed."""
        mujoco = load_mujoco("the scene")
        model = mujoco.MjModel.from_xml_string(self.mjcf)
        data = mujoco.MjData(model)
        if self.parts.joints is not None:
            data.qpos[:6] = self.parts.joints
        mujoco.mj_forward(model, data)
        return model, data

    def pose(self, body: str) -> Array:
        """Pose (4, 4), m, of a body (``gel``, ``indenter``, ``tcp``) in the base frame, as computed by MuJoCo."""
        _, data = self._compiled
        placement = data.body(body)
        pose = np.eye(4)
        pose[:3, :3] = placement.xmat.reshape(3, 3)
        pose[:3, 3] = placement.xpos
        return pose

    def distance(self) -> tuple[float, Array]:
        """Least distance of gel and indenter, m, negative where they overlap, and its end points (2, 3), base frame."""
        model, data = self._compiled
        ends = np.zeros(6)
        mujoco = load_mujoco("the scene")
        least_distance = mujoco.mj_geomDistance(
            model, data, model.geom("gel").id, model.geom("indenter").id, FARTHEST, ends
        )
        return float(least_distance), ends.reshape(2, 3)

    def picture(self) -> NDArray[np.uint8]:
        """Draw an RGB picture (rows, 2 columns, 3) with the whole arm on the left and a close-up on the right.

        Raises
        ------
        TactileDataError
            OpenGL is not available.
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
        """Return two cameras: one of the whole arm, one close to the touch along the gel's surface."""
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
    """Return the MJCF document of the scene; refuse joints without a tool."""
    if parts.joints is not None and parts.flange_from_tcp is None:
        raise UsageError("joints without flange_from_tcp", "the tool between flange and tcp", "See fit_tool.")
    root = ElementTree.Element("mujoco", model="touch")
    ElementTree.SubElement(root, "compiler", angle="radian")
    ElementTree.SubElement(root, "statistic", extent="0.5", center="0 0 0.2")
    visual = ElementTree.SubElement(root, "visual")
    ElementTree.SubElement(visual, "global", offwidth=str(PICTURE[1]), offheight=str(PICTURE[0]))
    ElementTree.SubElement(visual, "map", znear="0.01")
    ElementTree.SubElement(visual, "headlight", ambient="0.4 0.4 0.4", diffuse="0.5 0.5 0.5")
    # sky and meshes
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
    # floor, arm (where joints are known), tcp and gel
    world = ElementTree.SubElement(root, "worldbody")
    _geom(world, "floor", "floor", type="plane", size="1 1 0.1", pos="0 0 -0.05")
    holder = world if parts.joints is None else _arm(world)
    tcp_at = parts.base_from_tcp if parts.flange_from_tcp is None or parts.joints is None else parts.flange_from_tcp
    tcp = _body(holder, "tcp", tcp_at)
    gel = _body(tcp, "gel", parts.tcp_from_gel)
    _geom(gel, "gel", "gel", type="mesh", mesh="gel")
    # a straight tool from the flange to the back of the gel
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
    """Add a UR5e of plain capsules to the world; return its last body, the flange."""
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
    """Add a body at a pose (4, 4) relative to its parent."""
    x, y, z, qx, qy, qz, qw = matrix_poses(pose)[0]
    return ElementTree.SubElement(parent, "body", name=name, pos=_numbers((x, y, z)), quat=_numbers((qw, qx, qy, qz)))


def _geom(parent: ElementTree.Element, name: str, colour: str, **attributes: str) -> None:
    """Add a shape without collisions, in a colour of ``COLOURS``."""
    fixed = {"name": name, "rgba": COLOURS[colour], "contype": "0", "conaffinity": "0"}
    ElementTree.SubElement(parent, "geom", {**attributes, **fixed})


def _numbers(values: Any) -> str:
    """Text of numbers for an attribute of the document."""
    return " ".join(f"{value:.9g}" for value in np.asarray(values, dtype=float).ravel())
