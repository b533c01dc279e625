"""A zero that wanders by chance is told from one that scatters, follows the time, or was set to zero each time."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_zeros import zeros

from tactiledata.diagnose.zeros import wander
from tactiledata.diagnose.zeros.causes import zero_causes
from tactiledata.diagnose.zeros.wander import wandering_zero
from tactiledata.diagnose.zeros.zero_models import cable_shapes


def walking(seed=0, walk=0.1, **more):
    """Zeros of 60 trajectories, 40 s apart, that walk by 0.1 N from one to the next, with little scatter."""
    return zeros(seed, trajectories=60, scatter=0.01, walk=walk, **more)


def test_a_walk_is_found_with_its_size():
    """Each of ten zeros that were drawn as random walks is found to wander, on average with the planted variance."""
    found = [wandering_zero(walking(seed)) for seed in range(10)]
    assert all(found)
    variance = np.mean([one.walk**2 for one in found])
    assert variance == pytest.approx(0.1**2 / 40.0, rel=0.25)
    # ten seconds pass from the free air to the end of a trajectory
    assert found[0].within == pytest.approx(np.sqrt((found[0].walk ** 2).sum() * 10.0))
    assert found[0].explained == pytest.approx(1 - (found[0].after / found[0].before) ** 2)
    assert found[0].p == pytest.approx(1 / (wander.DRAWS + 1))


@pytest.mark.parametrize("planted", [{}, {"scatter": 0.1}, {"mass": 0.06, "cable": 0.3}], ids=["own", "large", "pose"])
def test_zeros_that_scatter_do_not_wander(planted):
    """Zeros that differ by chance from trajectory to trajectory, or follow the pose, are not said to wander."""
    assert not any(wandering_zero(zeros(seed, trajectories=36, **planted)) for seed in range(40))


def test_a_steady_drift_is_no_walk():
    """What is linear in time is taken away, and so is a drift since power-on of a known time constant."""
    still = zeros(trajectories=36, scatter=0.03)
    steady = replace(still, load=still.load + 0.002 * still.seconds[:, None])
    assert wandering_zero(steady) is None
    warming = zeros(trajectories=36, drift=3.0)
    assert wandering_zero(warming) is not None
    assert wandering_zero(warming, [300.0]) is None


def test_a_zero_that_is_set_before_each_trajectory_tells_nothing():
    """A walk shows between trajectories of one stretch; eight of them are too few."""
    walked = walking()
    assert wandering_zero(walked) is not None
    assert wandering_zero(replace(walked, zeroed=walked.trajectory)) is None
    assert wandering_zero(zeros(trajectories=8, walk=1.0, scatter=0.01)) is None


def test_a_tare_in_free_air_is_no_step_of_the_zero():
    """Readings of a trajectory after a tare within it are left out of its mean."""
    still = zeros(trajectories=36, scatter=0.03)
    tared = still.zeroed.copy()
    load = still.load.copy()
    for number in range(1, 36, 2):
        last = np.flatnonzero(still.trajectory == number)[-1]
        tared[last] = 100 + number
        load[last] += 5.0
    assert wandering_zero(replace(still, load=load, zeroed=tared)) is None


def test_a_component_that_always_reads_the_same_is_passed_over():
    """A dead axis neither hides a walk of the others nor walks itself."""
    walked = walking()
    found = wandering_zero(replace(walked, load=walked.load * np.array([1, 0, 1, 1, 1, 1])))
    assert found.walk[1] < 1e-12 < found.walk.max()


def test_the_likelihood_is_that_of_a_normal_distribution():
    """The gain of the restricted likelihood agrees with dense determinants; the component variances with their sum."""
    walked = walking()
    first = np.unique(walked.trajectory, return_index=True)[1]
    together = walked.zeroed[first][:, None] == np.unique(walked.zeroed)
    seconds = walked.seconds[first]
    design = wander._design(walked.down[first], cable_shapes(walked)[first], seconds, together, ())
    _, covariance = wander._walk_covariance(seconds, together)
    basis = np.linalg.svd(design)[0][:, design.shape[1] :]
    sizes, axes = np.linalg.eigh(basis.T @ covariance @ basis)
    left = basis.T @ walked.load[first, :3]
    gain, share, white = wander._Walks(basis.T, axes.T, sizes).fitted(left)

    def likelihood(part):
        whole = np.eye(len(left)) + part * basis.T @ covariance @ basis
        total = 0.0
        for column in left.T:
            variance = column @ np.linalg.solve(whole, column) / len(left)
            total -= 0.5 * (np.linalg.slogdet(variance * whole)[1] + len(left))
        return total

    assert gain == pytest.approx(2 * (likelihood(share) - likelihood(0.0)))
    assert gain == pytest.approx(max(2 * (likelihood(part) - likelihood(0.0)) for part in wander.SHARES))
    whole = np.eye(len(left)) + share * basis.T @ covariance @ basis
    assert white == pytest.approx(np.diag(left.T @ np.linalg.solve(whole, left)) / len(left))


def test_each_zero_is_predicted_from_the_others():
    """The closed form of errors of zeros that are left out agrees with fits that leave each one out."""
    rng = np.random.default_rng(3)
    seconds = np.sort(rng.uniform(0, 300, 12))
    together = np.ones((12, 1), bool)
    design = np.stack([np.ones(12), seconds], axis=1)
    covariance = np.eye(12) + wander._walk_covariance(seconds, together)[1]
    force = rng.normal(0, 1, (12, 3))
    errors = []
    for out in range(12):
        rest = np.arange(12) != out
        inverse = np.linalg.inv(covariance[np.ix_(rest, rest)])
        numbers = np.linalg.solve(design[rest].T @ inverse @ design[rest], design[rest].T @ inverse @ force[rest])
        near = covariance[out, rest] @ inverse @ (force[rest] - design[rest] @ numbers)
        errors.append(force[out] - design[out] @ numbers - near)
    expected = np.sqrt((np.array(errors) ** 2).sum(axis=1).mean())
    assert wander._unseen(design, covariance, force) == pytest.approx(expected)


def test_a_walk_is_a_cause_that_matters():
    """It is told with its size, once; where it stays within a dead-band, or changes too little, nothing is said."""
    (cause,) = zero_causes(walking(1))
    assert (cause.effect, cause.matters) == ("sensor_drift", True)
    assert cause.document["values"].keys() == {"walk_x", "walk_y", "walk_z"}
    assert f"changes by {cause.within:.3f} N" in cause.words
    assert not zero_causes(walking(1), band=cause.within + 0.001)
    # 0.008 N within a trajectory
    small = zeros(1, trajectories=60, scatter=0.001, walk=0.009)
    assert 0.0 < wandering_zero(small).within < 0.01
    assert not any("walk_x" in cause.values for cause in zero_causes(small))


@pytest.mark.parametrize(("planted", "is_walk"), [({"drift": 3.0}, False), ({"walk": 0.1, "scatter": 0.01}, True)])
def test_a_drift_is_told_once_by_what_changes_the_zero_most(planted, is_walk):
    """A walk that resembles a drift since power-on is told as a walk, and such a drift is not told again as a walk."""
    for seed in (5, 6):
        (cause,) = zero_causes(zeros(seed, trajectories=60, **planted))
        assert cause.effect == "sensor_drift"
        assert ("walk_x" in cause.values) == is_walk
