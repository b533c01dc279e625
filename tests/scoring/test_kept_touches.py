"""What synthetic sets keep of the touches that they were made of, in a store that holds both."""

import json

import numpy as np
import pytest
from cli.command import run_command

from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.transfer_store import transfer_store
from tactiledata.scoring.kept_touches import kept_scores
from tactiledata.scoring.sensor_sets import sensor_sets
from tactiledata.store.change.merge import merge
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import find_target

METHODS = ("relit", "no_contact")


@pytest.fixture(scope="module")
def folder(tiny_store, tmp_path_factory):
    """A merged store of the tiny world and one sensor's touches by two methods, and a store of the children alone."""
    folder = tmp_path_factory.mktemp("kept")
    store = Store.open(tiny_store)
    target = find_target("ycb-sensorB", store)
    for name in METHODS:
        transfer_store(store, target, PIXEL_TRANSFERS[name], folder / f"{name}.zarr", ["D20001"])
    merge([store, *(folder / f"{name}.zarr" for name in METHODS)], folder / "both.zarr")
    return folder


def by_method(scores):
    return {(score.first.rpartition(" ")[2], score.score.name): score.interval.value for score in scores}


@pytest.mark.slow
def test_a_vanished_touch_is_punished_and_a_kept_one_is_not(folder):
    """Without a contact strength and overlap are 0, by `relit` both are near 1; recorded sets have no such score."""
    store = Store.open(folder / "both.zarr")
    scores, notes = kept_scores(store, sensor_sets(store, 12))
    values = by_method(scores)
    assert notes == []
    assert len(scores) == len(METHODS) * 3
    assert values["no_contact", "strength_kept"] == 0.0
    assert values["no_contact", "mask_overlap"] == 0.0
    assert values["relit", "strength_kept"] == pytest.approx(1.0, abs=0.15)
    assert values["relit", "mask_overlap"] > 0.8
    assert {score.second for score in scores} == {"D20001"}
    assert {score.second_kind for score in scores} == {"simulated recording"}


def test_parents_are_the_same_frames(folder):
    """Against the wrong frames of the parent correlation is lower: frames are matched by trajectory and time."""
    store = Store.open(folder / "both.zarr")
    sets = [one for one in sensor_sets(store, 12) if one.name.endswith("relit")]
    scores, _ = kept_scores(store, sets)
    assert by_method(scores)["relit", "change_correlation"] > 0.9
    from tactiledata.metrics.kept_touch import change_of, correlation

    parents = next(one for one in sensor_sets(store, 12) if one.name == "D20001")
    background, goal = store.reference("D20001").image, store.reference("ycb-sensorB").image
    ours = change_of(np.asarray(store.images(sets[0].rows)), goal)
    wrong = change_of(np.asarray(store.images(np.roll(parents.rows, len(parents.rows) // 2))), background)
    assert np.nanmean(correlation(ours, wrong)) < 0.7


def test_children_without_their_parents_are_said_so(folder):
    """A store of children alone has no figures, and a sentence says why."""
    store = Store.open(folder / "relit.zarr")
    scores, notes = kept_scores(store, sensor_sets(store, 12, least=1))
    assert scores == []
    assert len(notes) == 1
    assert "parents are not here" in notes[0]


def test_a_store_without_children_is_answered(tiny_store, capsys):
    """Where nothing was made of touches, the command says so and what makes it, in place of nothing at all."""
    code, out, err = run_command(capsys, "score", str(tiny_store), "--metric", "kept_touch")
    assert code == 0, err
    assert "No set was made of touches of this store" in out
    assert "tactiledata transfer" in out


@pytest.mark.slow
def test_the_command_shows_what_is_kept_beside_any_metric(folder, capsys):
    """Three rows for each synthetic set stand in words and in JSON, and alone where only they are asked for."""
    typed = ("score", str(folder / "both.zarr"), "--frames", "6", "--metric")
    code, out, err = run_command(capsys, *typed, "histogram_intersection", "--against", "ycb-sensorA")
    assert code == 0, err
    told = " ".join(out.split())
    assert "strength kept" in told
    assert "mask overlap" in told
    assert "nearer to 1 is closer" in told
    assert "no interval for" in told
    assert ": it takes 5 trajectories" in told
    code, out, err = run_command(capsys, *typed, "kept_touch", "--json")
    assert code == 0, err
    document = json.loads(out)
    assert document["scores"] == []
    assert {row["score"]["name"] for row in document["kept"]} == {"strength_kept", "change_correlation", "mask_overlap"}
