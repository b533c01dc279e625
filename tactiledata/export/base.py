"""What every format of exports offers: files that can be written one by one, and what it cannot keep."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from tactiledata.export.episodes import Episodes, FrameBatch
from tactiledata.export.plan import ExportPlan

FileFacts = Mapping[str, Any]
"""What a format notes of a file that it wrote, as JSON values; `Exporter.finish` gets them back, in order."""


@dataclass(frozen=True)
class ExportedFile:
    """One large file of an export, which is written as a whole.

    Parameters
    ----------
    path : str
        Inside the export's folder, with ``/``.
    start, stop : int
        Episodes (or recordings) that it holds: [start, stop).
    frames : int
        Frames that it holds, for progress.
    """

    path: str
    start: int
    stop: int
    frames: int


class Exporter(ABC):
    """A format. Equal stores and options give equal bytes.

    Attributes
    ----------
    name, title : str
        The word after ``--to``, and what it is, for people.
    at_frames : bool
        Whether it holds frames and the values at them, from which models learn: then a split must be named.
    lost : tuple of str
        Sentences that say what of a store the format does not keep.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    at_frames: ClassVar[bool] = True
    lost: ClassVar[Sequence[str]] = ()

    @abstractmethod
    def files(self, episodes: Episodes, plan: ExportPlan) -> Sequence[ExportedFile]:
        """Return the large files of an export, by tables alone; nothing is read but these."""

    @abstractmethod
    def write(self, episodes: Episodes, file: ExportedFile, path: Path, advance: Callable[[int], None]) -> FileFacts:
        """Write one large file and return what is noted of it.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        file : ExportedFile
            Which of it.
        path : Path
            Where the file is written; it counts only once this function has returned.
        advance : callable
            Called with the number of frames written since the last call.
        """

    def finish(  # noqa: B027 -- most formats have no small files, and leave it as it is
        self,
        episodes: Episodes,
        files: Sequence[ExportedFile],
        facts: Callable[[], Iterator[FileFacts]],
        folder: Path,
    ) -> None:
        """Write the small files that stand beside the large ones; none where a format needs none.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        files : sequence of ExportedFile
            The large files.
        facts : callable
            Gives what was noted of each of them, one after another.
        folder : Path
            Where the export is made.
        """

    @abstractmethod
    def kept_as(self, stream: str, episodes: Episodes) -> str:
        """Return the name under which the format keeps a stream."""

    @abstractmethod
    def snippet(self, episodes: Episodes, files: Sequence[ExportedFile]) -> str:
        """Return lines of Python that read the export, run beside it, by the format's own loader."""

    def remarks(self, episodes: Episodes) -> list[str]:
        """Return sentences that say what this export, beside what all of the format do, changes or derives."""
        return []

    def left_out(self, episodes: Episodes) -> dict[str, int]:
        """Return how many frames do not go out, by reason."""
        return dict(episodes.left_out)

    def front_matter(self, episodes: Episodes, files: Sequence[ExportedFile], key: str) -> str:
        """Return lines of YAML with which the page for people begins; empty for none.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        files : sequence of ExportedFile
            The large files.
        key : str
            Digest of all that decides the bytes.
        """
        return ""


def files_by_part(episodes: Episodes, largest: int, path: Callable[[str, int, int], str]) -> list[ExportedFile]:
    """Return files of some episodes each, none over two parts, whose pictures have about ``largest`` bytes.

    Parameters
    ----------
    episodes : Episodes
        What is exported.
    largest : int
        Bytes.
    path : callable
        Gives the path of a file: called with its part, its number within the part, and the number of files of the part.
    """
    groups = episodes.groups(largest)
    counts = Counter(episodes.parts[start] for start, _ in groups)
    before: Counter[str] = Counter()
    files = []
    for start, stop in groups:
        part = episodes.parts[start]
        frames = int(episodes.lengths[start:stop].sum())
        files.append(ExportedFile(path(part, before[part], counts[part]), start, stop, frames))
        before[part] += 1
    return files


def no_counts() -> dict[str, Any]:
    """Return what is noted of a file without frames: no values missing, no pictures made anew."""
    return {"missing": {}, "remade": 0}


def count(noted: dict[str, Any], batch: FrameBatch) -> None:
    """Add a batch to the notes of a file: frames of each part without a stream's value, and pictures made anew."""
    for name, values in batch.values.items():
        if lacking := int((~np.isfinite(values)).any(axis=1).sum()):
            of_parts = noted["missing"].setdefault(name, {})
            of_parts[batch.part] = of_parts.get(batch.part, 0) + lacking
    noted["remade"] += sum(not is_unchanged for _, _, is_unchanged in batch.pictures)
