"""What was planted is found, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form import FRAMES, NOISE, TRUTH, ClosedFormWorld

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.fit import draw_held_out, fit
from tactiledata.calibrate.gent import youngs_modulus_of_shore_a
from tactiledata.calibrate.least_squares import polish
from tactiledata.calibrate.losses import NormLoss, VectorLoss
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.search import search, search_squares
from tactiledata.errors import UsageError

PAPER = find_bounds("paper")
START = np.array([883e3, 0.47, 0.7])


@pytest.fixture(scope="module")
def world():
    return ClosedFormWorld()


def vector(world, measured, noise=NOISE, prior=4e-5):
    return VectorLoss(world.response(), measured, noise, np.full(world.count, 40.0), prior)


@pytest.mark.parametrize(("hardness", "kilopascal"), [(24, 883.140), (25, 923.464)])
def test_gent(hardness, kilopascal):
    """The law gives the SPLIT paper's two figures, which the paper cuts off behind the third digit."""
    assert youngs_modulus_of_shore_a(hardness) / 1e3 == pytest.approx(kilopascal, abs=1e-3)


@pytest.mark.parametrize("hardness", [-1.0, 100.0, float("nan")])
def test_gent_off_the_scale(hardness):
    """A Shore A hardness below 0, at 100 or not a number is refused."""
    with pytest.raises(UsageError, match="Shore A"):
        youngs_modulus_of_shore_a(hardness)


@pytest.mark.parametrize(
    ("nu", "mu", "offset"), [(0.46, 0.57, 0.0), (0.478, 0.78, 3e-5), (0.494, 0.9, -4e-5), (0.451, 0.98, 5e-5)]
)
def test_the_grid_holds_what_lies_between_its_nodes(world, nu, mu, offset):
    """The grid is within a hundredth of the largest force, corners included, and exact at a node without offset."""
    truth = world.wrench(nu, mu, offset)
    found = world.response().at(nu, mu).at(np.full(len(truth), offset))
    assert np.abs(found - truth)[:, :3].max() < 0.01 * np.abs(truth[:, :3]).max()
    node = world.response().plan.ratios[0]
    exact = world.response().at(node, 0.7).level
    assert np.allclose(exact, world.wrench(node, 0.7, 0.0), rtol=1e-12, atol=1e-20)


@pytest.mark.slow
def test_without_noise_nothing_is_left(world):
    """Null: the residual at the truth is that of the interpolation, far below the noise; the truth is found."""
    offsets = np.random.default_rng(1).normal(0, 3e-5, world.count)
    loss = vector(world, world.measured(offsets=offsets, noise=None), prior=1e-3)
    found = search_squares(loss, PAPER, START)
    assert loss.value(found) < 0.1
    assert found == pytest.approx(TRUTH, rel=3e-3)
    assert np.allclose(loss.offsets(found), offsets, atol=3e-6)


@pytest.mark.slow
def test_planted_truth_is_found_in_noise(world):
    """E within 1 %, mu within 3 %, offsets within what the noise allows; the residual is the noise."""
    offsets = np.random.default_rng(2).normal(0, 3e-5, world.count)
    loss = vector(world, world.measured(offsets=offsets))
    found = search_squares(loss, PAPER, START)
    assert found[0] == pytest.approx(TRUTH[0], rel=0.01)
    assert found[2] == pytest.approx(TRUTH[2], rel=0.03)
    assert loss.value(found) == pytest.approx(1.0, abs=0.06)
    assert np.corrcoef(loss.offsets(found), offsets)[0, 1] > 0.9


@pytest.mark.slow
def test_a_rough_search_ends_where_a_fine_one_does(world):
    """Gauss-Newton ends a rough search where it ends a fine one, within a thousandth of the box, for half the work."""
    chance, asked = np.random.default_rng(4), np.zeros(2)
    for bounds in (PAPER, find_bounds("wide"), find_bounds("wide")):
        truth = TRUTH * [1 + chance.uniform(-0.25, 0.25), 1.0, 1 + chance.uniform(-0.3, 0.3)]
        measured = world.measured(truth=truth, offsets=chance.normal(0, 3e-5, world.count))
        fine, rough = CountedLoss(vector(world, measured)), CountedLoss(vector(world, measured))
        wanted = polish(fine, bounds, bounds.shares(search(fine, bounds, START))).shares
        assert bounds.shares(search_squares(rough, bounds, START)) == pytest.approx(wanted, abs=1e-3)
        asked += [fine.asked, rough.asked]
    assert asked[1] < 0.5 * asked[0]


class CountedLoss:
    """A vector loss that counts how often it is asked."""

    def __init__(self, loss):
        self._loss, self.asked = loss, 0

    def residual(self, parameters):
        self.asked += 1
        return self._loss.residual(parameters)

    def value(self, parameters):
        self.asked += 1
        return self._loss.value(parameters)


@pytest.mark.slow
def test_offsets_that_are_not_allowed_for_bias(world):
    """A shift that all trajectories share goes into E where poses are taken as they are, and not with offsets."""
    measured = world.measured(offsets=4e-5)
    assert abs(search_squares(vector(world, measured), PAPER, START)[0] / TRUTH[0] - 1) < 0.03
    assert abs(search_squares(vector(world, measured, prior=0.0), PAPER, START)[0] / TRUTH[0] - 1) > 0.04


@pytest.mark.slow
def test_the_norm_loss_finds_the_truth_of_its_own_world(world):
    """No noise, no offsets: the paper's loss is 0 at the truth."""
    loss = NormLoss(world.response(), world.measured(noise=None))
    found = search(loss, PAPER, START)
    assert loss.value(found) < 0.01
    assert found == pytest.approx(TRUTH, rel=0.02)


def test_the_norm_loss_is_the_papers(world):
    """Trajectory means of frame means, recomputed by hand."""
    measured = world.measured()
    simulated = TRUTH[0] * world.response().at(*TRUTH[1:]).level
    by_hand = [
        np.mean([abs(np.linalg.norm(measured[row, :3]) - np.linalg.norm(simulated[row, :3])) for row in rows])
        for rows in np.arange(len(measured)).reshape(-1, FRAMES)
    ]
    assert NormLoss(world.response(), measured).value(TRUTH) == pytest.approx(np.mean(by_hand))


def test_only_the_vector_loss_sees_directions(world):
    """A force sensor that is turned by 20 degrees leaves the norm loss as it was."""
    turn = np.array([[np.cos(0.35), -np.sin(0.35), 0], [np.sin(0.35), np.cos(0.35), 0], [0, 0, 1]])
    straight = world.measured()
    turned = np.hstack([straight[:, :3] @ turn.T, straight[:, 3:] @ turn.T])
    norms = [NormLoss(world.response(), measured).value(TRUTH) for measured in (straight, turned)]
    vectors = [vector(world, measured).value(TRUTH) for measured in (straight, turned)]
    assert norms[0] == pytest.approx(norms[1])
    assert vectors[1] > 1.5 * vectors[0]


@pytest.mark.slow
@pytest.mark.parametrize("loss", ["vector", pytest.param("norm", marks=pytest.mark.nightly)])
def test_a_fit_is_the_same_every_time(world, loss):
    """A fit gives the same answer every time, and what is held out is not fitted, yet foretold nearly as well."""
    experiment = world.experiment(world.measured())
    options = CalibrationOptions(loss=loss, hold_out=0.25, seed=3)
    one, other = (fit(experiment, NOISE, PAPER, options) for _ in range(2))
    assert (one.parameters == other.parameters).all()
    assert (one.intervals.ends == other.intervals.ends).all()
    assert len(one.held_out) == 5
    assert not set(one.held_out) & set(one.fitted)
    values = one.losses[loss]
    assert values.fitted < values.start
    assert values.held_out < 1.5 * values.fitted


@pytest.mark.slow
def test_held_out_trajectories_do_not_touch_the_fit(world):
    """Spoiling them changes their loss only."""
    measured = world.measured()
    options = CalibrationOptions(hold_out=0.25)
    _, held = draw_held_out(world.count, 0.25, 0)
    spoilt = measured.copy()
    spoilt[held[0] * FRAMES : (held[0] + 1) * FRAMES] *= 2
    clean, other = (fit(world.experiment(values), NOISE, PAPER, options) for values in (measured, spoilt))
    assert (clean.parameters == other.parameters).all()
    assert other.losses["vector"].held_out > clean.losses["vector"].held_out


@pytest.mark.parametrize(("count", "share", "held"), [(25, 0.2, 5), (25, 0.0, 0), (3, 0.9, 1), (2, 0.5, 0)])
def test_dealing_leaves_two_to_fit(count, share, held):
    """Every trajectory is fitted or held out, and at least two remain to fit whatever share is held out."""
    fitted, held_out = draw_held_out(count, share, 0)
    assert len(held_out) == held
    assert sorted([*fitted, *held_out]) == list(range(count))


@pytest.mark.parametrize(
    "wrong",
    [
        {"loss": "l2"}, {"fidelity": "fine"}, {"bounds": "narrow"}, {"trajectories": 1}, {"hold_out": 1.0},
        {"offset_prior": -1.0}, {"shore_a": 120.0}, {"seed": -1},
    ],
)  # fmt: skip
def test_options_that_mean_nothing_are_refused(wrong):
    """Options of a calibration outside their range are refused."""
    with pytest.raises(UsageError):
        replace(CalibrationOptions(), **wrong)
