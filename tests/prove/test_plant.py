"""Effects planted into a copy of a store: what changes, what stays, the sealed label, and the score."""

import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from tactiledata.cli.main import app
from tactiledata.contract.description import LogDescription
from tactiledata.contract.take import findings_of
from tactiledata.errors import MissingFile, StoreError, UsageError
from tactiledata.prove.plant.effects import PLANTS, PlantedReadings
from tactiledata.prove.plant.label import (
    drawn_planting,
    kept_planting,
    score_planting,
    seal_files,
    write_label,
)
from tactiledata.prove.plant.planting import Planting, plant_into
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import create

SIZES = {name: plant.high for name, plant in PLANTS.items()}


@pytest.fixture(scope="module")
def store(tmp_path_factory, tiny_mcaps):
    """A store of one recording of the tiny world; read only."""
    from tactiledata.ingest.pipeline import ingest

    place = tmp_path_factory.mktemp("planted") / "plain.zarr"
    ingest([str(tiny_mcaps[0])], place)
    return Store.open(place)


def planted(store, place, effect, size):
    """A copy of the store with an effect."""
    plant_into(store, place, Planting(effect, size, 3), "c" * 64)
    return Store.open(place)


def readings_of(store, name="wrench"):
    """Times, ns, and values of a stream."""
    signal = store.signal(name)
    return signal.t_ns(0, signal.n_rows), signal.values(0, signal.n_rows)


@pytest.mark.slow
def test_nothing_planted_changes_no_number(store, tmp_path):
    """A copy with nothing planted has the same readings, contact wrenches, images and forces, bit for bit."""
    copy = planted(store, tmp_path / "copy.zarr", "nothing", 0.0)
    for name in store.signal_names:
        for ours, theirs in zip(readings_of(copy, name), readings_of(store, name), strict=True):
            assert np.array_equal(ours, theirs, equal_nan=True)
    assert copy.frames().select(["t_ns", "contact_force", "crc32c"]) == store.frames().select(
        ["t_ns", "contact_force", "crc32c"]
    )
    assert copy.encoded([0, 5]) == store.encoded([0, 5])
    assert "effect-planted" in {finding.code for finding in findings_of(copy.findings())}


@pytest.mark.slow
def test_deriving_anew_gives_what_ingest_derived(store, tmp_path):
    """A change that changes nothing gives the contact wrenches and forces that ingest found: the way is the same."""
    copy = planted(store, tmp_path / "copy.zarr", "gain", 0.0)
    ours, theirs = readings_of(copy, "contact_wrench")[1], readings_of(store, "contact_wrench")[1]
    assert np.allclose(ours, theirs, atol=1e-9, equal_nan=True)
    for column in ("contact_force", "t_ns"):
        assert np.allclose(copy.frames()[column].to_numpy(), store.frames()[column].to_numpy(), equal_nan=True)
    peaks = [one.trajectories()["peak_force"].to_numpy() for one in (copy, store)]
    assert np.allclose(*peaks, rtol=1e-6)
    assert not [one for one in check(copy) if one.severity == "damage"]


def test_a_recording_without_forces_stays_as_it_is():
    """An effect of the force sensor cannot be in it; the copy is whole all the same."""
    without = SimpleNamespace(signals={}, aligned={})
    assert Planting("lag", 0.05, 3).take(without) is without


@pytest.mark.slow
@pytest.mark.parametrize("effect", [name for name in PLANTS if name not in ("thickness", "added_mass")])
def test_every_effect_changes_the_contact_wrench(store, tmp_path, effect):
    """Each effect of the sensor changes readings and what is derived from them, and leaves poses and images alone."""
    copy = planted(store, tmp_path / "copy.zarr", effect, SIZES[effect])
    assert not np.array_equal(readings_of(copy)[1], readings_of(store)[1], equal_nan=True)
    before, after = (one.frames()["contact_force"].to_numpy() for one in (store, copy))
    assert np.nanmax(np.abs(after - before)) > 0.005
    assert np.array_equal(readings_of(copy, "tcp")[1], readings_of(store, "tcp")[1], equal_nan=True)
    assert copy.encoded([3]) == store.encoded([3])


@pytest.mark.slow
def test_a_relabelled_thickness_changes_what_is_stated_alone(store, tmp_path):
    """The gel is stated thicker by the share, by sensor and by recording; no reading changes."""
    copy = planted(store, tmp_path / "copy.zarr", "thickness", 0.2)
    for serial, facts in store.sensors().items():
        if "gel" in facts:
            assert copy.sensors()[serial]["gel"]["thickness"] == pytest.approx(1.2 * facts["gel"]["thickness"])
    stated = json.loads(copy.sources()["description"].to_pylist()[0])["sensors"]
    assert all(facts["gel"]["thickness"] > 0.0042 for facts in stated.values())
    assert np.array_equal(readings_of(copy)[1], readings_of(store)[1], equal_nan=True)


def made_up(values, seconds, poses=None):
    """Readings at 100 Hz."""
    description = LogDescription({"robot": {"tcp_from_ft": {"xyz": [0, 0, 0], "rpy": [0, 0, 0]}}})
    return PlantedReadings((seconds * 1e9).astype(np.int64), values, poses, description)


def test_a_lag_is_what_was_read_earlier():
    """A ramp that is late by 0.05 s is lower by its slope times the delay."""
    seconds = np.arange(200) / 100.0
    late = PLANTS["lag"].change(made_up(np.tile(seconds[:, None], 6), seconds), 0.05, np.random.default_rng(0))
    assert np.allclose(late[10:, 0], seconds[10:] - 0.05)


def test_a_turned_sensor_keeps_the_size_of_a_force():
    """A rotation keeps norms; its angle is the one that is planted, for a force across the axis."""
    chance = np.random.default_rng(1)
    values, seconds = chance.normal(size=(50, 6)), np.arange(50) / 100.0
    turned = PLANTS["frame_rotation"].change(made_up(values, seconds), 0.1, np.random.default_rng(2))
    assert np.allclose(np.linalg.norm(turned[:, :3], axis=1), np.linalg.norm(values[:, :3], axis=1))
    moved = np.linalg.norm(turned[:, :3] - values[:, :3], axis=1) / np.linalg.norm(values[:, :3], axis=1)
    assert moved.max() <= 0.1 + 1e-9
    assert moved.max() > 0.09


def test_an_added_mass_weighs_what_it_should():
    """A tool that is turned over changes the load by twice the weight of the mass."""
    seconds = np.arange(2) / 100.0
    poses = np.stack([np.eye(4), np.diag([1.0, -1.0, -1.0, 1.0])])
    load = PLANTS["added_mass"].change(made_up(np.zeros((2, 6)), seconds, poses), 0.1, np.random.default_rng(0))
    assert np.linalg.norm(load[1, :3]) == pytest.approx(2 * 0.1 * 9.80665)


def diagnosed(place, store, **naming):
    """A diagnosis of a store, as far as the score reads it."""
    document = {
        "naming": {"verdict": "explained", "names": [], "ties": [], **naming},
        "zeros": [],
        "readings": [],
        "provenance": {"inputs": {"store": store}},
    }
    place.write_text(json.dumps(document))
    return place


@pytest.fixture
def sealed(tmp_path):
    """An empty store with a sealed lag beside it."""
    create(tmp_path / "copy.zarr")
    write_label(tmp_path / "copy.zarr", Planting("lag", 0.03, 5))
    return Store.open(tmp_path / "copy.zarr")


@pytest.mark.slow
def test_a_label_is_sealed_and_scored(sealed, tmp_path):
    """A diagnosis is scored against the label; a label that was changed does not fit the seal."""
    copy = tmp_path / "copy.zarr"
    assert kept_planting(copy) == Planting("lag", 0.03, 5)
    for names, ties, outcome in (
        (["lag"], [], "named"),
        (["relaxation"], ["lag"], "in the set"),
        (["relaxation"], [], "wrong"),
        ([], [], "missed"),
    ):
        told = diagnosed(tmp_path / "d.json", sealed.digest, names=names, ties=[{"name": name} for name in ties])
        assert score_planting(copy, told)["outcome"] == outcome
    label = seal_files(copy)[1]
    changed = json.loads(label.read_text())
    changed["label"]["size"] = 0.04
    label.write_text(json.dumps(changed))
    with pytest.raises(StoreError, match="does not fit"):
        score_planting(copy, told)


def test_the_diagnosis_of_another_store_opens_no_label(sealed, tmp_path):
    """A label that was seen is spent: a diagnosis that is not of the copy is refused, or none at all."""
    copy = tmp_path / "copy.zarr"
    with pytest.raises(StoreError, match=r"of a store with the digest ffffffffffff.*The label was not opened"):
        score_planting(copy, diagnosed(tmp_path / "d.json", "f" * 64, names=["lag"]))
    for odd in ({"names": [None]}, {"names": [3]}, {"names": 3}, {"ties": [None]}, {"verdict": {}}):
        with pytest.raises(StoreError, match=r"in place of a name|no naming that can be read"):
            score_planting(copy, diagnosed(tmp_path / "d.json", sealed.digest, **odd))
    with pytest.raises(MissingFile, match=r"there is no .*nope.*seal.*plant STORE --into"):
        score_planting(tmp_path / "nope", tmp_path / "d.json")


@pytest.mark.parametrize("size", [0.0, -1.0, 1e3, 1e9, float("nan")])
def test_a_size_that_cannot_be_planted_is_refused_with_both_limits(size):
    """Who gives a size that is too large learns how large it may be."""
    with pytest.raises(UsageError, match=r"a size of .* s; expected more than 0 and less than 1000"):
        drawn_planting("lag", size)


def test_chance_plants_everything_and_nothing():
    """With ``any``, each effect and nothing at all come up; sizes lie within their ranges."""
    drawn = [drawn_planting("any", None, seed) for seed in range(120)]
    assert {one.effect for one in drawn} == {*PLANTS, "nothing"}
    for one in drawn:
        if one.effect != "nothing":
            plant = PLANTS[one.effect]
            assert plant.low * 0.99 <= one.size <= plant.high * 1.01


@pytest.mark.slow
def test_the_command_plants_and_goes_on(store, tmp_path):
    """The command writes copy, seal and label; run again it goes on with them; other options are refused."""
    copy = tmp_path / "blind.zarr"
    words = ["plant", store.location, "--into", str(copy)]
    done = CliRunner().invoke(app, [*words, "--effect", "any"])
    assert done.exit_code == 0, done.output
    label = json.loads(seal_files(copy)[1].read_text())["label"]
    assert label["effect"] not in done.output.replace("nothing", "") or label["effect"] == "nothing"
    before = readings_of(Store.open(copy))[1]
    shutil.rmtree(copy)
    assert CliRunner().invoke(app, [*words, "--effect", "any"]).exit_code == 0
    assert np.array_equal(readings_of(Store.open(copy))[1], before, equal_nan=True)
    other = CliRunner().invoke(app, [*words, "--effect", "lag" if label["effect"] != "lag" else "gain"])
    assert isinstance(other.exception, UsageError)
    assert isinstance(CliRunner().invoke(app, ["plant", store.location]).exception, UsageError)
    unknown = CliRunner().invoke(app, ["plant", store.location, "--effect", "magic", "--into", str(tmp_path / "x")])
    assert "magic" in str(unknown.exception)
