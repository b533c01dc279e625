"""Engine ``fem``: a quasi-static finite-element pad, at finite strain or linear."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.gel.contact.contact_path import ContactPath, ContactState
from tactiledata.gel.contact.gap import APART
from tactiledata.gel.contact.history import GelHistory, GelTouch
from tactiledata.gel.contact.recorder import FrameRecorder, Keep
from tactiledata.gel.contact.relief import IndenterRelief, indenter_relief
from tactiledata.gel.contact.trajectory_solve import TrajectorySolve
from tactiledata.gel.elasticity.compliance import FactorisedPad, patch_compliance, surface_response
from tactiledata.gel.elasticity.internal_forces import NEO_HOOKEAN, ElasticPad
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.engines.finite_strain import TOLERANCE, FiniteStrainSolver
from tactiledata.gel.engines.linear import LinearSolver
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.indenters.base import Indenter

Fidelity = Literal["finite-strain", "linear"]

WIDTH = 16
"""Trajectories solved in lockstep, which read the factor from memory once for all; more gain little."""


class FemEngine:
    """Pad of one mesh and one Poisson's ratio: assembled, factorised and condensed once for many trajectories.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of c cells.
    poisson_ratio : float
        Of the gel.
    fidelity : "finite-strain" or "linear"
        ``linear`` is a preview: at 1 mm depth its forces are 5 to 15 % low (docs/results.md).
    tolerance : m
        At finite strain, a load step is solved when no node moves further than this in an iteration.
    stiffening : Stiffening
        Yeoh's terms of the law; none by default.
    modulus : (c,), optional
        Factor on Young's modulus of each cell, for example for a skin or a soft spot.

    Raises
    ------
    UsageError
        An unknown fidelity, a Poisson's ratio out of range, or factors that are not positive.
    """

    def __init__(
        self,
        mesh: PadMesh,
        poisson_ratio: float,
        fidelity: Fidelity = "finite-strain",
        tolerance: float = TOLERANCE,
        stiffening: Stiffening = NEO_HOOKEAN,
        modulus: Array | None = None,
    ) -> None:
        if fidelity not in ("finite-strain", "linear"):
            raise UsageError(f"fidelity {fidelity!r}", "finite-strain or linear", "Name one of them.")
        self.mesh = mesh
        self.fidelity = fidelity
        self._tolerance = tolerance
        self.poisson_ratio = GelMaterial(1.0, poisson_ratio, 0.0).poisson_ratio
        self._stiffening = stiffening
        quadrature = cell_quadrature(mesh)
        if modulus is not None:
            quadrature = quadrature.stiffened(modulus)
        self.surface = contact_surface(mesh)
        self._pad = FactorisedPad(mesh, quadrature, poisson_ratio)
        self._elastic = ElasticPad.of(mesh, quadrature)
        self._response = surface_response(self._pad, self.surface)
        self._compliance = patch_compliance(self._response, self.surface)
        self._reliefs: dict[str, IndenterRelief] = {}

    def play(
        self, touches: Sequence[GelTouch], material: GelMaterial, keep: Keep = "all", width: int = WIDTH
    ) -> Iterator[tuple[int, GelHistory]]:
        """Solve trajectories, and yield the number and the answer of each when it is done.

        Parameters
        ----------
        touches : sequence of GelTouch
            Poses and indenters.
        material : GelMaterial
            Young's modulus and friction; its Poisson's ratio must be the engine's.
        keep : "all", "surface" or "none"
            Nodes whose displacements are returned.
        width : int
            Trajectories solved in lockstep at finite strain.

        Raises
        ------
        UsageError
            A material with another Poisson's ratio than the engine's.
        """
        if material.poisson_ratio != self.poisson_ratio:
            raise UsageError(
                f"a material with Poisson's ratio {material.poisson_ratio}",
                f"that of the engine, {self.poisson_ratio}",
                "Make an engine for it.",
            )
        trajectories = (self._prepare(number, touch, material, keep) for number, touch in enumerate(touches))
        if self.fidelity == "linear":
            yield from LinearSolver(self._pad, self.surface, self._response).run(trajectories)
        else:
            solver = FiniteStrainSolver(self._pad, self._elastic, self.surface, self._tolerance, self._stiffening)
            yield from solver.run(trajectories, width)

    def _prepare(self, number: int, touch: GelTouch, material: GelMaterial, keep: Keep) -> TrajectorySolve:
        """Prepare the solution of one trajectory, from the pad at rest."""
        nodes = self.surface.nodes
        is_linear = self.fidelity == "linear"
        patches = len(self.surface.corners)
        unknown_pose = np.full((4, 4), np.nan)
        moving_nodes = len(nodes) if is_linear else len(self.mesh.vertices)
        state = ContactState(unknown_pose, np.zeros((patches, 3)), np.zeros((moving_nodes, 3)), np.full(patches, APART))
        path = ContactPath(
            self.surface,
            self._compliance,
            self.mesh.vertices[nodes],
            np.arange(len(nodes)) if is_linear else nodes,
            self._relief(touch.indenter),
            material.friction,
            state,
        )
        recorder = FrameRecorder(len(touch.poses), self.mesh, self.surface, material.youngs_modulus, keep)
        return TrajectorySolve(number, touch, path, recorder, self.mesh.thickness)

    def _relief(self, indenter: Indenter) -> IndenterRelief:
        """Return the height map of an indenter, computed once for each shape."""
        key = json.dumps(indenter.document, sort_keys=True)
        if key not in self._reliefs:
            self._reliefs[key] = indenter_relief(indenter)
        return self._reliefs[key]
