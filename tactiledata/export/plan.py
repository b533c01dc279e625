"""What decides the bytes of an export: a store, a format and options, under one digest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tactiledata import __version__
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import UsageError

MEGABYTE = 10**6
LARGEST_FILE_MB = 2000
"""Parquet pages and tar headers count bytes in 32 bits; a larger file gains nothing."""
NO_SPLIT = "none"
"""Said in the place of a split's name: everything goes out, unparted."""
NO_ACTION = "none"
USUAL_ACTION = "tcp"


@dataclass(frozen=True)
class ExportPlan:
    """The options of an export.

    Parameters
    ----------
    to : str
        Name of the format.
    split : str
        Name of the split; ``"none"`` for all trajectories, unparted; empty where the format needs none.
    camera : str
        Empty: the only one.
    streams : tuple of str, optional
        ``None``: all values at the frames, and all that a corpus annotates.
    action : str
        Stream whose value at the next frame is the action; ``"none"`` for no action, empty for the pose where there is
        one.
    file_mb : int
        Size, in 10^6 bytes, at which a file ends and the next begins.
    """

    to: str
    split: str = ""
    camera: str = ""
    streams: tuple[str, ...] | None = None
    action: str = ""
    file_mb: int = 100

    def __post_init__(self) -> None:
        if not 1 <= self.file_mb <= LARGEST_FILE_MB:
            raise UsageError(f"--file-mb {self.file_mb}", f"a size from 1 to {LARGEST_FILE_MB}, in 10^6 bytes")

    def require_frames(self, at_frames: bool) -> None:
        """Refuse choices of frames and values for a format that keeps whole recordings.

        Raises
        ------
        UsageError
            A camera, streams or an action are named, and the format is no format of frames.
        """
        chosen = {"--camera": self.camera, "--streams": self.streams, "--action": self.action}
        named = [option for option, value in chosen.items() if value]
        if named and not at_frames:
            raise UsageError(
                f"{', '.join(named)} with --to {self.to}, which keeps whole recordings",
                "no choice of cameras or values",
                f"Leave {' and '.join(named)} out.",
            )

    def unlike(self, document: Mapping[str, Any], store_digest: str, split: Mapping[str, Any] | None) -> list[str]:
        """Say in what a finished export differs from one by this plan, as far as its document tells.

        Parameters
        ----------
        document : dict
            That of the finished export.
        store_digest : str
            Digest of the store's content.
        split : dict, optional
            The document of the split.
        """
        made = document["provenance"]
        differing = []
        if made["version"] != __version__:
            differing.append(f"it was made by tactiledata {made['version']}")
        if document["store"]["digest"] != store_digest:
            differing.append("the store holds something else by now, or it is another store")
        for name, wanted in self.document().items():
            if name != "split" and (there := made["settings"].get(name)) != wanted:
                differing.append(f"--{name.replace('_', '-')} is {_option(wanted)} and was {_option(there)}")
        differing += _unlike_split(document["split"], split)
        return differing or ["recordings were replaced or flags were set since, in the same store"]

    def document(self) -> dict[str, Any]:
        """Return the options as JSON values."""
        return {**vars(self), "streams": None if self.streams is None else list(self.streams)}

    def key(
        self,
        store_digest: str,
        row_state: tuple[int, int, str],
        split: Mapping[str, Any] | None,
        flags: Mapping[str, str],
    ) -> str:
        """Return the digest of all that decides the bytes of the export.

        Parameters
        ----------
        store_digest : str
            Digest of the store's content.
        row_state : (int, int, str)
            What decides which row is which.
        split : dict, optional
            The document of the split.
        flags : dict, uid -> str
            Reasons for which trajectories are flagged; they are no part of the store's digest.
        """
        return digest_of(
            {
                "version": __version__,
                "plan": self.document(),
                "store": store_digest,
                "rows": list(row_state),
                "split": None if split is None else {**split, "provenance": None},
                "flags": dict(flags),
            }
        )


def _option(value: object) -> str:
    """Return an option of an export as a person types it."""
    if isinstance(value, list | tuple):
        return ",".join(map(str, value))
    return str(value) if value not in (None, "") else "left out"


def _unlike_split(there: Mapping[str, Any] | None, wanted: Mapping[str, Any] | None) -> list[str]:
    """Say how the split of a finished export differs from the one that is wanted."""
    if there is None or wanted is None:
        return [] if there == wanted else ["--split is " + ("another" if wanted else "none, and was not")]
    if there["name"] != wanted["name"]:
        return [f"--split is {wanted['name']} and was {there['name']}"]
    if there["table"]["sha256"] != wanted["table"]["sha256"]:
        return [f"the split {wanted['name']} has other parts"]
    options = [
        f"{name} {wanted['options'].get(name)} instead of {there['options'].get(name)}"
        for name in sorted({*there["options"], *wanted["options"]})
        if there["options"].get(name) != wanted["options"].get(name)
    ]
    if options:
        return [f"the split {wanted['name']} has the same parts and was drawn with {', '.join(options)}"]
    if {**there, "provenance": None} != {**wanted, "provenance": None}:
        return [f"the split {wanted['name']} has the same parts and was drawn again, with other remarks or counts"]
    return []
