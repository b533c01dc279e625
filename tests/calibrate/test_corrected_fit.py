"""Errors of the interpolated response do not move E, nu and mu, once it was corrected by plays at the optimum."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form import FRAMES, NOISE, TRUTH, ClosedFormWorld

from tactiledata.calibrate import corrected_fit as under_test
from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.corrected_fit import MOST_CORRECTIONS, corrected_fit, interpolated
from tactiledata.calibrate.fit import fit
from tactiledata.calibrate.measured import Measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.compute import make_scheduler
from tactiledata.gel.contact.history import FrameStatus

PAPER = find_bounds("paper")
OPTIONS = CalibrationOptions(hold_out=0.0, shape_error=0.0)


@pytest.fixture
def world(monkeypatch):
    """A world in closed form that plays its touches exactly; ``asked`` has touches and batch size by optimum."""
    made = ClosedFormWorld(count=10)
    made.asked = {}

    def play(mesh, mechanics, touches, ratio, friction, offsets, runner, most_together):
        places = [int(touch.uid.removeprefix("uid")) for touch in touches]
        made.asked.setdefault((ratio, friction), []).append((places, most_together))
        every = np.zeros(made.count)
        every[places] = offsets
        wrenches = made.wrench(ratio, friction, every).reshape(made.count, FRAMES, 6)
        status = np.full(FRAMES, FrameStatus.SOLVED, np.int8)
        return [Play(wrench, status, np.ones(FRAMES)) for wrench in wrenches[places]]

    monkeypatch.setattr(under_test, "play_at", play)
    return made


def distorted(world, share):
    """An experiment without noise whose interpolated forces grow by a share over each touch."""
    exact = world.experiment(world.measured(noise=None))
    more = np.tile(np.linspace(0.0, share, FRAMES), world.count)[:, None]
    return replace(exact, response=replace(exact.response, level=exact.response.level * (1.0 + more)))


def fitted(world, experiment):
    measured = Measured(experiment.touches, object(), {}, NOISE, {})
    return corrected_fit(experiment, measured, PAPER, OPTIONS, make_scheduler())


def test_a_response_that_is_off_finds_the_truth_after_its_correction(world):
    """Forces that are 3 % off at the end of a touch move the plain fit by ten times what the corrected one is off."""
    experiment = distorted(world, 0.03)
    plain = np.abs(fit(experiment, NOISE, PAPER, OPTIONS).parameters / TRUTH - 1)
    found = fitted(world, experiment)
    off = np.abs(found.fit.parameters / TRUTH - 1)
    assert plain.max() > 0.01
    assert off.max() < 0.1 * plain.max()
    # what the page draws is the corrected response at the optimum, in newtons
    assert np.abs(found.simulated - world.measured(noise=None))[:, :3].max() < 0.02


def test_the_error_that_is_told_is_that_of_the_interpolated_forces(world, monkeypatch):
    """After one correction alone, the error is the distance of the interpolated forces from the plays, in newtons."""
    monkeypatch.setattr(under_test, "MOST_CORRECTIONS", 1)
    experiment = distorted(world, 0.03)
    first = fit(experiment, NOISE, PAPER, OPTIONS)
    modulus, ratio, friction = first.parameters
    away = interpolated(experiment.response, ratio, friction, first.offsets) - world.wrench(
        ratio, friction, first.offsets
    )
    sizes = modulus * np.linalg.norm(away[:, :3], axis=1)
    expected = (np.sqrt(np.mean(sizes**2)), sizes.max())
    assert fitted(world, experiment).interpolation_error == pytest.approx(expected, rel=1e-3)


def test_a_fit_that_moves_is_corrected_again_and_one_that_stays_is_not(world):
    """A response without error is played once; one that is off twice, the second time where the fit came to."""
    fitted(world, distorted(world, 0.0))
    assert len(world.asked) == 1
    world.asked.clear()
    fitted(world, distorted(world, 0.06))
    assert len(world.asked) == MOST_CORRECTIONS


def test_touches_are_simulated_in_small_batches_and_each_once(world):
    """All touches are asked for once, in batches of at most seven: one that is hard to solve holds up six others."""
    fitted(world, distorted(world, 0.0))
    ((asked,),) = world.asked.values()
    assert asked == (list(range(world.count)), 7)


def test_a_frame_that_cannot_be_solved_is_not_corrected(world, monkeypatch):
    """A frame that the play at the optimum did not solve keeps its response; if none is solved, both errors are NaN."""

    def play(mesh, mechanics, touches, ratio, friction, offsets, runner, most_together):
        unsolved = np.full(FRAMES, FrameStatus.NOT_CONVERGED, np.int8)
        return [Play(np.full((FRAMES, 6), np.nan), unsolved, np.zeros(FRAMES))] * len(touches)

    monkeypatch.setattr(under_test, "play_at", play)
    experiment = distorted(world, 0.03)
    found = fitted(world, experiment)
    assert np.array_equal(found.experiment.response.level, experiment.response.level)
    assert np.isnan(found.interpolation_error).all()
