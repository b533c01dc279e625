"""Engine ``mujoco-flex``: MuJoCo's soft body on the same pad, for comparison only."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.gel.contact.contact_path import interpolated_poses
from tactiledata.gel.contact.gap import height_above
from tactiledata.gel.contact.history import FrameStatus, GelHistory, GelTouch
from tactiledata.gel.contact.path import load_steps, pose_status
from tactiledata.gel.contact.recorder import FrameRecorder, Keep
from tactiledata.gel.contact.relief import IndenterRelief, indenter_relief
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.flex.model import FlexModel, require_convex, tetrahedra_of
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.gel.scene.mujoco_package import load_mujoco

MOVES = 2
"""Time steps for each load step."""
WINDOW = 10
"""Time steps over which a frame's forces are averaged: under flat faces contact points appear and vanish."""
BUDGET = 60
"""Most time steps in which a frame must come to rest."""
DRIFT = 0.002
"""Largest difference of the forces of the window's two halves, as a share of the force."""
SWING = 0.08
"""Largest deviation of a single step's force from the window's mean, as a share of the force."""


class FlexEngine:
    """Pad as a flex of MuJoCo 4: stable neo-Hookean four-node tetrahedra on the vertices of the pad's hexahedra.

    The engine exists for comparison. Four-node tetrahedra lock, so that forces are too high, the more so the coarser
    the mesh and the nearer Poisson's ratio is to one half (docs/gel.md has the figures). Only structured pads and
    convex indenters are accepted. Time steps with much damping stand for a solution at rest: a frame whose force still
    drifts after ``BUDGET`` steps is NOT_CONVERGED. MuJoCo's friction creeps a little where Coulomb's sticks.

    Parameters
    ----------
    mesh : PadMesh
        A pad of hexahedra.
    poisson_ratio : float
        Of the gel.

    Raises
    ------
    UsageError
        MuJoCo is not installed, or the pad is not made of hexahedra.
    """

    fidelity = "mujoco-flex"

    def __init__(self, mesh: PadMesh, poisson_ratio: float) -> None:
        load_mujoco("engine mujoco-flex")
        self.mesh = mesh
        self.poisson_ratio = GelMaterial(1.0, poisson_ratio, 0.0).poisson_ratio
        self.surface = contact_surface(mesh)
        self._cells = tetrahedra_of(mesh)

    def play(
        self, touches: Sequence[GelTouch], material: GelMaterial, keep: Keep = "all", width: int = 1
    ) -> Iterator[tuple[int, GelHistory]]:
        """Solve trajectories as ``FemEngine.play``, one after another.

        In the answer, ``residual`` is that of forces averaged over the last steps, ``iterations`` are time steps, and
        ``gaps`` are those of single nodes.

        Parameters
        ----------
        touches : sequence of GelTouch
            Poses and convex indenters.
        material : GelMaterial
            Young's modulus and friction; its Poisson's ratio must be the engine's.
        keep : "all", "surface" or "none"
            Nodes whose displacements are returned.
        width : int
            Ignored; ``FemEngine`` has it.

        Raises
        ------
        UsageError
            A material with another Poisson's ratio than the engine's; an indenter that is not convex.
        """
        if material.poisson_ratio != self.poisson_ratio:
            raise UsageError(
                f"a material with Poisson's ratio {material.poisson_ratio}",
                f"that of the engine, {self.poisson_ratio}",
                "Make an engine for it.",
            )
        for touch in touches:
            require_convex(touch.indenter)
        for number, touch in enumerate(touches):
            model = FlexModel(self.mesh, self._cells, touch.indenter, self.poisson_ratio, material.friction)
            recorder = FrameRecorder(len(touch.poses), self.mesh, self.surface, material.youngs_modulus, keep)
            _FlexTrajectory(self, model, indenter_relief(touch.indenter), recorder, material.youngs_modulus).go(
                touch.poses
            )
            yield number, recorder.history()


class _FlexTrajectory:
    """One trajectory: the indenter moves from frame to frame, and each frame waits until the pad is at rest."""

    def __init__(
        self, engine: FlexEngine, model: FlexModel, relief: IndenterRelief, recorder: FrameRecorder, modulus: float
    ) -> None:
        self._model, self._relief, self._recorder, self._modulus = model, relief, recorder, modulus
        self._surface, self._vertices = engine.surface, engine.mesh.vertices
        self._thickness = engine.mesh.thickness
        self._rest = self._vertices[self._surface.nodes]
        self._pose = np.full((4, 4), np.nan)
        self._is_touching = False

    def go(self, poses: Array) -> None:
        """Solve and record all frames, at poses (n, 4, 4), gel_from_indenter."""
        for frame, pose in enumerate(poses):
            status = pose_status(pose, self._rest, self._relief, self._thickness)
            if status != FrameStatus.SOLVED:
                self._recorder.give_up(frame, status)
            elif height_above(self._rest, self._relief, pose).min() >= 0:
                self._release(frame, pose)
            else:
                self._press(frame, pose)

    def _release(self, frame: int, pose: Array) -> None:
        """Record a frame without contact, and set the pad to rest."""
        self._model.reset()
        self._pose, self._is_touching = pose, False
        self._write(frame, np.zeros_like(self._vertices), np.zeros_like(self._vertices), 0.0)
        self._recorder.put_rest(frame)

    def _press(self, frame: int, pose: Array) -> None:
        """Move the indenter to a frame's pose (4, 4) and record the frame once the pad is at rest."""
        _, steps = load_steps(self._pose, pose, self._rest, self._relief, self._is_touching)
        current = self._pose if self._is_touching else steps[0]
        count = 0
        for step in steps:
            for waypoint in interpolated_poses(current, step, MOVES):
                self._model.step(current, waypoint)
                current = waypoint
                count += 1
        self._recorder.iterations[frame] = count
        self._pose, self._is_touching = pose, True
        # a state with numbers that are not finite would spoil the next frame, too
        if not self._settle(frame, pose):
            self._recorder.give_up(frame, FrameStatus.NOT_CONVERGED)
        if not self._model.is_sound:
            self._model.reset()
            self._is_touching = False

    def _settle(self, frame: int, pose: Array) -> bool:
        """Step in time until the force is steady, and record the frame; return whether it became steady."""
        contact: list[Array] = []
        elastic: list[Array] = []
        for _ in range(BUDGET):
            self._model.step(pose, pose)
            self._recorder.iterations[frame] += 1
            contact.append(self._model.contact_forces())
            elastic.append(self._model.elastic_forces())
            if not self._model.is_sound:
                return False
            window = np.array(contact[-WINDOW:])
            if len(window) < WINDOW or not _is_steady(window.sum(axis=1)):
                continue
            forces = window.mean(axis=0)
            unbalanced = np.linalg.norm(forces + np.mean(elastic[-WINDOW:], axis=0), axis=1).max()
            largest = np.linalg.norm(forces, axis=1).max()
            self._write(frame, self._model.displacement(), forces, unbalanced / largest if largest > 0 else 0.0)
            return True
        return False

    def _write(self, frame: int, displacement: Array, forces: Array, residual: float) -> None:
        """Record a frame from displacements (v, 3), m, and node forces (v, 3), m^2, over Young's modulus."""
        recorder, surface = self._recorder, self._surface
        places = self._vertices + displacement
        recorder.wrench[frame] = -self._modulus * np.concatenate(
            [forces.sum(axis=0), np.cross(places, forces).sum(axis=0)]
        )
        on_surface = forces[surface.nodes]
        recorder.node_forces[frame] = self._modulus * on_surface
        nodes = surface.nodes[surface.corners]
        recorder.gaps[frame] = np.maximum(height_above(places[nodes], self._relief, self._pose), 0.0)
        recorder.pressed[frame] = forces[nodes].any(axis=1)
        recorder.status[frame] = FrameStatus.SOLVED if on_surface.any() else FrameStatus.NO_CONTACT
        recorder.residual[frame] = residual
        recorder.put_displacement(frame, displacement)


def _is_steady(forces: Array) -> bool:
    """Whether contact forces (n, 3) of successive time steps neither drift nor oscillate."""
    mean = np.linalg.norm(forces.mean(axis=0))
    half = len(forces) // 2
    drift = np.linalg.norm(forces[half:].mean(axis=0) - forces[:half].mean(axis=0))
    swing = np.linalg.norm(forces - forces.mean(axis=0), axis=1).max()
    return bool(drift <= DRIFT * mean and swing <= SWING * mean)
