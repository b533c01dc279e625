"""Noise, zeros and offsets are found where they were planted, and not where they were not."""

import numpy as np
import pytest

from tactiledata.nuisance.noise import WrenchNoise, noise_at_rest, specified_noise
from tactiledata.nuisance.numerical import with_law_error
from tactiledata.nuisance.offsets import FARTHEST, OffsetSeries, profile_offsets
from tactiledata.nuisance.tare import tare_variance, without_tare
from tactiledata.sensors.robotiq_ft300s import ROBOTIQ_FT300S


def planted_covariance(seed=0):
    chance = np.random.default_rng(seed)
    scale = np.diag([0.1, 0.12, 0.2, 0.003, 0.004, 0.001])
    mixing = np.linalg.cholesky(0.6 * np.eye(6) + 0.4)
    return chance, scale @ mixing @ mixing.T @ scale


def test_the_covariance_of_rest_is_found_beside_drift():
    """Sampled covariance, correlation of forces and torques included; a drift in each stretch is not noise."""
    chance, covariance = planted_covariance()
    factor = np.linalg.cholesky(covariance)
    drift = np.linspace(0, 1, 100)[:, None]
    stretches = [chance.standard_normal((100, 6)) @ factor.T + k + drift for k in range(40)]
    noise = noise_at_rest(stretches)
    assert noise is not None
    assert np.allclose(noise.covariance / covariance, 1.0, atol=0.15)
    assert noise.inflation == pytest.approx(1.0, abs=0.1)


def test_whitened_noise_is_white():
    """Noise of a planted covariance has the unit matrix as its covariance once whitened."""
    chance, covariance = planted_covariance(1)
    noise = WrenchNoise(covariance, 1.0, "")
    white = noise.whitened(chance.standard_normal((20_000, 6)) @ np.linalg.cholesky(covariance).T)
    assert np.allclose(np.cov(white.T), np.eye(6), atol=0.04)


@pytest.mark.parametrize("r", [0.0, 0.6])
def test_correlated_neighbours_count_for_less(r):
    """An AR(1) process is told from white noise, and by how much its mean is less certain."""
    chance = np.random.default_rng(2)
    stretches = []
    for _ in range(40):
        steps = chance.standard_normal((150, 6))
        for k in range(1, 150):
            steps[k] = r * steps[k - 1] + np.sqrt(1 - r**2) * steps[k]
        stretches.append(steps)
    noise = noise_at_rest(stretches)
    assert noise is not None
    assert noise.inflation == pytest.approx((1 + r) / (1 - r), rel=0.15)


def test_too_few_samples_say_nothing():
    """No noise is estimated from no samples, from constant ones, or from stretches that are too short."""
    assert noise_at_rest([]) is None
    assert noise_at_rest([np.zeros((100, 6))]) is None
    assert noise_at_rest([np.ones((3, 6))] * 100) is None


def test_a_standing_component_gets_no_infinite_weight():
    """A torque that a driver always sends as 0 does not decide everything."""
    chance = np.random.default_rng(0)
    stretch = chance.standard_normal((200, 6)) * 0.1
    stretch[:, 5] = 0.0
    noise = noise_at_rest([stretch])
    assert noise is not None
    assert noise.deviations[5] > 0.02 * noise.deviations[4]


def test_the_specification_has_six_components():
    """The noise of a data sheet is positive in all six components, and not below the stated noise of force."""
    deviations = specified_noise(ROBOTIQ_FT300S.force).deviations
    assert (deviations > 0).all()
    assert deviations[0] >= ROBOTIQ_FT300S.force.force_noise


def test_without_tare_is_the_inverse_root_of_the_covariance():
    """Sums of squares are those of generalised least squares with the covariance I + v w wᵀ."""
    chance = np.random.default_rng(3)
    counts, variance = np.array([5, 1, 12]), tare_variance(np.array([40.0, 2.0, 0.0]))
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    rows = chance.standard_normal((counts.sum(), 6)) + 3.0
    weights = chance.uniform(0.3, 1.0, len(rows))
    done = without_tare(rows, starts, variance, weights)
    for start, count, v in zip(starts, counts, variance, strict=True):
        part = rows[start : start + count]
        weight = weights[start : start + count]
        whole = np.eye(count) + v * np.outer(weight, weight)
        expected = np.trace(part.T @ np.linalg.solve(whole, part))
        assert np.sum(done[start : start + count] ** 2) == pytest.approx(expected)


def quadratic_touches(seed=0, count=6, frames=9):
    chance = np.random.default_rng(seed)
    series = OffsetSeries(*(chance.standard_normal((count * frames, 6)) * s for s in (20.0, 1.5e5, 4e8)))
    return series, np.arange(count) * frames, chance.normal(0, 4e-5, count), frames


def test_planted_offsets_are_found():
    """Offsets without noise, with a prior that hardly binds, are found to the nanometre."""
    series, starts, truth, frames = quadratic_touches()
    found = profile_offsets(series.at(np.repeat(truth, frames)), series, starts, prior=1e-2)
    assert np.allclose(found, truth, atol=2e-9)


def test_the_profile_is_stationary():
    """No offset nearby is better, prior included."""
    series, starts, truth, frames = quadratic_touches(1)
    measured = series.at(np.repeat(truth, frames)) + np.random.default_rng(0).standard_normal((54, 6)) * 5
    found = profile_offsets(measured, series, starts)

    def value(offsets):
        return ((measured - series.at(np.repeat(offsets, frames))) ** 2).sum() + ((offsets / 4e-5) ** 2).sum()

    for k in range(len(found)):
        for step in (-1e-6, 1e-6):
            other = found.copy()
            other[k] += step
            assert value(other) >= value(found)


def test_offsets_stay_where_they_mean_something():
    """Offsets stay within their largest value, and are 0 under a prior of width 0."""
    series, starts, _, frames = quadratic_touches(2)
    far = series.at(np.repeat(np.full(len(starts), 5e-3), frames))
    assert np.abs(profile_offsets(far, series, starts)).max() <= FARTHEST
    assert (profile_offsets(far, series, starts, prior=0.0) == 0).all()


def test_a_law_error_is_a_power_of_the_force():
    """Over a factor e of the force, a share; directions and torques per force stay; what weighs most stays."""
    forces = np.exp(np.arange(4.0))
    wrenches = np.outer(forces, [0.6, 0.0, 0.8, 0.01, 0.0, 0.0])
    bent = with_law_error(wrenches, 0.06)
    growth = np.linalg.norm(bent[:, :3], axis=1) / forces
    assert np.diff(np.log(growth)) == pytest.approx(0.06)
    assert bent / bent[:, :1] == pytest.approx(wrenches / wrenches[:, :1])
    assert np.average(np.log(growth), weights=forces**2) == pytest.approx(0.0, abs=1e-12)
    assert (with_law_error(wrenches, 0.0) == wrenches).all()


def test_a_law_error_of_no_forces_is_none():
    """The error of the force law is 0 where forces are 0."""
    assert (with_law_error(np.zeros((3, 6)), 0.06) == 0).all()


def at_frames(readings, fractions):
    """What linear interpolation makes of readings (n, 6) between neighbours."""
    places = np.arange(len(readings) - 1)
    u = fractions[: len(places), None]
    return (1 - u) * readings[places] + u * readings[places + 1]


def white_readings(chance, count):
    return chance.standard_normal((count, 6))


def coloured_readings(chance, count):
    """Half of the variance remembers five readings."""
    slow = np.zeros((count, 6))
    for k in range(1, count):
        slow[k] = 0.8 * slow[k - 1] + 0.6 * chance.standard_normal(6)
    return (chance.standard_normal((count, 6)) + slow) / np.sqrt(2.0)


def repeated_readings(chance, count):
    """A driver that is faster than its sensor sends each reading twice."""
    return np.repeat(chance.standard_normal((count // 2, 6)), 2, axis=0)


@pytest.mark.parametrize("readings_of", [white_readings, coloured_readings, repeated_readings])
@pytest.mark.parametrize("phase", ["spread", "coincident", "midway"])
def test_what_is_left_of_interpolated_noise_has_a_mean_square_of_one(readings_of, phase):
    """Noise is measured as the frames have it, wherever they lie between readings and whatever the readings share."""
    chance = np.random.default_rng(4)
    stretches = [readings_of(chance, 300) for _ in range(60)]
    draws = {"spread": chance.uniform(size=20_000), "coincident": np.zeros(20_000), "midway": np.full(20_000, 0.5)}
    noise = noise_at_rest(stretches, fractions=draws[phase])
    assert noise is not None
    frames = at_frames(readings_of(chance, 20_001), draws[phase])
    white = np.linalg.solve(np.linalg.cholesky(noise.covariance), frames.T)
    assert (white**2).mean() == pytest.approx(1.0, abs=0.06)


def test_a_reading_has_three_halves_of_the_variance_of_what_lies_anywhere_between_two():
    """The mean of (1 - u)^2 + u^2 over 0 to 1 is 2/3; the zero of free air, made of readings, counts by it."""
    chance = np.random.default_rng(5)
    noise = noise_at_rest([white_readings(chance, 200) for _ in range(100)], fractions=np.linspace(0, 1, 1001))
    assert noise is not None
    assert noise.reading_variance == pytest.approx(1.5, rel=0.03)
    assert tare_variance(np.array([100.0]), 1.5)[0] == pytest.approx(1.5 * np.pi / 200)


def test_frames_as_dense_as_readings_share_a_reading_with_their_neighbour():
    """Midway between independent readings, neighbouring frames correlate by 1/2: (1 + r) / (1 - r) is 3."""
    chance = np.random.default_rng(6)
    noise = noise_at_rest([white_readings(chance, 300) for _ in range(60)], fractions=[0.5])
    assert noise is not None
    assert noise.inflation == pytest.approx(3.0, rel=0.1)
