"""What every log format offers; a new format is one file with one such object and one line in the table."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from tactiledata.contract.records import Finding, Image, ImageSink, Recording, Source


@dataclass(frozen=True)
class TopicInfo:
    """One stream of a source: what `tactiledata inspect` prints.

    Parameters
    ----------
    name : str
        Topic or file.
    kind : str
        Message type or content.
    encoding : str
        How messages are encoded, for example ``"cdr/ros2msg"``.
    messages : int
    rate : float, optional
        Hz, from first to last message; ``None`` of a single message, and where there are no times.
    role : str
        What the toolkit would read it as: ``wrench``, ``tcp``, ``joints``, ``image:<camera>`` or empty.
    note : str
        Why it cannot be read, or what stands out.
    example : str
        A decoded message, shortened.
    has_times : bool
        Whether its stamps are times; of pictures without times they are mere numbers.
    """

    name: str
    kind: str
    encoding: str
    messages: int
    rate: float | None = None
    role: str = ""
    note: str = ""
    example: str = ""
    has_times: bool = True


@dataclass(frozen=True)
class Inspection:
    """What a source holds.

    ``suggested_mapping`` is a document that fits ``schemas/mapping.json``; ``None`` where the format needs no mapping.
    ``suggested_text`` is the same as YAML, with remarks and alternatives in comments. ``recording`` is what
    `read` would give, from which ingest's checks are made; ``None`` where the format does not give it here, or `read`
    would refuse. ``grounds`` is what `Format.draft` makes one mapping of several recordings from.
    """

    source: Source
    topics: tuple[TopicInfo, ...]
    findings: tuple[Finding, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    suggested_mapping: Mapping[str, Any] | None = None
    suggested_text: str = ""
    recording: Recording | None = None
    grounds: object = None


class NoSink:
    """Takes pictures that nobody wants to keep."""

    def add(self, image: Image) -> None:
        """Let it go."""


class Format(ABC):
    """A way in which recordings are kept on disk.

    Members are stateless. They read what is there, report what is wrong as findings, and raise `BrokenLog` only where
    nothing can be read. They never write, never execute, and never follow a path out of the source's folder.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    layout: ClassVar[str]
    """One or more lines that show how the files lie, for `tactiledata formats` and the docs."""
    licence_note: ClassVar[str] = ""
    """What a user of a public corpus must know before redistributing."""
    judges_whole_folders: ClassVar[bool] = False
    """Whether `sniff` claims a folder only where all that lies in it may lie beside recordings of this format. Of a
    folder that another format claims, what lies beside its recordings is searched for others."""
    takes_subfolders: ClassVar[bool] = True
    """Whether a folder that is a recording takes the folders below it; else they are searched for others."""

    @abstractmethod
    def sniff(self, path: Path) -> bool:
        """Whether this file or folder is of this format, judged by content; never claims another format's files."""

    @abstractmethod
    def sources(self, path: Path) -> Sequence[Source]:
        """The recordings in a file or folder that `sniff` accepted, in natural order, without reading their data."""

    @abstractmethod
    def read(self, source: Source, sink: ImageSink, mapping: Mapping[str, Any] | None = None) -> Recording:
        """A recording, its images pushed into ``sink`` as they are met.

        Parameters
        ----------
        source : Source
            One of `sources`.
        sink : ImageSink
        mapping : dict, optional
            A document that fits ``schemas/mapping.json``.

        Raises
        ------
        BrokenLog
            Nothing can be read from it.
        """

    @abstractmethod
    def inspect(
        self, source: Source, mapping: Mapping[str, Any] | None = None, sink: ImageSink | None = None
    ) -> Inspection:
        """What the source holds, for a person who wonders what is in a file.

        Parameters
        ----------
        source : Source
            One of `sources`.
        mapping : dict, optional
            A document that fits ``schemas/mapping.json``.
        sink : ImageSink, optional
            Takes the images in their order; those that were not opened come without bytes.
        """

    def draft(
        self, inspections: Sequence[Inspection], mapping: Mapping[str, Any] | None = None
    ) -> tuple[Mapping[str, Any] | None, str]:
        """One mapping to start from for several recordings, as a document and as text; ``None`` where none is needed.

        Parameters
        ----------
        inspections : sequence of Inspection
            Made by `inspect`.
        mapping : dict, optional
            The mapping by which they were made.
        """
        return None, ""
