"""tactiledata: recordings of a robot pressing a vision-based tactile sensor, as a training-ready dataset.

Importing this package imports neither torch nor mujoco; each part is imported where it is used.
"""

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    # imported when it is asked for: it brings the effects and scipy with it
    if name == "identifiability":
        from tactiledata.diagnose.naming.identifiability import identifiability

        return identifiability
    raise AttributeError(f"module 'tactiledata' has no attribute {name!r}")
