"""The command `transfer`: a store as another sensor might have recorded it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

import typer

from split_models.commands.device_option import DEVICE, require_device
from split_models.transfer.methods import LATENT
from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import listed_names, need_writable_folder
from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say
from tactiledata.cli.task_options import SCHEDULER, WORKERS
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.extras import need_packages
from tactiledata.contract.own_files import mark_png
from tactiledata.contract.wording import counted
from tactiledata.errors import UnknownName

if TYPE_CHECKING:
    from split_models.transfer.methods import TransferMethod
    from split_models.transfer.transfer_store import TransferReport
    from tactiledata.store.read.reader import Store

MODEL = typer.Option(None, "--model", help="Checkpoint of an image VAE [default: the bundled one].")
OUT = typer.Option(None, "--out", help="Store to write [default: transferred/STORE-TARGET-METHOD.zarr].")


def _typed_methods() -> list[str]:
    """Return the names of all methods as they are typed, those by a model first."""
    return [name.replace("_", "-") for name in (*LATENT, *PIXEL_TRANSFERS)]


def method_help() -> str:
    """Return the help of ``--method``: the names of all methods as they are typed, those by a model first."""
    *names, last = _typed_methods()
    return (
        f"{', '.join(names)} or {last} [default: latent-relit where the model draws the store's own touches, else "
        "relit]."
    )


def register(app: typer.Typer) -> None:
    """Add the command `transfer` to the application."""
    app.command("transfer")(transfer)


def transfer(
    store: str = STORE_ARGUMENT,
    to: str = typer.Option(..., "--to", help="The target sensor: a name that `tactiledata sensors` lists."),
    method: str = typer.Option(
        None,
        "--method",
        help=method_help(),
    ),
    model: Path = MODEL,
    sources: str = typer.Option(
        None, "--from", help="Comma-separated sensors whose frames are transferred [default: all]."
    ),
    out_store: Path = OUT,
    device: str = DEVICE,
    workers: int = WORKERS,
    scheduler: str = SCHEDULER,
    as_json: bool = JSON_OPTION,
) -> None:
    """Give the touches of a store the style of another sensor.

    The result is a new store, whose trajectories name their parents. The command prints how much of a touch is kept.

    Example: tactiledata transfer --to ycb-sensorA
    """
    need_packages("a transfer", "torch")
    from split_models.transfer.method_choice import choose_method, documents, kept_by, touch_samples
    from split_models.transfer.transfer_picture import write_transfer_picture
    from split_models.transfer.transfer_store import refuse_unfit, transfer_store
    from tactiledata.scoring.kept_touches import touch_findings
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.simulated import simulated_recordings
    from tactiledata.store.read.targets import find_target

    location = working_store(store)
    require_device(device)
    _need_method(method)
    with damage_explains(location):
        opened = Store.open(location)
        target = find_target(to, opened)
        named = None if sources is None else listed_names(sources, "--from")
        samples = touch_samples(opened, named)
        choice = choose_method(method, model, samples, device)
        way = choice.method
        written = out_store if out_store is not None else _default_out(location, to, way.name)
        pictured = written.with_suffix(".png")
        need_writable_folder(written.parent, pictured.name)
        refuse_unfit(opened, target, way, written, named)
        kept = kept_by(way, samples, target.background)
        measured = documents(choice.drawn, kept)
        with progress("transferring", quiet=as_json) as tell:
            report = transfer_store(
                opened, target, way, written, named, tell, measured, workers=workers, scheduler=scheduler
            )
        lost = list(touch_findings(kept, way.name.replace("_", "-"), target.name))
        report = replace(report, findings=(*report.findings, *lost))
        picture = write_transfer_picture(opened, Store.open(written), target, way.name, pictured)
        mark_png(picture)
    if as_json:
        hashes = {"model": getattr(way, "model", ""), "recipe": getattr(way, "recipe", "")}
        simulated = {"simulated_recordings": simulated_recordings(opened).document()}
        emit({**report.document(), **hashes, **measured, "reason": choice.reason, **simulated, "picture": str(picture)})
        return
    if sentence := simulated_recordings(opened).sentence:
        say(sentence)
    for facts in choice.drawn:
        say(facts.sentence("own touches drawn by the model"))
    if choice.reason:
        say(f"{choice.reason}: {way.name.replace('_', '-')}")
    for facts in kept:
        say(facts.sentence(f"touches kept by {way.name.replace('_', '-')}"))
    _print_report(report, to, way, location, picture, _left_out(opened, report.sensors) if report.left_out else ())


def _default_out(location: str, target: str, method: str) -> Path:
    """Default output in a folder of its own: the working folder keeps a single store, which commands then find."""
    stem = location.rstrip("/").rpartition("/")[2].removesuffix(".zarr")
    safe = target.replace("/", "_")
    return Path("transferred") / f"{stem}-{safe}-{method.replace('_', '-')}.zarr"


def _print_report(
    report: TransferReport, to: str, way: TransferMethod, location: str, picture: Path, left_out: Sequence[str]
) -> None:
    """Print the report of a transfer, and the next steps."""
    say(f"{to} is {report.target.resolved}")
    if model := getattr(way, "model", ""):
        say(f"model {model[:12]}, of recipe {getattr(way, 'recipe', '')[:12]}")
    was = "" if report.added == report.recordings else f"; {counted(report.added, 'recording')} of them added now"
    say(
        f"{counted(report.frames, 'frame')} of {', '.join(report.sensors)} in {counted(report.recordings, 'recording')}"
        f" by {report.method.replace('_', '-')}{was}"
    )
    for sentence in left_out:
        say(sentence)
    for note in report.notes:
        say(note)
    findings((report.target.name, finding) for finding in report.findings)
    say(f"wrote {report.out} and {picture}: look at the picture before you train on them")
    both = f"{quote(str(location))} {quote(str(report.out))} --into with-children/both.zarr"
    say(f"to train on both: tactiledata merge {both}, then split that")


def _left_out(store: Store, sensors: Sequence[str]) -> list[str]:
    """Return a sentence for each reason for which frames of a store were not transferred, each frame under one."""
    import numpy as np

    from split_models.transfer.transfer_take import barred_frames

    frames = store.frames(["sensor", "flags", "trajectory"])
    waits = np.ones(frames.num_rows, dtype=bool)
    sentences = []
    for words, barred in barred_frames(frames, sensors).items():
        if count := int((waits & barred).sum()):
            sentences.append(f"{counted(count, 'frame')} left out: {words}")
        waits &= ~barred
    return sentences


def _need_method(method: str | None) -> None:
    """Refuse a method that is not known, with the names as they are typed."""
    known = _typed_methods()
    if method is not None and method.replace("_", "-") not in known:
        raise UnknownName("transfer method", method, known)
