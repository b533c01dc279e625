"""The demo's step with an image model: touches of one sensor in another sensor's style, and scores of the result."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactiledata.contract.extras import missing_package
from tactiledata.contract.wording import agreeing
from tactiledata.errors import TactileDataError

if TYPE_CHECKING:
    from tactiledata.rig.scenario.scenario import Scenario

FRAMES = 12
"""Largest number of pictures of each sensor that the demo scores; the command takes 200 by default."""
STYLE = "gram_style"
"""Metric of the style distance."""


def transfer_touches(
    commands: Mapping[str, Any], store: Path, out: Path, scenario: Scenario, report_step: Callable[[str], None]
) -> tuple[dict[str, Any] | None, dict[str, Any] | None]:
    """Transfer one sensor's touches to a sensor that the world does not use, score them, and return both documents.

    Both are None where the commands or PyTorch are not installed, and where the store cannot be transferred.

    Parameters
    ----------
    commands : dict, name -> command
        The application's commands; `transfer` and `score` come with a package that not every installation has.
    store : Path
        The demo's store.
    out : Path
        The demo's folder.
    scenario : Scenario
        The world, whose sensors' pictures are no target.
    report_step : callable
        Prints a line.
    """
    from tactiledata.store.change.merge import merge

    source, target = _source(store), unused_target(scenario)
    report_step(f"9. Transfer: touches of {source}, one sensor to keep it short, in the style of another; and scores")
    if lacking := _lacking(commands, target):
        report_step(f"   left out: {lacking}")
        return None, None
    folder = out / "transfer"
    made, both = folder / f"{source}-{target}.zarr", folder / "both.zarr"
    try:
        transferred = _document(
            commands["transfer"], str(store), "--to", str(target), "--from", source, "--out", str(made)
        )
        _report_transfer(transferred, report_step)
        # what is kept is scored against the parents, so both stand in one store
        merge([store, made], both)
        scored = _document(
            commands["score"], str(both), "--metric", STYLE, "--against", str(target), "--frames", str(FRAMES)
        )
    except TactileDataError as error:
        report_step(f"   left out: {error.found}")
        return None, None
    _report_score(scored, source, report_step)
    report_step(f"   Open:  {transferred['picture']}: touches of simulated recordings before and after, row by row")
    return transferred, scored


def unused_target(scenario: Scenario) -> str | None:
    """Return the first bundled picture without contact that no sensor of a world has; None where all are used."""
    from tactiledata.sensors.backgrounds import ALIASES, bundled_backgrounds

    used = {ALIASES.get(setup.background, setup.background) for setup in scenario.sensors.values()}
    return next((name for name in (*ALIASES, *bundled_backgrounds()) if ALIASES.get(name, name) not in used), None)


def _source(store: Path) -> str:
    """Return the first sensor, by name, that has a touch in the store."""
    from tactiledata.store.read.reader import Store

    return str(min(Store.open(store).trajectories(["sensor"])["sensor"].to_pylist()))


def _lacking(commands: Mapping[str, Any], target: str | None) -> str:
    """Return what the step lacks, in words; empty where it can be taken."""
    if missing := [name for name in ("transfer", "score") if name not in commands]:
        return f"no installed package adds the {agreeing(len(missing), 'command', 'commands')} {' and '.join(missing)}"
    if find_spec("torch") is None:
        return str(missing_package("torch", "a transfer"))
    return "" if target else "the sensors of this world have all bundled pictures, and none is left as a target"


def _document(command: Any, *words: str) -> dict[str, Any]:
    """Run a command of the application as it is typed, and return the document that it prints for machines."""
    with redirect_stdout(io.StringIO()) as printed:
        command.main([*words, "--json"], standalone_mode=False)
    return dict(json.loads(printed.getvalue()))


def _report_transfer(document: dict[str, Any], report_step: Callable[[str], None]) -> None:
    """Print which sensor was transferred to which, by which method and why, and what is kept."""
    from tactiledata.contract.wording import counted
    from tactiledata.scoring.kept_touches import KeptTouch

    method = document["method"].replace("_", "-")
    report_step(f"   target: {document['target']['name']}, a real picture without contact that no sensor here has")
    for facts in document["drawn_by_model"]:
        report_step(f"   {KeptTouch(**facts).sentence('own touches drawn by the bundled image model')}")
    report_step(f"   {document['reason']}: {method}")
    for facts in document["kept_touch"]:
        report_step(f"   {KeptTouch(**facts).sentence(f'touches kept by {method}')}")
    for finding in document["findings"]:
        report_step(f"   {finding['severity']}: {finding['message']}")
    report_step(f"   {counted(document['frames'], 'image')} of {', '.join(document['sensors'])} transferred")


def _report_score(document: dict[str, Any], source: str, report_step: Callable[[str], None]) -> None:
    """Print the style distance before and after the transfer, and beside it what is kept of the touches."""
    made = {score["first"] for score in document["kept"]}
    for score in document["scores"]:
        if score["first"] == source or score["first"] in made:
            when = "before" if score["first"] == source else "after "
            report_step(
                f"   {when} {score['score']['title']} to {score['second']}, {score['looked_at']}: {_interval(score)}, "
                f"{score['score']['better']} is closer"
            )
    kept = ", ".join(f"{score['score']['title']} {_interval(score)}" for score in document["kept"])
    report_step(f"   after  {kept}" if kept else "   what is kept of the touches is not known")
    for note in document["notes"]:
        report_step(f"   {note}")


def _interval(score: dict[str, Any]) -> str:
    """Return a score, with its interval where there are enough touches for one."""
    value, low, high = (score[name] for name in ("value", "low", "high"))
    return f"{value:.3g}" if low is None else f"{value:.3g} [{low:.3g}, {high:.3g}]"
