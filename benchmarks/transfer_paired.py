"""Transfers against paired truth: the rig makes the same touches on several units, so that each has its right answer.

    python benchmarks/transfer_paired.py [--touches 12] [--model CHECKPOINT] [--style] [--seed 5]
        [--frames 3] [--backgrounds digit-bg-1,digit-bg-16] [--json docs/results/transfer-paired.json]

Every touch goes from every unit to every other one. Scores look at the whole frame and at where the true picture shows
the touch; geometry is the overlap of that region with where the transferred picture differs from the target's
background, and from what the method makes of no touch. Intervals draw touches. A second table has medians over frames
with the 10 % and 90 % quantiles, and how much of the recorded touch is kept; its last row is the true picture itself.
Further tables say by how much methods differ from the swap and from the ratio on the same frames.

The units' optics follow from the seed and their names. With `--backgrounds` the units are others, named U1, U2, ….
"""

from __future__ import annotations

import argparse
import itertools
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from split_models.tables.paired_truth import kept_values, paired_values
from split_models.transfer.methods import LATENT, transfer_method
from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.ingest.pipeline import ingest
from tactiledata.metrics import METRICS
from tactiledata.metrics.bootstrap import Interval, bootstrap
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.store.read.reader import Store

QUANTILES = ("ssim_contact", "l1_contact", "strength_kept", "change_correlation", "mask_overlap")
TRUTH = "true picture"
RIVALS = ("background_swap", "background_ratio")
COMPARED = ("ssim_contact", "l1_contact", "ssim", "l1")
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
    parser.add_argument("--seed", type=int, default=WORLD["seed"])
    parser.add_argument("--frames", type=int, help="largest number of frames of each touch [default: all]")
    parser.add_argument("--backgrounds", help="comma-separated: another unit for each")
    parser.add_argument("--json", type=Path, help="file that takes the tables as a document")
    given = parser.parse_args()
    if given.backgrounds:
        UNITS.clear()
        UNITS.update({f"U{n}": name for n, name in enumerate(given.backgrounds.split(","), start=1)})
        WORLD["sensors"] = {unit: {"background": background} for unit, background in UNITS.items()}
    WORLD["seed"] = given.seed
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
            if given.frames:
                chosen = np.unique(np.linspace(0, len(images) - 1, given.frames).astype(int))
                images, truth = images[chosen], truth[chosen]
            for score, values in kept_values(truth, goal, images, base).items():
                found.setdefault((TRUTH, score), []).append(values)
            for name in (AS_IT_IS, *methods):
                pictures, untouched = (
                    some if name == AS_IT_IS else methods[name].transfer(some, base, goal)
                    for some in (images, base[None])
                )
                for score, values in paired_values(pictures, truth, goal, untouched[0], style).items():
                    found.setdefault((name, score), []).append(values)
                if name != AS_IT_IS:
                    for score, values in kept_values(pictures, goal, images, base).items():
                        found.setdefault((name, score), []).append(values)
            touches += [touch] * len(images)
    joined = {key: np.concatenate(parts) for key, parts in found.items()}
    names = list(dict.fromkeys(score for name, score in found if name == AS_IT_IS))
    print(f"{given.touches} touches on {len(UNITS)} units, {len(touches)} transferred frames")
    print(f"| method | {' | '.join(names)} |\n|---|{'---|' * len(names)}")
    for name in [AS_IT_IS, *methods]:
        cells = [str(bootstrap(joined[name, score], touches)) for score in names]
        print(f"| {name} | {' | '.join(cells)} |")
    print(f"\n| method, median [10 %, 90 %] | {' | '.join(QUANTILES)} |\n|---|{'---|' * len(QUANTILES)}")
    for name in [AS_IT_IS, *methods, TRUTH]:
        print(f"| {name} | {' | '.join(spread(found.get((name, score), [])) for score in QUANTILES)} |")
    rows = [
        {"method": name, "score": score, "less": "", **interval(bootstrap(joined[name, score], touches))}
        for name in [AS_IT_IS, *methods]
        for score in names
    ]
    for rival in RIVALS:
        print(f"\n| method, less {rival} | {' | '.join(COMPARED)} |\n|---|{'---|' * len(COMPARED)}")
        for name in methods:
            if name == rival:
                continue
            cells = []
            for score in COMPARED:
                less = bootstrap(joined[name, score] - joined[rival, score], touches)
                rows.append({"method": name, "score": score, "less": rival, **interval(less)})
                cells.append(f"{less.value:+.4g} [{less.low:+.4g}, {less.high:+.4g}]")
            print(f"| {name} | {' | '.join(cells)} |")
    if given.json:
        facts = {"seed": given.seed, "units": UNITS, "touches": given.touches, "frames": len(touches)}
        write_json_atomic(given.json, {"format": "tactiledata-figures/1", **facts, "rows": rows})


def interval(found: Interval) -> dict[str, float | None]:
    """A bootstrap's value and ends; None for what is no number."""
    ends = {"value": found.value, "low": found.low, "high": found.high}
    return {name: float(value) if np.isfinite(value) else None for name, value in ends.items()}


def spread(values: list[np.ndarray]) -> str:
    """Median of all values with the 10 % and 90 % quantiles; empty where there are none."""
    if not values:
        return ""
    low, middle, high = np.nanquantile(np.concatenate(values), (0.1, 0.5, 0.9))
    return f"{middle:.3g} [{low:.3g}, {high:.3g}]"


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
