"""`demo`: all steps from recording to diagnosis and transfer, on simulated recordings, with reports."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.demo_steps.diagnosis import diagnose_touches
from tactiledata.cli.demo_steps.gel import play_gel
from tactiledata.cli.demo_steps.transfer import transfer_touches
from tactiledata.cli.documents import wrong_document_is_wrong_usage
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.contract.extras import GEL, PAGE, missing_package, need_packages
from tactiledata.contract.wording import counted
from tactiledata.contract.worker_pool import need_workers
from tactiledata.errors import UsageError

MARKER = ".tactiledata-demo"
"""Name of a file that marks a folder as made by the demo: only such a folder is emptied."""


def register(app: typer.Typer) -> None:
    """Add the command `demo` to the application."""
    app.command("demo")(demo)


def demo(
    context: typer.Context,
    out: Path = typer.Option(Path("demo-out"), "--out", help="Folder for everything that the demo makes."),
    world: str = typer.Option("demo", "--world", help="Scenario to record: demo, tiny, or a scenario file."),
    workers: int = typer.Option(2, "--workers", help="Number of local processes."),
    fidelity: str = typer.Option(
        "finite-strain", "--fidelity", help="Strain model of the gel: finite-strain, or linear for a quick preview."
    ),
    as_json: bool = JSON_OPTION,
) -> None:
    """Run all steps on simulated recordings of a small world.

    The steps are record, ingest, split, audit, calibrate, replay, load a batch, report, diagnose, and transfer to
    another sensor with scores.

    Example: tactiledata demo --out demo-out
    """
    need_packages("the demo", "sklearn", *GEL, *PAGE)
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.ingest.sources.overview import write_report
    from tactiledata.replay.overview import mesh_sections
    from tactiledata.rig.record import record
    from tactiledata.rig.scenario.scenario import load_scenario
    from tactiledata.rig.scenario.worlds import find_scenario
    from tactiledata.splits.audit import audit
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.simulated import simulated_recordings

    def report_step(text: str) -> None:
        """Print a line for people."""
        if not as_json:
            say(text)

    # 1 and 2: recordings, and a store of them
    with wrong_document_is_wrong_usage():
        scenario = load_scenario(find_scenario(world))
    need_workers(workers)
    _empty_folder(out)
    report_step("1. Record: a UR5e presses DIGIT sensors on indenters, simulated recordings as ROS 2 MCAP")
    report_step("   Touches, forces and pictures are simulated, with known truth; backgrounds of pictures are real")
    with progress("recording", quiet=as_json) as bar:
        logs = record(scenario, out / "recordings", "mcap", bar, workers)
    report_step(f"   {counted(len(logs), 'recording')} in {out / 'recordings'}")

    report_step("2. Ingest: clocks, contact forces, trajectories and checks into one Zarr store")
    store_path = out / "demo.zarr"
    with progress("ingesting", quiet=as_json) as bar:
        report = ingest(logs, store_path, workers=workers, progress=bar)
    added = [source for source in report.sources if source.state == "added"]
    trajectories, images = sum(source.trajectories for source in added), sum(source.frames for source in added)
    report_step(f"   {store_path}: {counted(trajectories, 'trajectory')}, {counted(images, 'image')}")
    report_step(f"   {report.simulated.sentence}")

    # 3: a split, and its audit
    report_step("3. Split: whole trajectories, one sensor never seen in training; audit for leaks")
    store = Store.open(store_path)
    split = make_split(store)
    for part, count in split.counts.items():
        report_step(f"   {part}: {counted(count.trajectories, 'trajectory')}, {counted(count.frames, 'image')}")
    for note in split.notes:
        report_step(f"   note: {note}")
    with progress("auditing", quiet=as_json) as bar:
        audited = audit(store, "default", progress=bar)
    report_step(f"   audit: {audited.lines()[0]}")

    # 4 and 5: calibration and meshes; 6: a batch
    gel = play_gel(store_path, out, scenario, fidelity, workers, report_step, quiet=as_json)

    report_step("6. Load: a batch from PyTorch")
    batch = _load_batch(store_path)
    report_step(f"   {batch['said']}")

    # 7 and 8: pages; 9: another sensor's style
    store = Store.open(store_path)
    written = write_report(store, out, further=mesh_sections(store))
    report_step(f"7. Look: {written['picture']}\n   Open:  {written['page']}")
    diagnosis, page = diagnose_touches(store_path, out, scenario, workers, report_step, quiet=as_json)
    commands: Any = context.find_root().command
    transferred, scored = transfer_touches(commands.commands, store_path, out, scenario, report_step)
    if gel.page is not None:
        report_step(f"   Open:  {gel.page}: measured and simulated forces, and how well E, nu and mu are known")
    if page is not None:
        report_step(f"   Open:  {page}: where the simulation and these simulated recordings differ, and why")
    if as_json:
        emit({
            "recordings": [str(log) for log in logs],
            "ingest": report.document(),
            "split": split.document(),
            "audit": audited.document(),
            "calibration": gel.calibration,
            "replay": gel.replay.document(),
            "batch": batch,
            "diagnosis": diagnosis,
            "transfer": transferred,
            "score": scored,
            "simulated_recordings": simulated_recordings(store).document(),
            **{name: str(path) for name, path in written.items()},
        })  # fmt: skip
    if report.fell_short or audited.leaks or gel.replay.fell_short:
        raise typer.Exit(1)


def _empty_folder(out: Path) -> None:
    """Make the demo's folder, emptied where an earlier demo made it; refuse a file, and a folder of other files."""
    if out.exists() and not out.is_dir():
        raise UsageError(f"--out {out} is a file", "a folder that is new, empty, or of an earlier demo")
    if out.is_dir() and any(out.iterdir()):
        if not (out / MARKER).is_file():
            raise UsageError(
                f"--out {out} holds files that no demo made",
                "a folder that is new, empty, or of an earlier demo",
                "Name another folder.",
            )
        shutil.rmtree(out)
    out.mkdir(parents=True, exist_ok=True)
    (out / MARKER).touch()


def _load_batch(store_path: Path) -> dict[str, Any]:
    """Return a batch of training frames, in words under ``said`` and, where PyTorch is installed, as ``shapes``."""
    try:
        from torch.utils.data import DataLoader
    except ImportError:
        return {"said": f"left out: {missing_package('torch', 'a batch of PyTorch')}"}
    from tactiledata.loaders.torch import TactileDataset

    streams = ("digit", "contact_wrench", "mesh")
    train = TactileDataset(store_path, split="default/train", streams=list(streams), missing="drop")
    batch = next(iter(DataLoader(train, batch_size=min(64, len(train)))))
    shapes = {name: list(batch[name].shape) for name in streams}
    listed = ", ".join(f"{name} {tuple(shape)} {batch[name].dtype}" for name, shape in shapes.items())
    return {"said": f"{counted(len(train), 'training frame')}; a batch: {listed}", "shapes": shapes}
