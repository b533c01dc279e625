"""Contacts of the layer solver, solved once at a few offsets and kept: a third form of the rig's contact, for many
recordings of the same touches.

Exact: Young's modulus, which multiplies everything; nu, friction, path, indenter and angle, each of which has solutions
of its own. Interpolated: the depth offset, constant or changing, by a cubic through the nearest four solutions, as if
the whole path had had each moment's; thickness and radius, linearly between solutions. Approximated: a constant offset
along the gel moves the contact without regard to the pad's sides; one that changes adds what springs and sliders, as
stiff and as spread as the solution's own pull asks for, say that it changes. No pictures.
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
from tactiledata.rig.bank.own_springs import OwnSprings, own_springs
from tactiledata.rig.bank.solution import Solution, keep_solution, key_of, load_solution
from tactiledata.rig.contact.by_layer import touch_layer
from tactiledata.rig.contact.closed_form import contact_law
from tactiledata.rig.contact.contact import DEEPEST, TouchSetup, contact_times
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.hidden.coulomb_limit import beyond_coulomb
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.solver import Layer
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.scenario.scenario import Gel, Material

MODULUS = 1e6
"""Pa, with which is solved."""
OFFSETS = (-2e-4, -1e-4, 0.0, 1e-4, 2e-4)
"""m, deeper."""
THICKNESSES = (0.8, 0.9, 1.0)
RADII = (1.0, 1.05)
"""Of what is stated, ascending; what lies between is interpolated."""
BEYOND = 0.5
"""Of a spacing, by which a value may lie outside."""


@dataclass(frozen=True)
class BankedContact:
    """See `RigContact`; it has no surface."""

    path: Path
    deviation: RealArray | None
    wrench: RealArray
    slipping: NDArray[np.bool_]
    unsettled: int

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Of none.

        Raises
        ------
        UsageError
            Always.
        """
        raise UsageError("a picture of a contact from a bank", "forces only", "Record with contact: layer.")


@dataclass
class ContactBank:
    """Solutions in a folder; what it lacks is solved and kept.

    Parameters
    ----------
    folder : Path
    pitch : m, of the layer's grid
    indenters : name -> Indenter
        As stated: effects may make them larger.
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
        """The contact of a touch, as `tactiledata.rig.play.RigSetup` asks for it.

        Raises
        ------
        UsageError
            An offset, a thickness or a radius beyond what is solved for; a force beyond the touch's limit.
        """
        path = path or setup.plan(lambda _: DEEPEST * setup.thickness)
        times = contact_times(path)
        deeper = np.full(len(times), float(setup.offset[2])) + (0.0 if deviation is None else deviation[:, 2])
        # a dome is as thick as it is at the touch, in every recording
        near = setup.thickness if setup.cap.curvature else gel.thickness
        stated = replace(setup, thickness=near, indenter=self.indenters[setup.touch.indenter])
        plain, nearest = self._at(gel, stated, path, deeper)
        wrench = plain
        thicker = setup.thickness / near
        for share, value in _between(thicker, THICKNESSES, "a thickness"):
            other = self._at(gel, replace(stated, thickness=value * near), path, deeper)[0]
            wrench = wrench + share * (other - plain)
        radius = setup.indenter.sizes.get("radius", 1.0) / stated.indenter.sizes.get("radius", 1.0)
        for share, value in _between(radius, RADII, "a radius"):
            wrench = wrench + share * (self._at(gel, _larger(stated, value), path, deeper)[0] - plain)
        wrench = wrench * setup.material.youngs_modulus
        wrench[(path.at(times)[:, 2] + deeper <= 0) | (wrench[:, 2] <= 0)] = 0.0
        if (peak := float(wrench[:, 2].max())) > setup.normal_limit:
            raise UsageError(
                f"{peak:.1f} N in touch {setup.touch.name}",
                f"at most {setup.normal_limit:.1f} N",
                "Press less deep: a path of the bank does not depend on forces.",
            )
        springs = OwnSprings()
        if deviation is not None and deviation[:, :2].any():
            springs = self._own_springs(gel, stated, path, float(deeper.mean()))
        wrench = _placed(setup, path, deviation, wrench, springs)
        return BankedContact(path, deviation, wrench, nearest.slipping, nearest.unsettled)

    def _at(self, gel: Gel, setup: TouchSetup, path: Path, deeper: RealArray) -> tuple[RealArray, Solution]:
        """Wrench (n, 6) over the modulus at offsets (n,), and the solution nearest to their mean."""
        weights = _cubic_weights(deeper, OFFSETS)
        used = weights.any(axis=0)
        wrench = np.zeros((len(deeper), 6))
        for place in np.flatnonzero(used):
            wrench += weights[:, place, None] * self._solution(gel, setup, path, OFFSETS[place]).wrench
        nearest = min(np.flatnonzero(used), key=lambda place: abs(OFFSETS[place] - float(deeper.mean())))
        return wrench, self._solution(gel, setup, path, OFFSETS[nearest])

    def _own_springs(self, gel: Gel, setup: TouchSetup, path: Path, deeper: float) -> OwnSprings:
        """Of the solution nearest to an offset."""
        offset = min(OFFSETS, key=lambda one: abs(one - deeper))
        material = replace(setup.material, youngs_modulus=MODULUS)
        key = key_of(self.pitch, gel, setup, material, path, offset)
        if key not in self._springs:
            wrench = MODULUS * self._solution(gel, setup, path, offset).wrench
            positions = path.at(contact_times(path)) + np.array([0.0, 0.0, offset])
            law = contact_law(setup.indenter, setup.footprint, setup.thickness, material)
            stiffness = law.columns_at(positions[:, 2])[1]
            self._springs[key] = own_springs(positions, wrench[:, 2], stiffness, material.friction, -wrench[:, :2])
        return self._springs[key]

    def _solution(self, gel: Gel, setup: TouchSetup, path: Path, offset: float) -> Solution:
        material = replace(setup.material, youngs_modulus=MODULUS)
        key = key_of(self.pitch, gel, setup, material, path, offset)
        if key not in self._known:
            file = self.folder / key[:2] / f"{key}.npz"
            found = load_solution(file, len(contact_times(path)))
            if found is None:
                found = self._solved(gel, setup, material, path, offset)
                keep_solution(file, found)
            self._known[key] = found
        return self._known[key]

    def _solved(self, gel: Gel, setup: TouchSetup, material: Material, path: Path, offset: float) -> Solution:
        real = replace(gel, thickness=setup.thickness)
        if (real, material) not in self._layers:
            grid = LayerGrid.of(gel.outline, self.pitch)
            self._layers[real, material] = Layer(grid, setup.thickness, material)
        footprint = make_footprint(setup.indenter, setup.rotation, setup.touch.position, GelGrid.of(gel))
        there = replace(setup, material=material, footprint=footprint, offset=np.array([0.0, 0.0, offset]))
        found = touch_layer(there, self._layers[real, material], path)
        return Solution(found.wrench / MODULUS, found.slipping, found.unsettled)


def _larger(setup: TouchSetup, factor: float) -> TouchSetup:
    indenter: Any = setup.indenter
    return replace(setup, indenter=replace(indenter, radius=factor * indenter.sizes["radius"]))


def _between(value: float, nodes: Sequence[float], what: str) -> list[tuple[float, float]]:
    """Shares of nodes other than 1 that a value is made of, linearly; none where it is 1."""
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
    """Weights (n, k) of ascending nodes in the cubic through the four about each value (n,)."""
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
    """The wrench where the indenter really is along the gel."""
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
            springs.pull(positions[:, :2] + move, normal, stiffness, friction) for move in (deviation[:, :2], 0.0)
        )
        pull = changed - plain - wrench[:, :2]
        size, limit = np.linalg.norm(pull, axis=1), friction * normal
        over = size > limit
        pull[over] *= (limit[over] / size[over])[:, None]
        gained = np.concatenate([-pull - wrench[:, :2], np.zeros((len(pull), 1))], axis=1)
        centre[:, :2] += positions[:, :2]
        out[:, :3] += gained
        out[:, 3:] += np.cross(centre, gained)
        beside[:, :2] += deviation[:, :2]
    out[:, 3:] += np.cross(beside, out[:, :3])
    return out
