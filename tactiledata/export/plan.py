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
