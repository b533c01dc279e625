"""`formats`, `indenters`, `effects`, `inspect`: the members of the families, and the content of a log."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.documents import mapping_document
from tactiledata.cli.given_values import need_writable_folder
from tactiledata.cli.output import JSON_OPTION, emit, err, findings, plain, say, say_left_alone, table
from tactiledata.contract.extras import need_packages
from tactiledata.contract.own_files import mark_png
from tactiledata.contract.wording import counted
from tactiledata.errors import TactileDataError, UsageError


def register(app: typer.Typer) -> None:
    """Add the commands `formats`, `indenters`, `effects` and `inspect` to the application."""
    app.command("formats")(formats)
    app.command("indenters")(indenters)
    app.command("effects")(effects)
    app.command("inspect")(inspect)


def formats(as_json: bool = JSON_OPTION) -> None:
    """List the formats of recordings, with their layouts on disk.

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
    """List the indenters that have names, with their sizes. Lengths are in metres.

    Example: tactiledata indenters --picture indenters.png
    """
    from tactiledata.indenters import INDENTERS

    members = {name: INDENTERS[name]() for name in INDENTERS}
    if picture is not None:
        if picture.suffix.lower() != ".png":
            raise UsageError(f"--picture {picture}", "a file name that ends in .png", "For example indenters.png.")
        need_writable_folder(picture.parent, picture.name, option="--picture")
        need_packages("a picture", "matplotlib")
        from tactiledata.indenters.gallery import draw_gallery

        draw_gallery(picture)
        mark_png(picture)
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
    """List the physics that a simulation may have left out.

    Each entry has its slot, its parameters with plausible ranges in SI units, and the effects that look alike.

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
    paths: list[Path] = typer.Argument(..., help="Recordings, or folders of recordings."),
    suggest_mapping: bool = typer.Option(
        False, "--suggest-mapping", help="Print a draft of one mapping file for all these recordings."
    ),
    mapping: Path = typer.Option(None, "--mapping", help="Read the recording by this mapping file."),
    format_name: str = typer.Option(None, "--format", help="Read the recordings as this format, without detection."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Show what is in logs, and what ingest would say of them.

    Lists streams with their types and rates, and what each would be read as. Makes the checks of ingest that need no
    decoded picture.

    Example: tactiledata inspect run3.mcap --suggest-mapping > mapping.yaml
    """
    from tactiledata.ingest.sources.discover import find_sources, unclaimed_findings
    from tactiledata.ingest.sources.preview import NOT_CHECKED

    sources, unclaimed = find_sources(paths, format_name)
    document = mapping_document(mapping)
    previews, failed = _previews(sources, document)
    inspections = [item.inspection for item in previews]
    left, said = unclaimed_findings(unclaimed)
    if suggest_mapping:
        _print_mapping(inspections, failed, document, as_json)
    elif as_json:
        emit({
            "sources": [_document(item) for item in previews],
            "failed": [{"key": key, "error": reason} for key, reason in failed.items()],
            "unclaimed": [str(item) for item in left],
            "findings": [vars(finding) for finding in said],
            "suggested_mapping": _drafted(inspections, document)[0],
            "not_checked": NOT_CHECKED,
        })  # fmt: skip
    else:
        for item in previews:
            _print_preview(item)
        for key, reason in failed.items():
            say(f"{key}: cannot be read: {reason}")
        is_one = len(sources) == 1
        if not is_one:
            _print_summary(previews, failed)
        say_left_alone(map(str, left))
        of_sources = ((item.source.key, finding) for item in inspections for finding in item.findings)
        findings([*(("" if is_one else key, finding) for key, finding in of_sources), *(("", item) for item in said)])
        say(NOT_CHECKED)
    told = [*said, *(finding for inspection in inspections for finding in inspection.findings)]
    damaged = any(finding.severity == "damage" for finding in told)
    if suggest_mapping and damaged:
        err().print(
            "The draft is whole. A recording is damaged: inspect without --suggest-mapping says which, and how."
        )
    if failed or damaged:
        raise typer.Exit(1)


def _previews(sources: list[Any], mapping: Any) -> tuple[list[Any], dict[str, str]]:
    """Return the previews of readable sources, and the reasons of unreadable ones; a single one raises it."""
    from tactiledata.ingest.sources.preview import compared, preview

    previews, failed = [], {}
    for source in sources:
        try:
            previews.append(preview(source, mapping))
        except TactileDataError as error:
            if len(sources) == 1:
                raise
            failed[source.key] = str(error)
    return compared(previews), failed


def _drafted(inspections: list[Any], mapping: Any) -> tuple[Any, str]:
    """Return one mapping for all recordings that need one, as a document and as text; ``None`` where none does."""
    from tactiledata.formats import FORMATS

    mapped = [item for item in inspections if item.suggested_mapping is not None]
    alike = [item for item in mapped if item.source.format == mapped[0].source.format]
    return FORMATS[alike[0].source.format]().draft(alike, mapping) if alike else (None, "")


def _print_mapping(inspections: list[Any], failed: dict[str, str], mapping: Any, as_json: bool) -> None:
    """Print the draft of a mapping for all recordings, as YAML with remarks or as JSON; refuse those that need none."""
    for key, reason in failed.items():
        err().print(plain(f"{key}: cannot be read: {reason}"))
    draft, text = _drafted(inspections, mapping)
    if draft is not None and as_json:
        emit(draft)
    elif draft is not None:
        typer.echo(text, nl=False)
    elif inspections:
        source = inspections[0].source
        raise UsageError(
            f"{source.key} is a {source.format} recording, which needs no mapping",
            "a recording with topics, as MCAP files are",
            "Ingest the recording as it is.",
        )


def _document(item: Any) -> dict[str, Any]:
    """Return the preview of one source as a JSON object."""
    inspection, take = item.inspection, item.take
    return {
        "key": inspection.source.key,
        "format": inspection.source.format,
        "files": list(inspection.source.files),
        "facts": dict(inspection.facts),
        "topics": [vars(topic) for topic in inspection.topics],
        "findings": [vars(finding) for finding in inspection.findings],
        "suggested_mapping": inspection.suggested_mapping,
        "status": item.status,
        "trajectories": 0 if take is None else take.trajectories.num_rows,
        "frames": 0 if take is None else take.frames.num_rows,
    }


def _print_preview(item: Any) -> None:
    """Print facts and streams of one source, and what ingest would make of it."""
    from tactiledata.ingest.sources.reports import status_in_words

    inspection, take = item.inspection, item.take
    source = inspection.source
    say(f"{source.key}: {source.format}, {counted(len(source.files), 'file')}")
    for line in _fact_lines(inspection.facts):
        say(f"  {line}")
    rows = [
        (topic.name, topic.kind, topic.encoding, topic.messages, _rate(topic), topic.role or "-", topic.note)
        for topic in inspection.topics
    ]
    if rows:
        table("", ("stream", "kind", "encoding", "messages", "Hz", "read as", "note"), rows)
    for topic in inspection.topics:
        if topic.example:
            say(f"  {topic.name}: {topic.example}")
    if take is not None:
        made = f"{counted(take.trajectories.num_rows, 'trajectory')} and {counted(take.frames.num_rows, 'frame')}"
        say(f"  ingest would make: {made}, status {status_in_words(item.status, inspection.findings)}")


_FACTS = {"trajectories": "trajectories stated"}
"""Names of facts for people, where the machine's name says too little."""


def _print_summary(previews: list[Any], failed: Mapping[str, str]) -> None:
    """Print a line for each of several sources, behind all that was printed of each: what ingest would make of it."""
    from tactiledata.ingest.sources.reports import status_in_words

    rows: list[tuple[Any, ...]] = []
    for item in previews:
        source, take = item.inspection.source, item.take
        lasts = _duration(item.inspection.facts) or "-"
        made = ("-", "-") if take is None else (take.trajectories.num_rows, take.frames.num_rows)
        rows.append(
            (
                source.key,
                source.format,
                lasts,
                *made,
                status_in_words(item.status, item.inspection.findings) or "would not be read",
            )
        )
    rows += [(key, "-", "-", "-", "-", "cannot be read") for key in failed]
    table("", ("recording", "format", "duration, s", "trajectories", "frames", "status at ingest"), rows)


def _fact_lines(facts: Mapping[str, Any]) -> Iterator[str]:
    """Yield facts of a recording as lines: lists without brackets, how long it lasts, nothing of what is empty."""
    for name, value in facts.items():
        if value not in ("", None, []):
            yield f"{_FACTS.get(name, name)}: {', '.join(value) if isinstance(value, list) else value}"
    if duration := _duration(facts):
        yield f"duration: {duration} s"


def _duration(facts: Mapping[str, Any]) -> str:
    """Return how long a recording lasts, in seconds; empty where its facts do not say."""
    start, end = facts.get("start_ns"), facts.get("end_ns")
    return "" if start is None or end is None else f"{(end - start) / 1e9:.1f}"


def _rate(topic: Any) -> str:
    """Return the rate of a topic, Hz, in words."""
    if not topic.has_times:
        return "no times"
    return "-" if topic.rate is None else f"{topic.rate:.1f}"
