"""`formats`, `indenters`, `effects`, `inspect`: what the families hold, and what is in a log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer
from rich.markup import escape

from tactiledata.cli.documents import mapping_document
from tactiledata.cli.output import JSON_OPTION, emit, err, findings, say, table
from tactiledata.contract.wording import counted
from tactiledata.errors import TactileDataError, UsageError


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command("formats")(formats)
    app.command("indenters")(indenters)
    app.command("effects")(effects)
    app.command("inspect")(inspect)


def formats(as_json: bool = JSON_OPTION) -> None:
    """Formats that recordings may have, and how each lies on disk.

    Example: tactiledata formats
    """
    from tactiledata.formats import FORMATS

    members = [FORMATS[name] for name in FORMATS]
    if as_json:
        emit([
            {"name": member.name, "title": member.title, "layout": member.layout, "licence": member.licence_note}
            for member in members
        ])  # fmt: skip
        return
    for member in members:
        say(f"{member.name}: {member.title}")
        for line in member.layout.strip().splitlines():
            say(f"    {line}")
        if member.licence_note:
            say(f"    Licence: {member.licence_note}")


def indenters(
    picture: Path = typer.Option(None, "--picture", help="Draw all of them into this PNG file."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Indenters that the toolkit knows by name, with their sizes. Lengths are in metres.

    Example: tactiledata indenters --picture indenters.png
    """
    from tactiledata.indenters import INDENTERS

    members = {name: INDENTERS[name]() for name in INDENTERS}
    if picture is not None:
        from tactiledata.indenters.gallery import draw_gallery

        draw_gallery(picture)
    if as_json:
        emit([
            {"shape": name, "title": member.title, "sizes": member.sizes} for name, member in members.items()
        ])  # fmt: skip
        return
    rows = [
        (name, ", ".join(f"{key} {value:g}" for key, value in member.sizes.items()), member.title)
        for name, member in members.items()
    ]
    table("", ("shape", "sizes by default [m, rad]", "what it is"), rows)
    if picture is not None:
        say(f"drawn: {picture}")


def effects(as_json: bool = JSON_OPTION) -> None:
    """Physics that a simulation may have left out.

    Slot, parameters with plausible ranges, look-alikes. SI units.

    Example: tactiledata effects
    """
    from tactiledata.effects import EFFECTS
    from tactiledata.effects.simulate.catalogue import catalogue

    listed = catalogue(EFFECTS[name]() for name in EFFECTS)
    if as_json:
        emit(listed)
        return
    for entry in listed:
        say(f"{entry['name']} ({entry['slot']}): {entry['title']}")
        for parameter in entry["parameters"]:
            low, high = parameter["plausible"]
            kind = "" if parameter["null"] is not None else ", form only"
            say(f"    {parameter['name']} [{parameter['unit']}] {low:g} to {high:g}{kind}: {parameter['meaning']}")
        say(f"    Looks like {', '.join(entry['look_alikes'])}. {entry['distinguishing_trial']}")


def inspect(
    path: Path = typer.Argument(..., help="A recording, or a folder of recordings."),
    suggest_mapping: bool = typer.Option(False, "--suggest-mapping", help="Print a mapping file to start from."),
    mapping: Path = typer.Option(None, "--mapping", help="Look at it as this mapping file says."),
    as_json: bool = JSON_OPTION,
) -> None:
    """What is in a log, and what is wrong with it. Streams, types, rates, and what they would be read as.

    Example: tactiledata inspect run3.mcap --suggest-mapping > mapping.yaml
    """
    from tactiledata.contract.lfs_pointer import is_lfs_pointer, pointer_words
    from tactiledata.ingest.sources.discover import find_sources

    sources, unclaimed = find_sources([path])
    document = mapping_document(mapping)
    looked, failed = _looked_at(sources, document)
    if suggest_mapping:
        _print_mapping(looked, failed)
    elif as_json:
        emit({
            "sources": [_document(one) for one in looked],
            "failed": [{"key": key, "error": reason} for key, reason in failed.items()],
            "unclaimed": [str(item) for item in unclaimed],
        })  # fmt: skip
    else:
        for one in looked:
            _print_inspection(one)
        for key, reason in failed.items():
            say(f"{key}: cannot be read: {reason}")
        for item in unclaimed:
            say(pointer_words(str(item)) if is_lfs_pointer(item) else f"{item}: no format claims it")
    if failed or any(finding.severity == "damage" for one in looked for finding in one.findings):
        raise typer.Exit(1)


def _looked_at(sources: list[Any], mapping: Any) -> tuple[list[Any], dict[str, str]]:
    """Inspections of the sources that can be read, and the reason for each that cannot; one alone raises it."""
    from tactiledata.formats import FORMATS

    looked, failed = [], {}
    for source in sources:
        try:
            looked.append(FORMATS[source.format]().inspect(source, mapping))
        except (TactileDataError, OSError) as error:
            if len(sources) == 1:
                raise
            failed[source.key] = str(error)
    return looked, failed


def _print_mapping(looked: list[Any], failed: dict[str, str]) -> None:
    for key, reason in failed.items():
        err().print(escape(f"{key}: cannot be read: {reason}"))
    suggestions = [one.suggested_text for one in looked if one.suggested_mapping is not None]
    if suggestions:
        typer.echo(suggestions[0], nl=False)
    elif looked:
        raise UsageError(
            f"{looked[0].source.key} is a {looked[0].source.format} recording, which needs no mapping",
            "a recording with topics, as MCAP files are",
            "Ingest it as it is.",
        )


def _document(one: Any) -> dict[str, Any]:
    return {
        "key": one.source.key,
        "format": one.source.format,
        "files": list(one.source.files),
        "facts": dict(one.facts),
        "topics": [vars(topic) for topic in one.topics],
        "findings": [vars(finding) for finding in one.findings],
        "suggested_mapping": one.suggested_mapping,
    }


def _print_inspection(one: Any) -> None:
    say(f"{one.source.key}: {one.source.format}, {counted(len(one.source.files), 'file')}")
    for name, value in one.facts.items():
        say(f"  {name}: {value}")
    rows = [
        (topic.name, topic.kind, topic.encoding, topic.messages, _rate(topic), topic.role or "-", topic.note)
        for topic in one.topics
    ]
    if rows:
        table("", ("stream", "kind", "encoding", "messages", "Hz", "read as", "note"), rows)
    for topic in one.topics:
        if topic.example:
            say(f"  {topic.name}: {topic.example}")
    findings(("", finding) for finding in one.findings)


def _rate(topic: Any) -> str:
    if not topic.has_times:
        return "no times"
    return "-" if topic.rate is None else f"{topic.rate:.1f}"
