"""Solutions of a bank of contacts: what each depends on, and their files."""

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
from tactiledata.rig.contact.contact import TouchSetup
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.scenario.scenario import Gel, Material


@dataclass(frozen=True)
class Solution:
    """A touch at `CONTACT_RATE`: wrench (n, 6) over the modulus, m² and m³, whether all slides, steps not solved."""

    wrench: RealArray
    slipping: NDArray[np.bool_]
    unsettled: int


def key_of(pitch: float, gel: Gel, setup: TouchSetup, material: Material, path: Path, offset: float) -> str:
    """Of everything that a solution hangs on: the solver's programs too."""
    whole = hashlib.sha256()
    told = [pitch, gel.outline, setup.thickness, material.poisson_ratio, material.friction, offset]
    if setup.cap.curvature:
        told += [setup.cap.curvature, setup.touch.position]
    whole.update(json.dumps([*told, setup.indenter.document, _solver_digest()], sort_keys=True).encode())
    for part in (setup.rotation, path.times, path.positions):
        whole.update(np.ascontiguousarray(part, dtype=float).tobytes())
    return whole.hexdigest()


@cache
def _solver_digest() -> str:
    """Of the programs that a solution depends on."""
    whole = hashlib.sha256()
    layer = sorted(resources.files("tactiledata.rig.layer").iterdir(), key=lambda entry: entry.name)
    contact = resources.files("tactiledata.rig.contact")
    for source in [*layer, contact / "by_layer.py", contact / "closed_form.py", contact / "layer_picture.py"]:
        if source.name.endswith(".py"):
            whole.update(source.name.encode() + source.read_bytes())
    return whole.hexdigest()


def load_solution(file: FilePath, count: int) -> Solution | None:
    """Of so many moments; ``None`` where the file is missing, broken or another's."""
    try:
        with np.load(io.BytesIO(file.read_bytes()), allow_pickle=False) as kept:
            found = Solution(kept["wrench"].astype(float), kept["slipping"], int(kept["unsettled"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return found if found.wrench.shape == (count, 6) else None


def keep_solution(file: FilePath, solution: Solution) -> None:
    """Whole or not at all."""
    content = io.BytesIO()
    np.savez_compressed(
        content, wrench=solution.wrench.astype(np.float32), slipping=solution.slipping, unsettled=solution.unsettled
    )
    write_atomic(file, content.getvalue())
