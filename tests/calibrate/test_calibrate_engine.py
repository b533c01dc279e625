"""Through the gel engine: touches played on a coarse pad, kept on disk, fitted, written and drawn."""

import importlib.util
import json
from dataclasses import replace

import numpy as np
import pytest

from tactiledata.calibrate.calibrate import calibrate_measured
from tactiledata.calibrate.document import calibration_document, write_calibration
from tactiledata.calibrate.measured import Measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.page import calibration_page
from tactiledata.calibrate.plays import player
from tactiledata.calibrate.plays.kept_plays import load_play, play_path
from tactiledata.calibrate.plays.player import PlayBatch, play_at
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.errors import TactileDataError
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.nuisance.numerical import FORCE_ERROR
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow

PAD = structured_pad("coarse", DIGIT.gel, GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0)))
TRUTH = (905e3, 0.475, 0.78)
SMALL_NOISE = WrenchNoise(np.diag([0.01**2] * 3 + [0.0002**2] * 3), 1.0, "planted")
OPTIONS = CalibrationOptions(fidelity="linear", hold_out=0.25)


def pressed(depth, shear, place, frames=8):
    """Down in four frames, sideways in four."""
    poses = np.tile(np.eye(4), (frames, 1, 1))
    half = frames // 2
    poses[:, :2, 3] = place
    poses[:, 2, 3] = -depth * np.concatenate([np.linspace(-0.2, 1, half), np.ones(frames - half)])
    poses[half:, 0, 3] += shear * np.linspace(0.25, 1, frames - half)
    return GelTouch(Sphere(radius=0.004), poses)


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """Eight touches whose wrenches the engine itself gave at the truth, with offsets and a little noise."""
    chance = np.random.default_rng(0)
    touches = [
        pressed(depth, shear * (-1) ** k, chance.uniform(-2e-3, 2e-3, 2))
        for k, (depth, shear) in enumerate(zip(np.linspace(0.5e-3, 1.1e-3, 8), [1e-4, 6e-4] * 4, strict=True))
    ]
    named = [
        MeasuredTouch(f"u{k}", f"t{k}", "D1", "ball", touch, np.zeros((8, 6)), np.arange(8) / 5, 50.0)
        for k, touch in enumerate(touches)
    ]
    offsets = chance.normal(0, 2e-5, 8)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))
        plays = play_at(PAD, "linear", named, TRUTH[1], TRUTH[2], offsets)
    full = tuple(
        replace(touch, wrench=TRUTH[0] * play.wrench + chance.standard_normal((8, 6)) * SMALL_NOISE.deviations)
        for touch, play in zip(named, plays, strict=True)
    )
    return Measured(full, PAD, {}, SMALL_NOISE, {}), offsets


@pytest.fixture(scope="module")
def calibration(measured, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))
        return calibrate_measured(measured[0], OPTIONS, "0" * 64)


def test_the_engines_own_truth_is_found(calibration, measured):
    """E within 1 %, mu within 3 %, offsets; what is interpolated is what is played."""
    found = calibration.fit.parameters
    assert found[0] == pytest.approx(TRUTH[0], rel=0.01)
    assert found[2] == pytest.approx(TRUTH[2], rel=0.03)
    assert np.allclose(calibration.fit.offsets, measured[1], atol=5e-6)
    assert calibration.interpolation_error[0] < 0.02
    assert len(calibration.fit.held_out) == 2


def test_a_second_calibration_plays_nothing(calibration, measured, monkeypatch):
    """All plays are kept; the file is the same, byte by byte."""

    def no_engine(*_arguments):
        raise AssertionError("an engine was made")

    monkeypatch.setattr(player, "make_engine", no_engine)
    again = calibrate_measured(measured[0], OPTIONS, "0" * 64)
    assert calibration_document(again) == calibration_document(calibration)


def test_a_broken_file_is_played_again(calibration, measured):
    """A truncated file of the cache is not read, and the touch is simulated again with the same wrench."""
    touch = measured[0].touches[0].touch
    path = play_path(touch, PAD.digest, "linear", 0.4725, 0.7)
    whole = load_play(path)
    assert whole is not None
    path.write_bytes(path.read_bytes()[:50])
    assert load_play(path) is None
    again = PlayBatch(PAD, "linear", 0.4725, 0.7, (touch,)).play()[0]
    assert np.allclose(again.wrench, whole.wrench, rtol=1e-9, atol=1e-18)


def test_what_a_play_depends_on_has_a_place_of_its_own(measured):
    """Another path, mesh, engine, fidelity, nu, mu or indenter gives a play another file name."""
    touch = measured[0].touches[0]
    paths = {
        play_path(touch.touch, PAD.digest, "linear", 0.47, 0.7),
        play_path(touch.deeper(1e-6), PAD.digest, "linear", 0.47, 0.7),
        play_path(touch.touch, "0" * 64, "linear", 0.47, 0.7),
        play_path(touch.touch, PAD.digest, "finite-strain", 0.47, 0.7),
        play_path(touch.touch, PAD.digest, "mujoco-flex", 0.47, 0.7),
        play_path(touch.touch, PAD.digest, "linear", 0.471, 0.7),
        play_path(touch.touch, PAD.digest, "linear", 0.47, 0.71),
        play_path(GelTouch(Sphere(radius=0.003), touch.touch.poses), PAD.digest, "linear", 0.47, 0.7),
    }
    assert len(paths) == 8


def test_another_engine_is_named_in_every_output(measured, monkeypatch, tmp_path):
    """What plays the touches is what was asked for, and file, provenance, force error and page say so."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path))
    asked = set()

    def stand_in(mesh, poisson_ratio, mechanics):
        asked.add(mechanics)
        return FemEngine(mesh, poisson_ratio, "linear")

    monkeypatch.setattr(player, "make_engine", stand_in)
    options = CalibrationOptions(engine="mujoco-flex", hold_out=0.25)
    found = calibrate_measured(measured[0], options, "0" * 64)
    document = calibration_document(found)
    assert asked == {"mujoco-flex"}
    assert document["engine"] == document["provenance"]["settings"]["engine"] == "mujoco-flex"
    assert document["intervals"]["with_simulation_error"]["force_error"] == FORCE_ERROR["mujoco-flex"]
    pytest.importorskip("matplotlib")
    assert "engine mujoco-flex" in calibration_page(found)


def test_touches_are_played_by_the_flex():
    """MuJoCo's flex plays touches through the player: forces over E are of the order of ``fem``'s, and are kept."""
    if importlib.util.find_spec("mujoco") is None:
        pytest.skip("MuJoCo is not installed")
    touch = pressed(0.4e-3, 0.0, (0.0, 0.0), frames=4)
    flex, again, fem = (
        PlayBatch(PAD, mechanics, 0.46, 0.7, (touch,)).play()[0]
        for mechanics in ("mujoco-flex", "mujoco-flex", "finite-strain")
    )
    np.testing.assert_array_equal(flex.wrench, again.wrench)
    assert 1.0 < flex.wrench[-1, 2] / fem.wrench[-1, 2] < 3.0


def test_the_file_and_the_page(calibration, tmp_path):
    """The file fits its schema and names what it rests on; the page holds three pictures and the words."""
    document = write_calibration(calibration, tmp_path / "calibration.json")
    assert json.loads((tmp_path / "calibration.json").read_text()) == document
    assert document["mesh"]["sha256"] == PAD.digest
    assert set(document["offsets"]) == {f"u{k}" for k in range(8)}
    assert document["provenance"]["inputs"]["store"] == "0" * 64
    pytest.importorskip("matplotlib")
    page = calibration_page(calibration)
    begin = ["<figure>", "E is ", ">Result</h2>", ">What to know</h2>", "<details>", "Why other steps state another E"]
    places = [page.index(words) for words in begin]
    assert places == sorted(places)
    # eight trajectories, four of them at the top; two maps; residuals over force and their counts
    assert page.count("data:image/png") == 8 + 2 + 2
    assert "preview" in page


def test_no_contact_no_pose_and_no_wrench_are_named(measured):
    """Each touch that cannot be used has its reason; with fewer than two left, the error counts them."""
    touches = list(measured[0].touches)
    high = replace(touches[0], touch=touches[0].deeper(-5e-3))
    lost = replace(touches[1], touch=GelTouch(touches[1].touch.indenter, np.full((8, 4, 4), np.nan)))
    deaf = replace(touches[2], wrench=np.full((8, 6), np.nan))
    deep = replace(touches[3], touch=pressed(6e-3, 1e-4, (0, 0)))
    spoilt = replace(measured[0], touches=(high, lost, deaf, deep))
    with pytest.raises(TactileDataError, match="0 trajectories can be used") as caught:
        calibrate_measured(spoilt, OPTIONS, "0" * 64)
    reasons = " ".join(caught.value.facts["left_out"])
    for words in ("never touches the gel", "missing or not a number", "fewer than 3 frames", "deeper than"):
        assert words in reasons
