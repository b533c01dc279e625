"""What a replay attaches: the engine's own numbers, in rows of the frames, whole after any kill."""

import os
import signal

import numpy as np
import pytest
from coarse import MATERIAL, coarse_pad, files, options
from copied_trees import copy_tree

from tactiledata.errors import UsageError
from tactiledata.gel.contact.history import FrameStatus
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.replay import attach
from tactiledata.replay.attach import replay
from tactiledata.replay.overview import mesh_sections, write_replay_page
from tactiledata.replay.plan import plan_replay
from tactiledata.replay.status import STATUSES, ReplayStatus
from tactiledata.store.check.check import check
from tactiledata.store.read.meshes import FRAME_ARRAYS, HAS_MESH
from tactiledata.store.read.reader import Store


def test_rows_are_what_the_engine_says(replayed):
    """Every trajectory played alone through the engine gives the rows of its frames, and its pad the vertices."""
    store = Store.open(replayed)
    mesh, plan = store.mesh("coarse"), plan_replay(store, coarse_pad)
    engine = FemEngine(plan.pads[0].mesh, MATERIAL.poisson_ratio, "linear")
    for touch in plan.touches:
        (_, history), = engine.play([touch.gel_touch(store, 0.0)], MATERIAL)  # fmt: skip
        rows = np.arange(*touch.frames)
        assert np.array_equal(mesh.status(rows), history.status)
        assert np.array_equal(mesh.displacement(rows), history.displacement, equal_nan=True)
        assert np.array_equal(mesh.force(rows), history.node_forces, equal_nan=True)
        assert np.array_equal(mesh.wrench(rows), history.wrench, equal_nan=True)
        assert np.array_equal(mesh.contact(rows), history.pressed)
    assert np.array_equal(mesh.pad().vertices[0], plan.pads[0].mesh.vertices)
    assert np.array_equal(mesh.pad().triangles, plan.pads[0].mesh.triangles)


def test_the_forces_of_the_nodes_make_the_wrench(replayed):
    """What the indenter exerts on the nodes is the opposite of what the gel exerts on it; free air moves nothing."""
    mesh = Store.open(replayed).mesh("coarse")
    status = mesh.status()
    assert set(status.tolist()) == set(HAS_MESH)
    assert np.allclose(mesh.force().sum(axis=1), -mesh.wrench()[:, :3], atol=1e-5)
    assert not mesh.displacement(status == FrameStatus.NO_CONTACT).any()
    assert (mesh.wrench(status == FrameStatus.SOLVED)[:, 2] > 0).all()
    # the base is bonded
    assert not mesh.displacement()[:, mesh.pad().base].any()


def test_simulated_forces_follow_the_measured_ones(replayed):
    """Poses, frames and signs are right: on a sphere the simulated force goes with the measured one."""
    store = Store.open(replayed)
    balls = [touch for touch in plan_replay(store, coarse_pad).touches if touch.indenter == "ball4"]
    rows = np.concatenate([np.arange(*touch.frames) for touch in balls])
    measured, simulated = store.aligned("contact_wrench", rows)[0][:, :3], store.mesh("coarse").wrench(rows)[:, :3]
    assert np.corrcoef(measured[:, 2], simulated[:, 2])[0, 1] > 0.97
    sheared = np.abs(measured[:, 0]) > 0.5
    assert sheared.any()
    assert (np.sign(measured[sheared, 0]) == np.sign(simulated[sheared, 0])).all()


@pytest.mark.slow
def test_a_whole_store_checks_and_damage_shows(replayed, tmp_path):
    """No findings on a whole mesh; a chunk that is gone, and one that is changed, are found."""
    assert check(replayed) == []
    for number, spoil in enumerate((lambda place: place.unlink(), lambda place: _flip(place))):
        place = tmp_path / f"{number}.zarr"
        copy_tree(replayed, place)
        spoil(next((place / "meshes/coarse/displacement").glob("c.0*")))
        assert [(one.code, one.severity) for one in check(place, images=False)] == [("store-mesh", "damage")]


@pytest.mark.slow
def test_a_damaged_mesh_is_made_anew(replayed, tmp_path):
    """What `check` says of a damaged mesh helps: with --replace the same options give the bytes of before."""
    place = tmp_path / "ds.zarr"
    copy_tree(replayed, place)
    before = files(place)
    _flip(next((place / "meshes/coarse/displacement").glob("c.0*")))
    (found,) = check(place, images=False)
    assert found.message.endswith("; `tactiledata replay --replace` makes it anew")
    assert replay(place, options(), replace=True).new_frames == Store.open(place).n_frames
    assert files(place) == before
    assert replay(place, options(), replace=True).new_frames == 0


def _flip(place):
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 0xFF
    place.write_bytes(content)


@pytest.mark.slow
def test_the_same_replay_again_changes_nothing(replayed, tmp_path):
    """The same replay again changes no byte of the store, and reports no new frame."""
    place = tmp_path / "ds.zarr"
    copy_tree(replayed, place)
    before = files(place)
    assert replay(place, options()).new_frames == 0
    assert files(place) == before


@pytest.mark.slow
def test_others_stand_beside_it_or_are_refused(copied):
    """Another name stands beside; another material under the same name is an error, unless it is to replace."""
    replay(copied, options())
    replay(copied, options(name="surface", keep="surface"))
    stiffer = options(material=GelMaterial(2 * MATERIAL.youngs_modulus, MATERIAL.poisson_ratio, MATERIAL.friction))
    with pytest.raises(UsageError, match=r"\(youngs modulus \S+ there, \S+ here\).*--replace"):
        replay(copied, stiffer)
    with pytest.raises(UsageError, match=r"\(keep all there, surface here\).*--replace"):
        replay(copied, options(keep="surface"))
    with pytest.raises(UsageError, match=r"\(offsets 0 \(\w+\) there, 1 \(\w+\) here\).*--replace"):
        replay(copied, options(offsets={"0" * 16: 1e-5}))
    store = Store.open(copied)
    assert store.mesh_names == ("coarse", "surface")
    whole, surface = store.mesh("coarse"), store.mesh("surface")
    assert np.array_equal(whole.displacement()[:, surface.pad().kept], surface.displacement())
    before = whole.wrench()
    assert replay(copied, stiffer, replace=True).new_frames == store.n_frames
    assert np.allclose(Store.open(copied).mesh("coarse").wrench(), 2 * before, rtol=1e-4, atol=1e-9)
    assert check(copied) == []


@pytest.mark.slow
def test_an_offset_presses_deeper(copied, replayed):
    """The offset of a calibration makes its trajectory firmer, and leaves the others as they are."""
    store = Store.open(replayed)
    touch = plan_replay(store, coarse_pad).touches[0]
    replay(copied, options(offsets={touch.uid: 1e-4}))
    rows = np.arange(*touch.frames)
    deeper, as_recorded = (Store.open(place).mesh("coarse").wrench() for place in (copied, replayed))
    assert deeper[rows, 2].max() > 1.1 * as_recorded[rows, 2].max()
    others = np.setdiff1d(np.arange(store.n_frames), rows)
    assert np.array_equal(deeper[others], as_recorded[others])


@pytest.mark.slow
def test_workers_do_not_change_a_byte(tiny_store, tmp_path, monkeypatch):
    """One worker and two give the same files."""
    monkeypatch.setattr(attach, "RUN_TOUCHES", 1)
    for workers in (1, 2):
        place = tmp_path / f"{workers}.zarr"
        copy_tree(tiny_store, place)
        replay(place, options(), workers)
    assert files(tmp_path / "1.zarr") == files(tmp_path / "2.zarr")


MOMENTS = ("replace", "rename", "fsync", "unlink", "rmdir", "open")


def _killed_at(place, moment):
    """A replay in a process that ends by SIGKILL at the n-th call that changes the disk; whether it did."""
    child = os.fork()
    if child == 0:
        try:
            left = moment

            def counted(call):
                def run(*arguments, **named):
                    nonlocal left
                    left -= 1
                    if left < 0:
                        os.kill(os.getpid(), signal.SIGKILL)
                    return call(*arguments, **named)

                return run

            for name in MOMENTS:
                setattr(os, name, counted(getattr(os, name)))
            replay(place, options())
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_killed_and_resumed_is_the_same(copied, seed, tmp_path, monkeypatch):
    """A replay that is killed at random moments and resumed leaves every file as an uninterrupted one does."""
    monkeypatch.setattr(attach, "RUN_TOUCHES", 1)
    whole = tmp_path / "whole.zarr"
    copy_tree(copied, whole)
    replay(whole, options())
    chance = np.random.default_rng(seed)
    kills = 0
    for _ in range(5):
        kills += _killed_at(copied, int(chance.integers(1, 250)))
        assert [one.code for one in check(copied, images=False) if one.severity != "info"] == []
    replay(copied, options())
    assert kills
    assert files(copied) == files(whole)


@pytest.mark.slow
def test_frames_that_come_later_are_replayed_later(tiny_mcaps, tmp_path):
    """A store that grew goes on where the mesh ended, and is then as if all had been there at once."""
    from tactiledata.ingest.pipeline import ingest

    place, whole = tmp_path / "ds.zarr", tmp_path / "whole.zarr"
    ingest(tiny_mcaps[:1], place)
    first = replay(place, options()).new_frames
    ingest(tiny_mcaps[1:], place)
    assert [one.code for one in check(place)] == ["mesh-behind"]
    store = Store.open(place)
    assert np.isnan(store.mesh("coarse").wrench(np.arange(first, store.n_frames))).all()
    assert replay(place, options()).new_frames == store.n_frames - first
    ingest(tiny_mcaps, whole)
    replay(whole, options())
    grown, at_once = (Store.open(one).mesh("coarse") for one in (place, whole))
    for array in FRAME_ARRAYS:
        read = "pad_numbers" if array == "pad" else array
        assert np.array_equal(getattr(grown, read)(), getattr(at_once, read)(), equal_nan=array != "contact"), array


@pytest.mark.slow
def test_a_replaced_recording_drops_the_mesh(tiny_folders, tmp_path):
    """Rows mean other frames then; a finding says so, and a new replay makes them again."""
    from tactiledata.ingest.pipeline import ingest

    log, place = tmp_path / "D20001", tmp_path / "ds.zarr"
    copy_tree(tiny_folders[0], log)
    ingest([log], place)
    replay(place, options())
    (log / "log.yaml").write_text((log / "log.yaml").read_text().replace("thickness: 0.0041", "thickness: 0.0040"))
    report = ingest([log], place, replace=True)
    assert "mesh-dropped" in [one.code for one in report.findings]
    assert Store.open(place).mesh_names == ()
    assert replay(place, options()).new_frames == Store.open(place).n_frames
    assert check(place) == []


def test_statuses_of_a_mesh_are_those_of_the_engine():
    """The store's word for what has a mesh, and every status in words."""
    assert {FrameStatus.SOLVED, FrameStatus.NO_CONTACT} == set(HAS_MESH)
    assert {*FrameStatus, *ReplayStatus} == set(STATUSES)
    assert len({*FrameStatus, *ReplayStatus}) == len(FrameStatus) + len(ReplayStatus)


@pytest.mark.slow
def test_the_page_shows_every_mesh(replayed, tmp_path):
    """One page with a picture; the linear one is called a preview."""
    store = Store.open(replayed)
    (section,) = mesh_sections(store)
    assert len(section.pictures) == 1
    text = write_replay_page(store, "coarse", tmp_path).read_text()
    assert "preview" in text
    assert "data:image/png;base64," in text
    assert "<h1>What was replayed (simulated recordings)</h1>" in text
    assert "Simulated recordings.</figcaption>" in text
