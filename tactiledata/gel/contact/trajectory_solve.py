"""Order of work on one trajectory: which load step comes next, and what happens when one fails."""

from __future__ import annotations

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import ContactPath, ContactState
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.contact.path import load_steps, pose_status
from tactiledata.gel.contact.recorder import FrameRecorder

FINEST = 4
"""Largest factor on the number of load steps: a frame that fails is tried again with 2, then 4 times as many."""


class TrajectorySolve:
    """Load steps of one trajectory, in order, with the frames recorded as they are solved.

    Parameters
    ----------
    number : int
        Place of the trajectory among those that are simulated.
    touch : GelTouch
        Poses of the frames.
    path : ContactPath
        Contact of its indenter.
    recorder : FrameRecorder
        Takes the solved frames.
    thickness : m
        Thickness of the pad.
    """

    def __init__(
        self, number: int, touch: GelTouch, path: ContactPath, recorder: FrameRecorder, thickness: float
    ) -> None:
        self.number = number
        self.path = path
        self.recorder = recorder
        self._poses = touch.poses
        self._thickness = thickness
        self._frame = -1
        self._steps: list[Array] = []
        self._finer = 1
        self._before: ContactState = path.state

    def next_step(self) -> bool:
        """Start the next load step that must be solved; return false where the trajectory has no more.

        Frames that cannot be solved, and those in free air, are recorded here and skipped.
        """
        while not self._steps:
            self._frame += 1
            if self._frame >= len(self._poses):
                return False
            self._finer = 1
            self._before = self.path.state
            pose = self._poses[self._frame]
            status = pose_status(pose, self.path.rest, self.path.relief, self._thickness)
            if status != FrameStatus.SOLVED:
                self.recorder.give_up(self._frame, status)
                continue
            self._plan()
        if self.path.move_to(self._steps[0]):
            return True
        self.path.release()
        frame = self.step_done(0.0)
        if frame is not None:
            self.recorder.put_rest(frame)
        return self.next_step()

    def step_done(self, residual: float) -> int | None:
        """Take the present load step as solved; return the frame that it completes, or ``None``."""
        self._steps.pop(0)
        if self._steps:
            return None
        self.recorder.keep(self._frame, self.path, residual)
        return self._frame

    def step_failed(self) -> bool:
        """Return to the last frame and plan smaller steps, or give the frame up where they are the finest.

        Returns
        -------
        bool
            Whether the frame is tried again.
        """
        self.path.state = self._before
        self._finer *= 2
        if self._finer > FINEST:
            self.recorder.give_up(self._frame, FrameStatus.NOT_CONVERGED)
            self._steps = []
            return False
        self._plan()
        return True

    def count(self, iterations: int) -> None:
        """Add solver iterations to the count of the present frame."""
        self.recorder.iterations[self._frame] += iterations

    def _plan(self) -> None:
        """Set the load steps from the present state to the present frame."""
        state = self.path.state
        self._steps = load_steps(
            state.pose, self._poses[self._frame], self.path.rest, self.path.relief, state.is_touching, self._finer
        )
