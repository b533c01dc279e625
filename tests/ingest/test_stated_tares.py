"""What is stated about a recording, and is true, never makes its forces worse."""

import numpy as np
import pytest
from few_examples import few
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.contact import contact_wrench
from tactiledata.ingest.forces.gravity import STANDARD_GRAVITY
from tactiledata.ingest.forces.tare import find_zero
from tactiledata.ingest.trajectories.segment import segment_by_contact
from tactiledata.units import SIGNAL_COLUMNS, signal_units

START = 1_700_000_000_000_000_000
RATE = 100
MASS, CENTRE = 0.45, [0.0, 0.0, 0.06]
TOUCH_SECONDS, FREE, RAMP = 8.0, 1.0, 0.4
NOISE = 0.05
"""N, one component."""
WITHIN = 0.15
"""N: what noise, drift within a touch and the measured jump of a tare leave."""
WITHIN_A_RAMP = 0.2
"""N: largest error allowed where the force rises while the sensor is tared; 1 % of such worlds are beyond 0.15 N."""


def stored(t_ns, values, name):
    columns = SIGNAL_COLUMNS[name]
    return StoredSignal(t_ns, values, columns, signal_units(columns), "", Stamps(t_ns))


class World:
    """Touches one after another, each in its own pose; a sensor with drift (N/s), set to zero at ``tares`` (s)."""

    def __init__(self, seed, touches, dwell, tares, drift=0.01, peak=9.0, sign=1.0, compensated=False):
        rng = np.random.default_rng(seed)
        self.seconds = np.arange(int(touches * TOUCH_SECONDS * RATE)) / RATE
        self.t_ns = START + (self.seconds * 1e9).astype(np.int64)
        touch, into = np.divmod(self.seconds, TOUCH_SECONDS)
        leaves = FREE + RAMP + dwell
        shape = np.clip((into - FREE) / RAMP, 0, 1) * np.clip((leaves + RAMP - into) / RAMP, 0, 1)
        self.truth = np.zeros((len(into), 6))
        self.truth[:, 2] = shape * peak * (0.9 + 0.1 * np.cos(touch))
        self.truth[:, 0] = shape * 0.7
        self.pressed = shape == 1
        # the arm turns in the pause after each touch
        turned = touch + np.clip((into - 7.0) / 0.9, 0, 1)
        self.turn = Rotation.from_euler("xz", np.stack([np.pi + 0.4 * np.sin(2 * turned), 0.3 * turned], axis=1))
        weight = self.turn.inv().apply([0, 0, -MASS * STANDARD_GRAVITY])
        weight = np.concatenate([weight, np.cross(CENTRE, weight)], axis=1)
        felt = -self.truth + 3.0 + drift * self.seconds[:, None]
        felt = felt + (0 if compensated else weight)
        zero = np.zeros((len(felt), 6))
        for moment in sorted(tares):
            after = self.seconds >= moment
            if after.any():
                zero[after] = felt[np.flatnonzero(after)[0]]
        noise = rng.normal(0, NOISE, felt.shape) * [1, 1, 1, 0.02, 0.02, 0.02]
        self.wrench = stored(self.t_ns, sign * (felt - zero + noise), "wrench")
        poses = np.concatenate([np.tile([0.4, 0.1, 0.3], (len(felt), 1)), self.turn.as_quat()], axis=1)
        self.tcp = stored(self.t_ns, poses, "tcp")
        starts = START + (np.arange(touches) * TOUCH_SECONDS * 1e9).astype(np.int64)
        self.spans = [(f"t{n}", int(start), int(start + 7e9)) for n, start in enumerate(starts)]
        self.facts = {
            "tool": {"mass": MASS, "centre_of_gravity": CENTRE},
            "gravity": "compensated" if compensated else "included",
            "sign": "load_on_sensor" if sign > 0 else "reaction",
            "tare_ns": [START + int(moment * 1e9) for moment in tares],
        }

    def described(self, stated):
        pose = {"xyz": [0.0, 0.0, 0.0], "xyzw": [0.0, 0.0, 0.0, 1.0]}
        robot = {"tcp_from_gel": pose, "tcp_from_ft": pose}
        if "tool" in stated:
            robot["tool"] = self.facts["tool"]
        wrench = {key: self.facts[key] for key in ("gravity", "sign", "tare_ns") if key in stated}
        document = {"format": "tactiledata-log/1", "sensors": {"D1": {"model": "digit"}}, "robot": robot}
        return LogDescription.checked({**document, "wrench": wrench}, "test")

    def answer(self, stated, named=True):
        """Contact wrench, and codes of findings, from what is stated."""
        description = self.described(stated)
        spans = self.spans
        if not named:
            rough = contact_wrench(description, self.wrench, self.tcp, [])
            spans = [(t.name, t.start_ns, t.end_ns) for t in segment_by_contact(rough.signal, rough.noise, "")[0]]
        answer = contact_wrench(description, self.wrench, self.tcp, spans)
        return answer.signal.values, {finding.code for finding in answer.findings}

    def error(self, stated, named=True):
        """N: the largest mean error of the force over the dwell of a touch."""
        off = (self.answer(stated, named)[0] - self.truth)[:, :3]
        return max(
            np.linalg.norm(off[rows & self.pressed].mean(axis=0))
            for rows in (self.seconds // TOUCH_SECONDS == touch for touch in range(len(self.spans)))
        )


ALL = ("tool", "gravity", "sign", "tare_ns")
PLACES = {
    "free air of every touch": lambda touches, dwell: [n * TOUCH_SECONDS + 0.5 for n in range(touches)],
    "between touches": lambda touches, dwell: [n * TOUCH_SECONDS + 7.95 for n in range(touches)],
    "start of the log": lambda touches, dwell: [0.1],
    "before and after the log": lambda touches, dwell: [-30.0, 1e4],
    "twice in one free air": lambda touches, dwell: [0.3, 0.6],
    "while pressing": lambda touches, dwell: [TOUCH_SECONDS + FREE + RAMP + dwell / 2],
    "on the way into the gel": lambda touches, dwell: [TOUCH_SECONDS + FREE + RAMP / 2],
}


def test_a_tare_in_the_air_of_every_touch_leaves_its_forces_right():
    """Dwells of 4 s between tares: no zero is taken from them, and nothing claims that the touches begin in contact."""
    world = World(1, 6, 4.0, PLACES["free air of every touch"](6, 4.0))
    assert world.error(ALL) < WITHIN
    assert "no-free-air" not in world.answer(ALL)[1]


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("place", PLACES)
def test_forces_are_right_wherever_the_sensor_was_tared(place, named):
    """A tare in free air, in contact, on the way, before or after: the planted force of every touch comes back."""
    world = World(2, 4, 3.0, PLACES[place](4, 3.0))
    assert world.error(ALL, named) < WITHIN


@pytest.mark.slow
@few(60)
@example(0, 2, 4.0, "while pressing", 0.0, 6.0, 1.0, False, set())
@example(115641, 2, 1.0, "on the way into the gel", 0.0, 2.0, 1.0, False, set())
@given(
    st.integers(0, 10**6),
    st.integers(2, 5),
    st.floats(0.5, 4.0),
    st.sampled_from(sorted(PLACES)),
    st.floats(-0.02, 0.02),
    st.floats(2.0, 12.0),
    st.sampled_from([1.0, -1.0]),
    st.booleans(),
    st.sets(st.sampled_from(ALL)),
)
def test_the_truth_never_makes_forces_worse(seed, touches, dwell, place, drift, peak, sign, compensated, kept):
    """All that is true, stated, gives forces no worse than any part of it does, and right ones."""
    tares = PLACES[place](touches, dwell)
    world = World(seed, touches, dwell, tares, drift, peak, sign, compensated)
    whole = world.error(ALL)
    # a jump within a ramp is known less well; a zero that is known at one end of a dwell drifts until its other end
    known = WITHIN_A_RAMP if place == "on the way into the gel" else WITHIN
    assert whole < known + abs(drift) * dwell
    assert whole < world.error(sorted(kept)) + 0.05


@pytest.mark.slow
@pytest.mark.parametrize("true", [[], [0.1]])
@pytest.mark.parametrize("count", [5, 50, 300, 970])
def test_tares_that_never_were_are_said_and_move_no_force(count, true):
    """Moments stated at random, most of them where the reading is not zero, beside a true one or none."""
    for seed in range(3):
        world = World(seed, 4, 3.0, true)
        honest = world.error(ALL)
        moments = np.random.default_rng(seed).uniform(0.2, 31, count)
        world.facts["tare_ns"] = [*world.facts["tare_ns"], *(START + int(moment * 1e9) for moment in moments)]
        assert world.error(ALL) < honest + 0.02
        assert "tare-not-seen" in world.answer(ALL)[1]


def test_tares_at_the_last_samples_are_no_fault():
    """Several moments between the last two samples: the forces before are right, and nothing breaks."""
    world = World(1, 2, 3.0, [0.1])
    world.facts["tare_ns"] = [*world.facts["tare_ns"], *(int(world.t_ns[-1]) - 10**6 * n for n in range(5))]
    assert world.error(ALL) < WITHIN


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda ns: ns // 10**9, "these look like seconds"),
        (lambda ns: ns // 10**6, "these look like milliseconds"),
        (lambda ns: ns + 30 * 86400 * 10**9, "more than a day"),
        (lambda ns: ns - 2 * 86400 * 10**9, "more than a day"),
    ],
)
def test_tares_of_another_time_are_said_and_not_used(change, words):
    """Seconds that were read as nanoseconds, or another week's tares: a finding says so, and forces stay right."""
    world = World(2, 4, 3.0, [-10.0])
    assert "tare-elsewhere" not in world.answer(ALL)[1]
    world.facts["tare_ns"] = [change(moment) for moment in world.facts["tare_ns"]]
    assert world.error(ALL) < WITHIN
    answer = contact_wrench(world.described(ALL), world.wrench, world.tcp, world.spans)
    [finding] = [one for one in answer.findings if one.code == "tare-elsewhere"]
    assert (finding.severity, finding.count) == ("warning", 1)
    assert words in finding.message


@pytest.mark.parametrize("pause", [1.0, 60.0])
@pytest.mark.parametrize("step", [0.5, 3.0, 5.0, 8.0])
def test_a_zero_that_moved_between_recorded_touches_is_no_press(pause, step):
    """Free air reads a constant until the tare and nothing after it, in every touch: the jump back was not recorded."""
    rng = np.random.default_rng(3)
    times, loads, planted, spans, tares = [], [], [], [], []
    for number in range(6):
        start = int(number * (7.0 + pause) * 1e9)
        seconds = np.arange(700) * 0.01
        pressed = np.clip((seconds - 1.5) / 0.5, 0, 1) * np.clip((6.0 - seconds) / 0.5, 0, 1)
        force = np.outer(pressed, [0.3, 0, 3.0 + number, 0, 0, 0])
        offset = np.where(seconds[:, None] < 0.5, step * np.array([0.42, -0.32, 0.85, 0, 0, 0]), 0.0)
        times.append(start + (seconds * 1e9).astype(np.int64))
        loads.append(force + offset + rng.normal(0, 0.02, (700, 6)))
        planted.append(force)
        spans.append((f"touch-{number}", start, start + 7_000_000_000))
        tares.append(start + 500_000_000)
    zero = find_zero(np.concatenate(times), np.concatenate(loads), spans, tares)
    off = np.linalg.norm((np.concatenate(loads) - zero.bias - np.concatenate(planted))[:, :3], axis=1).reshape(6, 700)
    assert np.median(off[:, :45], axis=1).max() < 0.1
    assert np.median(off[:, 250:500], axis=1).max() < 0.1
    assert "no-free-air" not in [finding.code for finding in zero.findings]
