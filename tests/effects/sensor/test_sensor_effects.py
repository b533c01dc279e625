"""Effects of the force sensor, in closed form."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.effects.sensor.cable_drag import with_play
from tactiledata.effects.sensor.clipping import limited, selection_bias
from tactiledata.effects.sensor.quantisation import mean_reading


def in_free_air(touch, moved, n=90, **fields):
    """A touch that never touches."""
    return moved(touch, np.arange(float(n)), np.full(n, -1e-3), **fields)


def test_weight_is_a_sinusoid_of_the_wrist(touch, play, moved):
    """Turned once about x, 20 g shows as a sinusoid of 0.196 N, its centre as a torque, both without contact."""
    angle = np.linspace(0.0, 2 * np.pi, 90)
    gravity = Rotation.from_rotvec(np.outer(angle, [1.0, 0.0, 0.0])).apply([0.0, 0.0, -9.81])
    path = in_free_air(touch, moved, gravity=gravity)
    wrench = play("tool_weight", on=path, mass=0.02, moment_z=1e-3).wrench
    np.testing.assert_allclose(wrench[:, 1], 0.02 * 9.81 * np.sin(angle), atol=1e-12)
    np.testing.assert_allclose(wrench[:, 2], -0.02 * 9.81 * np.cos(angle), atol=1e-12)
    np.testing.assert_allclose(wrench[:, 3], -1e-3 * 9.81 * np.sin(angle), atol=1e-12)
    assert (wrench[:, [0, 5]] == 0).all()


def test_a_zero_hides_what_does_not_change(touch, play):
    """Where the zero was taken from this touch, a weight at one orientation is gone; of a drift its slope is left."""
    zeroed = dataclasses.replace(touch, tare=np.arange(len(touch)) < 8)
    np.testing.assert_allclose(
        play("tool_weight", on=zeroed, mass=0.06).wrench, play(on=zeroed).wrench, rtol=0, atol=1e-12
    )
    left = play("sensor_drift", on=zeroed, fx=3.0, time=1200.0).wrench - play(on=zeroed).wrench
    powered = touch.powered
    wanted = -3.0 * np.exp(-powered / 1200.0)
    np.testing.assert_allclose(left[:, 0], wanted - np.median(wanted[:8]), atol=1e-12)
    assert np.abs(left[:, 0]).max() < 0.03


def test_drift_is_there_without_contact(touch, play, moved):
    """The drift is a bias of b (1 - exp(-t / T)) on each component, in free air."""
    path = in_free_air(touch, moved, powered=np.arange(90.0) * 60)
    wrench = play("sensor_drift", on=path, fz=2.0, ty=0.05, time=1200.0).wrench
    warm = 1 - np.exp(-np.arange(90.0) * 60 / 1200.0)
    np.testing.assert_allclose(wrench, np.outer(warm, [0, 0, 2.0, 0, 0.05, 0]), atol=1e-12)


def test_a_turned_frame_keeps_the_norm(play):
    """|F|, |M| and F . M stay; each turn is the one about its axis."""
    plain = play().wrench
    wrench = play("frame_rotation", tilt_x=0.01, tilt_y=-0.015, yaw=0.05).wrench
    for part in (slice(0, 3), slice(3, 6)):
        np.testing.assert_allclose(
            np.linalg.norm(wrench[:, part], axis=1), np.linalg.norm(plain[:, part], axis=1), rtol=1e-12
        )
    np.testing.assert_allclose(
        (wrench[:, :3] * wrench[:, 3:]).sum(axis=1), (plain[:, :3] * plain[:, 3:]).sum(axis=1), atol=1e-12
    )
    assert np.abs(wrench - plain).max() > 0.05
    cos, sin = np.cos(0.05), np.sin(0.05)
    yawed = play("frame_rotation", yaw=0.05).wrench
    np.testing.assert_allclose(yawed[:, 0], cos * plain[:, 0] - sin * plain[:, 1], atol=1e-12)
    np.testing.assert_allclose(yawed[:, 1], sin * plain[:, 0] + cos * plain[:, 1], atol=1e-12)
    tilted = play("frame_rotation", tilt_x=0.05).wrench
    np.testing.assert_allclose(tilted[:, 1], cos * plain[:, 1] - sin * plain[:, 2], atol=1e-12)


def test_a_frame_is_turned_about_the_origin_of_the_sensor(touch, play):
    """A sensor 0.15 m away that is turned about its x reads a torque about its own origin, turned; not the gel's."""
    pose = np.eye(4)
    pose[:3, 3] = [0.0, 0.0, 0.15]
    there = dataclasses.replace(touch, gel_from_sensor=np.tile(pose, (len(touch), 1, 1)))
    plain, found = play(on=there).wrench, play("frame_rotation", on=there, tilt_x=0.05).wrench
    turn = Rotation.from_rotvec([0.05, 0.0, 0.0]).as_matrix()
    force = plain[:, :3] @ turn.T
    lever = np.array([0.0, 0.0, 0.15])
    about_sensor = plain[:, 3:] - np.cross(lever, plain[:, :3])
    np.testing.assert_allclose(found[:, :3], force, atol=1e-12)
    np.testing.assert_allclose(found[:, 3:], about_sensor @ turn.T + np.cross(lever, force), atol=1e-12)
    assert np.abs(found[:, 3:] - plain[:, 3:] @ turn.T).max() > 0.01


def test_cross_talk_names_row_and_column(play):
    """What is called xz is what of z shows in x; frame by frame, against loops."""
    plain, values = play().wrench, {"xx": 0.02, "xz": -0.03, "zy": 0.01, "quadratic": 1e-3}
    found = play("gain_crosstalk", **values).wrench
    for frame in (60, 120, 180):
        for row, name in enumerate("xyz"):
            force = plain[frame, row]
            wanted = force + 1e-3 * force * abs(force)
            wanted += sum(values.get(name + other, 0.0) * plain[frame, place] for place, other in enumerate("xyz"))
            assert found[frame, row] == pytest.approx(wanted)
    np.testing.assert_array_equal(found[:, 3:], plain[:, 3:])


def test_cross_talk_of_torques_names_row_and_column(play):
    """What is called mx_z is the torque about x of a newton along z; x_mz is the force along x of a torque about z."""
    plain = play().wrench
    found = play("gain_crosstalk", mx=0.02, my_z=1e-3, z_mx=0.5).wrench
    wanted = plain.copy()
    wanted[:, 3] += 0.02 * plain[:, 3]
    wanted[:, 4] += 1e-3 * plain[:, 2]
    wanted[:, 2] += 0.5 * plain[:, 3]
    np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_cross_talk_is_that_of_the_axes_of_the_sensor(touch, play):
    """A gain of x of a sensor that is turned by a quarter about z, far away, is a gain of y with its torque."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, [0.0, 0.0, 0.15]
    there = dataclasses.replace(touch, gel_from_sensor=np.tile(pose, (len(touch), 1, 1)))
    plain, found = play(on=there).wrench, play("gain_crosstalk", on=there, xx=0.02).wrench
    np.testing.assert_allclose(found[:, 1], 1.02 * plain[:, 1], atol=1e-12)
    np.testing.assert_allclose(found[:, [0, 2]], plain[:, [0, 2]], atol=1e-12)
    extra = np.zeros((len(touch), 3))
    extra[:, 1] = 0.02 * plain[:, 1]
    np.testing.assert_allclose(found[:, 3:] - plain[:, 3:], np.cross([0.0, 0.0, 0.15], extra), atol=1e-12)


def test_play_is_a_stop_in_a_band():
    """The follower stays within half the play, moves only at the band's ends, and loops have the play's width."""
    angle = np.concatenate([np.linspace(0, 1, 101), np.linspace(1, -1, 201)])
    follows = with_play(angle, 0.2)
    assert np.abs(follows - angle).max() <= 0.1 + 1e-12
    assert follows[100] == pytest.approx(0.9)
    assert follows[121] == pytest.approx(0.9, abs=0.011)
    assert follows[-1] == pytest.approx(-0.9)
    np.testing.assert_array_equal(with_play(angle, 0.0), angle)


def test_a_cable_pulls_by_joint_and_not_by_gravity(touch, play, moved):
    """Force follows the last joint, to and fro on two lines."""
    angle = np.concatenate([np.linspace(0, 1, 45), np.linspace(1, 0, 45)])
    joints = np.zeros((90, 6))
    joints[:, 5] = angle
    path = in_free_air(touch, moved, joints=joints)
    wrench = play("cable_drag", on=path, fx=0.2, play=0.1).wrench
    np.testing.assert_allclose(wrench[44, 0], 0.2 * 0.95)
    assert wrench[60, 0] - wrench[29, 0] == pytest.approx(0.2 * 0.1)
    assert (wrench[:, 1:] == 0).all()
    twisted = play("cable_drag", on=path, tz=0.03, play=0.1).wrench
    np.testing.assert_allclose(twisted[:, 5], 0.15 * wrench[:, 0])
    assert (twisted[:, :5] == 0).all()


@pytest.mark.parametrize("centre", [0.0, 0.25, 1.0])
def test_inertia_acts_at_the_centre_of_gravity(touch, play, moved, centre):
    """The sensor, 0.12 m from the gel, reads the force of inertia with the torque of what is left of that lever."""
    seconds = np.arange(0.0, 1.0, 0.02)
    poses = np.tile(np.eye(4), (50, 1, 1))
    poses[:, 2, 3] = -0.12
    path = moved(touch, seconds, np.full(50, -5e-3), x=0.5 * 0.2 * seconds**2)
    path = dataclasses.replace(path, gel_from_sensor=poses)
    load = path.to_sensor(play("inertia", on=path, mass=0.5, centre=centre).wrench)[2:-2]
    np.testing.assert_allclose(load[:, 0], 0.5 * 0.2, rtol=1e-9)
    np.testing.assert_allclose(load[:, 4], 0.12 * (1.0 - centre) * 0.5 * 0.2, rtol=1e-9, atol=1e-12)


def test_inertia_is_mass_times_acceleration(touch, play, moved):
    """Constant acceleration on uneven frames gives -m a, constant speed nothing."""
    seconds = np.arange(0.0, 1.0, 0.02)
    path = moved(touch, seconds, np.full(50, -5e-3), x=0.5 * 0.2 * seconds**2, y=0.1 * seconds)
    wrench = play("inertia", on=path, mass=0.5).wrench
    np.testing.assert_allclose(wrench[2:-2, 0], -0.5 * 0.2, rtol=1e-9)
    np.testing.assert_allclose(wrench[2:-2, 1], 0.0, atol=1e-9)


def test_readings_are_multiples_of_a_step(play):
    """All are, none is off by more than half a step; below the dead-band there is a plateau of zeros."""
    plain = play().wrench
    wrench = play("quantisation", step=0.1, torque_step=0.01).wrench
    np.testing.assert_allclose(wrench[:, :3] / 0.1, np.round(wrench[:, :3] / 0.1), atol=1e-9)
    assert np.abs(wrench[:, :3] - plain[:, :3]).max() <= 0.05 + 1e-12
    assert np.abs(wrench[:, 3:] - plain[:, 3:]).max() <= 0.005 + 1e-12
    dead = play("quantisation", dead_band=0.5, noise=0.0).wrench[:, :3]
    small = np.abs(plain[:, :3]) < 0.5
    assert (dead[small] == 0).all()
    np.testing.assert_array_equal(dead[~small], plain[:, :3][~small])


def test_what_is_simulated_is_the_mean_of_noisy_readings():
    """The simulated force is the mean of readings that have noise and then a dead-band; far outside nothing changes."""
    chance = np.random.default_rng(3)
    force = np.linspace(-0.9, 0.9, 13)
    read = force + chance.normal(0.0, 0.1, (40_000, 13))
    mean = np.where(np.abs(read) < 0.25, 0.0, read).mean(axis=0)
    np.testing.assert_allclose(mean_reading(force, 0.25, 0.1), mean, atol=4 * 0.2 / 200)
    np.testing.assert_array_equal(mean_reading(force[[0, -1]], 0.25, 0.01), force[[0, -1]])
    np.testing.assert_allclose(mean_reading(force, 0.25, 1e-9), mean_reading(force, 0.25, 0.0), atol=1e-15)


def in_a_sensor(touch, weight):
    """The touch with a sensor that is turned and stands apart, and reads a weight beside the contact."""
    turn = Rotation.from_euler("zyx", [0.8, 0.2, -0.1]).as_matrix()
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = turn, [0.01, -0.02, 0.12]
    count = len(touch)
    return dataclasses.replace(
        touch, gel_from_sensor=np.tile(frame, (count, 1, 1)), sensor_weight=np.tile(weight, (count, 1))
    )


def test_the_sensors_frame_goes_there_and_back(touch):
    """A reading of the contact alone is its wrench again, and a pure force has its lever's torque."""
    there = in_a_sensor(touch, np.zeros(6))
    wrench = np.random.default_rng(0).normal(size=(len(touch), 6))
    np.testing.assert_allclose(there.from_sensor(there.to_sensor(wrench)), wrench, atol=1e-12)
    pushed = np.zeros((len(touch), 6))
    pushed[:, 2] = 1.0
    torque = -there.to_sensor(pushed)[0, 3:] @ there.gel_from_sensor[0, :3, :3].T
    np.testing.assert_allclose(torque, np.cross([-0.01, 0.02, -0.12], [0.0, 0.0, 1.0]), atol=1e-12)


def test_a_dead_band_is_of_the_sensors_own_reading(touch, play):
    """What the sensor reads of contact and weight together is 0 or untouched, axis by axis."""
    there = in_a_sensor(touch, np.array([0.2, -0.1, 0.3, 0.0, 0.0, 0.0]))
    before = there.to_sensor(play(on=there).wrench)
    values = {"dead_band": 0.5, "torque_dead_band": 0.02, "noise": 0.0, "torque_noise": 0.0}
    after = there.to_sensor(play("quantisation", on=there, **values).wrench)
    least = np.repeat([0.5, 0.02], 3)
    small = np.abs(before) < least
    assert small.any(axis=0).all()
    np.testing.assert_allclose(after, np.where(small, 0.0, before), atol=1e-12)


def test_readings_end_at_the_limit(play):
    """No component is beyond it, those within are left."""
    plain, wrench = play().wrench, play("clipping", inverse_limit=0.5).wrench
    assert np.abs(wrench[:, :3]).max() == 2.0
    within = np.abs(plain[:, :3]) <= 2.0
    np.testing.assert_array_equal(wrench[:, :3][within], plain[:, :3][within])


@pytest.mark.parametrize("force", [0.9, 1.0, 1.1, 5.0, 12.95])
def test_selection_bias_is_that_of_truncated_noise(force):
    """Against a million draws of which those in the range are kept."""
    noise = np.random.default_rng(5).normal(scale=0.1, size=1_000_000)
    kept = noise[(force + noise >= 1.0) & (force + noise <= 13.0)]
    bias = selection_bias(np.array([force]), 0.1, 1.0, 13.0)[0]
    assert bias == pytest.approx(kept.mean(), abs=5e-4)


def test_selection_concerns_only_what_can_have_been_chosen(play):
    """Free air and the middle of the range are left, and directions are kept."""
    plain, wrench = play().wrench, play("clipping", noise=0.1).wrench
    size = np.linalg.norm(plain[:, :3], axis=1)
    np.testing.assert_allclose(wrench[(size < 0.7) | (size > 2)], plain[(size < 0.7) | (size > 2)], rtol=1e-9)
    near = (size > 0.9) & (size < 1.2)
    assert (np.linalg.norm(wrench[near, :3], axis=1) > size[near]).all()
    np.testing.assert_allclose(np.cross(wrench[near, :3], plain[near, :3]), 0.0, atol=1e-12)


def test_a_knee_bends_between_what_stays_and_the_limit():
    """A knee leaves small forces as they are, ends at the limit, and bends smoothly between, for both signs."""
    force, limit = np.linspace(-9.0, 9.0, 1801), 5.0
    for knee in (0.1, 0.6):
        told = limited(force, limit, knee)
        below, beyond = np.abs(force) <= (1 - knee) * limit, np.abs(force) >= (1 + knee) * limit
        assert told[below].tobytes() == force[below].tobytes()
        np.testing.assert_allclose(told[beyond], np.copysign(limit, force[beyond]))
        slopes = np.diff(told) / np.diff(force)
        assert slopes.min() > -1e-9
        assert slopes.max() < 1 + 1e-9
        assert np.abs(np.diff(slopes)).max() < 0.02  # no edge anywhere
        np.testing.assert_allclose(told, -limited(-force, limit, knee))


def test_a_knee_of_nothing_is_a_hard_limit():
    """A knee of width 0 cuts forces off at the limit, and a narrow one nearly so."""
    force = np.linspace(-9.0, 9.0, 181)
    np.testing.assert_array_equal(limited(force, 5.0, 0.0), np.clip(force, -5.0, 5.0))
    np.testing.assert_allclose(limited(force, 5.0, 1e-4), np.clip(force, -5.0, 5.0), atol=5.0 * 1e-4)


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_without_a_dead_band_no_bit_of_a_reading_changes(noise):
    """The sign of a zero stays, too."""
    rows = np.array([[-0.0, 0.0, 1e-3, -0.25]])
    assert mean_reading(rows, 0.0, noise).tobytes() == rows.tobytes()


def test_the_ends_of_a_dead_band_are_read():
    """Within the open band a single reading is 0; at its ends it is what it is."""
    rows = np.array([[-0.25, -0.24, 0.24, 0.25]])
    assert mean_reading(rows, 0.25, 0.0).tolist() == [[-0.25, 0.0, 0.0, 0.25]]


@pytest.mark.parametrize(
    ("away", "is_biased"), [(-2.01, False), (-1.99, True), (0.0, True), (1.99, True), (2.01, False)]
)
def test_noise_biases_up_to_two_deviations_from_an_end(away, is_biased):
    """Inwards at both ends of the range; beyond, and in the middle, a frame was not chosen by noise."""
    low, high = selection_bias(np.array([1.0 + 0.1 * away, 13.0 - 0.1 * away]), 0.1, 1.0, 13.0)
    assert (low > 1e-4) == (is_biased or away == 2.01)
    assert high == pytest.approx(-low, abs=1e-12)


@pytest.mark.parametrize(("frames", "force"), [(1, 0.0), (2, 0.0), (3, -0.125)])
def test_of_less_than_three_frames_no_acceleration_is_known(touch, play, moved, frames, force):
    """Three frames, 0.25 and 0.75 m apart, have speeds of 0.25, 0.5 and 0.75 m/s: a quarter of a m/s^2."""
    seconds = np.arange(float(frames))
    path = moved(touch, seconds, np.full(frames, -1.0), x=0.25 * seconds**2)
    wrench = play("inertia", on=path, mass=0.5).wrench
    assert wrench.shape == (frames, 6)
    assert wrench[frames // 2, 0] == pytest.approx(force)
    assert bool(wrench.any()) == (frames == 3)
