"""A dead-band of a force sensor is read from its readings, and nothing else is taken for one."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from recorded_touches import recorded_store

from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.diagnose.zeros.dead_band import find_dead_band
from tactiledata.diagnose.zeros.readings import StoreReadings
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.read.reader import Store

ARM = 0.02
"""m: torques are that many times as large as forces."""
SCALE = np.array([1.0, 1.0, 1.0, ARM, ARM, ARM])


def presses(seed=0, noise=0.1, count=8, rate=100, bias=0.0, deepest=6.0):
    """Readings (m, 6), N and N m, of presses: free air, in within a second, a dwell, out, free air; white noise."""
    rng = np.random.default_rng(seed)
    ramp = np.linspace(0.0, 1.0, rate)
    shape = np.concatenate([np.zeros(2 * rate), ramp, np.ones(2 * rate), ramp[::-1], np.zeros(rate)])
    rows = []
    for _ in range(count):
        direction = rng.normal(size=6) * [0.3, 0.3, 1.0, 0.3, 0.3, 0.1]
        rows.append(deepest * shape[:, None] * direction)
    return (np.concatenate(rows) + bias + noise * rng.normal(size=(count * len(shape), 6))) * SCALE


def read_through(load, band=0.0, step=0.0):
    """Loads (m, 6) as a sensor with a dead-band and a step, both N, reads them."""
    shown = step * SCALE * np.round(load / (step * SCALE)) if step else load
    return np.where(np.abs(load) < band * SCALE, 0.0, shown)


@pytest.mark.parametrize("step", [0.0, 0.01, 0.05])
@pytest.mark.parametrize("band", [0.1, 0.3])
def test_a_planted_band_is_found_with_its_width(band, step):
    """Half widths of 0.1 and 0.3 N, with and without steps: within a step and 5 %."""
    found = find_dead_band([read_through(presses(seed), band, step) for seed in range(3)])
    assert found.band["force"] == pytest.approx(band, rel=0.05, abs=step)
    assert found.band["torque"] == pytest.approx(ARM * band, rel=0.05, abs=ARM * step)
    assert {"fx", "fy", "tx", "tz"} <= set(found.axes)


def test_the_share_of_zeros_is_that_of_the_readings():
    """It is counted over the components that show the band, and stands in the sentence."""
    readings = read_through(presses(), 0.2)
    found = find_dead_band([readings])
    assert found.zeros == pytest.approx((readings == 0).mean())
    assert f"{100 * found.zeros:.0f} % of the readings" in found.words
    assert "up to 0.20 N (force) and 0.0040 N m (torque)" in found.words


def test_a_band_of_the_forces_alone_is_told_so():
    """Torques that are read as they are have no band."""
    load = presses()
    readings = np.hstack([read_through(load, 0.2)[:, :3], load[:, 3:]])
    found = find_dead_band([readings])
    assert set(found.band) == {"force"}
    assert found.axes == ("fx", "fy", "fz")


@pytest.mark.parametrize("steps", [1.5, 2.5])
def test_a_band_of_few_steps_is_found(steps):
    """A band in which one number is missing on either side of 0, or two."""
    found = find_dead_band([read_through(presses(seed), steps * 0.07, 0.07) for seed in range(3)])
    assert found.band["force"] == pytest.approx(0.07 * np.ceil(steps), rel=1e-6)


@pytest.mark.parametrize("noise", [0.03, 0.1])
@pytest.mark.parametrize("is_sharp", [True, False])
def test_a_sensor_that_saturates_has_no_band(noise, is_sharp):
    """Steps of 0.01 N below its bound, and other numbers above: one, or one for each load."""
    load = presses(noise=noise)
    readings, bound = read_through(load, step=0.01), 2.0037 * SCALE
    above = np.sign(load) * (bound if is_sharp else bound * (1.0 + 0.1 * np.tanh(np.abs(load / bound) - 1.0)))
    assert find_dead_band([np.where(np.abs(readings) > bound, above, readings)]) is None


@pytest.mark.parametrize("noise", [0.03, 0.1, 0.3])
@pytest.mark.parametrize("step", [0.0, 0.01, 0.1, 0.3])
def test_steps_alone_are_no_band(step, noise):
    """Rounding crowds 0 as it crowds every other number, however coarse it is."""
    assert find_dead_band([read_through(presses(noise=noise), step=step)]) is None


def test_loads_that_occur_equally_often_are_no_band():
    """One step about 0 holds half as many readings as the two beyond it, and a logged load is often repeated."""
    step = 2.0**-7
    for seed in range(12):
        rng = np.random.default_rng(seed)
        readings = step * rng.integers(-30, 31, (12_000, 6))
        assert find_dead_band([np.repeat(readings, rng.integers(1, 4, 12_000), axis=0)]) is None, seed


def test_large_loads_that_are_shrunk_make_no_band():
    """A sensor that saturates logs large loads closer together: small ones look far apart then, and are not."""
    step = 2.0**-7
    readings = step * np.random.default_rng(0).integers(-30, 31, (12_000, 6))
    shrunk = np.sign(readings) * (10 * step + 0.37 * (np.abs(readings) - 10 * step))
    assert find_dead_band([np.where(np.abs(readings) > 10 * step, shrunk, readings)]) is None


def test_readings_without_noise_are_no_band():
    """Free air of a simulated log is exactly 0; the forces of presses begin beside it all the same."""
    assert find_dead_band([presses(noise=0.0, count=40)]) is None


def test_loads_that_stay_away_from_zero_are_no_band():
    """A sensor whose zero is 3 N off never comes near 0, except in presses against it."""
    assert find_dead_band([presses(bias=3.0)]) is None
    assert find_dead_band([read_through(presses(bias=3.0, deepest=1.0), 0.2)]) is None


def test_two_levels_with_nothing_between_are_no_band():
    """Free air at 1 N and contact at -1 N leave numbers about 0 out, but zeros do not stand in for them."""
    rng = np.random.default_rng(0)
    load = np.where(rng.random((4000, 6)) < 0.5, 1.0, -1.0) + 0.2 * rng.normal(size=(4000, 6))
    assert find_dead_band([np.round(load * SCALE, 4)]) is None


def test_one_component_alone_is_no_band():
    """A broken axis is not a dead-band."""
    readings = presses()
    readings[:, 0] = read_through(readings, 0.2)[:, 0]
    assert find_dead_band([readings]) is None


@example(433, 0.01, 0.0, 0.05)
@given(
    st.integers(0, 10_000), st.floats(0.01, 0.5), st.floats(-0.5, 0.5), st.sampled_from([0.0, 0.01, 0.05, 0.2])
)  # fmt: skip
def test_no_band_is_found_where_there_is_none(seed, noise, bias, step):
    """Whatever the noise, the zero and the step of the sensor."""
    assert find_dead_band([read_through(presses(seed, noise, 3, bias=bias), step=step)]) is None


@pytest.mark.parametrize("readings", [[], [np.full((50, 6), np.nan)], [np.zeros((5000, 6))]])
def test_readings_that_say_nothing_are_no_band(readings):
    """None at all, none that is known, and a sensor that only ever reads 0."""
    assert find_dead_band(readings) is None


@pytest.mark.slow
def test_readings_of_a_store_are_those_of_its_log(tmp_path):
    """Each trajectory with forces gives its readings, without zero and weight taken off."""
    opened = OpenedStore.planned(Store.open(recorded_store(tmp_path)), CalibrationOptions().pads)
    logged = StoreReadings(opened).logged()
    assert len(logged) == len(opened.trajectories)
    for readings, row in zip(logged, opened.trajectories, strict=True):
        name = next(name for name in row["spans"] if name.partition("@")[0] == "wrench")
        np.testing.assert_array_equal(readings, opened.store.signal(name).values(*row["spans"][name]))
