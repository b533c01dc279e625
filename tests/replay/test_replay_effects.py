"""Replays with missing physics: nothing at the null, poses and gels moved, the wrench as it is read."""

import os
import signal

import numpy as np
import pytest
import yaml
from coarse import MATERIAL, coarse_pad, files, options
from copied_trees import copy_tree
from scipy.spatial.transform import Rotation

from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.ingest.pipeline import ingest
from tactiledata.replay import attach
from tactiledata.replay.attach import replay
from tactiledata.replay.overview import mesh_section
from tactiledata.replay.plan import plan_replay
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import Robot, load_scenario
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store

pytestmark = pytest.mark.slow

ARM = EffectSetting("arm_compliance", {"translation": 2e-5})
NULLS = (EffectSetting("arm_compliance", {"translation": 0.0}), EffectSetting("relaxation", {"time": 3.0}))


def with_effects(store, *effects, **changes):
    """The mesh of a replay with effects, beside those that are there."""
    report = replay(store, options(effects=effects, name="other", **changes), replace=True)
    return Store.open(store).mesh("other"), report


def test_null_effects_change_not_one_byte(copied, replayed):
    """A replay with effects of strength 0 writes byte for byte the files of one without effects."""
    replay(copied, options(effects=NULLS))
    assert files(copied) == files(replayed)
    assert options(name=None, effects=NULLS).mesh_name == "low-linear"
    assert options(name=None, effects=(*NULLS, ARM)).mesh_name == "low-linear-effects"


def test_an_arm_that_yields_is_in_balance_with_the_gel(copied, replayed):
    """Played by the engine at the poses that the replayed force bends the arm to, the gel answers that very force."""
    mesh, report = with_effects(copied, ARM)
    plain = Store.open(replayed).mesh("coarse")
    store = Store.open(copied)
    plan = plan_replay(store, coarse_pad)
    engine = FemEngine(plan.pads[0].mesh, MATERIAL.poisson_ratio, "linear")
    for touch in plan.touches:
        rows = np.arange(*touch.frames)
        wrench = mesh.wrench(rows)
        gel = touch.gel_touch(store, 0.0)
        poses = gel.poses.copy()
        poses[:, 2, 3] += 2e-5 * wrench[:, 2]
        poses[:, :2, 3] += 2e-5 * wrench[:, :2]
        (_, history), = engine.play([GelTouch(gel.indenter, poses)], MATERIAL)  # fmt: skip
        assert np.allclose(history.wrench, wrench, atol=5e-3)
        assert np.allclose(history.displacement, mesh.displacement(rows), atol=1e-6)
    assert mesh.wrench()[:, 2].max() < 0.97 * plain.wrench()[:, 2].max()
    assert "compliance of arm and mount (translation 2e-05 m/N" in report.effects
    assert report.lines()[1].startswith("  with compliance of arm")


def test_another_gel_is_another_pad(copied, replayed):
    """A thicker gel is softer, its base lies deeper, and its surface where it was."""
    mesh, _ = with_effects(copied, EffectSetting("thickness", {"error": 0.2}))
    plain = Store.open(replayed).mesh("coarse")
    thick, nominal = mesh.pad(), plain.pad()
    assert np.ptp(thick.vertices[0][:, 2]) == pytest.approx(1.2 * np.ptp(nominal.vertices[0][:, 2]), rel=0.05)
    assert np.nanmax(mesh.wrench()[:, 2]) < 0.99 * np.nanmax(plain.wrench()[:, 2])
    law, _ = with_effects(copied, EffectSetting("skin", {"excess": 4e-4}))
    assert law.facts["pads"][0]["law"]["skin"] == 4e-4
    assert np.nanmax(law.wrench()[:, 2]) > 1.01 * np.nanmax(plain.wrench()[:, 2])


def test_what_acts_on_the_reading_leaves_the_mesh(copied, replayed):
    """A turned force frame turns the wrench about the sensor's z, norm of the force kept; the gel is where it was."""
    turn = 0.1
    mesh, _ = with_effects(copied, EffectSetting("frame_rotation", {"yaw": turn}))
    plain = Store.open(replayed).mesh("coarse")
    assert np.array_equal(mesh.displacement(), plain.displacement())
    # the sensor's place in the gel frame, as this rig states it
    robot = Robot()
    sensor = (robot.tcp_from_gel.inverse() @ robot.tcp_from_ft).matrix
    about = sensor[:3, :3] @ Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix() @ sensor[:3, :3].T
    force = plain.wrench()[:, :3]
    about_sensor = plain.wrench()[:, 3:] - np.cross(sensor[:3, 3], force)
    assert np.allclose(mesh.wrench()[:, :3], force @ about.T, atol=1e-9)
    assert np.allclose(
        mesh.wrench()[:, 3:], about_sensor @ about.T + np.cross(sensor[:3, 3], force @ about.T), atol=1e-9
    )
    # what the gel itself exerts is still in the nodal forces
    assert np.allclose(mesh.force().sum(axis=1), -plain.wrench()[:, :3], atol=1e-5)


def test_an_effect_of_one_indenter_leaves_the_others(copied, replayed):
    """Rows of other indenters are those of the plain replay, to rounding of the company that they are solved in."""
    mesh, _ = with_effects(copied, EffectSetting("mount_offset", {"deeper": 5e-5}, {"indenter_name": "ball4"}))
    plain, store = Store.open(replayed).mesh("coarse"), Store.open(copied)
    for touch in plan_replay(store, coarse_pad).touches:
        rows = np.arange(*touch.frames)
        changed = np.abs(mesh.wrench(rows) - plain.wrench(rows)).max()
        assert changed > 0.05 if touch.indenter == "ball4" else changed < 1e-6


def test_friction_acts_on_what_slides(copied, replayed):
    """Half the friction halves the shear of frames that slide, and no normal force."""
    mesh, _ = with_effects(copied, EffectSetting("wear", {"friction_change": -0.5, "stiffness_change": 0.0}))
    plain = Store.open(replayed).mesh("coarse")
    assert np.array_equal(mesh.wrench()[:, 2], plain.wrench()[:, 2])
    size = np.linalg.norm(mesh.wrench()[:, :2], axis=1)
    assert (size <= np.linalg.norm(plain.wrench()[:, :2], axis=1) + 1e-12).all()


def test_effects_that_this_store_cannot_have_are_refused(copied):
    """Before anything is attached, with what the store holds."""
    for effect, changes, words in (
        (EffectSetting("arm_compliance", {"translation": 1e-5}, {"sensor": "D99999"}), {}, "D20001"),
        (EffectSetting("strain_stiffening", {"c20": 0.1}), {}, "finite-strain"),
        (EffectSetting("thickness", {"error": 0.1}), {"resolution": "high", "make_pad": None}, "--resolution low"),
    ):
        with pytest.raises(UsageError, match=words):
            replay(copied, options(effects=(effect,), **changes))
    assert Store.open(copied).mesh_names == ()


def test_what_recordings_do_not_tell_is_named(tiny_folders, tmp_path):
    """A log without the moment of power-on is named where an effect asks for it."""
    log, place = tmp_path / "D20001", tmp_path / "ds.zarr"
    copy_tree(tiny_folders[0], log)
    document = yaml.safe_load((log / "log.yaml").read_text())
    document["sensors"]["D20001"].pop("power_on_ns")
    (log / "log.yaml").write_text(yaml.safe_dump(document))
    ingest([log], place)
    with pytest.raises(UsageError, match="'heating' depends on 'powered'"):
        replay(place, options(effects=(EffectSetting("heating", {"change": -0.1}),)))
    assert Store.open(place).mesh_names == ()


def test_killed_and_resumed_is_the_same(copied, tmp_path, monkeypatch):
    """A replay with effects that is killed after each commit leaves, once resumed, the files of a replay in one go."""
    monkeypatch.setattr(attach, "RUN_TOUCHES", 1)
    given = options(effects=(ARM, EffectSetting("lag", {"delay": 0.02})))
    whole = copy_tree(copied, tmp_path / "whole.zarr")
    replay(whole, given)
    for _ in range(2):
        child = os.fork()
        if child == 0:
            try:
                replay(copied, given, progress=lambda *_: os.kill(os.getpid(), signal.SIGKILL))
            finally:
                os._exit(0)
        assert os.WIFSIGNALED(os.waitpid(child, 0)[1])
    assert 0 < Store.open(copied).mesh("coarse").facts["rows"] < Store.open(copied).n_frames
    replay(copied, given)
    assert files(copied) == files(whole)


PRESS = {"press": {"depth": 8e-4, "step": 2e-4, "settle": 0.05}}
SLIDE = {"shear": {"by": [6e-4, 4e-4], "step": 2e-4, "settle": 0.05}}


def world(*hidden):
    """Two touches of a ball by a quiet rig."""
    return {
        "format": "tactiledata-scenario/1",
        "seed": 2,
        "sensors": {"D20542": {"background": "digit-bg-0"}},
        "indenters": {"ball": {"shape": "sphere", "radius": 0.004}},
        "material": {"youngs_modulus": 0.9e6, "poisson_ratio": 0.475, "friction": 0.7},
        "streams": {"tcp": 125, "wrench": 100, "joints": 0, "arm_wrench": 0},
        "imperfections": {"pose_repeatability": 0.0, "force_noise": 0.02, "force_drift": 0.0},
        "hidden": list(hidden),
        "trajectories": [
            {"name": f"{number}", "sensor": "D20542", "indenter": "ball", "position": place, "steps": [PRESS, SLIDE]}
            for number, place in enumerate(([0.001, -0.002], [-0.002, 0.003]))
        ],
    }


def recorded(folder, *hidden):
    ingest(record(load_scenario(world(*hidden)), folder / "logs", "folder"), folder / "ds.zarr")
    return folder / "ds.zarr"


def forces(store, *effects):
    """Recorded and replayed forces (n, 3) in contact."""
    mesh, _ = with_effects(store, *effects)
    rows = np.flatnonzero(mesh.status() == FrameStatus.SOLVED)
    return Store.open(store).aligned("contact_wrench", rows)[0][:, :3], mesh.wrench(rows)[:, :3]


def test_planted_effects_fit_better_with_them(tmp_path):
    """Worlds of the rig's own formulas, E known from one that hides nothing: each fits better with what it hides."""
    measured, simulated = forces(recorded(tmp_path / "nothing"))
    stiffness = (measured * simulated).sum() / (simulated**2).sum()

    def off(store, *effects):
        measured, simulated = forces(store, *effects)
        return float(np.sqrt(((measured - stiffness * simulated) ** 2).mean()))

    turned = recorded(tmp_path / "turned", {"effect": "frame_rotation", "parameters": {"yaw": 0.15, "tilt": 0.0}})
    plain, right, wrong = (off(turned, EffectSetting("frame_rotation", {"yaw": yaw})) for yaw in (0.0, 0.15, -0.15))
    assert right < 0.8 * plain < plain < wrong
    soft = recorded(tmp_path / "soft", {"effect": "arm_compliance", "parameters": {"softness": 1 / 4e3}})
    plain, right = (off(soft, EffectSetting("arm_compliance", {"translation": by})) for by in (0.0, 8e-5))
    assert right < 0.5 * plain


def test_the_page_and_the_arrays_say_it(copied):
    """The effects of a replay are named on the page and in the attributes of its wrench, and the store is whole."""
    with_effects(copied, ARM)
    store = Store.open(copied)
    assert check(copied) == []
    section = mesh_section(store, "other")
    assert any("compliance of arm and mount" in text for _, text in section.sentences)
    attributes = store.array("meshes/other/wrench").attrs
    assert attributes["effects"] == [ARM.document]
    assert "as the force sensor would read it" in attributes["content"]
