"""What transferred pictures still tell: place, depth and force, read by networks of the target and of the source.

    python benchmarks/transfer_downstream.py [--touches 200] [--frames 3] [--seed 303]
        [--backgrounds digit-bg-1,digit-bg-16] [--json docs/results/transfer-downstream.json]

The rig makes the same touches on two units, which neither the bundled model nor the rule of `relit` has seen. A quarter
of the touches is tested on. Two uses of a transfer are tried, each from either unit to the other:

- *reads*: a network that learned on the target's own pictures reads transferred ones of touches that it never saw.
- *teaches*: a network that learned on transferred pictures reads the target's own, of touches that it never saw.

The row "target's own" has no transfer in it. A network that is given the change against the sensor's picture without
contact, instead of the picture, reads without a transfer what others read after a swap of the backgrounds: the changes
are equal, but for the ends of the grey levels. Values are mean absolute errors, with the share of the range of the
touches, and R²; intervals and the paired differences against the swap draw touches.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from split_models.tables.touch_head import READINGS, explained, learned_head, small_pictures
from split_models.transfer.methods import BUNDLED_MODEL, LATENT, transfer_method
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.provenance import provenance
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.ingest.pipeline import ingest
from tactiledata.metrics.bootstrap import Interval, bootstrap
from tactiledata.replay.plan import plan_replay
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.store.read.reader import Store

METHODS = (
    "no_contact", "background_swap", "background_ratio", "histogram_matching", "relit", "latent_relit",
    "latent_on_background", "latent",
)  # fmt: skip
AS_IT_IS, OWN, SWAP = "not transferred", "target's own", "background_swap"
USES = ("reads", "teaches")
SHAPES = ("sphere", "hexagon", "edge")
FORCE = (1.0, 13.0)
TESTED = 0.25
COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))

Rows = list[dict[str, Any]]
Answer = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Values that a network read (n, 6), true ones, and the touch of each (n,)."""


@dataclass(frozen=True)
class Unit:
    """Frames of one unit: pictures (n, H, W, 3), values (n, 6) as in `READINGS`, touches (n,), and no contact."""

    pictures: np.ndarray
    values: np.ndarray
    touches: np.ndarray
    background: np.ndarray


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--touches", type=int, default=200)
    parser.add_argument("--frames", type=int, default=3, help="largest number of frames of each touch")
    parser.add_argument("--seed", type=int, default=303)
    parser.add_argument("--backgrounds", default="digit-bg-1,digit-bg-16", help="two: a unit for each")
    parser.add_argument("--model", type=Path, default=BUNDLED_MODEL, help="an image VAE [default: the bundled one]")
    parser.add_argument("--json", type=Path, help="file that takes the table as a document")
    given = parser.parse_args()
    methods = {name: transfer_method(name, given.model if name in LATENT else None) for name in METHODS}
    backgrounds = {f"U{number}": name for number, name in enumerate(given.backgrounds.split(","), start=1)}
    with tempfile.TemporaryDirectory() as scratch:
        store = recorded(Path(scratch), backgrounds, given.touches, given.seed)
        units = {name: unit_of(store, name, given.frames) for name in backgrounds}
    errors = errors_of(units, methods, given.seed)
    rows = rows_of(errors)
    first = next(iter(units.values()))
    tested = len(tested_touches(first.touches, given.seed))
    counts = {
        "touches": len(set(first.touches)),
        "tested": tested,
        "frames": sum(len(u.values) for u in units.values()),
    }
    print(f"{counts['touches']} touches on {len(units)} units, {counts['frames']} frames; {tested} touches tested on")
    for use in USES:
        print(f"\n{use}\n")
        print(table([row for row in rows if row["use"] == use]))
    if given.json:
        facts = {"seed": given.seed, "backgrounds": backgrounds, **counts, "provenance": provenance("benchmark", {})}
        write_json_atomic(given.json, {"format": "tactiledata-figures/1", **facts, "rows": rows})


def recorded(home: Path, backgrounds: dict[str, str], count: int, seed: int) -> Store:
    """A store of the same touches on every unit."""
    world = {
        "format": "tactiledata-scenario/1",
        "seed": seed,
        "sensors": {unit: {"background": background} for unit, background in backgrounds.items()},
        "indenters": {name: {"shape": name} for name in SHAPES},
        "streams": {"joints": 125, "tcp": 125, "wrench": 100},
        "recordings": {"group": "sensor"},
        "generate": {
            "paired": True, "count": count, "depth": [0.0005, 0.0009], "shear": [0.0003, 0.0006], "shear_share": 0.5,
        },
    }  # fmt: skip
    ingest(record(load_scenario(world), home / "recorded", "folder"), home / "ds.zarr")
    return Store.open(home / "ds.zarr")


def unit_of(store: Store, unit: str, most: int) -> Unit:
    """Frames of 1 to 13 N of a unit, at most ``most`` of each touch, with what they show."""
    force = np.asarray(store.frames(["contact_force"])["contact_force"])
    rows, values, touches = [], [], []
    for planned in plan_replay(store, lambda sensor, geometry: structured_pad(sensor, geometry, COARSE)).touches:
        if planned.sensor != unit:
            continue
        numbers = np.arange(*planned.frames)
        felt = np.flatnonzero((force[numbers] >= FORCE[0]) & (force[numbers] <= FORCE[1]))
        if not len(felt):
            continue
        felt = felt[np.unique(np.linspace(0, len(felt) - 1, most).astype(int))]
        tip = planned.gel_touch(store, 0.0).poses[felt, :3, 3] * 1e3
        tip[:, 2] *= -1.0  # depth grows into the gel
        wrench = store.aligned("contact_wrench", numbers[felt])[0][:, :3]
        rows.append(numbers[felt])
        values.append(np.hstack([tip, wrench]))
        touches += [planned.name.removesuffix(f"-{unit}")] * len(felt)
    pictures = np.asarray(store.images(np.concatenate(rows)))
    return Unit(pictures, np.concatenate(values), np.array(touches, object), store.reference(unit).image)


def tested_touches(touches: np.ndarray, seed: int) -> set[str]:
    """A quarter of the touches, drawn."""
    names = sorted(set(touches))
    return set(np.random.default_rng(seed).permutation(names)[: max(int(TESTED * len(names)), 1)])


def errors_of(units: dict[str, Unit], methods: dict[str, Any], seed: int) -> dict[tuple[str, str], list[Answer]]:
    """Predicted and true values with their touches, one entry for each direction, by use and method."""
    found: dict[tuple[str, str], list[Answer]] = {}
    tested = tested_touches(next(iter(units.values())).touches, seed)
    for source_name, source in units.items():
        for target_name, target in units.items():
            if source_name == target_name:
                continue
            new = np.array([touch in tested for touch in source.touches])
            known = np.array([touch not in tested for touch in target.touches])
            moved = {AS_IT_IS: source.pictures}
            for name, method in methods.items():
                moved[name] = method.transfer(source.pictures, source.background, target.background)
            own = small_pictures(target.pictures)
            head = learned_head(own[known], target.values[known], seed)
            answer = (head.read(own[~known]), target.values[~known], target.touches[~known])
            for use in USES:
                found.setdefault((use, OWN), []).append(answer)
            for name, pictures in moved.items():
                ours = small_pictures(pictures)
                answer = (head.read(ours[new]), source.values[new], source.touches[new])
                found.setdefault(("reads", name), []).append(answer)
                taught = learned_head(ours[~new], source.values[~new], seed)
                answer = (taught.read(own[~known]), target.values[~known], target.touches[~known])
                found.setdefault(("teaches", name), []).append(answer)
    return found


def rows_of(found: dict[tuple[str, str], list[Answer]]) -> Rows:
    """A row for each use and method, with the scores of each reading."""
    joined = {key: tuple(np.concatenate(part) for part in zip(*each, strict=True)) for key, each in found.items()}
    rows: Rows = []
    for (use, name), (predicted, true, touches) in joined.items():
        swapped, _, _ = joined[use, SWAP]
        scores = {}
        for column, (reading, unit) in enumerate(READINGS.items()):
            error = np.abs(predicted[:, column] - true[:, column])
            span = float(np.ptp(true[:, column]))
            scores[reading] = {
                "unit": unit,
                "mae": interval(bootstrap(error, touches)),
                "percent_of_range": 100.0 * float(error.mean()) / span,
                "r2": interval(
                    bootstrap(np.stack([predicted[:, column], true[:, column]], axis=1), touches, statistic=r2)
                ),
            }
            if name not in (OWN, SWAP):
                other = np.abs(swapped[:, column] - true[:, column])
                scores[reading]["mae_less_swap"] = interval(bootstrap(error - other, touches))
        rows.append({"use": use, "method": name, "scores": scores})
    return rows


def r2(pairs: np.ndarray) -> float:
    """R² of rows of a predicted and a true value."""
    return explained(pairs[:, 0], pairs[:, 1])


def interval(found: Interval) -> dict[str, float | None]:
    """A bootstrap's value and ends; an end is None where there are too few touches."""
    ends = {"value": found.value, "low": found.low, "high": found.high}
    return {name: float(value) if np.isfinite(value) else None for name, value in ends.items()}


def table(rows: Rows) -> str:
    """Lines of Markdown: error with the share of the range and R², and whether the force differs from the swap's."""
    heads = [f"{name}, {unit}" for name, unit in READINGS.items()]
    lines = [f"| method | {' | '.join(heads)} | fz less the swap's, N |", f"|---|{'---|' * (len(heads) + 1)}"]
    for row in sorted(rows, key=lambda row: row["method"] != OWN):
        cells = []
        for score in row["scores"].values():
            cells.append(f"{score['mae']['value']:.3f} ({score['percent_of_range']:.1f} %), {score['r2']['value']:.2f}")
        less = row["scores"]["fz"].get("mae_less_swap")
        cells.append(f"{less['value']:+.3f} [{less['low']:+.3f}, {less['high']:+.3f}]" if less else "–")
        lines.append(f"| {row['method'].replace('_', '-')} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
