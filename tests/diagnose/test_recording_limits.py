"""Recordings that leave something out are told so, and those that do not are left in peace."""

from dataclasses import fields, replace

import numpy as np
import pytest
from touch_worlds import START, World, world_cases

from tactiledata.diagnose.next_trial.limits import limits
from tactiledata.diagnose.touches.touch_case import TouchSet


@pytest.fixture(scope="module")
def whole():
    return world_cases(World(), trajectories=16)


def changed(cases, change):
    return TouchSet([change(case) for case in cases.touches], cases.base)


def rows(case, keep):
    """The case with some of its frames."""
    touch = replace(
        case.touch,
        **{
            field.name: value[keep]
            for field in fields(case.touch)
            if isinstance(value := getattr(case.touch, field.name), np.ndarray)
        },
    )
    return replace(case, touch=touch, measured=case.measured[keep], free_air=case.free_air[keep])


def one_indenter(case):
    return replace(case, touch=replace(case.touch, indenter_name="ball3"))


def no_dwell(case):
    tips = case.touch.tips
    keep = np.ones(len(tips), dtype=bool)
    keep[1:] = np.linalg.norm(np.diff(tips, axis=0), axis=1) > 1e-5
    return rows(case, keep)


def no_free_air(case):
    return rows(case, ~case.free_air)


def no_free_samples(case):
    return replace(case, free_samples=0.0)


def clipped(case):
    measured = case.measured.copy()
    measured[:, 2] = np.minimum(measured[:, 2], 1.0)
    return replace(case, measured=measured)


def dead(case):
    measured = case.measured.copy()
    measured[:, 0] = 0.0
    return replace(case, measured=measured)


def no_slide(case):
    return rows(case, np.linalg.norm(case.touch.tips[:, :2] - case.touch.tips[0, :2], axis=1) < 1e-5)


def one_depth(case):
    poses = case.touch.poses.copy()
    poses[:, 2, 3] *= 6e-4 / -poses[:, 2, 3].min()
    return replace(case, touch=replace(case.touch, poses=poses))


def test_whole_recordings_are_left_in_peace(whole):
    """Recordings in which nothing is left out have no limits."""
    assert limits(whole, START) == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (one_indenter, "one indenter (ball3)"),
        (no_dwell, "rests in contact"),
        (no_free_air, "free air"),
        (no_free_samples, "16 of 16 trajectories have no readings before contact"),
        (clipped, "fz stands at 1.00 N"),
        (dead, "fx never changes"),
        (no_slide, "Nothing slides"),
        (one_depth, "about equally deep"),
    ],
)
def test_what_is_left_out_is_named_with_what_to_record(whole, change, words):
    """What recordings leave out (an indenter, a dwell, free air, slides and others) is named."""
    said = limits(changed(whole, change), START)
    assert any(words in sentence for sentence in said), said


def test_one_speed_is_told(whole):
    """Slides that all have one speed are reported, with that speed."""

    def same_speed(case):
        # times follow the way along the gel
        steps = np.maximum(case.touch.lateral_steps / 1e-3, 0.2)
        return replace(case, touch=replace(case.touch, seconds=np.cumsum(steps)))

    said = limits(changed(whole, same_speed), START)
    assert any("All sliding is at about 1 mm/s" in sentence for sentence in said), said
