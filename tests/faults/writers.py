"""Writers of tactiledata on small data, each as something that is prepared once and run again and again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

if TYPE_CHECKING:
    from tactiledata.rig.scenario.scenario import Scenario


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
    same : callable, optional
        What of a folder is the same each time, where not every byte of its files is.
    """

    prepare: Callable[[Path], object]
    write: Callable[[Path], object]
    tiny: bool = False
    same: Callable[[Path], object] | None = None


def nothing(folder: Path) -> None:
    """Leave the folder as it is."""


def imported(*modules: str, before: Callable[[Path], object] = nothing) -> Callable[[Path], object]:
    """A preparation that also imports modules, which the forked writers then need not do, each for itself."""

    def prepare(folder: Path) -> None:
        for module in modules:
            import_module(module)
        before(folder)

    return prepare


def command(*words: object) -> None:
    """Run a command line to its end; its errors come out."""
    from tactiledata.cli.main import app

    assert not app([str(word) for word in words], standalone_mode=False)


def store_in(folder: Path, name: str = "ds.zarr", n_sources: int = 3) -> None:
    """A small store of two sensors."""
    from loaders.loader_stores import write_loader_store

    write_loader_store(folder / name, n_sources=n_sources)


# -- recordings and stores ---------------------------------------------------------------------------------------------


def small_world(touches: int) -> Scenario:
    """A world of some touches, each with a log of its own."""
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
        "trajectories": [{"name": f"touch{number}", **touch} for number in range(touches)],
    }
    return load_scenario(world)


def record(folder: Path) -> None:
    from tactiledata.rig.record import record as run

    run(small_world(2), folder / "logs", "folder")


def two_logs(folder: Path) -> None:
    """Two folder logs."""
    from generators import folder_log

    for seed in (1, 2):
        folder_log.write(folder / "logs" / f"run{seed}", touches=1, frames=3, seed=seed)


def ingest(folder: Path) -> None:
    from tactiledata.ingest.pipeline import ingest as run

    run([folder / "logs"], folder / "ds.zarr")


def corrected_logs(folder: Path) -> None:
    """A store of two folder logs, of which one was corrected since."""
    two_logs(folder)
    ingest(folder)
    with (folder / "logs" / "run1" / "log.yaml").open("a", encoding="utf-8") as log:
        log.write("# corrected\n")


def replace(folder: Path) -> None:
    command("ingest", folder / "logs", "--store", folder / "ds.zarr", "--replace")


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


def keep_decoded(folder: Path) -> None:
    """The first epoch of a dataset that keeps decoded pictures."""
    from tactiledata.loaders.numpy import TactileArrays

    dataset = TactileArrays(
        folder / "ds.zarr", "all", ["digit"], cache=folder / "decoded", image_dtype="uint8", allow_leaks=True, threads=1
    )
    dataset.batch(range(len(dataset)))


def view(folder: Path) -> None:
    command("view", folder / "ds.zarr", "--out", folder / "view.rrd", "--most", 1, "--json")


def viewed(folder: Path) -> object:
    """What a view shows: rerun numbers each row by the time at which it was written."""
    from viewed_store import read_view

    views, layouts = read_view(folder / "view.rrd")
    return {uid: sorted(one.entities) for uid, one in views.items()}, layouts


def train(folder: Path) -> None:
    """A training whose clock stands still, for its curve tells seconds."""
    from types import SimpleNamespace

    import torch
    from learner import learn

    from split_models.learning import train as training

    torch.set_num_threads(1)
    training.time = SimpleNamespace(monotonic=lambda: 0.0)
    learn(folder / "models", epochs=2)


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


def begun_engine(folder: Path) -> None:
    """The engine begun here, so that the forked writers need not load it, each for itself."""
    import os
    from tempfile import TemporaryDirectory
    from unittest.mock import patch

    from small_plays import NODES, PAD, press

    from tactiledata.calibrate.plays.player import play_nodes

    with TemporaryDirectory() as cache, patch.dict(os.environ, TACTILEDATA_CACHE=cache):
        play_nodes(PAD, "linear", [press(0)], NODES[:1])


def played_store(folder: Path) -> None:
    """A small store, and the engine begun."""
    store_in(folder)
    begun_engine(folder)


def diagnose_store(folder: Path) -> None:
    """Plays of two touches, and the files of a diagnosis; what lies between them writes nothing, and is left out."""
    from types import SimpleNamespace

    from small_plays import NODES, PAD, press

    from tactiledata.calibrate.plays.player import play_nodes
    from tactiledata.diagnose import store as diagnosing
    from tactiledata.diagnose.answer import documents

    def diagnosed(store: object, options: object, play_progress: Callable, *others: object) -> object:
        play_nodes(PAD, "linear", [press(0), press(1)], NODES[:2], None, play_progress)
        shown, played = SimpleNamespace(located=None), SimpleNamespace(start=None)
        return SimpleNamespace(is_missing=False, shown=shown, naming=None, simulated=None, played=played, stated=())

    trial = {"trial": "next-1", "title": "A trial", "scenario": {"seed": 1}}
    document = {
        "sentences": [],
        "notes": [],
        "next_trials": {"proposals": [trial]},
        "source": {"groups": 8, "rows": 80},
        "provenance": {"tool": "tactiledata"},
    }
    diagnosing.diagnose_store = diagnosed
    documents.store_document = lambda done: document
    documents.effects_file = lambda done, document: {"effects": [], "provenance": {"tool": "tactiledata"}}
    documents.naming_page = lambda *parts, **more: '<meta name="generator" content="tactiledata">'
    documents._further = documents._sensor_sentences = lambda done: []
    documents.other_steps_section = lambda *parts: None
    command("diagnose", folder / "ds.zarr", "--out", folder / "diagnosis", "--json")


def frozen_tool(folder: Path) -> None:
    """The digests of the program, which the forked writers then need not compute, each for itself."""
    from tactiledata.prove.seal import frozen

    frozen.frozen_tool()


def prove(folder: Path) -> None:
    """A proof by the command; its plays, cases and diagnoses are made up, and so is its chance."""
    import itertools
    from types import SimpleNamespace

    from sealed_proofs import label, said

    from tactiledata.prove.answers import tasks
    from tactiledata.prove.cases.draw import CaseRequest, DrawnCase
    from tactiledata.prove.seal import merkle, sealing
    from tactiledata.prove.worlds.logs import LogReadings
    from tactiledata.prove.worlds.played_plan import PlayedPlan

    def drawn(request: CaseRequest) -> DrawnCase:
        readings = LogReadings(np.arange(9), np.full((9, 6), float(request.number)))
        return DrawnCase(SimpleNamespace(document=label(request.kind, request.number)), [readings], {})

    numbers = itertools.count()
    chance = SimpleNamespace(token_hex=lambda count: f"{next(numbers):0{2 * count}x}")
    PlayedPlan.of = classmethod(lambda *given, **more: None)
    tasks.played_plan = lambda *given: None
    tasks.drawn_case = drawn
    tasks.named_world = lambda *given: SimpleNamespace(document=said([]))
    tasks.time = SimpleNamespace(perf_counter=lambda: 0.0)
    sealing.secrets = merkle.secrets = chance
    words = ("--generators", "analytic", "--plans", "coarse-0", "--nulls", 2, "--visible", 1, "--json")
    command("prove", "--out", folder / "proof", *words)


def proved(folder: Path) -> object:
    """A proof without the numbers of its attempts, of which it counts every one, and what does not fit in it."""
    import json

    from tactiledata.prove.seal.folder import ProofFolder
    from tactiledata.prove.seal.verify import verify

    proof = ProofFolder(folder / "proof")
    names = ("proof.json", "sealed", "cases", "seal.json", "report.html")
    places = [place for name in names for place in ((proof.path / name), *sorted((proof.path / name).rglob("*")))]
    kept = {
        str(place.relative_to(folder)): place.read_bytes()
        for place in places
        if place.is_file() and place.name[0] != "."
    }
    return kept, json.loads(proof.score.read_bytes())["score"], verify(proof).faults


DIAGNOSING = ("tactiledata.cli.main", "tactiledata.diagnose.store")
PROVING = ("sealed_proofs", "tactiledata.cli.main", "tactiledata.prove.page", "tactiledata.prove.seal.verify")
WRITERS = {
    "record": Writer(nothing, record),
    "ingest": Writer(two_logs, ingest),
    "replace": Writer(imported("tactiledata.cli.main", before=corrected_logs), replace),
    "merge": Writer(two_stores, merge),
    "split": Writer(store_in, split),
    "flag": Writer(store_in, flag),
    "sensors-add": Writer(store_and_picture, add_sensor),
    "export-data": Writer(store_in, export),
    "transfer": Writer(store_in, transfer),
    "decoded": Writer(imported("tactiledata.loaders.numpy", before=store_in), keep_decoded),
    "view": Writer(imported("viewed_store", "tactiledata.view.recording", before=store_in), view, same=viewed),
    "train": Writer(imported("learner", "torch._dynamo"), train),
    "replay": Writer(nothing, replay, tiny=True),
    "calibrate": Writer(
        imported("tactiledata.calibrate.calibrate", "tactiledata.calibrate.document", before=begun_engine),
        calibrate,
        tiny=True,
    ),
    "plant": Writer(nothing, plant, tiny=True),
    "diagnose": Writer(imported("joblib", before=presses), diagnose),
    "diagnose-store": Writer(imported(*DIAGNOSING, before=played_store), diagnose_store),
    "prove": Writer(imported(*PROVING, before=frozen_tool), prove, same=proved),
}
"""Writers by the name of their command."""
