"""Trajectories that a description lists itself, where no table stands beside it, and the topics of a camera.

Shared by all formats, as `base` is: members of the family may import it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Trajectory

KNOWN = ("trajectory", "start_ns", "end_ns", "sensor", "indenter")
"""Columns and keys of a trajectory that have a meaning; all others are free."""


def camera_topics(entry: Mapping[str, Any]) -> list[str]:
    """Return the topics of a camera in a mapping, of which a recording has one."""
    topic = entry["topic"]
    return [str(name) for name in topic] if isinstance(topic, list) else [str(topic)]


def described_trajectories(description: LogDescription) -> list[Trajectory]:
    """The trajectories under ``trajectories`` in a log.yaml or a mapping, free keys kept."""
    return [
        Trajectory(
            entry["trajectory"],
            int(entry["start_ns"]),
            int(entry["end_ns"]),
            str(entry.get("sensor", "")),
            str(entry.get("indenter", "")),
            {key: value for key, value in entry.items() if key not in KNOWN},
        )
        for entry in description.document.get("trajectories", [])
    ]
