"""Touches by finite elements, solved once and kept on disk, for many recordings of the same touches."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.program import statements
from tactiledata.prove.element_world.bodies import body_of
from tactiledata.prove.element_world.pad import Array
from tactiledata.prove.element_world.touch import GelPad, Solved, Travel, solve_touch
from tactiledata.rig.contact.contact import CONTACT_RATE, DEEPEST, TouchSetup, contact_times
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.scenario.scenario import Gel

APART = 1e-4
"""Distance, m, between depth offsets at which touches are solved."""
UNUSED = 1e-12
"""Weight in the interpolation between offsets below which a solution is not needed."""


@dataclass(frozen=True)
class ElementContact:
    """The contact of one touch by finite elements: a `RigContact` without a surface."""

    path: Path
    deviation: Array | None
    wrench: Array
    slipping: NDArray[np.bool_]
    unsettled: int

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Refuse to give a surface, since forces only are kept."""
        raise NotImplementedError(f"the gel's surface at {seconds:g} s: this generator keeps forces only")


@dataclass(frozen=True)
class ElementBank:
    """Solved touches in a folder; one that the folder lacks is solved and kept.

    Exact: Young's modulus, to which forces are proportional. Interpolated: the depth offset, by a spline through
    solutions 0.1 mm apart, at each moment as if the whole path had that moment's offset. A constant offset along the
    gel moves the contact without regard to the pad's sides; one that changes is solved as it is, and so is another
    thickness.

    Parameters
    ----------
    folder : Path
        Where solutions are kept.
    finer : float
        Factor on the fineness of grid and steps.
    """

    folder: FilePath
    finer: float = 1.0
    _known: dict[str, Solved] = field(default_factory=dict)

    @property
    def kept(self) -> dict[str, Solved]:
        """The solutions that were asked for so far, by their digests."""
        return self._known

    def contact(
        self, gel: Gel, setup: TouchSetup, path: Path | None = None, deviation: Array | None = None
    ) -> ElementContact:
        """Return the contact of a touch; a `SolveContact` for `tactiledata.rig.play.RigSetup`.

        Parameters
        ----------
        gel : Gel
            The gel as the scenario states it; its outline counts.
        setup : TouchSetup
            The touch as it really is, hidden effects included.
        path : Path, optional
            The path where it is planned already; else it is planned as deep as is ever allowed.
        deviation : (n, 3), m, optional
            See `RigContact.deviation`.

        Raises
        ------
        ValueError
            The gel is domed.
        """
        if setup.cap.curvature:
            raise ValueError("a domed gel: this generator knows flat ones only")
        path = path or setup.plan(lambda _: DEEPEST * setup.thickness)
        count = len(contact_times(path))
        moved = np.zeros((count, 3)) if deviation is None else deviation
        if np.ptp(moved[:, :2], axis=0).any():
            one = self.solution(gel, setup, path, moved + setup.offset)
            wrench, aside = one.wrench, np.zeros(3)
        else:
            deeper = moved[:, 2] + setup.offset[2]
            nodes = offset_nodes(deeper)
            weights = np.asarray(CubicSpline(nodes, np.eye(len(nodes)))(deeper / APART))
            # at an offset that is a node itself, no other one is solved
            used = np.abs(weights).max(axis=0) > UNUSED
            nodes, weights = nodes[used], weights[:, used]
            solved = [self.solution(gel, setup, path, np.array([[0.0, 0.0, APART * node]])) for node in nodes]
            wrench = np.einsum("nk,knc->nc", weights, np.stack([one.wrench for one in solved]))
            one = solved[int(np.argmin(np.abs(nodes - deeper.mean() / APART)))]
            wrench[(path.at(contact_times(path))[:, 2] + deeper <= 0) | (wrench[:, 2] <= 0)] = 0.0
            aside = np.append(moved[0, :2] + setup.offset[:2], 0.0)
        wrench = wrench * setup.material.youngs_modulus
        wrench[:, 3:] += np.cross(aside, wrench[:, :3])
        return ElementContact(path, deviation, wrench, one.slipping, one.unsettled)

    def solution(self, gel: Gel, setup: TouchSetup, path: Path, moved: Array) -> Solved:
        """Return a solution, m² and m³, from memory, from the folder, or solved and kept.

        Parameters
        ----------
        gel : Gel
            Its outline counts.
        setup : TouchSetup
            Indenter, orientation, thickness, Poisson's ratio and friction count.
        path : Path
            The commanded path.
        moved : (n, 3) or (1, 3), m
            What is added to it: x, y, depth.
        """
        key = self._key(gel, setup, path, moved)
        if key not in self._known:
            file = self.folder / key[:2] / f"{key}.npz"
            found = _loaded(file, len(contact_times(path)))
            if found is None:
                found = _solved(gel, setup, path, moved, self.finer)
                _keep(file, found)
            self._known[key] = found
        return self._known[key]

    def _key(self, gel: Gel, setup: TouchSetup, path: Path, moved: Array) -> str:
        """Return the SHA-256 digest of everything that a solution depends on, this generator's program included."""
        whole = hashlib.sha256()
        material = setup.material
        numbers = [gel.outline, setup.thickness, material.poisson_ratio, material.friction, self.finer]
        numbers += [setup.footprint.lowest, setup.indenter.document, _program()]
        whole.update(json.dumps(numbers, sort_keys=True).encode())
        for part in (setup.rotation, path.times, path.positions, moved):
            whole.update(np.ascontiguousarray(part, dtype=float).tobytes())
        return whole.hexdigest()


def offset_nodes(deeper: Array) -> Array:
    """Return the offsets, in multiples of `APART`, between whose solutions depth offsets (n,), m, lie; at least three.

    Examples
    --------
    >>> offset_nodes(np.array([0.3e-4, 2.1e-4])).tolist()
    [-1, 0, 1, 2]
    """
    low = min(-1, int(np.ceil(deeper.min() / APART - 0.5)))
    high = max(1, int(np.floor(deeper.max() / APART + 0.5)))
    return np.arange(low, high + 1)


def _solved(gel: Gel, setup: TouchSetup, path: Path, moved: Array, finer: float) -> Solved:
    """Return a solution in m² and m³."""
    material = setup.material
    pad = GelPad(
        (1e3 * gel.outline[0], 1e3 * gel.outline[1]), 1e3 * setup.thickness, material.poisson_ratio, material.friction
    )
    positions = 1e3 * (path.at(contact_times(path)) + moved)
    corners = np.minimum(np.rint(path.times * CONTACT_RATE).astype(np.intp), len(positions) - 1)
    body = body_of(setup.indenter.shape, setup.indenter.sizes)
    travel = Travel(body, setup.rotation, 1e3 * setup.footprint.lowest, positions, corners)
    found = solve_touch(pad, travel, finer)
    return Solved(found.wrench * ([1e-6] * 3 + [1e-9] * 3), found.slipping, found.unsettled, found.steps)


@cache
def _program() -> str:
    """Return the digest of this generator's statements: a changed generator gives new solutions."""
    whole = hashlib.sha256()
    for source in sorted(FilePath(__file__).parent.glob("*.py")):
        if source.name != FilePath(__file__).name:
            whole.update(source.name.encode() + statements(source.read_text("utf-8")))
    return whole.hexdigest()


def _loaded(file: FilePath, count: int) -> Solved | None:
    """Return the solution in a file, of ``count`` moments; ``None`` where the file is missing or broken."""
    try:
        with np.load(io.BytesIO(file.read_bytes()), allow_pickle=False) as kept:
            found = Solved(kept["wrench"].astype(float), kept["slipping"], int(kept["unsettled"]), int(kept["steps"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return found if found.wrench.shape == (count, 6) else None


def _keep(file: FilePath, solved: Solved) -> None:
    """Write a solution to a file, whole or not at all; the wrench in single precision."""
    content = io.BytesIO()
    np.savez_compressed(
        content,
        wrench=solved.wrench.astype(np.float32),
        slipping=solved.slipping,
        unsettled=solved.unsettled,
        steps=solved.steps,
    )
    write_atomic(file, content.getvalue())
