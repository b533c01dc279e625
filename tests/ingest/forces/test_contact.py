"""The true contact wrench comes back from a reading with tool weight, tare, sign and frames in the way."""

import copy

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.contact import contact_wrench
from tactiledata.ingest.forces.gravity import STANDARD_GRAVITY
from tactiledata.ingest.forces.onset import touching
from tactiledata.ingest.forces.tare import find_zero, half_sample_mode
from tactiledata.ingest.trajectories.segment import contact_spans, segment_by_contact
from tactiledata.transforms import Transform, move_wrench
from tactiledata.units import SIGNAL_COLUMNS, signal_units

START = 1_700_000_000_000_000_000
MASS, CENTRE = 0.45, [0.01, -0.02, 0.06]
TCP_FROM_GEL = Transform.from_parts(
    "tcp", "gel", [0.0, 0.01, 0.02], Rotation.from_euler("xyz", [0.2, 3.0, 0.1]).as_quat()
)
TCP_FROM_FT = Transform.from_parts("tcp", "ft", [0.0, 0.0, -0.08], Rotation.from_euler("z", 0.7).as_quat())


def description(sign="load_on_sensor", **wrench):
    return LogDescription.checked(
        {
            "format": "tactiledata-log/1",
            "sensors": {"D1": {"model": "digit"}},
            "robot": {
                "tcp_from_gel": TCP_FROM_GEL.document(),
                "tcp_from_ft": TCP_FROM_FT.document(),
                "tool": {"mass": MASS, "centre_of_gravity": CENTRE},
            },
            "wrench": {"sign": sign, "gravity": "included", **wrench},
        },
        "test",
    )


def stored(t_ns, values, name):
    columns = SIGNAL_COLUMNS[name]
    return StoredSignal(t_ns, values, columns, signal_units(columns), "", Stamps(t_ns))


def planted(rng, sign=1.0, bias=3.0, noise=0.05):
    """A tilting arm that presses between 2 s and 4 s: the truth in the gel frame, and what the sensor reads."""
    t_ns = START + np.arange(600) * 10_000_000
    seconds = (t_ns - START) / 1e9
    turn = Rotation.from_euler("xyz", np.stack([0.3 * np.sin(seconds), np.pi + 0.2 * seconds, 0 * seconds], axis=1))
    poses = np.concatenate([np.tile([0.4, 0.1, 0.3], (600, 1)), turn.as_quat()], axis=1)
    truth = np.zeros((600, 6))
    pressing = (seconds > 2) & (seconds < 4)
    truth[pressing] = [0.8, -0.4, 6.0, 0.01, 0.02, -0.005]
    ft_from_gel = TCP_FROM_FT.inverse() @ TCP_FROM_GEL
    load = move_wrench(-truth, ft_from_gel.matrix)
    weight_tcp = turn.inv().apply([0, 0, -MASS * STANDARD_GRAVITY])
    weight_force = weight_tcp @ TCP_FROM_FT.inverse().rotation.T
    lever = TCP_FROM_FT.inverse().points([CENTRE])[0]
    weight = np.concatenate([weight_force, np.cross(lever, weight_force)], axis=1)
    reading = (
        sign * (load + weight)
        + bias * np.array([1, -1, 0.5, 0.02, 0.01, 0])
        + rng.normal(0, noise, (600, 6)) * [1, 1, 1, 0.02, 0.02, 0.02]
    )
    return t_ns, truth, stored(t_ns, reading, "wrench"), stored(t_ns, poses, "tcp")


@pytest.mark.parametrize(("name", "sign"), [("load_on_sensor", 1.0), ("reaction", -1.0)])
def test_the_planted_contact_comes_back(name, sign):
    """Force comes back within the noise and torque within its lever, whichever sign the recording uses."""
    rng = np.random.default_rng(1)
    t_ns, truth, wrench, tcp = planted(rng, sign)
    found = contact_wrench(description(name), wrench, tcp, [("t", int(t_ns[0]), int(t_ns[-1]))])
    error = found.signal.values - truth
    assert found.signal.frame == "gel"
    assert np.abs(error[:, :3].mean(axis=0)).max() < 0.02
    assert np.abs(error[:, :3]).std(axis=0).max() < 0.08
    assert np.abs(error[:, 3:].mean(axis=0)).max() < 0.004


def test_wrong_weight_leaves_its_trace():
    """Negative control: without the tool's mass the tilting arm's weight stays in the contact wrench."""
    t_ns, truth, wrench, tcp = planted(np.random.default_rng(1))
    plain = LogDescription.checked(
        {**description().document, "robot": {k: v for k, v in description().robot.items() if k != "tool"}}, "test"
    )
    found = contact_wrench(plain, wrench, tcp, [("t", int(t_ns[0]), int(t_ns[-1]))])
    assert np.abs(found.signal.values - truth)[:, :3].max() > 0.5
    assert "gravity-not-compensated" in {finding.code for finding in found.findings}


def test_unknown_frames_are_said():
    """Without transforms the norm is right, the frame is called ft, and a finding says so."""
    _, _, wrench, tcp = planted(np.random.default_rng(2), bias=0.0)
    bare = LogDescription.checked(
        {"format": "tactiledata-log/1", "sensors": {"D1": {"model": "digit"}}, "wrench": {"gravity": "compensated"}},
        "test",
    )
    found = contact_wrench(bare, wrench, tcp, [])
    assert found.signal.frame == "ft"
    assert {"frame-unknown", "sign-assumed"} <= {finding.code for finding in found.findings}


def test_each_trajectory_gets_its_own_zero():
    """A drift of 1.5 N between two touches is taken out of both, and said."""
    rng = np.random.default_rng(3)
    t_ns = START + np.arange(2000) * 10_000_000
    load = rng.normal(0, 0.05, (2000, 6))
    load[1000:, 2] += 1.5
    for start in (300, 1300):
        load[start : start + 200, 2] += 8
    spans = [("a", int(t_ns[0]), int(t_ns[900])), ("b", int(t_ns[1000]), int(t_ns[1999]))]
    zero = find_zero(t_ns, load, spans, [])
    clean = load - zero.bias
    assert abs(clean[1000:1290, 2].mean()) < 0.02
    assert abs(clean[1310:1490, 2].mean() - 8) < 0.02
    assert "zero-drift" in {finding.code for finding in zero.findings}


def test_a_slow_press_does_not_pull_the_zero():
    """Half a second of air, then a press of 1 N a second that the noise hides at first: the zero is that of the air."""
    rng = np.random.default_rng(6)
    t_ns = START + np.arange(300) * 10_000_000
    load = rng.normal(0, 0.1, (300, 6)) * [1, 1, 1, 0.02, 0.02, 0.02]
    load[:, 2] -= np.maximum(np.arange(300) - 60, 0) * 0.01
    zero = find_zero(t_ns, load, [("t", int(t_ns[0]), int(t_ns[-1]))], [])
    assert abs(zero.bias[150, 2]) < 0.05


def test_a_trajectory_that_begins_in_contact_is_not_zeroed_there():
    """Starting at 9 N keeps the recording's zero, and is said."""
    rng = np.random.default_rng(4)
    t_ns = START + np.arange(1000) * 10_000_000
    load = rng.normal(0, 0.05, (1000, 6))
    load[600:900, 2] += 9
    zero = find_zero(t_ns, load, [("late", int(t_ns[610]), int(t_ns[999]))], [])
    assert abs((load - zero.bias)[700:800, 2].mean() - 9) < 0.05
    assert "no-free-air" in {finding.code for finding in zero.findings}


def test_a_tare_event_moves_the_zero_where_it_happened():
    """Without named trajectories, the zero jumps at the stated tare event and nowhere else."""
    rng = np.random.default_rng(5)
    t_ns = START + np.arange(1000) * 10_000_000
    load = rng.normal(0, 0.05, (1000, 6)) + np.where(np.arange(1000) < 500, 4.0, 0.0)[:, None]
    zero = find_zero(t_ns, load, [], [int(t_ns[500])])
    assert np.abs((load - zero.bias).reshape(2, 500, 6).mean(axis=1)).max() < 0.05


def test_the_mode_ignores_contacts():
    """The half-sample mode stays at rest level although a third of the samples are in contact."""
    rng = np.random.default_rng(6)
    samples = np.concatenate([rng.normal(2.0, 0.1, 700), rng.uniform(3, 12, 300)])
    assert abs(half_sample_mode(samples) - 2.0) < 0.1
    assert half_sample_mode(np.array([np.nan, 5.0])) == 5.0
    assert half_sample_mode(np.zeros(0)) == 0.0


def test_touching_holds_through_flicker():
    """Between release and touch thresholds the state stays what it was."""
    force = np.array([0, 0.4, 0.6, 0.4, 0.3, 0.2, 0.4, 0.6, np.nan, 0.1])
    assert touching(np.nan_to_num(force), 0.5).tolist() == [
        False,
        False,
        True,
        True,
        True,
        False,
        False,
        True,
        False,
        False,
    ]


def test_touches_are_found_and_knocks_are_not():
    """Two presses come out as two trajectories that do not overlap; a 20 ms spike does not."""
    rng = np.random.default_rng(7)
    t_ns = START + np.arange(3000) * 10_000_000
    values = rng.normal(0, 0.05, (3000, 6))
    values[500:900, 2] += 5
    values[1500:1502, 2] += 20
    values[2000:2400, 2] += 3
    found, _ = segment_by_contact(stored(t_ns, values, "wrench"), 0.05, "D1")
    assert len(found) == 2
    assert found[0].end_ns <= found[1].start_ns
    spans = contact_spans(t_ns, np.linalg.norm(values[:, :3], axis=1), 0.05)
    assert abs(spans[0][0] - t_ns[500]) <= 20_000_000
    assert abs(spans[1][1] - t_ns[2399]) <= 20_000_000


def test_no_contact_no_trajectory():
    """Negative control: noise alone gives nothing."""
    values = np.random.default_rng(8).normal(0, 0.1, (5000, 6))
    t_ns = START + np.arange(5000) * 10_000_000
    assert segment_by_contact(stored(t_ns, values, "wrench"), 0.1, "") == ((), None)


@pytest.mark.parametrize("taken", ["gravity", "centre_of_gravity"])
def test_what_is_assumed_of_the_weight_is_said(taken):
    """A tool whose gravity or centre of gravity is not stated is taken off by an assumption, and it is said."""
    t_ns, _, wrench, tcp = planted(np.random.default_rng(1))
    document = copy.deepcopy(dict(description().document))
    for part in (document["wrench"], document["robot"]["tool"]):
        part.pop(taken, None)
    spans = [("t", int(t_ns[0]), int(t_ns[-1]))]
    code = {"gravity": "gravity-assumed", "centre_of_gravity": "centre-of-gravity-assumed"}[taken]
    found = contact_wrench(LogDescription.checked(document, "test"), wrench, tcp, spans)
    assert code in {finding.code for finding in found.findings}
    whole = contact_wrench(description(), wrench, tcp, spans)
    assert not any(finding.code.endswith("-assumed") for finding in whole.findings)


@pytest.mark.parametrize("lost", [slice(250, 450), slice(0, 80), slice(400, None)])
def test_no_force_is_computed_from_a_pose_of_another_moment(lost):
    """In a long gap of the poses, and beyond them, the contact wrench is NaN and said; elsewhere it is right."""
    t_ns, truth, wrench, tcp = planted(np.random.default_rng(1))
    rows = np.delete(np.arange(len(t_ns)), lost)
    held = stored(t_ns[rows], tcp.values[rows], "tcp")
    found = contact_wrench(description(), wrench, held, [("t", int(t_ns[0]), int(t_ns[-1]))])
    masked = np.isnan(found.signal.values).all(axis=1)
    assert 0 < masked.sum() <= len(t_ns) - len(rows)
    assert not masked[rows].any()
    assert np.abs(found.signal.values - truth)[rows, :3].max() < 0.4
    [said] = [finding for finding in found.findings if finding.code == "weight-unknown"]
    assert said.count == masked.sum()
    compensated = contact_wrench(description(gravity="compensated"), wrench, held, [])
    assert np.isfinite(compensated.signal.values).all()


def test_poses_of_another_time_give_no_force_at_all():
    """A tcp stream an hour away says nothing of the weight: every sample is NaN, none is computed, and it is said."""
    t_ns, _, wrench, tcp = planted(np.random.default_rng(1))
    away = stored(t_ns + 3600 * 10**9, tcp.values, "tcp")
    for spans in ([], [("t", int(t_ns[0]), int(t_ns[-1]))]):
        found = contact_wrench(description(), wrench, away, spans)
        assert np.isnan(found.signal.values).all()
        assert "weight-unknown" in {finding.code for finding in found.findings}
        assert segment_by_contact(found.signal, found.noise, "") == ((), None)


def test_an_arm_that_stands_needs_no_poses():
    """A recorder that writes poses only while the arm moves loses no force in the pauses."""
    t_ns, _, wrench, tcp = planted(np.random.default_rng(1))
    poses = tcp.values.copy()
    poses[200:450] = poses[200]
    rows = np.delete(np.arange(len(t_ns)), slice(201, 449))
    found = contact_wrench(description(), wrench, stored(t_ns[rows], poses[rows], "tcp"), [])
    assert np.isfinite(found.signal.values).all()
    assert "weight-unknown" not in {finding.code for finding in found.findings}


def upright(rng, forces, **wrench):
    """An arm that does not turn and touches once for each of the forces (N, along the gel's z), and its description."""
    count = 600 * len(forces)
    t_ns = START + np.arange(count) * 10_000_000
    load = rng.normal(0, 0.02, (count, 6))
    load[:, 2] -= MASS * STANDARD_GRAVITY
    for touch, force in enumerate(forces):
        load[600 * touch + 200 : 600 * touch + 400, 2] -= force
    spans = [(f"t{n}", int(t_ns[600 * n]), int(t_ns[600 * n + 599])) for n in range(len(forces))]
    pose = {"xyz": [0.0, 0.0, 0.0], "xyzw": [0.0, 0.0, 0.0, 1.0]}
    robot = {"tcp_from_gel": pose, "tcp_from_ft": pose, "tool": {"mass": MASS, "centre_of_gravity": CENTRE}}
    document = {**description(**wrench).document, "robot": robot}
    tcp = stored(t_ns, np.tile([0.4, 0.1, 0.3, 0, 0, 0, 1.0], (count, 1)), "tcp")
    return LogDescription.checked(document, "test"), stored(t_ns, load, "wrench"), tcp, spans


@pytest.mark.parametrize("forces", [[5.0], [5.0, 2.0, 8.0], [5.0, -4.0, 6.0, 3.0, 4.0, 5.0, 3.0]])
def test_a_reversed_sign_is_said_with_the_other(forces):
    """Where nearly all touches pull, the sign to state is named; stated so, or with touches that press, nothing is."""
    for truth, other in (("load_on_sensor", "reaction"), ("reaction", "load_on_sensor")):
        for sign in (truth, other):
            document, wrench, tcp, spans = upright(np.random.default_rng(3), forces, sign=sign)
            read = wrench if truth == "load_on_sensor" else stored(wrench.t_ns, -wrench.values, "wrench")
            found = [one for one in contact_wrench(document, read, tcp, spans).findings if one.code == "sign-reversed"]
            assert len(found) == (sign != truth)
            for said in found:
                assert (said.severity, said.count) == ("warning", sum(force > 0 for force in forces))
                assert f"State wrench.sign: {truth}" in said.message


def test_single_touches_that_pull_say_nothing_of_the_sign():
    """Negative control: two of five touches pull, as a sticky gel does; weak touches and shear tell nothing."""
    for forces in ([5.0, -5.0, 5.0, -3.0, 5.0], [-0.3] * 5):
        document, wrench, tcp, spans = upright(np.random.default_rng(4), forces)
        assert "sign-reversed" not in {one.code for one in contact_wrench(document, wrench, tcp, spans).findings}
    document, wrench, tcp, spans = upright(np.random.default_rng(4), [-1.0] * 5)
    wrench.values[:, 0] += 3 * (wrench.values[:, 2] > -MASS * STANDARD_GRAVITY + 0.5)
    assert "sign-reversed" not in {one.code for one in contact_wrench(document, wrench, tcp, spans).findings}
