"""Which frames of measured trajectories take part in a diagnosis, and how a reader is told."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose.answer.notes import notes_of
from tactiledata.diagnose.naming.full_plays import FullPlay
from tactiledata.diagnose.touches.store_touches import FrameUse
from tactiledata.diagnose.touches.touch_case import TouchCase
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.sensors.digit import DIGIT

FIRST = [(0.0, 0.0, 1.0), (0.0, 3.0, 4.0), (np.nan, np.nan, np.nan), (2.0, 0.0, 0.0)]
"""Forces of four frames, N: their squares are 1, 25, unknown and 4."""
SECOND = [(0.0, 0.0, 5.0), (1.0, 2.0, 2.0)]
"""Forces of two frames, N: their squares are 25 and 9."""
FIRST_KEPT, SECOND_KEPT = [True, False, False, True], [True, True]


def wrenches(forces):
    """Wrenches (n, 6) with large torques, which no share of a force may count."""
    return np.hstack([np.array(forces), np.full((len(forces), 3), 100.0)])


def measured(forces):
    """A measured trajectory with these forces."""
    touch = GelTouch(Sphere(), np.tile(np.eye(4), (len(forces), 1, 1)))
    return MeasuredTouch("u", "touch", "D20001", "ball", touch, wrenches(forces), np.arange(float(len(forces))), 9.0)


def case(forces, kept):
    """The part of it whose frames take part."""
    count = sum(kept)
    material = GelMaterial(9e5, 0.47, 0.7)
    touch = Touch(np.arange(float(count)), np.tile(np.eye(4), (count, 1, 1)), Sphere(), material, DIGIT.gel)
    noise = WrenchNoise(np.eye(6), 1.0, "planted")
    return TouchCase(touch, wrenches(forces)[kept], noise, np.zeros(count, bool), 9.0)


def plays(estimated):
    """Plays of which only the estimated frames are asked."""
    return SimpleNamespace(estimated=None if estimated is None else np.array(estimated))


def use(first=FIRST, second=SECOND, estimated=((False, True), None)):
    """The use of two trajectories, of which the first loses two frames."""
    return FrameUse.of(
        [measured(first), measured(second)],
        [case(first, FIRST_KEPT), case(second, SECOND_KEPT)],
        [plays(frames) for frames in estimated],
    )


def test_the_lost_share_is_that_of_the_squared_forces():
    """Of 64 N^2 measured in six frames, the two lost frames hold 25 N^2; one of them has no wrench."""
    found = use()
    assert found.lost == 2
    assert found.force_lost == pytest.approx(25 / 64)


def test_estimated_frames_are_counted_over_all_trajectories():
    """One frame of the first and two of the second trajectory are three; plays that solved all frames count as none."""
    assert use().estimated == 1
    assert use(estimated=((True, False), (True, True))).estimated == 3
    assert use(estimated=(None, None)).estimated == 0


def test_without_any_force_no_share_is_lost():
    """Frames that all read 0 N are counted as lost, with no share of the force."""
    found = use(np.zeros((4, 3)), np.zeros((2, 3)))
    assert (found.lost, found.force_lost) == (2, 0.0)


def test_a_trajectory_that_is_left_out_loses_all_of_its_frames():
    """Without the second trajectory 4 of 6 frames and 59 of 64 N^2 are lost."""
    found = FrameUse.of([measured(FIRST), measured(SECOND)], [case(FIRST, FIRST_KEPT)], [plays(None)])
    assert found.lost == 4
    assert found.force_lost == pytest.approx(59 / 64)


def noted(frames, left_out=None, full_plays=()):
    """Notes of a diagnosis in which every effect was tried."""
    played = SimpleNamespace(left_out=left_out or {}, frames=frames, not_played={})
    return notes_of(
        SimpleNamespace(
            played=played,
            options=SimpleNamespace(effects=None),
            naming=SimpleNamespace(not_tried=()),
            full_plays=full_plays,
        )
    )


def test_the_notes_state_numbers_and_share():
    """A reader is told how many frames are lost with how much of the squared force, and how many were estimated."""
    lost, estimated = noted(FrameUse(2, 25 / 64, 3), {})
    assert lost.startswith("2 frames, with 39 % of the squared force, take no part")
    assert estimated.startswith("3 frames could not be solved at some parameters")


def test_nothing_is_noted_of_frames_that_all_take_part():
    """Notes of trajectories alone remain where no frame is lost or estimated."""
    assert noted(FrameUse(0, 0.0, 0)) == []
    assert noted(FrameUse(0, 0.0, 0), {"no pose": 4}) == ["4 trajectories took no part: no pose"]
    assert noted(FrameUse(0, 0.0, 0), {"flagged": 1}) == ["1 trajectory took no part: flagged"]


def test_a_gel_that_was_played_in_full_is_noted_with_what_the_estimate_missed():
    """Error in per cent, evidence before and after; an effect that was not refitted any more has none."""
    (said,) = noted(FrameUse(0, 0.0, 0), full_plays=(FullPlay("thickness", 0.173, 38.04, 12.5),))
    assert said.startswith(
        "thickness of the gel was first estimated and then played in full: the estimate was off by 17 %"
    )
    assert said.endswith("the evidence was 38.0 and is 12.5")
    (faint,) = noted(FrameUse(0, 0.0, 0), full_plays=(FullPlay("skin", 0.3, 20.0, float("nan")),))
    assert faint.endswith("the evidence was 20.0 and is too small for a refit")
