"""How importers hand over what they read: images one by one, values that belong to images, findings with counts.

Shared by the family, as `base` is: members may import it.
"""

from __future__ import annotations

import math
import tempfile
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.image_bytes import read_header, size_fault
from tactiledata.contract.lfs_pointer import fault_words
from tactiledata.contract.picture_kinds import remarks_on
from tactiledata.contract.records import Finding, FrameValues, Image, ImageSink, Severity
from tactiledata.errors import BrokenLog

MEMORY_LIMIT = 64 * 2**20
"""Bytes of values of one kind beyond which they wait in a temporary file instead of in memory."""

MOST_OPENED = 200
"""Images of each camera that `inspect` opens: a small recording wholly, and little of a corpus."""

Payload = Callable[[], "bytes | NDArray[np.uint8]"]
"""What gives an image's bytes as they came, or its pixels (H, W, 3), RGB, when it is called."""


@dataclass
class _Column:
    columns: tuple[str, ...]
    units: tuple[str, ...]
    note: str
    rows: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))
    spool: Any = None

    def add(self, row: int, values: Sequence[float] | NDArray[np.float64]) -> None:
        if len(values) != len(self.columns):
            raise ValueError(f"{len(values)} values for {len(self.columns)} columns")
        self.rows.append(row)
        self.values.frombytes(np.asarray(values, dtype=np.float64).tobytes())
        if len(self.values) * 8 > MEMORY_LIMIT:
            self._spill()

    def _spill(self) -> None:
        if self.spool is None:
            self.spool = tempfile.TemporaryFile()  # noqa: SIM115  lives as long as the values that are mapped from it
        self.spool.write(self.values.tobytes())
        self.values = array("d")

    def dense(self, count: int) -> FrameValues:
        width = len(self.columns)
        rows = np.frombuffer(self.rows, dtype=np.int64) if self.rows else np.zeros(0, dtype=np.int64)
        if self.spool is None:
            given = np.frombuffer(self.values, dtype=np.float64) if self.values else np.zeros(0)
            given = given.reshape(-1, width)
        else:
            self._spill()
            self.spool.flush()
            given = np.memmap(self.spool, dtype=np.float64, mode="r", shape=(len(rows), width))
            self.spool.close()
        is_whole = len(rows) == count and (rows == np.arange(count)).all()
        return FrameValues(given if is_whole else _spread(given, rows, count), self.columns, self.units, self.note)


def _spread(given: NDArray[np.float64], rows: NDArray[np.int64], count: int) -> NDArray[np.float64]:
    """Values (count, k) that are ``given`` in some rows and NaN in the others."""
    shape = (count, given.shape[1])
    whole: NDArray[np.float64]
    if math.prod(shape) * 8 > MEMORY_LIMIT:
        with tempfile.TemporaryFile() as backing:
            whole = np.memmap(backing, dtype=np.float64, mode="w+", shape=shape)
    else:
        whole = np.empty(shape)
    whole[:] = np.nan
    whole[rows] = given
    return whole


class Intake:
    """What a reader hands over: images one by one into the sink, values of images, findings with their counts.

    Parameters
    ----------
    sink : ImageSink
        Where images go.
    is_looking : bool
        Whether only the first ``MOST_OPENED`` images of each camera are opened (`inspect`); the others go to the sink
        without bytes, with the kind and size of the one before.
    """

    def __init__(self, sink: ImageSink, is_looking: bool = False) -> None:
        self._sink, self._is_looking = sink, is_looking
        self._opened: dict[str, Image] = {}
        self._findings: dict[tuple[str, str, str], Finding] = {}
        self._columns: dict[str, _Column] = {}
        self.cameras: dict[str, list[Any]] = {}  # name -> [images, first time, last time, example]
        self.images = 0

    def note(
        self, code: str, severity: Severity, message: str, stream: str = "", trajectory: str = "", count: int = 1
    ) -> None:
        """A finding; of the same code, stream and trajectory the first message is kept and the counts are added.

        Parameters
        ----------
        code : str
            Code of the finding.
        severity : str
            How bad it is.
        message : str
            Its text.
        stream, trajectory : str
            What it is about; empty where it is about the whole recording.
        count : int
            How many times it was found.
        """
        place = (code, stream, trajectory)
        known = self._findings.get(place)
        if known is None:
            self._findings[place] = Finding(code, severity, message, stream, trajectory, count=count)
        else:
            self._findings[place] = replace(known, count=known.count + count)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was noted, with ``(n times)`` where it was met more than once."""
        return tuple(
            found if found.count == 1 else replace(found, message=f"{found.message} (count {found.count})")
            for found in self._findings.values()
        )

    def declare(self, name: str, columns: tuple[str, ...], units: tuple[str, ...], note: str = "") -> None:
        """A kind of values that images carry.

        Parameters
        ----------
        name : str
            Of the kind of values.
        columns : tuple of str
            Names of its columns.
        units : tuple of str
            Their units; "1" for a number without one.
        note : str
            What the values are and where they come from.
        """
        self._columns.setdefault(name, _Column(columns, units, note))

    def width(self, name: str) -> int:
        """How many columns values of this name have, 0 where it was not declared."""
        return len(self._columns[name].columns) if name in self._columns else 0

    def image(
        self,
        camera: str,
        payload: Payload | None,
        t_ns: int,
        *,
        sensor: str = "",
        trajectory: str = "",
        name: str = "",
        values: Mapping[str, Sequence[float] | NDArray[np.float64]] | None = None,
    ) -> None:
        """One image (or, without a payload, a moment whose image is not there), with the values that belong to it.

        Parameters
        ----------
        camera : str
            Name of the camera.
        payload : callable, optional
            Gives the image's bytes, or its pixels (height, width, 3), RGB; ``None`` where only the moment is known.
        t_ns : int
            Its moment, ns.
        sensor : str
            Serial of the sensor that took it.
        trajectory : str
            The touch that it belongs to; empty where it belongs to none.
        name : str
            The image's name in the recording.
        values : dict of (c,), optional
            Values that belong to the image, by a declared name.
        """
        for kind, row in (values or {}).items():
            self._columns[kind].add(self.images, row)
        seen = self.cameras.setdefault(camera, [0, t_ns, t_ns, ""])
        seen[0] += 1
        seen[2] = t_ns
        self.images += 1
        if self._is_looking and seen[0] > MOST_OPENED and payload is not None:
            opened = self._opened.get(camera, Image(camera, b"", "missing", 0, 0, t_ns))
            self._sink.add(replace(opened, log_ns=t_ns, sensor=sensor, trajectory=trajectory, name=name))
            return
        image = self._made(camera, payload, t_ns, sensor, trajectory, name)
        if seen[0] == 1:
            seen[3] = f"{image.encoding} {image.height} x {image.width}, {name}"
        if image.payload and self._is_looking:
            self._opened[camera] = replace(image, payload=b"")
        self._sink.add(image)

    def not_opened(self) -> int:
        """How many images went to the sink unopened."""
        return sum(max(seen[0] - MOST_OPENED, 0) for seen in self.cameras.values()) if self._is_looking else 0

    def _made(self, camera: str, payload: Payload | None, t_ns: int, sensor: str, trajectory: str, name: str) -> Image:
        missing = Image(camera, b"", "missing", 0, 0, t_ns, sensor=sensor, trajectory=trajectory, name=name)
        if payload is None:
            return missing
        try:
            content = payload()
        except OSError as error:
            self.note("image-unreadable", "damage", f"{name} cannot be opened ({error.strerror})", camera, trajectory)
            return missing
        if isinstance(content, np.ndarray):
            return self._raw(content, missing)
        try:
            header = read_header(content)
        except BrokenLog as error:
            self.note("image-unreadable", "damage", f"{name}: {fault_words(error)}", camera, trajectory)
            return missing
        remarks = remarks_on(header, content)
        for remark in remarks:
            self.note(remark.code, remark.severity, f"{name} {remark.words}", camera)
        if any(remark.is_lost for remark in remarks):
            return missing
        if not header.is_complete:
            self.note("image-truncated", "damage", f"{name} ends before its end mark", camera, trajectory)
        return replace(missing, payload=content, encoding=header.encoding, height=header.height, width=header.width)

    def _raw(self, pixels: NDArray[np.uint8], missing: Image) -> Image:
        if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
            found = f"{missing.name} is an array of shape {pixels.shape} and type {pixels.dtype}"
            self.note("image-unreadable", "damage", found, missing.camera, missing.trajectory)
            return missing
        height, width = pixels.shape[:2]
        if fault := size_fault(height, width):
            self.note("image-too-large", "damage", f"{missing.name} is not taken: its {fault}", missing.camera)
            return missing
        return replace(missing, payload=pixels.tobytes(), encoding="raw", height=height, width=width)

    def frame_values(self) -> dict[str, FrameValues]:
        """All values of images, dense, NaN where an image has none."""
        return {name: column.dense(self.images) for name, column in self._columns.items()}
