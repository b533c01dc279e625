"""`sensors`: the sensors of a store, and pictures without contact that are added by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import refuse_given
from tactiledata.cli.output import JSON_OPTION, emit, findings, say, table
from tactiledata.cli.working_store import working_store
from tactiledata.errors import UsageError

OF_ADDING = ("background", "model", "licence", "source", "unchecked", "replace")
"""Options that have a meaning for a sensor that is added only."""


def register(app: typer.Typer) -> None:
    """Add the command `sensors` to the application."""
    app.command("sensors")(sensors)


def sensors(
    context: typer.Context,
    words: list[str] = typer.Argument(None, help="A store, or: add NAME [FILE…], or: remove NAME."),
    background: Path = typer.Option(
        None,
        "--background",
        help="With add: a picture of the sensor without contact; several pictures are averaged.",
    ),
    model: str = typer.Option(
        None, "--model", help="With add: the sensor's model [default: the known model, else digit]."
    ),
    licence: str = typer.Option("", "--licence", help="With add: licence of the picture."),
    source: str = typer.Option("", "--source", help="With add: origin of the picture."),
    unchecked: bool = typer.Option(False, "--unchecked", help="With add: accept a picture that looks doubtful."),
    replace: bool = typer.Option(False, "--replace", help="With add: replace another picture of the sensor."),
    store: str = typer.Option(
        None, "--store", help="The store, in the place of one among the words [default: the only *.zarr here]."
    ),
    as_json: bool = JSON_OPTION,
) -> None:
    """List the sensors of a store, and the bundled backgrounds.

    `add` adds a sensor to a store by its picture without contact; `remove` takes it out again.

    Example: tactiledata sensors add D20542 --background empty1.png empty2.png empty3.png
    """
    if words and words[0] == "add":
        options = {"model": model, "licence": licence, "source": source, "replace": replace, "unchecked": unchecked}
        _add_sensor(words[1:], background, options, store, as_json)
        return
    if words and words[0] == "remove":
        refuse_given(context, OF_ADDING, "with remove", "with add")
        _remove_sensor(words[1:], store, as_json)
        return
    refuse_given(context, OF_ADDING, "without add", "with add")
    if words and len(words) > 1:
        raise UsageError(
            f"sensors {' '.join(words or [])}",
            "a store, or: add NAME --background FILE, or: remove NAME",
            "See tactiledata sensors --help.",
        )
    if words:
        refuse_given(context, ["store"], f"beside the store {words[0]}", "alone")
    _list_sensors(words[0] if words else store, as_json)


def _add_sensor(
    words: list[str], background: Path | None, options: dict[str, Any], store: str | None, as_json: bool
) -> None:
    """Add a sensor to a store by its picture without contact; ``words`` are its name and further picture files."""
    from tactiledata.store.change.add_sensor import add_sensor

    if not words or background is None:
        raise UsageError(
            "sensors add needs one name and a picture", "tactiledata sensors add NAME --background FILE...", ""
        )
    name, *more = words
    location = working_store(store, "Name it: --store S")
    added = add_sensor(location, name, [background, *map(Path, more)], **options)
    if as_json:
        emit({"store": location, "sensor": name, "findings": [vars(finding) for finding in added]})
        return
    findings((name, finding) for finding in added)
    say(f"{name} is a sensor of {location} now")


def _remove_sensor(names: list[str], store: str | None, as_json: bool) -> None:
    """Take a sensor's picture that was added by hand out of a store."""
    from tactiledata.store.change.add_sensor import remove_sensor

    if len(names) != 1:
        raise UsageError("sensors remove needs one name", "tactiledata sensors remove NAME", "")
    location = working_store(store, "Name it: --store S")
    remove_sensor(location, names[0])
    if as_json:
        emit({"store": location, "removed": names[0]})
        return
    say(f"the picture of {names[0]} that was added by hand is out of {location}")


def _list_sensors(store: str | None, as_json: bool) -> None:
    """Print the sensors of a store, the names of target sensors, and the bundled backgrounds."""
    from tactiledata.sensors.backgrounds import ALIASES, bundled_backgrounds, resolve_background

    bundled = bundled_backgrounds()
    stands_for = {alias: resolve_background(alias).name for alias in ALIASES}
    rows: list[tuple[Any, ...]] = []
    if store is not None or list(Path.cwd().glob("*.zarr")):
        location = working_store(store)
        with damage_explains(location):
            rows, imported = _of_store(location)
        stands_for |= imported
    if as_json:
        keys = ("sensor", "model", "background", "licence")
        emit({
            "store": [dict(zip(keys, row, strict=True)) for row in rows],
            "names": stands_for,
            "bundled": {
                name: {"source": picture.source, "licence": picture.licence, "attribution": picture.attribution}
                for name, picture in bundled.items()
            },
        })  # fmt: skip
        return
    if rows:
        table("sensors of the store", ("sensor", "model", "picture without contact", "licence"), rows)
    table("names of the paper's target sensors", ("name", "stands for"), sorted(stands_for.items()))
    table(
        "real backgrounds that come with the toolkit",
        ("name", "source", "licence"),
        [(name, picture.source, picture.licence) for name, picture in bundled.items()],
    )
    say(next(iter(bundled.values())).attribution)


def _of_store(location: str) -> tuple[list[tuple[Any, ...]], dict[str, str]]:
    """Return the rows of a store's sensors, and the sensors of YCB-Slide that names of target sensors stand for."""
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.targets import YCB_SERIALS, ycb_store

    opened = Store.open(location)
    references = opened.references()
    rows: list[tuple[Any, ...]] = []
    for name, facts in sorted(opened.sensors().items()):
        reference = references.get(name)
        picture = (reference.origin, reference.licence or "-") if reference else ("no background", "-")
        rows.append((name, facts.get("model", "") or "-", *picture))
    places = {name: ycb_store(name, opened) for name in YCB_SERIALS}
    return rows, {name: f"{YCB_SERIALS[name]} of {place.location}" for name, place in places.items() if place}
