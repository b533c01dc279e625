"""Hidden effects of loads, the force sensor and its clock: each against a hand computation, in air and in contact."""

import numpy as np
import pytest
from hidden_worlds import PRESS, SLIDE, played, stated, strong, touch

from tactiledata.rig.hidden.load import bouc_wen

TURNED = [
    touch("a", steps=[PRESS, SLIDE], tilt=[0.12, 0.0]),
    touch("b", "punch", steps=[PRESS], tilt=[0.0, -0.12], yaw=1.0),
]


def both(entry, **changes):
    """The log with an effect and without: the same samples of the same touches."""
    found, plain = played([entry], TURNED, **changes), played((), TURNED, **changes)
    for with_it, without in zip(found.performance.plays, plain.performance.plays, strict=True):
        np.testing.assert_array_equal(with_it.contact.wrench, without.contact.wrench)
    return found, plain


def test_a_heavier_tool_weighs_in_every_pose():
    """Never set to zero, the reading misses 0.06 kg x 9.81 m/s² everywhere, in air as in contact; it turns."""
    found, plain = both(stated("tool_weight", mass=0.06))
    more = found.readings - plain.readings
    np.testing.assert_allclose(np.linalg.norm(more[:, :3], axis=1), 0.06 * 9.81, rtol=1e-9)
    assert np.ptp(more[found.in_air, :3], axis=0).max() > 0.05
    assert not np.abs(both(stated("tool_weight", mass=0.0, lever=0.01))[0].readings - plain.readings)[:, :3].any()
    torque = both(stated("tool_weight", lever=0.01))[0].readings[:, 3:] - plain.readings[:, 3:]
    assert 0.01 * 0.45 * 9.81 / 4 < np.linalg.norm(torque, axis=1).max() < 1.2 * 0.01 * 0.45 * 9.81


def test_a_zero_set_in_one_pose_leaves_the_turn_of_the_weight():
    """With a tare at the start of the log, nothing is left there, and a sine of the tilt later."""
    found, plain = both(stated("tool_weight", mass=0.06), recordings={"tare": "log"})
    more = np.linalg.norm((found.readings - plain.readings)[:, :3], axis=1)
    start = (found.seconds > 0.11) & (found.seconds < 0.2)
    end = found.seconds > found.seconds[-1] - 0.3
    assert more[start].max() < 1e-9
    # two tilts of 0.12 rad about axes that a yaw of 1 rad turns
    assert 0.5 * 0.12 < more[end].mean() / (0.06 * 9.81) < 2 * 0.12


def test_a_cable_pulls_with_the_wrist_only():
    """Bounded by its force, still while the arm is still, different on the way back."""
    found, plain = both(stated("cable_drag", force=0.5))
    more = (found.readings - plain.readings)[:, :3]
    size = np.linalg.norm(more, axis=1)
    assert 0.02 < size.max() < 0.5 * 1.6
    first = found.seconds < 0.5
    assert np.ptp(more[first], axis=0).max() < 1e-6
    way = np.concatenate([np.linspace(0, 10, 200), np.linspace(10, 0, 200)])
    value = bouc_wen(way)
    assert value[199] == pytest.approx(1.0, abs=1e-3)
    assert value[-1] == pytest.approx(-1.0, abs=1e-3)
    assert np.abs(value).max() <= 1.0


def test_inertia_is_mass_times_acceleration():
    """Above the motion's frequencies, -m a of the carried tool acts on the long way between touches, none at rest."""
    found, plain = both(stated("inertia", mass=0.6, frequency=100.0))
    more = np.linalg.norm((found.readings - plain.readings)[:, :3], axis=1)
    performance = found.performance
    start, end = performance.plays[0].end_ns, performance.plays[1].start_ns
    host = performance.start_ns + np.rint(found.seconds * 1e9).astype(np.int64)
    way = (host > start + 0.1e9) & (host < end - 0.1e9)
    step = 2_000_000
    places = [performance.tcp(host[way] + shift)[:, :3, 3] for shift in (-step, 0, step)]
    acceleration = np.linalg.norm(places[0] - 2 * places[1] + places[2], axis=1) / (step * 1e-9) ** 2
    np.testing.assert_allclose(np.median(more[way] / acceleration), 0.6, rtol=0.03)
    assert more[found.seconds < 0.8].max() < 1e-3


def test_a_turned_frame_keeps_lengths():
    """|F| and |T| stay; the direction turns by the angle."""
    found, plain = both(stated("frame_rotation", yaw=0.05))
    for part in (slice(0, 3), slice(3, 6)):
        lengths = [np.linalg.norm(log.readings[:, part], axis=1) for log in (found, plain)]
        np.testing.assert_allclose(*lengths, atol=1e-9)
    np.testing.assert_allclose(found.readings[:, 2], plain.readings[:, 2], atol=1e-12)
    angle = np.angle((found.readings[:, :2] @ [1, 1j]) / (plain.readings[:, :2] @ [1, 1j]))
    np.testing.assert_allclose(angle, 0.05, atol=1e-9)


def test_cross_talk_is_one_fixed_map_of_the_wrench():
    """A least-squares fit of wrench and wrench times |F| explains all of it; the same in another log."""
    found, plain = both(strong("cross_talk"))
    size = np.linalg.norm(plain.readings[:, :3], axis=1, keepdims=True) / 15.0
    terms = np.concatenate([plain.readings, plain.readings * size], axis=1)
    matrix, *_ = np.linalg.lstsq(terms, found.readings - plain.readings, rcond=None)
    np.testing.assert_allclose(terms @ matrix, found.readings - plain.readings, atol=1e-8)
    np.testing.assert_allclose(np.abs(np.diag(matrix[:6])), 0.05, rtol=1e-6)


@pytest.mark.slow
def test_a_zero_creeps_to_its_end_in_air_as_in_contact():
    """Without the walk: size (1 - exp(-t / T)), whatever is touched; the walk grows as the root of time."""
    found, plain = both(stated("ft_drift", size=2.0, time=20.0))
    creep = np.linalg.norm((found.readings - plain.readings)[:, :3], axis=1)
    np.testing.assert_allclose(creep, 2.0 * (1 - np.exp(-found.seconds / 20.0)), atol=1e-9)
    walks = []
    for seed in range(40):
        walked, still = (played(entry, [touch()], seed=seed) for entry in ([stated("ft_drift", walk=0.1)], []))
        walks.append((walked.readings - still.readings)[-1, :3])
    assert np.std(walks) == pytest.approx(0.1 * np.sqrt(walked.seconds[-1]), rel=0.2)


def test_a_slow_sensor_lags_by_its_delay_and_filter():
    """The missing area while a force builds up is force x lag, and comes back when it goes: opposite signs."""
    long = [touch(steps=[PRESS, {"dwell": {"time": 2.0}}])]
    found = played([stated("lag", delay=0.02, period=0.05)], long)
    plain = played((), long)
    off = (plain.readings - found.readings)[:, 2]
    push = np.abs(plain.readings[:, 2] - plain.readings[0, 2])
    held = np.flatnonzero(push >= 0.999 * push.max())
    middle = held[len(held) // 2]
    force = plain.readings[middle, 2] - plain.readings[0, 2]
    lag = 0.02 + 1.6 / (2 * np.pi / 0.05)
    assert off[:middle].sum() / 100.0 / force == pytest.approx(lag, rel=0.02)
    assert off[middle:].sum() / 100.0 / force == pytest.approx(-lag, rel=0.02)
    assert abs(off[middle]) < 1e-6


def test_a_dead_band_reads_zero_below_and_quanta_above():
    """No reading lies strictly between zero and the band less half a quantum, and forces come as multiples."""
    found, plain = both(stated("dead_band", band=0.5, quantum=0.1))
    small = np.abs(plain.readings[:, :3]) < 0.5
    assert small.any()
    assert (found.readings[:, :3][small] == 0).all()
    rest = found.readings[:, :3][~small]
    np.testing.assert_allclose(rest, np.round(rest / 0.1) * 0.1, atol=1e-12)
    assert np.abs(rest - plain.readings[:, :3][~small]).max() <= 0.05 + 1e-12


def test_a_range_ends_softly():
    """Never beyond the limit; half of it reads true within 0.1 %; torques stay."""
    found, plain = both(stated("saturation", bound=1 / 4.0))
    told, true = np.abs(found.readings[:, 2]), np.abs(plain.readings[:, 2])
    assert true.max() > 4.2
    assert told.max() < 4.0
    np.testing.assert_allclose(told[true < 2.0], true[true < 2.0], rtol=1e-3)
    np.testing.assert_array_equal(found.readings[:, 3:], plain.readings[:, 3:])


def test_a_skewed_clock_gains_and_falls_back():
    """A skewed clock is off by skew t - jump floor(t / every), in stamps only, and stamps still rise."""
    found, plain = both(stated("clock_skew", skew=1e-4, jump=0.004, every=3.0))
    np.testing.assert_array_equal(found.readings, plain.readings)
    off = (found.stamps - plain.stamps) * 1e-9
    np.testing.assert_allclose(off, 1e-4 * found.seconds - 0.004 * np.floor(found.seconds / 3.0), atol=1e-6)
    assert (np.diff(found.stamps) > 0).all()
    backwards = both(stated("clock_skew", jump=0.05, every=3.0))[0]
    assert (np.diff(backwards.stamps) > 0).all()
