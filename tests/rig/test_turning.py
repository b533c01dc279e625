"""Turns in free air: the gel feels nothing, gravity in its frame does turn, and the way back is made."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.errors import SchemaError
from tactiledata.rig.logs.sampling import load_on_ft
from tactiledata.rig.motion.motion import TURNING_CLEARANCE, gel_from_indenter_rotation, plan
from tactiledata.rig.play import RigSetup
from tactiledata.rig.scenario.scenario import load_scenario

TURNS = [{"turn": {"to": [0.5, 0.0, 0.0], "settle": 0.2}}, {"turn": {"to": [0.0, 0.0, 0.8], "speed": 1.0}}]
TOUCH = {"name": "turns", "sensor": "A", "indenter": "ball", "tilt": [0.0, 0.1], "yaw": 0.3}
PLAIN = {
    "format": "tactiledata-scenario/1",
    "sensors": {"A": {"background": "digit-bg-0"}},
    "indenters": {"ball": {"shape": "sphere"}},
    "imperfections": {"pose_repeatability": 0.0},
}


def scenario(steps):
    return load_scenario({**PLAIN, "trajectories": [{**TOUCH, "steps": steps}]})


def planned(steps):
    return plan(scenario(steps).trajectories[0], lambda force: 1e-3)


def test_turns_are_reached_well_above_the_gel():
    """Each rotation is held at its time, never nearer to the gel than the clearance."""
    path = planned(TURNS)
    seconds = np.linspace(0.0, path.duration, 2000)
    turned, depth = path.turned(seconds), path.at(seconds)[:, 2]
    away = np.linalg.norm(Rotation.from_matrix(turned).as_rotvec(), axis=1)
    assert (depth[away > 0] == -TURNING_CLEARANCE).all()
    for at, wanted in zip(path.captures[1:], ([0.5, 0.0, 0.0], [0.0, 0.0, 0.8]), strict=True):
        assert Rotation.from_matrix(path.turned(np.array([at]))).as_rotvec()[0] == pytest.approx(wanted, abs=1e-9)
    assert away[0] == away[-1] == 0.0
    assert [name for _, _, name in path.phases] == ["free", "turn", "turn", "retreat", "free"]


def test_a_press_after_a_turn_is_made_upright():
    """The sensor turns back before it comes near; the press is the one without turns."""
    after, plain = planned([*TURNS, {"press": {"depth": 5e-4}}]), planned([{"press": {"depth": 5e-4}}])
    near = after.positions[:, 2] > -TURNING_CLEARANCE
    assert not after.turns[near].any()
    assert after.positions[:, 2].max() == plain.positions[:, 2].max()


def test_only_the_weight_is_felt():
    """The load is the tool's weight, which goes around in the sensor's frame by the angle that was asked for."""
    loaded = scenario(TURNS)
    rig_setup = RigSetup(loaded)
    played = rig_setup.play(loaded.trajectories, 0, 0)
    play = played.plays[0]
    assert not np.asarray(play.contact.wrench).any()
    moments = play.start_ns + np.rint(play.path.captures * 1e9).astype(np.int64)
    loads = load_on_ft(loaded, played, moments)[:, :3]
    assert np.linalg.norm(loads, axis=1) == pytest.approx(loaded.robot.tool_mass * 9.81)
    turned = Rotation.from_matrix(gel_from_indenter_rotation(play.touch))
    table = rig_setup.mounted["ball"].matrix[:3, :3].T @ [0.0, 0.0, -1.0]
    wanted = [(Rotation.from_matrix(one) * turned).apply(table) for one in play.path.turned(play.path.captures)]
    assert loads @ loads.T == pytest.approx(
        (loaded.robot.tool_mass * 9.81) ** 2 * np.array(wanted) @ np.array(wanted).T
    )


def test_a_turn_beyond_the_wrist_is_refused():
    """The schema says how far."""
    with pytest.raises(SchemaError) as caught:
        scenario([{"turn": {"to": [3.0, 0.0, 0.0]}}])
    assert caught.value.facts["path"] == "$.trajectories[0].steps[0]"
