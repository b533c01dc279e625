"""`demo`: the whole chain on the bundled recorded world, with a report at the end."""

from __future__ import annotations

import shutil
from pathlib import Path

import typer

from tactiledata.cli.output import progress, say
from tactiledata.errors import UsageError

MARKER = ".tactiledata-demo"
"""Lies in every folder that the demo made, so that it never empties another one."""


def register(app: typer.Typer) -> None:
    """Add this module's command."""
    app.command("demo")(demo)


def demo(
    out: Path = typer.Option(Path("demo-out"), "--out", help="Folder for everything that the demo makes."),
    world: str = typer.Option("demo", "--world", help="Scenario to record: demo, tiny, or a file."),
    workers: int = typer.Option(2, "--workers", help="Local processes for the ingest."),
) -> None:
    """Record a small world, ingest it, split and audit it, load a batch, and write a report.

    Example: tactiledata demo --out demo-out
    """
    from tactiledata.ingest.overview import write_report
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.rig.record import record
    from tactiledata.rig.scenario import load_scenario
    from tactiledata.rig.worlds import find_scenario
    from tactiledata.splits.audit import audit
    from tactiledata.splits.make import make_split
    from tactiledata.store.reader import Store

    _empty_folder(out)
    say("1. Record: a UR5e presses DIGIT sensors on indenters (known truth, real backgrounds), as ROS 2 MCAP")
    with progress("recording") as tell:
        logs = record(load_scenario(find_scenario(world)), out / "recordings", "mcap", tell)
    say(f"   {len(logs)} recordings in {out / 'recordings'}")

    say("2. Ingest: clocks, contact forces, trajectories and checks into one Zarr store")
    store_path = out / "demo.zarr"
    with progress("ingesting") as tell:
        report = ingest(logs, store_path, workers=workers, progress=tell)
    added = [source for source in report.sources if source.state == "added"]
    trajectories, images = sum(one.trajectories for one in added), sum(one.frames for one in added)
    say(f"   {store_path}: {trajectories} trajectories, {images} images")

    say("3. Split: whole trajectories, one sensor never seen in training; audit for leaks")
    store = Store.open(store_path)
    split = make_split(store)
    for part, count in split.counts.items():
        say(f"   {part}: {count.trajectories} trajectories, {count.frames} images")
    for note in split.notes:
        say(f"   note: {note}")
    with progress("auditing") as tell:
        audited = audit(store, "default", progress=tell)
    say(f"   audit: {audited.lines()[0]}")

    say("4. Load: a batch from PyTorch")
    _load_batch(store_path)

    written = write_report(store, out)
    say(f"5. Look: {written['picture']}\n   Open:  {written['page']}")
    if report.fell_short or audited.leaks:
        raise typer.Exit(1)


def _empty_folder(out: Path) -> None:
    """The demo starts from an empty folder of its own; another's folder is never emptied."""
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


def _load_batch(store_path: Path) -> None:
    try:
        from torch.utils.data import DataLoader
    except ImportError:
        say("   PyTorch is not installed, so this step is left out: pip install 'tactiledata[models]'")
        return
    from tactiledata.loaders.torch import TactileDataset

    train = TactileDataset(store_path, split="default/train", streams=["digit", "contact_wrench"])
    batch = next(iter(DataLoader(train, batch_size=min(64, len(train)))))
    image, wrench = batch["digit"], batch["contact_wrench"]
    say(f"   {len(train)} training frames; a batch: digit {tuple(image.shape)} {image.dtype}, "
        f"contact_wrench {tuple(wrench.shape)} {wrench.dtype}")  # fmt: skip
