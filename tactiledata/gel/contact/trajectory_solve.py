"""A touch from its first frame to its last: which load step comes next, and what to do when one fails."""

from __future__ import annotations

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import ContactPath, ContactState
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.contact.path import judge_pose, load_steps
from tactiledata.gel.contact.recorder import FrameRecorder

FINEST = 4
"""A load step that fails is tried in 2 and at last this many parts."""


class TrajectorySolve:
    """The order of work on one touch.

    Parameters
    ----------
    number : int
        Of the touch among those asked for.
    touch : GelTouch
    walk : ContactPath
    recorder : FrameRecorder
    thickness : m, of the pad
    """

    def __init__(
        self, number: int, touch: GelTouch, walk: ContactPath, recorder: FrameRecorder, thickness: float
    ) -> None:
        self.number = number
        self.walk = walk
        self.recorder = recorder
        self._poses = touch.poses
        self._thickness = thickness
        self._frame = -1
        self._steps: list[Array] = []
        self._finer = 1
        self._before: ContactState = walk.state

    def next_step(self) -> bool:
        """Head for the next load step; false where the touch has no more.

        Frames that cannot be solved, and those in free air, are dealt with on the way.
        """
        while not self._steps:
            self._frame += 1
            if self._frame >= len(self._poses):
                return False
            self._finer = 1
            self._before = self.walk.state
            pose = self._poses[self._frame]
            status = judge_pose(pose, self.walk.rest, self.walk.relief, self._thickness)
            if status != FrameStatus.SOLVED:
                self.recorder.give_up(self._frame, status)
                continue
            self._plan()
        if self.walk.move_to(self._steps[0]):
            return True
        self.walk.release()
        frame = self.step_done(0.0)
        if frame is not None:
            self.recorder.put_rest(frame)
        return self.next_step()

    def step_done(self, residual: float) -> int | None:
        """A load step is solved; the number of the frame that it completes, if it does."""
        self._steps.pop(0)
        if self._steps:
            return None
        self.recorder.keep(self._frame, self.walk, residual)
        return self._frame

    def step_failed(self) -> bool:
        """A load step found no equilibrium: once more in smaller steps from the last frame, or the frame is given up.

        Returns whether it is tried again.
        """
        self.walk.state = self._before
        self._finer *= 2
        if self._finer > FINEST:
            self.recorder.give_up(self._frame, FrameStatus.NOT_CONVERGED)
            self._steps = []
            return False
        self._plan()
        return True

    def count(self, iterations: int) -> None:
        """Iterations that the present frame took."""
        self.recorder.iterations[self._frame] += iterations

    def _plan(self) -> None:
        state = self.walk.state
        self._steps = load_steps(
            state.pose, self._poses[self._frame], self.walk.rest, self.walk.relief, state.is_touching, self._finer
        )
