"""What a store holds, as a picture and a page for people: gathered here, drawn by `report`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tactiledata import __version__
from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.records import Finding
from tactiledata.contract.take import UNUSABLE
from tactiledata.contract.wording import counted, listed
from tactiledata.formats.mcap.passed_over import TOPIC_LEFT
from tactiledata.ingest.checks.beside import all_findings
from tactiledata.ingest.sources.first_program import first_program
from tactiledata.report.finding_words import codes_section
from tactiledata.report.page import Picture, Section, render_page
from tactiledata.report.panels import panels_of
from tactiledata.report.plots import TouchPicture, draw_touches, png_bytes
from tactiledata.splits.again import command
from tactiledata.splits.audit import parts_without
from tactiledata.splits.flagged import SHOWN, flagged_in_parts
from tactiledata.splits.manifest import coverage_problem, read_split, read_split_document
from tactiledata.splits.options import EXCLUDED, PARTITIONS
from tactiledata.splits.suggest import suggest_split
from tactiledata.store.read.flags import flag_words, flagged_trajectories
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.overview import overview, shown_rate
from tactiledata.store.read.reader import Store
from tactiledata.store.read.recording_names import recording_names
from tactiledata.store.read.simulated import simulated_recordings, touch_mark
from tactiledata.units import SIGNAL_COLUMNS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CONTACT_WRENCH = "contact_wrench"
"""Name of the signal whose force is drawn."""
MAX_TOUCHES = 6
MOST_FLAGS = 60
"""Flagged trajectories that the page lists."""
MOST_NAMED = 6
"""Recordings that the page names of each camera."""
WORST_FIRST = {"damage": 0, "warning": 1, "info": 2}


def write_report(store: Store, out: Path, split: str = "default", further: Sequence[Section] = ()) -> dict[str, Path]:
    """The page ``report.html`` and the picture ``recorded.png`` of a store, in a folder.

    Parameters
    ----------
    store : Store
    out : Path
        Made where it is not there.
    split : str
        Described where the store has it.
    further : sequence of Section
        What others have to say of the store, before its use.

    Returns
    -------
    dict
        ``"page"`` and ``"picture"``.
    """
    pictures = {"page": out / "report.html"}
    touches = choose_touches(store)
    picture = None
    if touches:
        figure, caption = draw(touches)
        picture = panels_of(figure, caption)
        png = png_bytes(figure, heading=simulated_recordings(store).heading, has_legend=True)
        pictures["picture"] = out / "recorded.png"
        write_atomic(pictures["picture"], png)
    write_atomic(pictures["page"], page(store, picture, split, further).encode())
    return pictures


def choose_touches(store: Store) -> list[TouchPicture]:
    """Touches to show: of each pair of sensor and indenter the firmest, as different as six can be."""
    table = store.trajectories(["sensor", "indenter", "peak_force", "frame_start", "frame_stop"]).to_pandas()
    table = table[table["frame_stop"] > table["frame_start"]]
    firmest = table.sort_values("peak_force", ascending=False, kind="stable", na_position="last")
    firmest = firmest.drop_duplicates(["sensor", "indenter"])
    # in turn: every new sensor and every new indenter before any is shown again
    chosen: list[int] = []
    rows = list(firmest.itertuples())
    while rows and len(chosen) < MAX_TOUCHES:
        sensors, indenters = ({getattr(table.loc[row], name) for row in chosen} for name in ("sensor", "indenter"))
        best = min(rows, key=lambda row: ((row.sensor in sensors) + (row.indenter in indenters), row.Index))
        rows.remove(best)
        chosen.append(int(best.Index))
    return [picture for picture in (touch_picture(store, row) for row in chosen) if picture is not None]


def touch_picture(store: Store, row: int) -> TouchPicture | None:
    """The picture of one trajectory; ``None`` where it has no image that can be shown."""
    trajectory = store.trajectories().slice(row, 1).to_pylist()[0]
    start, stop = trajectory["frame_start"], trajectory["frame_stop"]
    frames = store.frames(["t_ns", "contact_force", "flags", "sensor"]).slice(start, stop - start)
    usable = (frames["flags"].to_numpy() & UNUSABLE) == 0
    if not usable.any():
        return None
    force = np.where(usable, frames["contact_force"].to_numpy(), np.nan)
    middle = np.flatnonzero(usable)[usable.sum() // 2]
    shown = int(np.nanargmax(force) if np.isfinite(force).any() else middle)
    t_ns = frames["t_ns"].to_numpy()
    reference = store.references().get(frames["sensor"][shown].as_py())
    seconds, samples, force_frame = np.zeros(0), np.zeros((0, 3)), ""
    for name, (first, last) in json.loads(trajectory["signal_rows"]).items():
        # one that means something else than the store's first is kept as contact_wrench@…
        if name not in store.signal_names or name.partition("@")[0] != CONTACT_WRENCH:
            continue
        signal = store.signal(name)
        if tuple(signal.columns) != SIGNAL_COLUMNS[CONTACT_WRENCH]:
            continue
        seconds = (signal.t_ns(first, last) - trajectory["start_ns"]) / 1e9
        samples, force_frame = signal.values(first, last)[:, :3], signal.frame
    names = [trajectory["sensor"], trajectory["indenter"] or "(not named)", full_names(store)[row]]
    title = ", ".join([*names, *filter(None, [touch_mark(store, row)])])
    return TouchPicture(
        title=title,
        background=None if reference is None else reference.image,
        image=store.images([start + shown])[0],
        seconds=seconds,
        force=samples,
        force_frame=force_frame,
        frame_seconds=(t_ns - trajectory["start_ns"]) / 1e9,
        shown_second=(int(t_ns[shown]) - trajectory["start_ns"]) / 1e9,
    )


def draw(touches: Sequence[TouchPicture]) -> tuple[Figure, str]:
    """The picture of touches, and its caption, which names only what is there."""
    if any(touch.has_force for touch in touches):
        shown = (
            "The firmest touches, one per sensor and indenter: the sensor without contact, at the largest force, the "
            "difference (doubled, grey is none), and the contact force. Ticks mark images, and the dotted line marks "
            "the image that is shown."
        )
    else:
        shown = (
            "Touches, one per sensor and indenter: the sensor without contact, in the middle of the touch, and the "
            "difference (doubled, grey is none)."
        )
    return draw_touches(touches), shown


def page(store: Store, picture: Picture | None, split: str, further: Sequence[Section] = ()) -> str:
    """Return the report on a store, "What was recorded", as HTML that stands alone.

    Parameters
    ----------
    store : Store
        The store that is described.
    picture : Picture, optional
        Recorded touches as drawn; ``None`` where nothing was drawn.
    split : str
        Name of the split that is described.
    further : sequence of Section
        Sections of other parts of the toolkit, placed before the last one, on how to use the store.
    """
    facts, found = overview(store), all_findings(store)
    sentences = [
        f"The store {Path(str(store.location)).name} holds {counted(facts['sources'], 'recording')} with "
        f"{counted(facts['trajectories'], 'trajectory')} and {counted(facts['frames'], 'image')} of "
        f"{counted(len(facts['by_sensor']), 'sensor')} and "
        f"{counted(len([name for name in facts['by_indenter'] if name]), 'indenter')}.",
        _status_sentence(facts["status"], facts["findings"].get(TOPIC_LEFT, {"sources": 0})["sources"]),
    ]
    sections = [
        _recorded(picture),
        _cameras(facts),
        _counts(facts),
        _signals(facts),
        _findings(store, found),
        _flagged(store),
        _split(store, split),
        *further,
        codes_section(finding.code for _, finding in found),
        _use(store, split),
    ]
    footer = f"tactiledata {__version__}; store digest {store.digest}"
    return render_page(
        "What was recorded",
        sentences,
        [section for section in sections if section],
        footer,
        simulated_recordings(store),
    )


def _status_sentence(status: dict[str, int], left: int) -> str:
    words = {
        "ok": ("is whole", "are whole"),
        "unverified": ("has no checksums and could not be verified", "have no checksums and could not be verified"),
        "damaged": ("lost data to damage, and what is whole was kept",) * 2,
    }
    said = [f"{counted(count, 'recording')} {words[name][count != 1]}" for name, count in sorted(status.items())]
    unread = f" A wrench, tcp or images of {counted(left, 'recording')} were not read: see what the checks found."
    return f"{'; '.join(said)}.{unread if left else ''}"


def _recorded(picture: Picture | None) -> Section | None:
    return None if picture is None else Section("Touches", pictures=[picture])


def _counts(facts: dict) -> Section:
    rows = [("sensor", name, row["trajectories"], row["frames"]) for name, row in facts["by_sensor"].items()]
    rows += [
        ("indenter", name or "(not named)", row["trajectories"], row["frames"])
        for name, row in facts["by_indenter"].items()
    ]
    return Section("Sensors and indenters", columns=("", "name", "trajectories", "images"), rows=rows)


def _cameras(facts: dict) -> Section | None:
    rows = [(name, row["frames"], listed(row["recordings"], MOST_NAMED)) for name, row in facts["by_camera"].items()]
    return Section("Cameras", columns=("camera", "images", "recordings"), rows=rows) if rows else None


def _signals(facts: dict) -> Section | None:
    rows = [
        (
            name,
            " ".join(row["columns"]),
            row["frame"] or "not stated",
            row["samples"],
            shown_rate(row["rate_hz"]),
            shown_rate(row["effective_rate_hz"]),
        )
        for name, row in facts["signals"].items()
    ]
    columns = ("signal", "columns", "frame", "samples", "Hz", "changes at Hz while moving")
    return Section("Signals", columns=columns, rows=rows) if rows else None


def _findings(store: Store, found: Sequence[tuple[int, Finding]]) -> Section:
    keys = recording_names(store)
    ranked = sorted(found, key=lambda item: (WORST_FIRST[item[1].severity], item[1].code, item[0]))
    sentences: list[tuple[str, str]] = [
        (finding.severity, f"{finding.severity}: {keys[source]}: {finding.message} [{finding.code}]")
        for source, finding in ranked[:60]
    ]
    if len(ranked) > 60:
        sentences.append(("", f"… and {len(ranked) - 60} more: tactiledata info --json"))
    return Section("What the checks found", sentences=sentences or [("", "The checks found nothing.")])


def _flagged(store: Store) -> Section | None:
    flags = list(flagged_trajectories(store).values())
    if not flags:
        return None
    sentences: list[tuple[str, str]] = [
        ("", f"A person called {counted(len(flags), 'trajectory')} bad. Splits leave out what is flagged."),
        *(("warning", flag.words) for flag in flags[:MOST_FLAGS]),
    ]
    if len(flags) > MOST_FLAGS:
        sentences.append(("", f"… and {len(flags) - MOST_FLAGS} more: tactiledata flag --list"))
    return Section("Flagged trajectories", sentences=sentences)


def _split(store: Store, split: str) -> Section:
    document = read_split_document(store, split) if split in store.split_names() else None
    if document is None:
        suggested = suggest_split(store)
        none = [("warning", "There is no split yet. Draw one before you train on this store.")]
        if suggested.command:
            return Section("Split", sentences=none, code=[suggested.command])
        return Section("Split", sentences=[*none, ("warning", f"No split can be drawn yet: {suggested.reason}")])
    counts = document["counts"]
    rows = [(part, counts[part]["trajectories"], counts[part]["frames"]) for part in (*PARTITIONS, EXCLUDED)]
    held = "; ".join(f"{kind} {', '.join(names)}" for kind, names in document["held_out"].items() if names)
    code: list[str] = []
    sentences = [
        ("", f"The split {split!r} divides whole trajectories. Held out for test_unseen: {held or 'nothing'}.")
    ]
    loaded = read_split(store, split)
    taken = sum(counts[part]["frames"] for part in PARTITIONS)
    filtered = f" with a contact force of {loaded.force[0]:g} to {loaded.force[1]:g} N" if loaded.force else ""
    sentences.append(("info", f"It takes whole images{filtered}: its parts hold {taken:,} of {store.n_frames:,}."))
    sentences += [(finding.severity, f"{finding.message}.") for finding in parts_without(store, loaded)]
    if flags := flagged_in_parts(store, loaded):
        words = f"Flagged since it was drawn: {flag_words(flags, SHOWN)}. Draw it again, which leaves them out."
        sentences.append(("warning", words))
        code = [command(str(store.location), split, document["options"])]
    if problem := coverage_problem(loaded, store.trajectories(["uid"])["uid"]):
        again = "Draw it again; until then it cannot be loaded."
        sentences.append(("warning", f"The split is out of date: {problem}. {again}"))
        code = [command(str(store.location), split, document["options"])]
    return Section("Split", sentences=sentences, columns=("part", "trajectories", "images taken"), rows=rows, code=code)


def _use(store: Store, split: str) -> Section:
    return Section("Use it", code=[first_program(store, split)])
