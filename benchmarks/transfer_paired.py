"""Transfers against paired truth: the rig makes the same touches on several units, so that each has its right answer.

    python benchmarks/transfer_paired.py [--touches 12] [--model CHECKPOINT] [--style]

Every touch goes from every unit to every other one. Scores look at the whole frame and at where the true picture shows
the touch; geometry is the overlap of that region with where the transferred picture differs from the target's
background, and from what the method makes of no touch. Intervals draw touches.
"""

from __future__ import annotations

import argparse
import itertools
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from split_models.tables.paired_truth import paired_values
from split_models.transfer.methods import LATENT, transfer_method
from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.ingest.pipeline import ingest
from tactiledata.metrics import METRICS
from tactiledata.metrics.bootstrap import bootstrap
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.store.read.reader import Store

UNITS = {"D1": "digit-bg-0", "D2": "digit-bg-4", "D3": "digit-bg-6", "D4": "digit-bg-9"}
WORLD = {
    "format": "tactiledata-scenario/1",
    "seed": 5,
    "sensors": {unit: {"background": background} for unit, background in UNITS.items()},
    "indenters": {name: {"shape": name} for name in ("sphere", "edge", "ring", "cross", "cone", "hexagon")},
    "streams": {"joints": 125, "tcp": 125, "wrench": 100},
    "recordings": {"group": "sensor"},
    "generate": {"paired": True, "depth": [0.0005, 0.0009], "shear": [0.0003, 0.0006], "shear_share": 0.5},
}
FORCE = (1.0, 13.0)
AS_IT_IS = "not transferred"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--touches", type=int, default=12)
    parser.add_argument("--model", type=Path, help="an image VAE: adds the methods that need one")
    parser.add_argument("--style", action="store_true", help="the style distance as well: slow on two cores")
    given = parser.parse_args()
    methods = {name: PIXEL_TRANSFERS[name] for name in PIXEL_TRANSFERS}
    methods |= {name: transfer_method(name, given.model) for name in LATENT if given.model}
    style = METRICS["gram_style"].scores["gram_style_random"] if given.style else None
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    touches: list[str] = []
    with tempfile.TemporaryDirectory() as scratch:
        store = recorded(Path(scratch), given.touches)
        for touch, source, target in pairs(store):
            images, base = frames(store, touch, source), store.reference(source).image
            if not len(images):
                continue
            truth, goal = frames(store, touch, target), store.reference(target).image
            for name in (AS_IT_IS, *methods):
                pictures, untouched = (
                    some if name == AS_IT_IS else methods[name].transfer(some, base, goal)
                    for some in (images, base[None])
                )
                for score, values in paired_values(pictures, truth, goal, untouched[0], style).items():
                    found.setdefault((name, score), []).append(values)
            touches += [touch] * len(images)
    names = list(dict.fromkeys(score for _, score in found))
    print(f"{given.touches} touches on {len(UNITS)} units, {len(touches)} transferred frames")
    print(f"| method | {' | '.join(names)} |\n|---|{'---|' * len(names)}")
    for name in [AS_IT_IS, *methods]:
        cells = [str(bootstrap(np.concatenate(found[name, score]), touches)) for score in names]
        print(f"| {name} | {' | '.join(cells)} |")


def recorded(home: Path, count: int) -> Store:
    """A store of the same touches on every unit."""
    world = {**WORLD, "generate": {**WORLD["generate"], "count": count}}
    ingest(record(load_scenario(world), home / "recorded", "folder"), home / "ds.zarr")
    return Store.open(home / "ds.zarr")


def pairs(store: Store) -> Iterator[tuple[str, str, str]]:
    """Every touch with every ordered pair of units."""
    touches = sorted({json.loads(text)["touch"] for text in store.trajectories(["extra"])["extra"].to_pylist()})
    for touch, pair in itertools.product(touches, itertools.permutations(UNITS, 2)):
        if len(rows_of(store, touch, pair[0])) == len(rows_of(store, touch, pair[1])):
            yield touch, *pair


def rows_of(store: Store, touch: str, unit: str) -> np.ndarray:
    """Frames of a touch on a unit, in order."""
    table = store.trajectories(["trajectory", "frame_start", "frame_stop"]).to_pandas().set_index("trajectory")
    start, stop = table.loc[f"{touch}-{unit}", ["frame_start", "frame_stop"]]
    return np.arange(start, stop)


def frames(store: Store, touch: str, unit: str) -> np.ndarray:
    """Pictures (n, H, W, 3) of a touch on a unit, those that the first unit felt with 1 to 13 N."""
    force = store.frames(["contact_force"])["contact_force"].to_numpy()
    felt = force[rows_of(store, touch, next(iter(UNITS)))]
    rows = rows_of(store, touch, unit)[(felt >= FORCE[0]) & (felt <= FORCE[1])]
    return np.asarray(store.images(rows)) if len(rows) else np.zeros((0, *store.reference(unit).image.shape), np.uint8)


if __name__ == "__main__":
    main()
