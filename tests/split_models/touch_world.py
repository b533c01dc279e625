"""A store to learn from: a world of few touches, recorded, ingested, replayed on a coarse pad, and split."""

from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.ingest.pipeline import ingest
from tactiledata.replay.attach import replay
from tactiledata.replay.options import ReplayOptions
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import find_scenario
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store

PLAN = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))
UNSEEN = "D20003"
FEWEST = {"train": 4, "val": 1, "test": 2}
"""Trajectories that each part must have."""


def coarse_pad(sensor, geometry):
    """143 nodes on the surface."""
    return structured_pad(f"{sensor}-coarse", geometry, PLAN)


def coarse_replay(**changes):
    """Linear, of the surface's nodes."""
    settings = {
        "material": GelMaterial(0.88e6, 0.45, 0.8),
        "fidelity": "linear",
        "keep": "surface",
        "name": "coarse",
        "make_pad": coarse_pad,
    }
    return ReplayOptions(**{**settings, **changes})


def scenario():
    document = dict(find_scenario("tiny"))
    document["sensors"] = {**document["sensors"], UNSEEN: {"background": "digit-bg-14", "shore_00": 75}}
    document["generate"] = {**document["generate"], "count": 12}
    return load_scenario(document)


def make_store(folder):
    place = folder / "ds.zarr"
    ingest(record(scenario(), folder / "recordings", "mcap"), place)
    replay(place, coarse_replay())
    filled_split(place)
    return place


def filled_split(place):
    """A split with touches in every part: of so few, chance, which goes by the last bits of recordings, leaves some
    parts empty on one processor and others on another.
    """
    for seed in range(200):
        report = make_split(
            Store.open(place),
            by="trajectory,sensor",
            hold_out={"sensor": [UNSEEN]},
            fractions=(0.5, 0.25, 0.25),
            force=(0.3, 13.0),
            seed=seed,
            replace=True,
        )
        if all(report.counts[part].trajectories >= least for part, least in FEWEST.items()):
            return
    raise AssertionError("no seed of 200 fills every part")


TINY_MODELS = {
    "image_vae": {
        "blocks": [1, 1, 1], "down": [2, 5], "channels": [8, 8, 16], "latent": 12, "anneal": 1,
        "background_copies": 2, "training": {"epochs": 2, "batch_size": 16, "patience": 0},
    },
    "mesh_vae": {"filters": [4, 4, 4, 8], "order": 3, "latent": 6, "training": {"epochs": 2, "batch_size": 16}},
    "projection": {"layers": [16, 16], "dropout": [0.2], "training": {"epochs": 2, "batch_size": 32}},
    "cycle": {"training": {"epochs": 2, "batch_size": 32}},
    "end_to_end": {"training": {"epochs": 1, "batch_size": 16}},
    "force_head": {"layers": [16, 16], "dropout": [0.2], "training": {"epochs": 2, "batch_size": 32}},
    "raw_forces": {"training": {"epochs": 1, "batch_size": 16}},
}  # fmt: skip
"""Of which nothing is expected but that they run."""


def tiny_recipe(store, table, **rows):
    """A recipe at 40 x 30."""
    return {
        "format": "tactiledata-recipe/1",
        "title": f"tiny {table}",
        "table": table,
        "data": {"store": str(store), "image_size": [40, 30]},
        "models": TINY_MODELS,
        "rows": {"rounds": 50, "frames": 6, "cycles": 3, "head_seeds": 2, "raw_seeds": 1, **rows},
    }
