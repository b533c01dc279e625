"""What cannot be replayed has a named reason, and all the rest goes on."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
import yaml
from coarse import coarse_pad, options
from copied_trees import copy_tree

from tactiledata.gel.contact.history import FrameStatus
from tactiledata.ingest.pipeline import ingest
from tactiledata.replay.attach import replay as attach
from tactiledata.replay.geometry import gel_geometry
from tactiledata.replay.plan import plan_replay
from tactiledata.replay.poses import gel_from_indenter
from tactiledata.replay.status import STATUSES, ReplayStatus
from tactiledata.replay.untouched import UntouchedTouch, untouched_lines
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store
from tactiledata.transforms import Transform, matrix_poses

pytestmark = pytest.mark.slow


def deeper(document, metres):
    """Moves the ball along the direction of pressing: the arm comes from above, so that up is deeper."""
    document["indenters"]["ball4"]["base_from_indenter"]["xyz"][2] += metres


def without(*path):
    """Takes an entry out."""

    def spoil(document):
        for key in path[:-1]:
            document = document[key]
        document.pop(path[-1])

    return spoil


def unlike(**sizes):
    """States other sizes of the ball."""
    return lambda document: document["indenters"]["ball4"].update(sizes)


def beside_the_pad(document):
    """Moves the ball off the pad and lower: into the housing."""
    deeper(document, 0.5e-3)
    place = document["indenters"]["ball4"]["base_from_indenter"]
    place["xyz"] = [place["xyz"][0] + 0.013, place["xyz"][1] + 0.013, place["xyz"][2]]


DESCRIPTIONS = {
    "through the housing": (beside_the_pad, FrameStatus.BESIDE_THE_PAD),
    "5 mm deep": (lambda document: deeper(document, 5e-3), FrameStatus.TOO_DEEP),
    "never touched": (lambda document: deeper(document, -2e-3), FrameStatus.NO_CONTACT),
    "no place of the gel": (without("robot", "tcp_from_gel"), ReplayStatus.GEL_PLACE_UNKNOWN),
    "no such indenter": (without("indenters", "ball4"), ReplayStatus.INDENTER_UNKNOWN),
    "no place of it": (without("indenters", "ball4", "base_from_indenter"), ReplayStatus.INDENTER_PLACE_UNKNOWN),
    "a mesh that is not there": (unlike(mesh="ball.stl", unit="mm"), ReplayStatus.INDENTER_UNUSABLE),
    "an impossible gel": (
        lambda document: document["sensors"]["D20001"]["gel"].update(outline=[18.4, 25.0]),
        ReplayStatus.GEL_UNUSABLE,
    ),
}


QUICK = ("5 mm deep", "no such indenter", "an impossible gel")


@pytest.fixture
def log(tiny_folders, tmp_path):
    """A folder log that may be spoilt: one touch of a ball, one of a cross."""
    copy_tree(tiny_folders[0], tmp_path / "D20001")
    return tmp_path / "D20001"


def ball_status(log, **changes):
    """Statuses of the frames of the ball and of the cross, and the report."""
    place = log.parent / "ds.zarr"
    ingest([log], place)
    report = attach(place, options(**changes))
    store = Store.open(place)
    assert [one for one in check(place, images=False) if one.severity == "damage"] == []
    found = {}
    for touch in plan_replay(store, coarse_pad).touches:
        has = report.mesh in store.mesh_names
        found[touch.indenter] = store.mesh(report.mesh).status(np.arange(*touch.frames)) if has else None
    return found, report


@pytest.mark.parametrize(
    "what", [pytest.param(what, marks=[] if what in QUICK else pytest.mark.slow) for what in DESCRIPTIONS]
)
def test_a_spoilt_description_has_its_reason(what, log):
    """The frames of the ball say what is wrong; the cross is replayed unless it shares the fault."""
    spoil, expected = DESCRIPTIONS[what]
    document = yaml.safe_load((log / "log.yaml").read_text())
    spoil(document)
    (log / "log.yaml").write_text(yaml.safe_dump(document))
    found, report = ball_status(log)
    words = STATUSES[expected]
    if expected in (ReplayStatus.GEL_PLACE_UNKNOWN, ReplayStatus.GEL_UNUSABLE):
        # both touches share it: there is nothing to attach, and the report says why
        assert found == {"ball4": None, "cross": None}
        assert report.fell_short
    else:
        assert expected in found["ball4"]
        assert FrameStatus.SOLVED in found["cross"]
        assert report.status[words] == (found["ball4"] == expected).sum() + (found["cross"] == expected).sum()
    if isinstance(expected, ReplayStatus):
        assert report.fell_short
        assert any(reason.startswith(words) for reason in report.refused)
        assert any(words in line for line in report.lines())
    else:
        assert not report.refused


@pytest.mark.parametrize(
    ("metres", "cause"), [(-2e-3, "a transform (robot.tcp_from_gel"), (-1.0, "a length in millimetres")]
)
def test_a_pressed_trajectory_that_does_not_touch_is_told(metres, cause, log):
    """The largest measured force, the distance, the likely cause and the next step stand in the report."""
    document = yaml.safe_load((log / "log.yaml").read_text())
    deeper(document, metres)
    (log / "log.yaml").write_text(yaml.safe_dump(document))
    _, report = ball_status(log)
    store = Store.open(log.parent / "ds.zarr")
    (told,) = report.untouched
    force = store.frames(["contact_force"])["contact_force"].to_numpy()
    touch = next(touch for touch in plan_replay(store, coarse_pad).touches if touch.indenter == "ball4")
    assert told.largest_force == pytest.approx(np.nanmax(force[slice(*touch.frames)]))
    assert told.largest_force > 1
    assert told.height == pytest.approx(-metres, abs=1.2e-3 - 0.01 * metres)
    text = "\n".join(report.lines())
    assert f"up to {told.largest_force:.1f} N at frame {told.frame}" in text
    assert f"probably wrong: {cause}" in text
    assert f"--trajectory {touch.name} --frame {told.frame}" in text
    assert report.document()["untouched"][0]["name"] == touch.name


def test_a_touch_that_is_nearly_reached_points_to_a_calibration():
    """Some tenths of a millimetre above the gel are an error of place; without such trajectories nothing is said."""
    near = UntouchedTouch("0" * 16, "press", 1.5, 4, 3e-4, 2e-3)
    lines = untouched_lines([near], "ds.zarr")
    assert "does not touch the gel" in lines[0]
    assert "`tactiledata calibrate`" in lines[1]
    assert "0.30 mm above the top of the gel and 2.0 mm from its axis" in lines[0]
    assert "0.30 mm below" in untouched_lines([replace(near, height=-3e-4)], "ds.zarr")[0]
    assert untouched_lines([near] * 4, "ds.zarr")[0].endswith("; …)")
    assert untouched_lines([], "ds.zarr") == []


MESHES = {
    "closed": (1.0, slice(None), FrameStatus.SOLVED, ""),
    "open": (1.0, slice(None, -2), ReplayStatus.INDENTER_UNUSABLE, "not watertight"),
    "in metres": (1e-3, slice(None), ReplayStatus.INDENTER_UNUSABLE, "fit the unit m"),
}


@pytest.mark.parametrize("what", MESHES)
def test_a_mesh_of_an_indenter_is_pressed_or_says_why_not(what, log):
    """A ball as a mesh in millimetres is solved; with a hole, or in metres, its frames have the reason."""
    factor, faces, expected, words = MESHES[what]
    ball = trimesh.creation.icosphere(subdivisions=2, radius=4.0).apply_translation([0, 0, 4.0])
    trimesh.Trimesh(factor * ball.vertices, ball.faces[faces], process=False).export(log / "ball.stl")
    document = yaml.safe_load((log / "log.yaml").read_text())
    unlike(mesh="ball.stl", unit="mm")(document)
    (log / "log.yaml").write_text(yaml.safe_dump(document))
    found, report = ball_status(log, indenter_folder=log)
    assert expected in found["ball4"]
    assert FrameStatus.SOLVED in found["cross"]
    assert all(words in reason for reason in report.refused)
    assert len(report.refused) == bool(words)


def test_a_mesh_without_its_folder_names_the_option(log):
    """The reason names the option to give and no document, and the other touch goes on."""
    document = yaml.safe_load((log / "log.yaml").read_text())
    unlike(mesh="ball.stl", unit="mm")(document)
    (log / "log.yaml").write_text(yaml.safe_dump(document))
    found, report = ball_status(log)
    assert FrameStatus.SOLVED in found["cross"]
    assert len(report.refused) == 1
    assert all("'ball.stl'" in reason and "--indenters FOLDER" in reason for reason in report.refused)


def test_poses_that_are_missing_are_said_frame_by_frame(log):
    """With a gap of half a second and a second of NaN in the poses, those frames alone are missing."""
    lines = (log / "tcp.csv").read_text().splitlines()
    times = np.array([int(line.partition(",")[0]) for line in lines[1:]])
    start = int((log / "trajectories.csv").read_text().splitlines()[1].split(",")[1])
    gap = (times > start + 2.2e9) & (times < start + 2.7e9)
    nowhere = times > start + 4.0e9
    kept = [
        line if not blank else ",".join([line.partition(",")[0], *["nan"] * 7])
        for line, blank in zip(np.array(lines[1:])[~gap], nowhere[~gap], strict=True)
    ]
    (log / "tcp.csv").write_text("\n".join([lines[0], *kept]) + "\n")
    found, report = ball_status(log)
    store = Store.open(log.parent / "ds.zarr")
    touch = next(touch for touch in plan_replay(store, coarse_pad).touches if touch.indenter == "ball4")
    t_ns = store.frames(["t_ns"])["t_ns"].to_numpy()[np.arange(*touch.frames)]
    margin = 20e6
    inside = (t_ns > start + 2.2e9 + margin) & (t_ns < start + 2.7e9 - margin)
    clear = (t_ns < start + 2.2e9 - margin) | ((t_ns > start + 2.7e9 + margin) & (t_ns < start + 4.0e9 - margin))
    assert inside.any()
    assert (found["ball4"][inside] == FrameStatus.POSE_MISSING).all()
    assert (found["ball4"][clear] != FrameStatus.POSE_MISSING).all()
    assert report.status[STATUSES[FrameStatus.POSE_MISSING]] >= inside.sum()


def test_a_recording_without_poses_is_refused(log):
    """The other instruments stay; nothing is replayed."""
    (log / "tcp.csv").unlink()
    _, report = ball_status(log)
    assert report.fell_short
    assert list(report.refused) == [STATUSES[ReplayStatus.NO_POSES]]


def test_the_pose_is_the_chain_of_transforms():
    """gel_from_indenter is the chain through the arm, and an offset moves it along the gel's -z."""
    chance = np.random.default_rng(3)

    def some(to, source):
        return Transform.from_parts(to, source, chance.normal(size=3), chance.normal(size=4))

    base_from_tcp, tcp_from_gel, base_from_ball = some("base", "tcp"), some("tcp", "gel"), some("base", "ball")
    arm = np.concatenate([matrix_poses(base_from_tcp.matrix), np.full((1, 7), np.nan)])
    poses = gel_from_indenter(arm, tcp_from_gel.matrix, base_from_ball.matrix, 1e-3)
    chain = (base_from_tcp @ tcp_from_gel).inverse() @ base_from_ball
    shift = np.eye(4)
    shift[2, 3] = -1e-3
    assert np.allclose(poses[0], shift @ chain.matrix)
    assert np.isnan(poses[1]).all()


def test_what_a_log_states_of_the_gel_wins():
    """Stated sizes over the model's; without a model outline and thickness must be stated."""
    stated = gel_geometry({"model": "digit", "gel": {"thickness": 0.003, "edge_thickness": 0.001}})
    model = gel_geometry({"model": "digit"})
    assert (stated.thickness, stated.edge_thickness, stated.outline) == (0.003, 0.001, model.outline)
    assert gel_geometry({"model": "something"}) is None
    assert gel_geometry({"model": "something", "gel": {"outline": [0.02, 0.03], "thickness": 0.004}}).is_flat
