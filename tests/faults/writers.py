"""Writers of tactiledata on small data, each as something that is prepared once and run again and again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Writer:
    """A command that writes.

    Parameters
    ----------
    prepare : callable
        Puts what the command reads into a folder.
    write : callable
        Runs the command on that folder, in which it also writes.
    tiny : bool
        Whether it reads the store ``ds.zarr`` of the tiny world, which is put there before.
    """

    prepare: Callable[[Path], object]
    write: Callable[[Path], object]
    tiny: bool = False


def nothing(folder: Path) -> None:
    """Leave the folder as it is."""


def store_in(folder: Path, name: str = "ds.zarr", n_sources: int = 3) -> None:
    """A small store of two sensors."""
    from loaders.loader_stores import write_loader_store

    write_loader_store(folder / name, n_sources=n_sources)


# -- recordings and stores ---------------------------------------------------------------------------------------------


def record(folder: Path) -> None:
    from tactiledata.rig.record import record as run
    from tactiledata.rig.scenario.scenario import load_scenario

    press = {"press": {"depth": 2e-4, "settle": 0.05}}
    touch = {"sensor": "D1", "indenter": "ball", "position": [0.001, -0.002], "steps": [press]}
    world = {
        "format": "tactiledata-scenario/1",
        "seed": 5,
        "sensors": {"D1": {"background": "digit-bg-0"}},
        "indenters": {"ball": {"shape": "sphere", "radius": 0.004}},
        "streams": {"joints": 50, "tcp": 50, "wrench": 50, "arm_wrench": 20},
        "images": {"free_air_frames": 1},
        "recordings": {"group": "each"},
        "trajectories": [{"name": name, **touch} for name in ("one", "two")],
    }
    run(load_scenario(world), folder / "logs", "folder")


def two_logs(folder: Path) -> None:
    """Two folder logs."""
    from generators import folder_log

    for seed in (1, 2):
        folder_log.write(folder / "logs" / f"run{seed}", touches=1, frames=3, seed=seed)


def ingest(folder: Path) -> None:
    from tactiledata.ingest.pipeline import ingest as run

    run([folder / "logs"], folder / "ds.zarr")


def merge(folder: Path) -> None:
    from tactiledata.store.change.merge import merge as run

    run([folder / "ds.zarr", folder / "other.zarr"], folder / "both.zarr")


def two_stores(folder: Path) -> None:
    """Two stores with one recording in common."""
    from random_takes import SMALL, staged_take

    from tactiledata.store.write.commit import commit, create

    for name, seeds in (("ds.zarr", (1, 2)), ("other.zarr", (2, 3))):
        create(folder / name, SMALL)
        commit(folder / name, [staged_take(folder / name, seed)[0] for seed in seeds])


def split(folder: Path) -> None:
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store

    make_split(Store.open(folder / "ds.zarr"), hold_out="none", force=None)


def flag(folder: Path) -> None:
    from tactiledata.store.change.flag import flag_trajectories
    from tactiledata.store.read.reader import Store

    place = folder / "ds.zarr"
    flag_trajectories(place, [Store.open(place).trajectories(["uid"])["uid"][0].as_py()], "slipped")


def store_and_picture(folder: Path) -> None:
    """A store, and a picture of a sensor without contact."""
    import cv2

    store_in(folder)
    picture = np.random.default_rng(4).integers(60, 90, (16, 12, 3)).astype(np.uint8)
    cv2.imwrite(str(folder / "background.png"), picture)


def add_sensor(folder: Path) -> None:
    from tactiledata.store.change.add_sensor import add_sensor as run

    run(folder / "ds.zarr", "D9", folder / "background.png", model="gelsight_r15", unchecked=True)


def export(folder: Path) -> None:
    from tactiledata.export.export import export_data
    from tactiledata.export.plan import ExportPlan
    from tactiledata.store.read.reader import Store

    export_data(Store.open(folder / "ds.zarr"), ExportPlan("webdataset", split="none"), folder / "out")


def transfer(folder: Path) -> None:
    from split_models.transfer.pixels import PIXEL_TRANSFERS
    from split_models.transfer.transfer_store import transfer_store
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.targets import Target

    background = np.random.default_rng(9).integers(60, 90, (16, 12, 3)).astype(np.uint8)
    target = Target("T1", background, "made", licence="CC0", model="gelsight_r15")
    transfer_store(Store.open(folder / "ds.zarr"), target, PIXEL_TRANSFERS["background_swap"], folder / "t1.zarr")


# -- simulation --------------------------------------------------------------------------------------------------------


def replay(folder: Path) -> None:
    from replay.coarse import options

    from tactiledata.replay.attach import replay as run

    run(folder / "ds.zarr", options())


def calibrate(folder: Path) -> None:
    from tactiledata.calibrate.calibrate import calibrate as run
    from tactiledata.calibrate.document import write_calibration
    from tactiledata.calibrate.options import CalibrationOptions
    from tactiledata.store.read.reader import Store

    done = run(Store.open(folder / "ds.zarr"), CalibrationOptions(fidelity="linear", trajectories=2, hold_out=0.0))
    write_calibration(done, folder / "calibration.json")


def plant(folder: Path) -> None:
    from tactiledata.prove.plant.planting import Planting, plant_into
    from tactiledata.store.read.reader import Store

    plant_into(Store.open(folder / "ds.zarr"), folder / "planted.zarr", Planting("gain", 0.05, 3), "c" * 64)


def presses(folder: Path) -> None:
    """A table of presses on a spring."""
    rng = np.random.default_rng(0)
    depth = np.tile(np.linspace(0, 1, 6), 10)
    predicted = 8 * depth**1.5
    table = {"trial": np.repeat(np.arange(10), 6), "depth_mm": depth, "fz_predicted_N": predicted}
    table["fz_observed_N"] = predicted + rng.normal(0, 0.1, 60)
    pd.DataFrame(table).to_csv(folder / "presses.csv", index=False)


def diagnose(folder: Path) -> None:
    from tactiledata.diagnose.table import diagnose_table, write_diagnosis

    found = diagnose_table(folder / "presses.csv")
    write_diagnosis(folder / "diagnosis", "presses", *found)


WRITERS = {
    "record": Writer(nothing, record),
    "ingest": Writer(two_logs, ingest),
    "merge": Writer(two_stores, merge),
    "split": Writer(store_in, split),
    "flag": Writer(store_in, flag),
    "sensors-add": Writer(store_and_picture, add_sensor),
    "export-data": Writer(store_in, export),
    "transfer": Writer(store_in, transfer),
    "replay": Writer(nothing, replay, tiny=True),
    "calibrate": Writer(nothing, calibrate, tiny=True),
    "plant": Writer(nothing, plant, tiny=True),
    "diagnose": Writer(presses, diagnose),
}
"""Writers by the name of their command."""
