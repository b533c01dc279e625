"""A view holds what the store holds: read back with rerun's reader, value for value."""

import fcntl
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import time

import cv2
import numpy as np
import pytest
from copied_trees import copy_tree

pytest.importorskip("rerun")

from command import run_command
from random_takes import SMALL, staged_take
from viewed_store import UNSOLVED, attach_planted, planted_pad, read_view

from tactiledata.contract.take import UNUSABLE
from tactiledata.errors import StoreError, UnknownName, UsageError
from tactiledata.store.change.flag import flag_trajectories
from tactiledata.store.layout.places import MANIFEST
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit_groups, create
from tactiledata.view import recording
from tactiledata.view.chosen import thinned
from tactiledata.view.curves import every_so_many
from tactiledata.view.options import ViewOptions
from tactiledata.view.recording import write_view


@pytest.fixture(scope="module")
def planted(tiny_store, tmp_path_factory):
    """The tiny store with a planted mesh; read only."""
    place = tmp_path_factory.mktemp("planted") / "ds.zarr"
    copy_tree(tiny_store, place)
    attach_planted(place)
    return place


@pytest.fixture(scope="module")
def seen(planted, tmp_path_factory):
    """A view of the whole store, its report, and the store."""
    path = tmp_path_factory.mktemp("view") / "view.rrd"
    report = write_view(Store.open(planted), path)
    views, layouts = read_view(path)
    assert layouts == 1
    return views, report, Store.open(planted)


def create_store(place, *seeds):
    """A store of random takes: small pictures of all kinds, and signals."""
    create(place, SMALL)
    commit_groups(place, [staged_take(place, seed)[0] for seed in seeds])
    return place


def touches(store):
    return store.trajectories().to_pylist()


@pytest.mark.slow
def test_every_trajectory_is_there_once(seen):
    """A recording for each trajectory of the store, named by it, with the store's digest and the start of its clock."""
    views, report, store = seen
    assert set(views) == set(store.trajectories(["uid"])["uid"].to_pylist())
    for facts in touches(store):
        view = views[facts["uid"]]
        assert view.property("store_digest") == store.digest
        assert view.property("start_ns") == facts["start_ns"]
        assert facts["trajectory"] in view.static("__properties", "RecordingInfo:name")[0]
    assert (len(report.trajectories), report.found, report.pictures) == (len(views), len(views), store.n_frames)


@pytest.mark.slow
def test_pictures_are_the_bytes_that_came(seen):
    """Pictures stand at the moments of their frames, on both time lines, byte for byte as the store has them."""
    views, _, store = seen
    t_ns = store.frames(["t_ns"])["t_ns"].to_numpy()
    for facts in touches(store):
        view, rows = views[facts["uid"]], range(facts["frame_start"], facts["frame_stop"])
        start = view.property("log_start_ns")
        for line, zero in (("trajectory", facts["start_ns"]), ("log", start)):
            found = view.rows("cameras/digit/picture", "EncodedImage:blob", line)
            assert [t for t, _ in found] == (t_ns[list(rows)] - zero).tolist()
            assert [bytes(value[0]) for _, value in found] == store.encoded(list(rows))


def test_log_time_starts_with_the_recording(seen):
    """No sample or frame of a recording is before zero of the time line of its log, and one is there."""
    views, _, store = seen
    starts = {views[facts["uid"]].property("log_start_ns"): facts["source"] for facts in touches(store)}
    assert len(starts) == store.sources(["key"]).num_rows
    for start, source in starts.items():
        frames = store.frames(["t_ns", "source"])
        first = frames["t_ns"].to_numpy()[frames["source"].to_numpy() == source].min()
        contents = json.loads(store.sources(["contents"])["contents"][source].as_py())
        samples = [
            int(store.signal(name).t_ns(entry["rows"][0], entry["rows"][0] + 1)[0])
            for name, entry in contents["signals"].items()
        ]
        assert start == min(int(first), *samples)


def test_difference_is_doubled_about_grey(seen):
    """The difference is 128 + 2 (picture - background), up to its compression."""
    views, _, store = seen
    facts = touches(store)[0]
    background = store.reference(facts["sensor"]).image.astype(int)
    found = views[facts["uid"]].rows("cameras/digit/difference", "EncodedImage:blob")
    for (_, blob), row in zip(found, range(facts["frame_start"], facts["frame_stop"]), strict=True):
        drawn = cv2.imdecode(np.frombuffer(bytes(blob[0]), np.uint8), cv2.IMREAD_COLOR_RGB).astype(int)
        wanted = np.clip(128 + 2 * (store.images([row])[0].astype(int) - background), 0, 255)
        assert np.abs(drawn - wanted).mean() < 3


@pytest.mark.slow
def test_contact_mask_lies_in_touches_only(seen):
    """A mask has contact in the firmest frame and none in the first, which no indenter touches; it is of 0 and 1."""
    views, _, store = seen
    force = store.frames(["contact_force"])["contact_force"].to_numpy()
    for facts in touches(store):
        rows = np.arange(facts["frame_start"], facts["frame_stop"])
        found = [np.array(value[0]) for _, value in views[facts["uid"]].rows("cameras/digit/contact", BUFFER)]
        assert set(np.unique(found)) <= {0, 1}
        assert found[int(np.argmax(force[rows]))].any()
        assert not found[0].any()


BUFFER = "SegmentationImage:buffer"


def test_measured_force_is_dots_at_native_rate(seen):
    """Measured forces and torques are the store's samples, as points; simulated ones those of the mesh, as lines."""
    views, _, store = seen
    mesh, signal = store.mesh("planted"), store.signal("contact_wrench")
    t_frames = store.frames(["t_ns"])["t_ns"].to_numpy()
    for facts in touches(store):
        view = views[facts["uid"]]
        first, stop = json.loads(facts["signal_rows"])["contact_wrench"]
        rows = np.arange(facts["frame_start"], facts["frame_stop"])
        rows = rows[rows != UNSOLVED]
        for column, name in enumerate(("fx", "fy", "fz", "tx", "ty", "tz")):
            above = "force" if name[0] == "f" else "torque"
            t_ns, values = view.curve(f"{above}/measured/{name}")
            np.testing.assert_array_equal(t_ns, signal.t_ns(first, stop) - facts["start_ns"])
            np.testing.assert_array_equal(values, signal.values(first, stop)[:, column])
            assert view.static(f"{above}/measured/{name}", "SeriesPoints:markers")
            t_ns, values = view.curve(f"{above}/simulated/{name}")
            np.testing.assert_array_equal(t_ns, t_frames[rows] - facts["start_ns"])
            np.testing.assert_array_equal(values, mesh.wrench(rows)[:, column])
            assert view.static(f"{above}/simulated/{name}", "SeriesLines:widths")


def test_residual_is_measured_minus_simulated(seen):
    """The residual is the aligned measured force less the simulated one, at frames with a mesh."""
    views, _, store = seen
    for facts in touches(store):
        rows = np.arange(facts["frame_start"], facts["frame_stop"])
        rows = rows[rows != UNSOLVED]
        wanted = store.aligned("contact_wrench", rows)[0][:, :3] - store.mesh("planted").wrench(rows)[:, :3]
        for column, name in enumerate(("fx", "fy", "fz")):
            _, values = views[facts["uid"]].curve(f"residual/{name}")
            np.testing.assert_array_equal(values, wanted[np.isfinite(wanted[:, column]), column])


def test_pose_is_since_the_start(seen):
    """The pose is the tool's way in millimetres since its first sample."""
    views, _, store = seen
    for facts in touches(store):
        first, stop = json.loads(facts["signal_rows"])["tcp"]
        wanted = store.signal("tcp").values(first, stop)[:, :3]
        for column, name in enumerate("xyz"):
            _, values = views[facts["uid"]].curve(f"pose/moved_mm/{name}")
            np.testing.assert_allclose(values, 1e3 * (wanted[:, column] - wanted[0, column]), atol=1e-9)


def test_gel_is_the_deformed_surface(seen):
    """Each frame's surface is that of the pad plus its displacement, on the pad's triangles; without one, nothing."""
    views, report, store = seen
    pad = planted_pad()
    t_ns = store.frames(["t_ns"])["t_ns"].to_numpy()
    for facts in touches(store):
        view = views[facts["uid"]]
        rows = np.arange(facts["frame_start"], facts["frame_stop"])
        solved = rows[rows != UNSOLVED]
        shapes = view.rows("gel/surface", "Mesh3D:vertex_positions")
        drawn = [(t, np.array(value)) for t, value in shapes if value]
        assert [t for t, _ in drawn] == (t_ns[solved] - facts["start_ns"]).tolist()
        faces = np.array(view.static("gel/surface", "Mesh3D:triangle_indices"))
        for (_, positions), row in zip(drawn, solved, strict=True):
            wanted = pad.vertices[0].copy()
            wanted[pad.kept] += store.mesh("planted").displacement([row])[0]
            np.testing.assert_allclose(positions[faces], wanted[pad.triangles], atol=1e-7)
        pressed = [value for _, value in view.rows("gel/pressed", "Points3D:positions") if value]
        assert all(len(points) == -(-len(pad.corners) // 3) for points in pressed)
        largest = np.linalg.norm(store.mesh("planted").displacement(solved), axis=2).max()
        assert f"yellow has moved {1e3 * largest:.2f} mm" in view.static("about", "TextDocument:text")[0]
    assert report.meshes == store.n_frames - 1
    assert report.lines()[0].endswith("with a mesh (planted)")
    assert report.other_meshes == ()


def test_a_frame_without_mesh_clears_the_one_before(seen):
    """At the frame that was not solved the gel is cleared: the mesh of the frame before would be shown as its own."""
    views, report, store = seen
    (facts,) = [one for one in touches(store) if one["frame_start"] <= UNSOLVED < one["frame_stop"]]
    view = views[facts["uid"]]
    moment = int(store.frames(["t_ns"])["t_ns"][UNSOLVED].as_py()) - facts["start_ns"]
    assert moment in [t for t, _ in view.rows("gel/surface", "Clear:is_recursive")]
    assert "No mesh in 1 frame" in view.static("about", "TextDocument:text")[0]
    assert any("no equilibrium was found" in sentence for sentence in report.missing)


def test_the_indenter_is_at_its_recorded_pose(seen):
    """The tip in the view is where poses and the stated transforms put it: about the commanded depth in."""
    views, _, store = seen
    for facts in touches(store):
        places = views[facts["uid"]].rows("gel/indenter", "Transform3D:translation")
        assert len(places) == facts["frame_stop"] - facts["frame_start"]
        lowest = min(value[0][2] for _, value in places)
        depth = json.loads(facts["extra"])["commanded_depth_m"]
        assert -depth - 3e-4 < lowest < 0


def test_simulated_recordings_are_called_so(seen):
    """Name, words and report say that a recording is simulated; so does the property that programs read."""
    views, report, _ = seen
    for view in views.values():
        assert "simulated" in view.static("__properties", "RecordingInfo:name")[0]
        assert "Simulated recording" in view.static("about", "TextDocument:text")[0]
        assert view.property("recorded") == "simulated"
    assert report.simulated.simulated == len(views)


@pytest.mark.slow
def test_what_is_missing_is_said_and_absent(planted, tmp_path):
    """Without mesh, background and pose the panes are absent, and words name each; nothing else is lost."""
    place = tmp_path / "ds.zarr"
    copy_tree(planted, place)
    from tactiledata.contract.sealed import sealed_json
    from tactiledata.store.write.mesh_writer import drop_mesh

    drop_mesh(place, "planted")
    manifest = json.loads((place / MANIFEST).read_text())
    manifest["references"] = {}
    (place / MANIFEST).write_bytes(sealed_json(manifest))
    report = write_view(Store.open(place), tmp_path / "view.rrd", ViewOptions(names=("t00000",)))
    (view,) = read_view(tmp_path / "view.rrd")[0].values()
    assert not {entity for entity in view.entities if entity.startswith(("gel", "residual", "force/simulated"))}
    assert "cameras/digit/difference" not in view.entities
    words = view.static("about", "TextDocument:text")[0]
    for said in ("not replayed", "no picture of the sensor without contact"):
        assert said in words
        assert any(said in sentence for sentence in report.missing)
    assert len(view.rows("cameras/digit/picture", "EncodedImage:blob")) == report.pictures > 0


@pytest.mark.slow
def test_the_mesh_that_is_shown_is_named_beside_the_others(planted, tmp_path):
    """The report of a view names the mesh that is shown, and the other one with the option that shows it."""
    place = copy_tree(planted, tmp_path / "two.zarr")
    attach_planted(place, "another")
    report = write_view(Store.open(place), tmp_path / "a.rrd", ViewOptions(mesh="planted"))
    assert (report.mesh, report.other_meshes) == ("planted", ("another",))
    assert report.lines()[0].endswith("with a mesh (planted)")
    assert "other meshes, shown by --mesh NAME: another" in report.lines()


@pytest.mark.slow
def test_choice_and_limits(planted, tmp_path):
    """Sensor, number and stride choose; ends of a trajectory stay; what is not shown is counted."""
    store = Store.open(planted)
    sensor = touches(store)[-1]["sensor"]
    report = write_view(store, tmp_path / "a.rrd", ViewOptions(sensor=sensor, most=1, stride=4))
    assert (len(report.trajectories), report.found) == (1, 2)
    assert "1 trajectory of 2" in report.lines()[0]
    (uid,) = read_view(tmp_path / "a.rrd")[0]
    (facts,) = [one for one in touches(store) if one["uid"] == uid]
    count = facts["frame_stop"] - facts["frame_start"]
    assert report.pictures == len(thinned(count, 4, 0))
    with pytest.raises(UnknownName):
        write_view(store, tmp_path / "b.rrd", ViewOptions(sensor="nobody"))
    with pytest.raises(UnknownName):
        write_view(store, tmp_path / "b.rrd", ViewOptions(mesh="none"))
    with pytest.raises(UsageError, match="nothing to show"):
        write_view(store, tmp_path / "b.rrd", ViewOptions(flagged=True))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.rrd"]


@pytest.mark.parametrize(("count", "stride", "most"), [(0, 1, 0), (1, 3, 1), (10, 3, 0), (1000, 7, 20), (5, 9, 2)])
def test_thinned_keeps_both_ends(count, stride, most):
    """What is thinned ascends, keeps the first and the last (of one place: the first), and no more than allowed."""
    taken = thinned(count, stride, most)
    assert (np.diff(taken) > 0).all()
    assert len(taken) <= (most or count)
    assert count == 0 or taken[0] == 0
    assert count == 0 or most == 1 or taken[-1] == count - 1


@pytest.mark.slow
def test_a_flag_is_shown_and_its_words_steer_nothing(planted, tmp_path):
    """A flagged trajectory is called so in its name; its reason stands in the words as it was typed, as no markup."""
    place = tmp_path / "ds.zarr"
    copy_tree(planted, place)
    flag_trajectories(place, ["t00001"], "slipped <img src=x> *really* [a](b)")
    report = write_view(Store.open(place), tmp_path / "view.rrd", ViewOptions(flagged=True))
    (view,) = read_view(tmp_path / "view.rrd")[0].values()
    assert view.static("__properties", "RecordingInfo:name")[0].startswith("FLAGGED t00001")
    words = view.static("about", "TextDocument:text")[0]
    assert r"slipped \<img src=x\> \*really\* \[a\]\(b\)" in words
    assert view.property("flagged") == report.flags[0].reason


@pytest.mark.slow
def test_a_damaged_picture_is_left_out_and_said(planted, tmp_path):
    """One flipped byte in the heap: that picture is cleared and said, the others are there."""
    place = tmp_path / "ds.zarr"
    copy_tree(planted, place)
    store = Store.open(place)
    frames = store.frames(["offset", "length"])
    heap = place / "streams" / "digit" / "heap" / "c.0"
    content = bytearray(heap.read_bytes())
    content[frames["offset"][1].as_py() + frames["length"][1].as_py() // 2] ^= 255
    heap.unlink()
    heap.write_bytes(content)
    report = write_view(Store.open(place), tmp_path / "view.rrd", ViewOptions(names=(touches(store)[0]["uid"],)))
    count = touches(store)[0]["frame_stop"]
    assert report.pictures == count - 1
    assert any("No picture in 1 frame" in sentence for sentence in report.missing)


@pytest.mark.slow
def test_command_writes_and_says(planted, tmp_path, monkeypatch, capsys):
    """The command writes the file, says what it holds and how to look, opens nothing without a terminal, and a full
    name chooses; bad input exits with 2 and leaves what was there.
    """
    monkeypatch.chdir(tmp_path)
    shutil.copytree(planted, tmp_path / "ds.zarr", copy_function=shutil.copy)
    code, printed, _ = run_command(capsys, "view", "D20001.mcap/t00000")
    assert code == 0
    assert "view.rrd: 1 trajectory" in printed
    assert "rerun view.rrd" in printed
    before = (tmp_path / "view.rrd").read_bytes()
    code, printed, _ = run_command(capsys, "view", "ds.zarr", "t00000", "--json", "--pictures", "3", "--out", "b.rrd")
    document = json.loads(printed)
    assert (code, document["pictures"], document["simulated"]["simulated"]) == (0, 3, 1)
    for bad in (["nobody"], ["--stride", "0"], ["--out", "x.png"], ["--web", "--json"], ["--mesh", "q"]):
        assert run_command(capsys, "view", "ds.zarr", *bad)[0] == 2
    assert (tmp_path / "view.rrd").read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b.rrd", "ds.zarr", "view.rrd"]


def view_for_ever(place, path):
    while True:
        write_view(Store.open(place), path, ViewOptions(most=2, pictures=3))


@pytest.mark.slow
def test_killed_while_writing_the_file_is_whole(planted, tmp_path):
    """Killed with signal 9 at several moments, the file is a whole one, old or new; the next call writes it and takes
    away what the killed ones left.
    """
    path = tmp_path / "view.rrd"
    write_view(Store.open(planted), path, ViewOptions(most=2, pictures=3))
    wanted = set(read_view(path)[0])
    left = 0
    for attempt in range(3):
        writer = multiprocessing.get_context("spawn").Process(target=view_for_ever, args=(planted, path))
        # it imports the viewer for some seconds; then it writes one file after the other
        begun = set(tmp_path.glob(".view.rrd.*.part"))
        writer.start()
        while writer.is_alive() and not set(tmp_path.glob(".view.rrd.*.part")) - begun:
            time.sleep(0.01)
        time.sleep(0.4 * attempt)
        os.kill(writer.pid, signal.SIGKILL)
        writer.join()
        left += len(list(tmp_path.glob(".view.rrd.*.part")))
        assert set(read_view(path)[0]) == wanted
    assert left
    write_view(Store.open(planted), path, ViewOptions(most=2, pictures=3))
    assert [place.name for place in tmp_path.iterdir()] == ["view.rrd"]


@pytest.mark.slow
def test_what_a_killed_process_left_without_a_lock_is_taken_away(planted, tmp_path):
    """A process may die between the making of its folder and of its lock; a folder that is held stays."""
    (tmp_path / ".view.rrd.abc.part").mkdir()
    held = tmp_path / ".view.rrd.held.part"
    held.mkdir()
    with (held / "lock").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        write_view(Store.open(planted), tmp_path / "view.rrd", ViewOptions(most=1, pictures=1))
        assert sorted(place.name for place in tmp_path.iterdir()) == [held.name, "view.rrd"]


@pytest.mark.slow
def test_odd_stores_are_shown(tmp_path):
    """Raw, missing and stray pictures of several cameras, random signals, no poses, no calendar: each frame
    with a picture is shown once, raw ones as they are, and every other one is said.
    """
    place = create_store(tmp_path / "odd.zarr", 3, 4, 5, 10)
    store = Store.open(place)
    report = write_view(store, tmp_path / "view.rrd", ViewOptions(most=0, pictures=0))
    frames = store.frames(["trajectory", "flags", "camera", "encoding"]).to_pylist()
    views = read_view(tmp_path / "view.rrd")[0]
    shown = raw = 0
    for facts in touches(store):
        view = views[facts["uid"]]
        assert r"odd\.zarr" in view.static("about", "TextDocument:text")[0]
        for row in range(facts["frame_start"], facts["frame_stop"]):
            shown += not frames[row]["flags"] & UNUSABLE
        for path in (path for path in view.entities if path.endswith("/picture")):
            drawn = view.rows(path, "Image:buffer")
            raw += len(drawn)
            assert all(len(value[0]) % 3 == 0 for _, value in drawn)
    assert report.pictures == shown
    assert raw
    assert any("No picture in" in sentence for sentence in report.missing)


class CountedSignal:
    """Sample n at n nanoseconds, with the value -n."""

    def t_ns(self, start, stop):
        return np.arange(start, stop)

    def values(self, start, stop):
        return -np.arange(start, stop, dtype=float)[:, None]


@pytest.mark.parametrize(
    ("first", "stop", "most", "block"), [(3, 10, 100, 4), (0, 1000, 7, 64), (5, 6, 1, 1), (2, 98, 10, 3)]
)
def test_thinned_samples_are_evenly_taken_once(first, stop, most, block):
    """However samples lie in blocks, every so manieth is taken once, in order, with its own value, and no more than
    allowed.
    """
    t_ns, values, step = every_so_many(CountedSignal(), first, stop, most, block)
    assert t_ns.tolist() == list(range(first, stop, step))
    assert values[:, 0].tolist() == (-t_ns).tolist()
    assert len(t_ns) <= most


def test_a_message_of_rerun_has_no_colours(tmp_path, monkeypatch):
    """What rerun says of a failure is told without the codes that colour it on a terminal."""
    said = "\x1b[2m2026-11-29\x1b[0m \x1b[31mERROR\x1b[0m no room \x1b[1;31mleft\x1b[0m\n"
    failed = subprocess.CompletedProcess([], 1, "", said)
    monkeypatch.setattr(recording.subprocess, "run", lambda *given, **options: failed)
    with pytest.raises(StoreError) as refused:
        recording._join([], tmp_path / "joined.rrd", tmp_path / "view.rrd")
    assert refused.value.found.endswith("could not be written: 2026-11-29 ERROR no room left")
