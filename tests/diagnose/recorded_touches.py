"""A small recorded store: two balls, two units, free air, shear and dwells."""

from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario

POWERED = 90.0


def scenario(**changes):
    return {
        "format": "tactiledata-scenario/1",
        "seed": 3,
        "sensors": {"D20542": {"background": "digit-bg-0"}, "D20571": {"background": "digit-bg-2"}},
        "indenters": {
            "ball3": {"shape": "sphere", "radius": 0.003},
            "ball5": {"shape": "sphere", "radius": 0.005},
        },
        "material": {"youngs_modulus": 0.9e6, "poisson_ratio": 0.475, "friction": 0.7},
        "streams": {"joints": 125, "tcp": 125, "wrench": 100, "arm_wrench": 0},
        "images": {"frames_per_step": 2, "free_air_frames": 2},
        "recordings": {"group": "sensor", "tare": "log", "powered": POWERED},
        "generate": {
            "count": 10,
            "depth": [0.0004, 0.0007],
            "shear": [0.0004, 0.0008],
            "shear_share": 0.8,
            "dwell": [0.5, 1.0],
        },
        **changes,
    }


def recorded_store(folder, **changes):
    """Path of the store."""
    logs = record(load_scenario(scenario(**changes)), folder / "logs", "folder")
    ingest(logs, folder / "world.zarr")
    return folder / "world.zarr"
