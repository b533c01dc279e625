"""Solutions of a bank of contacts: the key of everything that a solution depends on, and its file."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.program import statements
from tactiledata.rig.contact.contact import TouchSetup
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.scenario.scenario import Gel, Material


@dataclass(frozen=True)
class Solution:
    """The solved contact of one touch at `CONTACT_RATE`, for a modulus of 1.

    Parameters
    ----------
    wrench : (n, 6), m² and m³
        Wrench on the indenter over Young's modulus, gel frame.
    slipping : (n,) bool
        Whether all that touches slides.
    unsettled : int
        Number of the solver's steps that did not converge.
    """

    wrench: RealArray
    slipping: NDArray[np.bool_]
    unsettled: int


def key_of(pitch: float, gel: Gel, setup: TouchSetup, material: Material, path: Path, offset: float) -> str:
    """Return the SHA-256 digest of everything that a solution depends on, the solver's source files included.

    Parameters
    ----------
    pitch : metres
        Spacing of the layer's grid.
    gel : Gel
        Its outline counts; the thickness is that of ``setup``.
    setup : TouchSetup
        Thickness, indenter, rotation and, on a dome, curvature and place.
    material : Material
        Poisson's ratio and friction count; forces are proportional to the modulus.
    path : Path
        Where the indenter moves.
    offset : metres
        Depth offset, positive is deeper.
    """
    whole = hashlib.sha256()
    numbers = [pitch, gel.outline, setup.thickness, material.poisson_ratio, material.friction, offset]
    if setup.cap.curvature:
        numbers += [setup.cap.curvature, setup.touch.position]
    whole.update(json.dumps([*numbers, setup.indenter.document, _solver_digest()], sort_keys=True).encode())
    for part in (setup.rotation, path.times, path.positions):
        whole.update(np.ascontiguousarray(part, dtype=float).tobytes())
    return whole.hexdigest()


@cache
def _solver_digest() -> str:
    """Return the digest of the program that a solution depends on: a changed solver gives new solutions."""
    whole = hashlib.sha256()
    layer = sorted(resources.files("tactiledata.rig.layer").iterdir(), key=lambda entry: entry.name)
    contact = resources.files("tactiledata.rig.contact")
    for source in [*layer, contact / "by_layer.py", contact / "closed_form.py", contact / "layer_picture.py"]:
        if source.name.endswith(".py"):
            whole.update(source.name.encode() + statements(source.read_text("utf-8")))
    return whole.hexdigest()


def load_solution(file: FilePath, count: int) -> Solution | None:
    """Return the solution in a file, of ``count`` moments; ``None`` where the file is missing, broken or foreign."""
    try:
        with np.load(io.BytesIO(file.read_bytes()), allow_pickle=False) as kept:
            solution = Solution(kept["wrench"].astype(float), kept["slipping"], int(kept["unsettled"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return solution if solution.wrench.shape == (count, 6) else None


def keep_solution(file: FilePath, solution: Solution) -> None:
    """Write a solution to a file, whole or not at all; the wrench is kept in single precision."""
    content = io.BytesIO()
    np.savez_compressed(
        content, wrench=solution.wrench.astype(np.float32), slipping=solution.slipping, unsettled=solution.unsettled
    )
    write_atomic(file, content.getvalue())
