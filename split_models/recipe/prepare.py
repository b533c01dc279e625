"""The store of a recipe: opened, or recorded, ingested, replayed and split; existing results are kept."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from split_models.recipe.recipe import Recipe
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.progress import Progress
from tactiledata.contract.provenance import digest_of
from tactiledata.contract.schema import read_document
from tactiledata.errors import MissingFile, TactileDataError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.ingest.pipeline import ingest
from tactiledata.replay.attach import replay
from tactiledata.replay.options import ReplayOptions
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import Scenario, load_scenario
from tactiledata.rig.scenario.worlds import find_scenario
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store

MATERIAL = ("youngs_modulus", "poisson_ratio", "friction")
"""Parameters of the gel's material."""
STORE = "ds.zarr"
"""Name of the store of a simulated world."""
RECORDED = "recorded.json"
"""File that is written beside the recordings when all of them are complete."""


def store_place(recipe: Recipe, out: Path) -> Path:
    """Path of a recipe's store; each simulated world has a folder in ``out/data``, which need not exist yet.

    Raises
    ------
    MissingFile
        The recipe names a store that does not exist.
    """
    data = recipe.data
    if data["store"]:
        if not Path(data["store"]).exists():
            raise MissingFile(
                f"the recipe {recipe.name} names the store {data['store']}, which does not exist",
                "a store that `tactiledata ingest` wrote, its path seen from the working folder",
                "Run the command in the folder from which that path leads to the store, or mend it in the recipe.",
            )
        return Path(data["store"])
    key = digest_of(_scenario_document(data["world"]))
    return out / "data" / f"{Path(data['world']).stem}-{key[:12]}" / STORE


def prepare_store(recipe: Recipe, out: Path, workers: int, tell: Progress) -> Path:
    """Path of the store that a recipe works on, after its meshes and its split have been made where they were missing.

    Parameters
    ----------
    recipe : Recipe
    out : Path
        Folder below which worlds are kept.
    workers : int
        Local processes that record, ingest and replay.
    tell : callable
        Called with how much is done, how much there is, and words.

    Raises
    ------
    TactileDataError
        A recording cannot be read, or no frame has a mesh.
    """
    data, place = recipe.data, store_place(recipe, out)
    if data["world"]:
        _make_world(data, place, workers, tell)
    split = data["split"]
    store = Store.open(place)
    if split["make"] and not (data["store"] and split["name"] in store.split_names()):
        options = {name: split[name] for name in ("by", "hold_out", "fractions", "force", "seed")}
        make_split(store, split["name"], **options)
    return place


def _scenario_document(world: str) -> Any:
    """The scenario of a world as a document, from a file or from the bundled ones."""
    source = find_scenario(world)
    return read_document(source, "scenario") if isinstance(source, Path) else source


def _make_world(data: Any, store: Path, workers: int, tell: Progress) -> None:
    """Record, ingest and replay a world into a store; steps that are complete are left alone."""
    scenario = load_scenario(find_scenario(data["world"]))
    recordings = store.parent / "recordings"
    if not (store.parent / RECORDED).exists():
        record(scenario, recordings, "mcap", partial(_report_step, tell, "recording"), workers)
        write_json_atomic(store.parent / RECORDED, {"scenario": digest_of(_scenario_document(data["world"]))})
    report = ingest([recordings], store, workers=workers, progress=partial(_report_step, tell, "ingesting"))
    if report.fell_short:
        raise TactileDataError(
            f"recordings of the world {data['world']} are not complete in the store",
            "complete recordings",
            f"Look with `tactiledata info {store}`.",
        )
    section = data["replay"]
    calibration = _calibration(section, store, workers, tell) if is_calibrated(section) else {}
    options = replay_options(section, scenario, calibration)
    replay(store, options, workers, progress=partial(_report_step, tell, "replaying"))


def is_calibrated(section: Any) -> bool:
    """Whether a recipe's section ``replay`` leaves a parameter of the material to a calibration."""
    return section["material"] == "calibrated" and any(section[name] is None for name in MATERIAL)


def _calibration(section: Any, store: Path, workers: int, tell: Progress) -> Any:
    """The calibration of a world's touches, beside its store; one that is complete is left alone."""
    from tactiledata.calibrate.calibrate import calibrate
    from tactiledata.calibrate.document import write_calibration
    from tactiledata.calibrate.options import CalibrationOptions

    path = store.parent / f"calibration-{section['fidelity']}.json"
    if path.exists():
        return read_document(path, "calibration")
    options = CalibrationOptions(fidelity=section["fidelity"], workers=workers)
    return write_calibration(calibrate(Store.open(store), options, partial(_report_step, tell, "calibrating")), path)


def _report_step(tell: Progress, step: str, done: int, total: int, what: str = "") -> None:
    """Report progress under the name of a step."""
    tell(done, total, f"{step}: {what}")


def replay_options(section: Any, scenario: Scenario, calibration: Mapping[str, Any]) -> ReplayOptions:
    """Options of a world's replay.

    Parameters
    ----------
    section : dict
        The recipe's section ``replay``; a parameter of the material that it states goes before all else.
    scenario : Scenario
        The world, whose own material is used without a calibration.
    calibration : dict
        Content of a calibration.json, with the contact offsets of the touches that it played; empty without one.
    """
    own = {name: calibration.get(name, getattr(scenario.material, name)) for name in MATERIAL}
    material = {name: own[name] if section[name] is None else section[name] for name in MATERIAL}
    return ReplayOptions(
        GelMaterial(**material),
        resolution=section["resolution"],
        fidelity=section["fidelity"],
        keep=section["keep"],
        offsets=calibration.get("offsets", {}),
        name=replayed_name(section),
    )


def replayed_name(section: Any) -> str:
    """Name of a replayed mesh in the store, from its resolution, fidelity, kept nodes and the material's origin."""
    linear = "-linear" if section["fidelity"] == "linear" else ""
    surface = "-surface" if section["keep"] == "surface" else ""
    calibrated = "-calibrated" if is_calibrated(section) else ""
    return f"{section['resolution']}{linear}{surface}{calibrated}"


def mesh_name(data: Any) -> str:
    """Name of the store's mesh that a recipe works with; empty for the store's only mesh."""
    if data["mesh"] or data["store"]:
        return str(data["mesh"])
    return replayed_name(data["replay"])
