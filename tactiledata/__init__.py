"""tactiledata: recordings of a robot pressing a vision-based tactile sensor, as a training-ready dataset.

Recordings come in by `formats` and `ingest`, lie in a `store`, and go out by `splits` and `loaders`, or in formats of
others by `export`. `gel`, `effects` and `optics` simulate a touch; `calibrate` and `replay` fit and play recordings;
`diagnose` names the physics that the simulation lacks. `view` shows single touches; `rig` makes recordings with known
truth, and `prove` puts the diagnosis to the proof with them; `cli` is the command line, and `__main__` runs it as
`python -m tactiledata`. docs/architecture.md has a map.

These parts share `sensors` and `indenters` (which instruments, which solids), `nuisance` (differences that are no
physics), `metrics` and `scoring` (how far apart pictures are), `report` (pages) and `compute` (where tasks run). At the
bottom lie `contract` (what parts hand to each other), `units`, `transforms`, `registry` (tables of names), `arrays`
(types) and `errors`.

The names below are enough for most work from Python (docs/python.md). Importing this package imports neither torch nor
mujoco: what stands behind a name is imported when the name is first used.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as checkers of types know it; the module of that name would take time in which Ctrl-C is loud
if TYPE_CHECKING:
    from tactiledata.calibrate.calibrate import calibrate as calibrate_store
    from tactiledata.diagnose.naming.identifiability import identifiability
    from tactiledata.diagnose.store import diagnose_store
    from tactiledata.diagnose.table import diagnose_table
    from tactiledata.ingest.pipeline import ingest as ingest_recordings
    from tactiledata.loaders.numpy import TactileArrays
    from tactiledata.loaders.torch import TactileDataset
    from tactiledata.replay.attach import replay as replay_store
    from tactiledata.splits.audit import audit
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store

__version__ = "0.1.0"

__all__ = [
    "Store",
    "TactileArrays",
    "TactileDataset",
    "audit",
    "calibrate_store",
    "diagnose_store",
    "diagnose_table",
    "identifiability",
    "ingest_recordings",
    "make_split",
    "replay_store",
]

# ingest, calibrate and replay are packages, so that these functions have longer names here
_PLACES = {
    "Store": "tactiledata.store.read.reader:Store",
    "TactileArrays": "tactiledata.loaders.numpy:TactileArrays",
    "TactileDataset": "tactiledata.loaders.torch:TactileDataset",
    "audit": "tactiledata.splits.audit:audit",
    "calibrate_store": "tactiledata.calibrate.calibrate:calibrate",
    "diagnose_store": "tactiledata.diagnose.store:diagnose_store",
    "diagnose_table": "tactiledata.diagnose.table:diagnose_table",
    "identifiability": "tactiledata.diagnose.naming.identifiability:identifiability",
    "ingest_recordings": "tactiledata.ingest.pipeline:ingest",
    "make_split": "tactiledata.splits.make:make_split",
    "replay_store": "tactiledata.replay.attach:replay",
}


def __getattr__(name: str) -> object:
    place = _PLACES.get(name)
    if place is None:
        raise AttributeError(f"module 'tactiledata' has no attribute {name!r}")
    from tactiledata.registry import Registry

    return Registry("name", {name: place})[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
