"""Inertia of the tool is read from readings in free air, with its mass, and nothing else is taken for it."""

from dataclasses import replace

import numpy as np
import pytest
from recorded_touches import recorded_store

from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.diagnose.zeros.inertia import FEWEST, FreeAirMoves, find_inertia
from tactiledata.diagnose.zeros.readings import StoreReadings
from tactiledata.effects.touch.felt_acceleration import FREQUENCIES, felt_accelerations
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.read.reader import Store

NOISE = 0.05
"""N, of a reading."""


def moves(mass=0.0, frequency=FREQUENCIES[20], count=20, seed=0, drift=0.0, memory=0.0, follows_speed=0.0):
    """Stretches of free air of 1 s in which the arm moves for a third of a second, at a time and speed of chance.

    Beside the force of inertia there is noise with a memory, a drift of the zero in N/s, and a force along the speed in
    N s/m, as of a cable.
    """
    rng = np.random.default_rng(seed)
    found = []
    for number in range(count):
        seconds = np.arange(0.0, 1.0, 0.01)
        start, velocity = rng.uniform(0.1, 0.5), rng.normal(size=3) * 2e-3
        places = np.clip(np.arange(0.0, 1.0, 0.008) - start, 0.0, 1 / 3)[:, None] * velocity
        felt = felt_accelerations(seconds, np.arange(0.0, 1.0, 0.008), places)
        white = NOISE * rng.normal(size=(len(seconds), 3))
        for row in range(1, len(white)):
            white[row] += memory * (white[row - 1] - white[row])
        moving = (seconds > start) & (seconds < start + 1 / 3)
        force = white + drift * seconds[:, None] + rng.normal(size=3)
        force += follows_speed * moving[:, None] * velocity * rng.choice([-1.0, 1.0])
        force -= mass * felt[:, FREQUENCIES.index(frequency)]
        found.append(FreeAirMoves(number, seconds, force, felt, np.zeros(len(FREQUENCIES))))
    return found


@pytest.mark.parametrize("frequency", [FREQUENCIES[5], FREQUENCIES[20], FREQUENCIES[33]])
def test_a_planted_mass_is_found(frequency):
    """A mass of 0.8 kg within two standard errors, at its frequency within three neighbours."""
    found = find_inertia(moves(0.8, frequency))
    assert found.mass == pytest.approx(0.8, abs=2.5 * found.error)
    assert abs(FREQUENCIES.index(found.frequency) - FREQUENCIES.index(frequency)) <= 3
    assert found.p == 0.001
    assert f"of the order of {found.mass:.2g}" in found.words
    assert found.document["values"]["mass"] == found.mass


def test_noise_of_positions_does_not_make_the_mass_smaller():
    """Positions with 2 um of noise blur the acceleration: what they add to its squares is taken off, to 15 %."""
    rng = np.random.default_rng(1)
    seconds = np.arange(0.0, 1.0, 0.008)
    unit = felt_accelerations(seconds, seconds, rng.normal(size=(len(seconds), 3)))
    blur = 2e-6**2 * (unit**2).mean(axis=(0, 2))
    noisy = [
        replace(
            one,
            acceleration=one.acceleration
            + felt_accelerations(one.seconds, seconds, 2e-6 * rng.normal(size=(len(seconds), 3))),
            blur=blur,
        )
        for one in moves(0.8, count=40)
    ]
    found, blurred = find_inertia(noisy), find_inertia([replace(one, blur=np.zeros_like(blur)) for one in noisy])
    assert found.mass == pytest.approx(0.8, rel=0.15)
    assert blurred.mass < found.mass


CLOSEST = [(1, 0.875, 0.0), (9051, 0.857, -0.101), (349, 0.811, 0.13), (8616, 0.772, -0.253), (114, 0.244, -0.058)]
"""Seed, memory and drift of worlds that look most like inertia, of 700 drawn ones."""


def drawn(count):
    """Seeds, memories and drifts of as many worlds, drawn once for all."""
    rng = np.random.default_rng(5)
    return zip(rng.integers(0, 10_000, count), rng.uniform(0, 0.95, count), rng.uniform(-0.3, 0.3, count), strict=True)


@pytest.mark.parametrize(("seed", "memory", "drift"), [*CLOSEST, *drawn(20)])
def test_nothing_is_found_where_there_is_none(seed, memory, drift):
    """Nothing is found without inertia, whatever the memory of the noise and the drift of the zero, N/s."""
    assert find_inertia(moves(seed=seed, memory=memory, drift=drift)) is None


def test_a_force_that_follows_the_speed_is_no_inertia():
    """A cable that pulls along the speed or against it, by up to 0.4 N, in eight worlds."""
    assert not any(find_inertia(moves(seed=seed, follows_speed=100.0)) for seed in range(8))


def test_a_negative_mass_is_no_inertia():
    """A force along the acceleration has another cause, such as a sign in the log."""
    assert find_inertia(moves(-0.8)) is None


def test_an_arm_that_stands_still_shows_nothing():
    """Without moves there is no acceleration."""
    still = [replace(one, acceleration=np.zeros_like(one.acceleration)) for one in moves(0.8)]
    assert find_inertia(still) is None


def test_few_trajectories_show_nothing():
    """Thirteen trajectories are too few, however large the mass, and eighteen are enough; those of one count once."""
    assert find_inertia(moves(3.0, count=FEWEST - 1)) is None
    same = [replace(one, trajectory=0) for one in moves(3.0)]
    assert find_inertia(same) is None
    assert find_inertia(moves(3.0, count=FEWEST + 4)) is not None
    assert find_inertia([]) is None


@pytest.mark.slow
def test_recorded_tools_swing(tmp_path):
    """The rig's own tool of 1.2 kg on an arm of 18 Hz is found in a store, within a factor of two; none is not."""
    generate = {"count": 24, "depth": [0.0004, 0.0006]}

    def found(name, **changes):
        store = Store.open(recorded_store(tmp_path / name, generate=generate, **changes))
        return find_inertia(StoreReadings(OpenedStore.planned(store, CalibrationOptions().pads)).moves())

    heavy = found("a", hidden=[{"effect": "inertia", "strength": "strong"}])
    # slow moves and positions with noise hardly tell the frequency
    assert 0.5 < heavy.mass / 1.2 < 2.0
    assert found("b") is None


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("reading", [0.0, np.nan])
def test_a_sensor_that_reads_nothing_reads_no_inertia(reading):
    """A reading of 0 in place of every force has no mass and no error: nothing over nothing is no finding."""
    silent = [replace(one, force=np.full_like(one.force, reading)) for one in moves(0.8)]
    assert find_inertia(silent) is None
