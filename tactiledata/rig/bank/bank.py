"""A bank of contacts: the layer solver's contact at a few offsets, kept on disk, for many recordings of one touch.

Exact: Young's modulus, since every force is proportional to it, and Poisson's ratio, friction, path, indenter and
angle, since each value has solutions of its own. Interpolated: the depth offset, by a cubic through the nearest four
solutions, at each moment as if the whole path had that moment's offset; thickness and radius, linearly. Approximated: a
constant offset along the gel moves the contact without regard to the pad's sides; for an offset that changes, springs
and sliders that are fitted to the solution's pull give the change of the pull. A banked contact has no pictures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.errors import UsageError
from tactiledata.indenters.base import Indenter
from tactiledata.rig.bank.solution import Solution, keep_solution, key_of, load_solution
from tactiledata.rig.contact.by_layer import touch_layer
from tactiledata.rig.contact.closed_form import contact_law
from tactiledata.rig.contact.contact import DEEPEST, TouchSetup, contact_times
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.hidden.coulomb_limit import beyond_coulomb, within
from tactiledata.rig.hidden.own_springs import OwnSprings, Pulled, own_springs
from tactiledata.rig.hidden.slider import Loaded
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.solver import Layer
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.scenario.scenario import Gel, Material

MODULUS = 1e6
"""Young's modulus, Pa, with which solutions are computed."""
OFFSETS = (-2e-4, -1e-4, 0.0, 1e-4, 2e-4)
"""Depth offsets, m, positive is deeper, at which contacts are solved."""
THICKNESSES = (0.8, 0.9, 1.0)
"""Thicknesses, relative to the stated one, at which contacts are solved; between them forces are interpolated."""
RADII = (1.0, 1.05)
"""Radii, relative to the stated one, at which contacts are solved."""
BEYOND = 0.5
"""Distance, in spacings of the solved values, up to which a value outside them is extrapolated."""


@dataclass(frozen=True)
class BankedContact:
    """The contact of one touch from a bank: a `RigContact` without a surface."""

    path: Path
    deviation: RealArray | None
    wrench: RealArray
    slipping: NDArray[np.bool_]
    unsettled: int

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Refuse to give a surface, since a bank keeps forces only.

        Raises
        ------
        UsageError
            Always.
        """
        raise UsageError("a picture of a contact from a bank", "forces only", "Record with contact: layer.")


@dataclass(frozen=True)
class ContactBank:
    """Solutions of contacts in a folder; a solution that the folder lacks is computed and kept.

    Parameters
    ----------
    folder : Path
        Where solutions are kept.
    pitch : metres
        Spacing of the layer's grid.
    indenters : dict, name -> Indenter
        The indenters as the scenario states them; hidden effects may make them larger.
    """

    folder: FilePath
    pitch: float
    indenters: Mapping[str, Indenter]
    _known: dict[str, Solution] = field(default_factory=dict)
    _springs: dict[str, OwnSprings] = field(default_factory=dict)
    _layers: dict[tuple[Gel, Material], Layer] = field(default_factory=dict)

    def contact(
        self, gel: Gel, setup: TouchSetup, path: Path | None = None, deviation: RealArray | None = None
    ) -> BankedContact:
        """Return the contact of a touch; a `SolveContact` for `tactiledata.rig.play.RigSetup`.

        Parameters
        ----------
        gel : Gel
            The gel as the scenario states it.
        setup : TouchSetup
            The touch as it really is, hidden effects included.
        path : Path, optional
            The path where it is planned already; else it is planned as deep as is ever allowed.
        deviation : (n, 3), m, optional
            See `RigContact.deviation`.

        Raises
        ------
        UsageError
            An offset, a thickness or a radius is beyond what is solved for, or a force is beyond the touch's limit.
        """
        path = path or setup.plan(lambda _: DEEPEST * setup.thickness)
        times = contact_times(path)
        deeper = np.full(len(times), float(setup.offset[2])) + (0.0 if deviation is None else deviation[:, 2])
        # the depth offset: interpolated on the stated gel; a dome is as thick as it is at the touch
        near = setup.thickness if setup.cap.curvature else gel.thickness
        stated = replace(setup, thickness=near, indenter=self.indenters[setup.touch.indenter])
        plain, nearest = self._at(gel, stated, path, deeper)
        wrench = plain
        # thickness and radius: the change from the stated value, linear between solutions
        thicker = setup.thickness / near
        for share, value in _between(thicker, THICKNESSES, "a thickness"):
            other = self._at(gel, replace(stated, thickness=value * near), path, deeper)[0]
            wrench = wrench + share * (other - plain)
        radius = setup.indenter.sizes.get("radius", 1.0) / stated.indenter.sizes.get("radius", 1.0)
        for share, value in _between(radius, RADII, "a radius"):
            wrench = wrench + share * (self._at(gel, _larger(stated, value), path, deeper)[0] - plain)
        # forces of the real material, which must neither pull nor exceed the limit of the touch
        wrench = wrench * setup.material.youngs_modulus
        wrench[(path.at(times)[:, 2] + deeper <= 0) | (wrench[:, 2] <= 0)] = 0.0
        if (peak := float(wrench[:, 2].max())) > setup.normal_limit:
            raise UsageError(
                f"{peak:.1f} N in touch {setup.touch.name}",
                f"at most {setup.normal_limit:.1f} N",
                "Press less deep: a path of the bank does not depend on forces.",
            )
        # a deviation along the gel changes the pull
        springs = OwnSprings()
        if deviation is not None and deviation[:, :2].any():
            springs = self._own_springs(gel, stated, path, float(deeper.mean()))
        wrench = _placed(setup, path, deviation, wrench, springs)
        return BankedContact(path, deviation, wrench, nearest.slipping, nearest.unsettled)

    def _at(self, gel: Gel, setup: TouchSetup, path: Path, deeper: RealArray) -> tuple[RealArray, Solution]:
        """Return the wrench over the modulus (n, 6) at depth offsets (n,), m, and the solution nearest their mean."""
        weights = _cubic_weights(deeper, OFFSETS)
        used = weights.any(axis=0)
        wrench = np.zeros((len(deeper), 6))
        for place in np.flatnonzero(used):
            wrench += weights[:, place, None] * self._solution(gel, setup, path, OFFSETS[place]).wrench
        nearest = min(np.flatnonzero(used), key=lambda place: abs(OFFSETS[place] - float(deeper.mean())))
        return wrench, self._solution(gel, setup, path, OFFSETS[nearest])

    def _own_springs(self, gel: Gel, setup: TouchSetup, path: Path, deeper: float) -> OwnSprings:
        """Return the springs that pull as the solution nearest to a depth offset, m, does."""
        offset = min(OFFSETS, key=lambda node: abs(node - deeper))
        material = replace(setup.material, youngs_modulus=MODULUS)
        key = key_of(self.pitch, gel, setup, material, path, offset)
        if key not in self._springs:
            wrench = MODULUS * self._solution(gel, setup, path, offset).wrench
            positions = path.at(contact_times(path)) + np.array([0.0, 0.0, offset])
            law = contact_law(setup.indenter, setup.footprint, setup.thickness, material)
            stiffness = law.columns_at(positions[:, 2])[1]
            pulled = Pulled(material.friction, wrench[:, 2], -wrench[:, :2])
            self._springs[key] = own_springs(positions, stiffness, [pulled])
        return self._springs[key]

    def _solution(self, gel: Gel, setup: TouchSetup, path: Path, offset: float) -> Solution:
        """Return the solution at a depth offset, m: from memory, from the folder, or computed and kept."""
        material = replace(setup.material, youngs_modulus=MODULUS)
        key = key_of(self.pitch, gel, setup, material, path, offset)
        if key not in self._known:
            file = self.folder / key[:2] / f"{key}.npz"
            solution = load_solution(file, len(contact_times(path)))
            if solution is None:
                solution = self._solved(gel, setup, material, path, offset)
                keep_solution(file, solution)
            self._known[key] = solution
        return self._known[key]

    def _solved(self, gel: Gel, setup: TouchSetup, material: Material, path: Path, offset: float) -> Solution:
        """Return a solution by the layer solver, at one depth offset, m, and no offset along the gel."""
        real = replace(gel, thickness=setup.thickness)
        if (real, material) not in self._layers:
            grid = LayerGrid.of(gel.outline, self.pitch)
            self._layers[real, material] = Layer(grid, setup.thickness, material)
        footprint = make_footprint(setup.indenter, setup.rotation, setup.touch.position, GelGrid.of(gel))
        there = replace(setup, material=material, footprint=footprint, offset=np.array([0.0, 0.0, offset]))
        contact = touch_layer(there, self._layers[real, material], path)
        return Solution(contact.wrench / MODULUS, contact.slipping, contact.unsettled)


def _larger(setup: TouchSetup, factor: float) -> TouchSetup:
    """Return the touch with an indenter whose radius is multiplied by a factor."""
    indenter: Any = setup.indenter
    return replace(setup, indenter=replace(indenter, radius=factor * indenter.sizes["radius"]))


def _between(value: float, nodes: Sequence[float], what: str) -> list[tuple[float, float]]:
    """Return (weight, node) pairs of the linear interpolation at a value, without the node 1; none where it is 1.

    Refuses a value that lies too far outside the nodes; ``what`` names it in the message.
    """
    if abs(value - 1.0) < 1e-9:
        return []
    place = int(np.clip(np.searchsorted(nodes, value) - 1, 0, len(nodes) - 2))
    low, high = nodes[place], nodes[place + 1]
    room = (high - low) * (2.0 if len(nodes) == 2 else BEYOND)
    if not nodes[0] - room <= value <= nodes[-1] + room:
        raise UsageError(
            f"{what} of {value:.3f} times what is stated", f"{nodes[0]:g} to {nodes[-1]:g}", "Ask for less."
        )
    share = (value - low) / (high - low)
    return [(part, node) for part, node in ((1.0 - share, low), (share, high)) if node != 1.0 and part != 0.0]


def _cubic_weights(values: RealArray, nodes: Sequence[float]) -> RealArray:
    """Return the weights (n, k) of ascending nodes (k,) in the cubic through the four about each value (n,)."""
    at = np.asarray(nodes)
    room = BEYOND * float(at[1] - at[0])
    if values.min() < at[0] - room or values.max() > at[-1] + room:
        worst = max(values.min(), values.max(), key=abs)
        raise UsageError(
            f"an offset of {1e6 * worst:.0f} µm", f"{1e6 * at[0]:g} to {1e6 * at[-1]:g} µm", "Ask for less."
        )
    first = np.clip(np.searchsorted(at, values) - 2, 0, len(at) - 4)
    weights = np.zeros((len(values), len(at)))
    rows = np.arange(len(values))
    for own in range(4):
        product = np.ones(len(values))
        for other in range(4):
            if other != own:
                product *= (values - at[first + other]) / (at[first + own] - at[first + other])
        weights[rows, first + own] = product
    return weights


def _placed(
    setup: TouchSetup, path: Path, deviation: RealArray | None, wrench: RealArray, springs: OwnSprings
) -> RealArray:
    """Return the wrench (n, 6) at the indenter's real place along the gel, from that (n, 6) at the commanded one."""
    beside = np.zeros((len(wrench), 3))
    beside[:, :2] = setup.offset[:2]
    out = wrench.copy()
    if deviation is not None and deviation[:, :2].any():
        positions = path.at(contact_times(path))
        law = contact_law(setup.indenter, setup.footprint, setup.thickness, setup.material)
        stiffness, centre = law.columns_at(positions[:, 2] + setup.offset[2] + deviation[:, 2])[1:]
        friction = setup.material.friction
        normal = wrench[:, 2] * beyond_coulomb(wrench[:, :2], friction * wrench[:, 2])
        changed, plain = (
            springs.pull(positions[:, :2] + move, Loaded(normal, stiffness), friction)
            for move in (deviation[:, :2], 0.0)
        )
        pull = within(changed - plain - wrench[:, :2], friction * normal)
        gained = np.concatenate([-pull - wrench[:, :2], np.zeros((len(pull), 1))], axis=1)
        centre[:, :2] += positions[:, :2]
        out[:, :3] += gained
        out[:, 3:] += np.cross(centre, gained)
        beside[:, :2] += deviation[:, :2]
    out[:, 3:] += np.cross(beside, out[:, :3])
    return out
