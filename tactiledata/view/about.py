"""What a person should know of a trajectory that is shown, in words beside the pictures."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from datetime import UTC, datetime

from tactiledata.store.read.meshes import StoredMesh
from tactiledata.view.touch import ViewedTouch

ABOUT = "about"
"""The entity of the words."""
ABSOLUTE_NS = 10**18
"""Times from here on are moments of the calendar; earlier ones count from the start of a recording or a machine."""
SPECIAL = re.compile(r"([\\`*_{}\[\]()#+\-.!|<>~])")


def about(
    touch: ViewedTouch, location: str, mesh: StoredMesh | None, largest_move: float, missing: Sequence[str]
) -> str:
    """Markdown on one trajectory: what it is, what is missing, how to read the panes, how to flag it.

    Parameters
    ----------
    touch : ViewedTouch
    location : str
        Path or URL of the store.
    mesh : StoredMesh, optional
        The mesh that is shown.
    largest_move : float, m
        Largest displacement of the gel in the trajectory.
    missing : sequence of str
        What is not there, a sentence each.
    """
    lines = [f"# {plain(touch.name)}", ""]
    if touch.flag is not None:
        lines += [f"**Flagged as bad:** {plain(touch.flag.words)}", ""]
    if touch.kind == "simulated":
        lines += ["**Simulated recording.** Dots are what the simulated rig measured.", ""]
    elif touch.kind == "real":
        lines += ["Real recording.", ""]
    if touch.facts["parent"]:
        lines += [f"**Synthetic:** made from the trajectory {plain(touch.facts['parent'])}; nobody recorded it.", ""]
    lines += [
        f"- sensor: {plain(touch.facts['sensor'] or 'not named')}",
        f"- indenter: {plain(touch.facts['indenter'] or 'not named')}",
        f"- uid: {touch.uid}",
        f"- {touch.seconds:.2f} s long, from {(touch.start_ns - touch.log_ns) / 1e9:.2f} s of its log"
        f"{_calendar(touch)}",
        f"- store: {plain(location)}",
    ]
    if mesh is not None:
        lines.append(f"- mesh: {plain(mesh.name)}, {mesh.settings['fidelity']}")
    lines += ["", "## How to read it", "", *(f"- {line}" for line in _legend(largest_move))]
    if missing:
        lines += ["", "## What is not here", "", *(f"- {plain(sentence)}" for sentence in missing)]
    # a line break in a name must not end the block of code
    command = shlex.join(["tactiledata", "flag", location, touch.uid, "--reason"]).replace("\n", "\n    ")
    lines += ["", "## Is it bad?", "", "Splits leave flagged trajectories out:", "", f'    {command} "..."', ""]
    return "\n".join(lines)


def _legend(largest_move: float) -> list[str]:
    lines = [
        "measured values are dots, simulated ones are lines; x red, y green, z blue",
        "time lines: `trajectory` counts seconds from its start, `log` from the start of its recording",
        "difference: twice the change against the sensor without contact; grey is none",
        "contact mask: orange where the picture shows a contact",
        "forces and torques are in the gel frame, unless the legend names another: pressing gives fz > 0",
        "residual: measured minus simulated force at the moments of the frames",
        "pose: how far the tool moved in the base frame, and by which angle it turned, since the start",
    ]
    if largest_move:
        lines.append(f"gel: dark is at rest, yellow has moved {1e3 * largest_move:.2f} mm; orange points are pressed")
        lines.append("the indenter stands where it was recorded")
    return lines


def _calendar(touch: ViewedTouch) -> str:
    """The start on the calendar, where the clock tells it."""
    if touch.start_ns < ABSOLUTE_NS:
        return ""
    return f", {datetime.fromtimestamp(touch.start_ns / 1e9, UTC):%Y-%m-%d %H:%M:%S} UTC"


def plain(text: str) -> str:
    """A text of any origin for Markdown: it is shown as it is, on one line, and steers nothing."""
    return SPECIAL.sub(r"\\\1", " ".join(text.split()))
