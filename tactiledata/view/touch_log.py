"""One trajectory as a rerun recording: every value on the time lines of the trajectory and of its log."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np

from tactiledata.arrays import Array, Times
from tactiledata.view.rerun_package import load_rerun
from tactiledata.view.touch import ViewedTouch

TRAJECTORY_TIME, LOG_TIME = "trajectory", "log"
"""Time lines: seconds since the start of the trajectory, and since the first frame or sample of its recording."""
COLOURS = ((192, 57, 43), (30, 132, 73), (44, 90, 160))
"""Colours of x, y and z: those of the other pages."""
OTHER_COLOURS = ((120, 120, 120), (142, 68, 173), (211, 132, 0), (0, 128, 128))
DOT, LINE = 2.0, 2.0
"""Sizes, in points of the screen, of a dot of measured values and of a line of simulated ones."""


class TouchLog:
    """Writes into the rerun recording of one trajectory.

    Parameters
    ----------
    stream : rerun.RecordingStream
    touch : ViewedTouch
    file : BinaryIO
        Receives the encoded recording. rerun's own thread that writes a file waits for ever where a disk is full.
    """

    def __init__(self, stream: Any, touch: ViewedTouch, file: BinaryIO) -> None:
        self.stream, self.touch, self._rr = stream, touch, load_rerun()
        self._encoded, self._file = stream.binary_stream(), file

    def flush(self) -> None:
        """Write all that was put so far to the file; it leaves the memory.

        Raises
        ------
        OSError
            The disk is full.
        """
        self._file.write(self._encoded.read() or b"")

    def at(self, t_ns: int) -> None:
        """What is put from now on belongs to a moment, ns, host clock."""
        for line, start in ((TRAJECTORY_TIME, self.touch.start_ns), (LOG_TIME, self.touch.log_ns)):
            self.stream.set_time(line, duration=np.timedelta64(int(t_ns) - start, "ns"))

    def put(self, entity: str, *archetypes: Any) -> None:
        """Put something at the moment that was named last."""
        self.stream.log(entity, *archetypes)

    def put_static(self, entity: str, *archetypes: Any) -> None:
        """Put something that belongs to all moments."""
        self.stream.log(entity, *archetypes, static=True)

    def clear(self, entity: str) -> None:
        """Take an entity away from the moment that was named last: without this, the one before would stay."""
        self.stream.log(entity, self._rr.Clear(recursive=True))

    def curves(
        self, entity: str, names: Sequence[str], t_ns: Times, values: Array, simulated: bool, note: str = ""
    ) -> None:
        """Put curves over time, one entity for each: dots where they are measured, lines where they are simulated.

        Parameters
        ----------
        entity : str
            The entity above them.
        names : (k,) str
            Their names; one that is x, y or z of something has that colour.
        t_ns : (n,) ns, host clock
        values : (n, k)
            NaN where there is no value: no dot, a gap in a line.
        simulated : bool
        note : str
            What stands behind each name in the legend.
        """
        rr = self._rr
        for column, name in enumerate(names):
            place = f"{entity}/{rr.escape_entity_path_part(name)}"
            label = f"{name} {note}".strip()
            colour = _colour(name, column)
            if simulated:
                style = rr.SeriesLines(colors=[colour], widths=[LINE], names=[label])
                kept = np.ones(len(t_ns), bool)
            else:
                style = rr.SeriesPoints(colors=[colour], markers=["circle"], marker_sizes=[DOT], names=[label])
                kept = np.isfinite(values[:, column])
            self.put_static(place, style)
            self.stream.send_columns(
                place,
                indexes=[
                    rr.TimeColumn(line, duration=(t_ns[kept] - start).astype("timedelta64[ns]"))
                    for line, start in ((TRAJECTORY_TIME, self.touch.start_ns), (LOG_TIME, self.touch.log_ns))
                ],
                columns=rr.Scalars.columns(scalars=values[kept, column]),
            )


def _colour(name: str, column: int) -> tuple[int, int, int]:
    """Colour of a curve: that of its axis, where its name ends in one."""
    if name[-1:] in ("x", "y", "z"):
        return COLOURS["xyz".index(name[-1])]
    return OTHER_COLOURS[column % len(OTHER_COLOURS)]
