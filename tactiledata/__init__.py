"""tactiledata: recordings of a robot pressing a vision-based tactile sensor, as a training-ready dataset.

Recordings come in by `formats` and `ingest`, lie in a `store`, and go out by `splits` and `loaders`. `gel`, `effects`
and `optics` simulate a touch; `calibrate` and `replay` fit and play recordings; `diagnose` names the physics that the
simulation lacks. `rig` makes recordings with known truth, and `prove` puts the diagnosis to the proof with
them; `cli` is the command line. docs/architecture.md has a map.

These parts share `sensors` and `indenters` (which instruments, which solids), `nuisance` (differences that are no
physics), `metrics` and `scoring` (how far apart pictures are), `report` (pages) and `compute` (where tasks run). At the
bottom lie `contract` (what parts hand to each other), `units`, `transforms`, `registry` (tables of names), `arrays`
(types) and `errors`.

Importing this package imports neither torch nor mujoco; each part is imported where it is used.
"""

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    # imported on first use, since identifiability brings the effects and scipy with it
    if name == "identifiability":
        from tactiledata.diagnose.naming.identifiability import identifiability

        return identifiability
    raise AttributeError(f"module 'tactiledata' has no attribute {name!r}")
