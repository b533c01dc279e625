"""Order of work on one trajectory: which load step comes next, and what happens when one fails."""

from __future__ import annotations

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import ContactPath, interpolated_poses
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.contact.path import load_steps, pose_status
from tactiledata.gel.contact.recorder import FrameRecorder

MOST_HALVINGS = 5
"""Times that a load step is halved before the path to the frame is given up."""


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
        self._steps: list[tuple[Array, int]] = []
        self._start = path.state.pose
        self._is_resumed = False
        self._is_pressed_anew = False

    def next_step(self) -> bool:
        """Start the next load step that must be solved; return false where the trajectory has no more.

        Frames that cannot be solved, and those in free air, are recorded here and skipped.
        """
        while not self._steps:
            self._frame += 1
            if self._frame >= len(self._poses):
                return False
            self._is_pressed_anew = False
            pose = self._poses[self._frame]
            status = pose_status(pose, self.path.rest, self.path.relief, self._thickness)
            if status != FrameStatus.SOLVED:
                self.recorder.give_up(self._frame, status)
                continue
            self._plan()
        if self.path.move_to(self._steps[0][0]):
            return True
        self.path.release()
        frame = self.step_done(0.0)
        if frame is not None:
            self.recorder.put_rest(frame)
        return self.next_step()

    def step_done(self, residual: float) -> int | None:
        """Take the present load step as solved; return the frame that it completes, or ``None``."""
        self._start = self._steps.pop(0)[0]
        if self._steps:
            return None
        self._is_resumed &= self.path.state.is_touching
        self.recorder.keep(self._frame, self.path, residual, self._is_resumed)
        return self._frame

    def step_failed(self) -> bool:
        """Plan how to go on from the last solved load step where the present one failed.

        The step is halved. Where halves are too small, the gel is released and pressed anew at the frame's pose; the
        frame is then marked as resumed, with all that follow up to the next one in free air, because friction does not
        know what happened before. Where that fails too, the frame is given up, and the next one is pressed anew.

        Returns
        -------
        bool
            Whether the gel was released.
        """
        pose, halvings = self._steps[0]
        if halvings < MOST_HALVINGS:
            middle = interpolated_poses(self._start, pose, 2)[0]
            self._steps[:1] = [(middle, halvings + 1), (pose, halvings + 1)]
            return False
        self.path.forget()
        self._is_resumed = True
        if self._is_pressed_anew:
            self.recorder.give_up(self._frame, FrameStatus.NOT_CONVERGED)
            self._steps = []
        else:
            self._is_pressed_anew = True
            self._plan()
        return True

    def count(self, iterations: int) -> None:
        """Add solver iterations to the count of the present frame."""
        self.recorder.iterations[self._frame] += iterations

    def _plan(self) -> None:
        """Set the load steps from the present state to the present frame."""
        state, pose = self.path.state, self._poses[self._frame]
        self._start, steps = load_steps(state.pose, pose, self.path.rest, self.path.relief, state.is_touching)
        self._steps = [(step, 0) for step in steps]
