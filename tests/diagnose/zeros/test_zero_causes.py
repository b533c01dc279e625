"""Zeros of a force sensor: planted causes come back with their numbers, and chance is not named."""

import jsonschema
import numpy as np
import pytest
from drawn_zeros import TOOL, zeros
from recorded_touches import recorded_store
from scipy.spatial.transform import Rotation

from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.contract.schema import load_schema
from tactiledata.diagnose.zeros.causes import ZeroCause, beside_claims, no_zeros, zero_causes
from tactiledata.diagnose.zeros.readings import ForceZeros, StoreReadings, free_air_between
from tactiledata.diagnose.zeros.zero_models import CABLE_PLAY, cable_friction
from tactiledata.ingest.clocks.align import POSE_COLUMNS
from tactiledata.replay.opened import OpenedStore
from tactiledata.rig.hidden.effects import HIDDEN_EFFECTS
from tactiledata.store.read.reader import Store
from tactiledata.store.read.signal_rows import SignalRows


def opened(place):
    """A store at a place, planned."""
    return OpenedStore.planned(Store.open(place), CalibrationOptions().pads)


def test_a_heavier_tool_is_found_with_its_mass_and_moment():
    """A planted mass of 50 g is found within 15 %, its moment within 30 %, and the error falls."""
    (cause,) = zero_causes(zeros(mass=0.05))
    assert cause.effect == "tool_weight"
    assert cause.values["mass"] == pytest.approx(0.05, rel=0.15)
    assert cause.values["moment_z"] == pytest.approx(0.05 * 0.03, rel=0.3)
    assert "+5" in cause.words
    assert "contact forces contain only what changes within a trajectory" in cause.words
    assert cause.alike == ("gain_crosstalk",)
    assert cause.words.endswith("In free air, gain and cross-talk of the force sensor would read the same.")
    assert cause.after < 0.7 * cause.before


def test_a_cause_fits_the_schema_of_a_diagnosis():
    """What a cause writes into ``diagnosis.json`` fits the schema, with and without effects that read the same."""
    of_causes = load_schema("diagnosis")["properties"]["zeros"]
    documents = [cause.document for planted in (zeros(mass=0.05), zeros(drift=3.0)) for cause in zero_causes(planted)]
    assert [document["alike"] for document in documents] == [["gain_crosstalk"], []]
    jsonschema.validate(documents, of_causes)


def turned_by(*angles):
    """The matrix by which a sensor reads whose frame is turned by three angles, rad."""
    turn = Rotation.from_rotvec(angles).as_matrix()
    return np.kron(np.eye(2), turn)


def test_a_turned_frame_is_found_with_its_angles():
    """Planted turns about three axes are found within half a degree; nothing else is named."""
    planted = (0.04, -0.03, 0.1)
    (cause,) = zero_causes(zeros(scatter=0.01, reads=turned_by(*planted)))
    assert cause.effect == "frame_rotation"
    assert [cause.values[name] for name in ("tilt_x", "tilt_y", "yaw")] == pytest.approx(planted, abs=0.009)
    assert "degrees about x, y and z from robot.tcp_from_ft" in cause.words
    assert "contact forces are read in the same wrong way, which no zero takes away" in cause.words
    assert cause.alike == ("gain_crosstalk",)


@pytest.mark.parametrize("planted", [{"mass": 0.2}, {"mass": 0.05, "centre": (0.0, 0.0, 0.2)}])
def test_no_sensor_of_usual_cross_talk_reads_a_much_heavier_tool(planted):
    """A quarter more mass, or a moment of 10 g m, is a weight: no gain is off by as much."""
    (cause,) = zero_causes(zeros(**planted))
    assert cause.effect == "tool_weight"
    assert not cause.alike
    assert "would read the same" not in cause.words


def test_a_large_turn_is_no_cross_talk():
    """No axis of a usual sensor shows a fifth of another one."""
    (cause,) = zero_causes(zeros(scatter=0.01, reads=turned_by(0.0, 0.0, 0.2)))
    assert cause.effect == "frame_rotation"
    assert not cause.alike


@pytest.mark.parametrize("seed", range(3))
def test_cross_talk_is_no_weight_and_no_turn(seed):
    """Entries of chance of some per cent in all 36 places are cross-talk, and nothing else."""
    mixes = np.eye(6) + np.random.default_rng(seed).normal(0.0, 0.06, (6, 6))
    (cause,) = zero_causes(zeros(scatter=0.005, reads=mixes))
    assert cause.effect == "gain_crosstalk"
    assert cause.explained > 0.5


def test_what_a_weight_was_taken_for_is_reported_as_cross_talk_alone():
    """A gain that is off reads as a heavier tool; where a mixing of axes comes to it, the wider cause stands alone."""
    gain = np.eye(6)
    gain[:3, :3] *= 1.1
    (weight,) = zero_causes(zeros(scatter=0.01, reads=gain))
    assert weight.effect == "tool_weight"
    assert weight.values["mass"] == pytest.approx(0.1 * TOOL, rel=0.15)
    gain[2, 0] = gain[4, 1] = 0.04
    (cause,) = zero_causes(zeros(scatter=0.01, reads=gain))
    assert cause.effect == "gain_crosstalk"
    assert cause.before == pytest.approx(weight.before, rel=0.1)


def test_without_a_stated_weight_no_frame_is_called_turned():
    """Zeros that a turned frame planted have no cause where the log does not state the weight of the tool."""
    planted = zeros(scatter=0.01, reads=turned_by(0.04, -0.03, 0.1))
    assert not zero_causes(ForceZeros(**{**vars(planted), "weight": None}))


@pytest.mark.parametrize(
    ("claimed", "shown", "alike"),
    [
        ([], ["tool_weight", "cable_drag"], ["gain_crosstalk"]),
        # the fit says which of the two it is
        (["tool_weight"], ["tool_weight", "cable_drag"], []),
        (["gain_crosstalk"], ["cable_drag"], []),
        (["lag"], ["tool_weight", "cable_drag"], ["gain_crosstalk"]),
    ],
)
def test_what_a_claimed_effect_reads_in_free_air_is_no_second_one(claimed, shown, alike):
    """A weight that a claimed cross-talk reads is not named; a drift too small to matter never is."""
    numbers = (0.003, 0.5, 0.1, 0.05, {}, "")
    causes = [
        ZeroCause("tool_weight", *numbers, alike=("gain_crosstalk",)),
        ZeroCause("sensor_drift", *numbers, within=0.002),
        ZeroCause("cable_drag", *numbers),
    ]
    assert beside_claims(causes, claimed) == (shown, alike)


def test_a_drift_is_found():
    """A planted drift of the zero is found within 30 %."""
    (cause,) = zero_causes(zeros(drift=0.6))
    assert cause.effect == "sensor_drift"
    assert cause.values["fz"] == pytest.approx(0.6, rel=0.3)


@pytest.mark.parametrize(("drift", "matters"), [(0.2, False), (3.0, True)])
def test_a_drift_matters_where_it_changes_the_zero_within_a_trajectory(drift, matters):
    """What a drift changes within a trajectory is that of its law, and more than 0.01 N of it matters."""
    planted = zeros(drift=drift, scatter=0.005)
    (cause,) = zero_causes(planted)
    speed = drift / 300.0 * np.exp(-planted.seconds / 300.0) * np.hypot(0.5, 1.0)
    assert cause.within == pytest.approx(np.sqrt(((10.0 * speed) ** 2).mean()), rel=0.3)
    assert cause.matters == matters
    assert ("too little to matter" in cause.words) == (not matters)
    assert cause.words.endswith("wrong by as much." if matters else "too little to matter.")


def test_a_cable_is_found_where_joints_are_known():
    """A planted drag of the cable is found, and is not looked for where joint angles are unknown."""
    with_cable = zeros(cable=0.3)
    (cause,) = zero_causes(with_cable)
    assert cause.effect == "cable_drag"
    assert not cause.alike
    unknown = ForceZeros(**{**vars(with_cable), "joints": None})
    assert not zero_causes(unknown)


def test_a_cable_is_found_by_its_friction():
    """What changes with the direction from which the last joint came is a cable; the sentence gives the difference."""
    rubbing = zeros(rubs=0.3)
    (cause,) = zero_causes(rubbing)
    assert cause.effect == "cable_drag"
    assert cause.values["friction"] == pytest.approx(0.3 * np.hypot(1.0, 0.3), rel=0.15)
    assert f"differs by {2 * cause.values['friction']:.2f} N" in cause.words
    # a joint that turns to and fro by less than the play leaves the cable where it is
    still = ForceZeros(**{**vars(rubbing), "joints": 0.01 * rubbing.joints})
    assert not zero_causes(still)


def test_friction_follows_the_last_joint_until_it_turns_back():
    """Over its largest: half a play turns it from 0 to 1, a whole one from 1 to -1; at a tare it begins anew."""
    turned = zeros(trajectories=4)
    angle = CABLE_PLAY * np.array([0.0, 0.25, 0.5, 2.0, 1.5, 1.0, 1.0, 0.0, 0.5, 0.5, 0.75, 0.0])
    planted = ForceZeros(
        **{**vars(turned), "joints": np.column_stack([turned.joints[:, :5], angle]), "zeroed": np.arange(12) // 8}
    )
    expected = [0.0, 0.5, 1.0, 1.0, 0.0, -1.0, -1.0, -1.0, 0.0, 0.0, 0.5, -1.0]
    np.testing.assert_allclose(cable_friction(planted), expected, atol=1e-9)


def test_two_causes_are_both_found():
    """A heavier tool and a drift in the same readings are both found."""
    assert {cause.effect for cause in zero_causes(zeros(mass=0.06, drift=0.8))} == {"tool_weight", "sensor_drift"}


@pytest.mark.slow
def test_chance_is_not_named():
    """Zeros that scatter by chance have a cause in at most two of sixty worlds."""
    named = [bool(zero_causes(zeros(seed))) for seed in range(60)]
    assert sum(named) <= 2


def test_what_a_dead_band_may_do_is_no_cause():
    """A tool of 50 g changes the zero by at most 0.3 N: a band of 0.2 N leaves it a cause, one of 0.4 N does not.

    A drift of 2 N beside it stays a cause of its own.
    """
    alone, both = zeros(mass=0.05), zeros(mass=0.05, drift=2.0)
    assert [cause.effect for cause in zero_causes(alone, band=0.2)] == ["tool_weight"]
    assert zero_causes(alone, band=0.4) == []
    assert {cause.effect for cause in zero_causes(both)} == {"tool_weight", "sensor_drift"}
    assert [cause.effect for cause in zero_causes(both, band=0.4)] == ["sensor_drift"]


def test_where_it_is_quiet_or_unknown_nothing_is_said():
    """Zeros that hardly scatter have no cause, and five trajectories are too few to look for one."""
    assert not zero_causes(zeros(scatter=0.002, trajectories=24))
    few = zeros(trajectories=5, mass=0.2)
    assert not zero_causes(few)
    assert "at least 8" in no_zeros(few)
    assert not no_zeros(zeros())


def test_the_same_again():
    """One seed gives the same causes twice."""
    assert zero_causes(zeros(mass=0.05), seed=3) == zero_causes(zeros(mass=0.05), seed=3)


def test_a_tare_in_free_air_parts_its_readings_and_is_no_touch():
    """Air at 3 N, set to zero after 1 s, pressed after 3 s: both levels are air, each under its own number."""
    rng = np.random.default_rng(4)
    t_ns = 1_700_000_000_000_000_000 + np.arange(500) * 10_000_000
    load = rng.normal(0, 0.05, (500, 6))
    load[:100] += 3
    load[300:] += 8
    tares = [int(t_ns[0]) - 10, int(t_ns[100])]
    (first, before, _), (second, after, times) = free_air_between(load, t_ns, tares, np.zeros((2, 6)))
    assert (first, second) == (1, 2)
    assert before.mean(axis=0) == pytest.approx(np.full(6, 3.0), abs=0.03)
    assert after.mean(axis=0) == pytest.approx(np.zeros(6), abs=0.03)
    assert (times[0], len(before)) == (t_ns[100], 100)
    assert 90 <= len(after) <= 100


@pytest.mark.nightly
def test_recorded_tools_are_weighed(tmp_path):
    """The rig's own tool, heavier by 60 g than its log says, one on a turned sensor, and one as stated."""
    turned = {"count": 16, "depth": [0.0004, 0.0006], "tilt": [0.0, 0.2]}
    hidden = [{"effect": "tool_weight", "strength": "strong"}]
    (cause,) = zero_causes(
        StoreReadings(opened(recorded_store(tmp_path / "a", generate=turned, hidden=hidden))).zeros()
    )
    assert cause.effect == "tool_weight"
    assert cause.values["mass"] == pytest.approx(0.06, rel=0.25)
    hidden = [{"effect": "frame_rotation", "strength": "strong"}]
    (cause,) = zero_causes(
        StoreReadings(opened(recorded_store(tmp_path / "c", generate=turned, hidden=hidden))).zeros()
    )
    assert cause.effect == "frame_rotation"
    assert cause.values["yaw"] == pytest.approx(HIDDEN_EFFECTS["frame_rotation"].STRENGTHS["strong"]["yaw"], abs=0.01)
    assert not zero_causes(StoreReadings(opened(recorded_store(tmp_path / "b", generate=turned))).zeros())


@pytest.mark.slow
def test_lost_poses_are_passed_over(tiny_store, monkeypatch):
    """Poses of zeros, as a driver sends where it lost the arm, are no rotations: the zeros are those of the others."""
    whole = StoreReadings(opened(tiny_store)).zeros()
    values = SignalRows.values

    def lost(rows, *span):
        found = values(rows, *span)
        if rows.columns == POSE_COLUMNS:
            found = found.copy()
            found[4::9] = 0.0
        return found

    monkeypatch.setattr(SignalRows, "values", lost)
    readings = StoreReadings(opened(tiny_store))
    assert len(whole) > 0
    np.testing.assert_allclose(readings.zeros().load, whole.load, atol=0.05)
    np.testing.assert_allclose(readings.zeros().down, whole.down, atol=1e-3)
    assert readings.moves()
