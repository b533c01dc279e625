"""A coarse pad, quick to solve, and replays of the tiny store on it."""

import hashlib

from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.replay.options import ReplayOptions

PLAN = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))
MATERIAL = GelMaterial(0.88e6, 0.45, 0.8)


def coarse_pad(sensor, geometry):
    """143 surface nodes."""
    return structured_pad(f"{sensor}-coarse", geometry, PLAN)


def options(**changes):
    """A linear replay on the coarse pad, called ``coarse``."""
    return ReplayOptions(
        **{"material": MATERIAL, "fidelity": "linear", "name": "coarse", "make_pad": coarse_pad, **changes}
    )


def files(folder):
    """Digest of every file of a store but its locks."""
    return {
        str(place.relative_to(folder)): hashlib.sha256(place.read_bytes()).hexdigest()
        for place in sorted(folder.rglob("*"))
        if place.is_file() and not place.name.endswith(".lock")
    }
