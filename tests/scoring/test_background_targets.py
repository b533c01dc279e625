"""A target that is known by its picture alone: what is compared with it, and what each set says of itself."""

import json

import numpy as np
import pytest
from cli.command import run_command
from copied_trees import copy_tree
from loaders.loader_stores import write_loader_store

from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.transfer_store import transfer_store
from tactiledata.errors import StoreError, UsageError
from tactiledata.scoring.background_targets import outside_contact, score_backgrounds, unlocated
from tactiledata.scoring.chosen_scores import chosen_scores
from tactiledata.scoring.sensor_sets import sensor_sets
from tactiledata.sensors.backgrounds import load_background
from tactiledata.store.change.keep_sensors import remove_picture
from tactiledata.store.change.merge import merge
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import Target, find_target

LEAK = {"histogram_intersection": 1e-9, "gram_style_random": 3e-4}
"""What a touch may change outside of it. Features of a network look beyond the pixel that they stand at: a white square
gives 2.4e-4 outside, 7.7e-4 on the whole frame; another sensor gives 8e-3."""
CHILDREN = "ycb-sensorB of D20001 by background_swap"


@pytest.fixture(scope="module")
def tiny(tiny_store):
    return Store.open(tiny_store)


@pytest.fixture(scope="module")
def both(tiny_store, tmp_path_factory):
    """The tiny world, whose recordings are simulated, and one sensor's touches transferred to ycb-sensorB."""
    folder = tmp_path_factory.mktemp("known-by-picture")
    store = Store.open(tiny_store)
    target = find_target("ycb-sensorB", store)
    transfer_store(store, target, PIXEL_TRANSFERS["background_swap"], folder / "made.zarr", ["D20001"])
    merge([store, folder / "made.zarr"], folder / "both.zarr")
    return Store.open(folder / "both.zarr")


@pytest.mark.slow
def test_each_set_says_what_it_is(both):
    """Simulated recordings are called so, and what was made of them synthetic, of a simulated recording."""
    kinds = {some.name: some.kind for some in sensor_sets(both, 20)}
    assert kinds == {
        "D20001": "simulated recording",
        "D20002": "simulated recording",
        CHILDREN: "synthetic, of a simulated recording",
    }


@pytest.mark.slow
def test_a_store_that_states_nothing_holds_recordings(tmp_path):
    """Negative control: without a description that says simulated, sets are recorded."""
    store = write_loader_store(tmp_path / "ds.zarr")
    assert {some.kind for some in sensor_sets(store, 20)} == {"recorded"}


def test_outside_is_what_no_contact_reaches():
    """By hand: a contact of one pixel at 320 x 240 is widened by 10 px (3 widths of 3.2), all else is outside."""
    masks = np.zeros((1, 320, 240), bool)
    masks[0, 100, 100] = True
    outside = outside_contact(masks)[0]
    assert outside[100, 88:90].tolist() == [True, True]
    assert not outside[100, 90:111].any()
    assert outside[111, 100]
    assert outside.sum() > 320 * 240 - 21 * 21


@pytest.mark.slow
def test_scores_are_of_what_lies_outside_the_contact(both):
    """A swap to the target is the target outside the contact but for noise; the sources are not."""
    target = find_target("ycb-sensorB", both)
    found = list(score_backgrounds(both, chosen_scores(["histogram_intersection"]), sensor_sets(both, 20), [target]))
    values = {pair.first: pair.interval.value for pair in found}
    assert {pair.looked_at for pair in found} == {"outside the contact"}
    assert {(pair.second, pair.second_kind) for pair in found} == {("ycb-sensorB", "picture without contact")}
    assert values[CHILDREN] > 0.9
    assert max(values["D20001"], values["D20002"]) < values[CHILDREN] - 0.05


@pytest.mark.parametrize("metric", LEAK)
def test_touched_pixels_change_nothing(tiny, monkeypatch, metric):
    """A picture that is the target's outside its contact scores best, whatever it shows inside."""
    target = Target("T", load_background("digit-bg-6"), "made")
    masks = np.zeros((320, 240), bool)
    masks[150:170, 110:130] = True
    module = "tactiledata.scoring.background_targets"
    monkeypatch.setattr(f"{module}.contact_masks", lambda pictures, _: np.stack([masks] * len(pictures)))
    values = []
    for shade in (0, 255):
        picture = np.where(masks[..., None], np.uint8(shade), target.background)
        monkeypatch.setattr(
            f"{module}.load_pictures", lambda _, some, shown=picture: np.stack([shown] * len(some.rows))
        )
        found = score_backgrounds(tiny, chosen_scores([metric]), sensor_sets(tiny, 3)[:1], [target])
        values += [(pair.interval.value, pair.score.best) for pair in found]
    assert values == [(pytest.approx(best, abs=LEAK[metric]), best) for _, best in values]


@pytest.mark.parametrize("metric", LEAK)
def test_each_picture_is_compared_under_its_own_mask(tiny, monkeypatch, metric):
    """Pictures that are the target itself score best, wherever their contacts are; one without any outside is NaN."""
    target = Target("T", load_background("digit-bg-6"), "made")
    masks = np.zeros((3, 320, 240), bool)
    masks[0, :150] = True
    masks[1, 170:] = True
    masks[2] = True
    module = "tactiledata.scoring.background_targets"
    monkeypatch.setattr(f"{module}.contact_masks", lambda pictures, _: masks)
    monkeypatch.setattr(f"{module}.load_pictures", lambda _, some: np.stack([target.background] * 3))
    taken = []
    monkeypatch.setattr(f"{module}.bootstrap", lambda values, _: taken.append(values))
    scores = chosen_scores([metric])
    list(score_backgrounds(tiny, scores, sensor_sets(tiny, 3)[:1], [target]))
    np.testing.assert_allclose(taken[0], [scores[0][1].best] * 2 + [np.nan], atol=1e-12)


def test_what_cannot_be_scored_is_refused(tiny):
    """Latent scores need touches of the target; a set without a background has no known contact."""
    target = Target("T", load_background("digit-bg-6"), "made")
    sets = sensor_sets(tiny, 3)
    with pytest.raises(UsageError, match="silhouette against T, of which no touch is known"):
        list(score_backgrounds(tiny, chosen_scores(["silhouette"]), sets, [target]))


def test_sets_without_a_background_are_named(tiny_store, tmp_path):
    """A sensor without a picture is left out by name; where all are, the store is refused."""
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    remove_picture(tmp_path / "ds.zarr", "D20001")
    store = Store.open(tmp_path / "ds.zarr")
    sets, scores = sensor_sets(store, 3), chosen_scores(["histogram_intersection"])
    assert unlocated(store, sets) == ["D20001"]
    target = Target("T", load_background("digit-bg-6"), "made")
    assert [pair.first for pair in score_backgrounds(store, scores, sets, [target])] == ["D20002"]
    with pytest.raises(StoreError, match="sensors add D20001"):
        list(score_backgrounds(store, scores, sets[:1], [target]))


@pytest.mark.slow
def test_the_command_says_what_it_cannot(both, capsys):
    """A target known by its picture is scored, in words and in JSON; what is no sensor stays refused."""
    typed = ("score", both.location, "--metric", "histogram_intersection", "--frames", "5", "--against")
    code, out, err = run_command(capsys, *typed, "ycb-sensorA")
    assert code == 0, err
    told = " ".join(out.split())
    assert "Whether a touch looks as it would on ycb-sensorA cannot be said" in told
    assert "simulated recording" in told
    assert "Real" not in told
    code, out, _ = run_command(capsys, *typed, "ycb-sensorA,D20002", "--json")
    document = json.loads(out)
    assert {pair["looked_at"] for pair in document["scores"] if pair["second"] == "ycb-sensorA"} == {
        "outside the contact"
    }
    assert {pair["second"] for pair in document["scores"]} == {"ycb-sensorA", "D20002"}
    assert len(document["notes"]) == 3
    code, _, err = run_command(capsys, *typed, "ycb-sensorC")
    assert code == 2
    assert "ycb-sensorA" in err


@pytest.mark.slow
def test_one_sensor_is_enough_for_a_target(both, tmp_path, capsys):
    """A store of one sensor has no pair, and can be scored against a picture; one without untouched pixels cannot."""
    typed = ("--metric", "histogram_intersection", "--against", "ycb-sensorA")
    made = both.location.replace("both.zarr", "made.zarr")
    code, out, err = run_command(capsys, "score", made, *typed)
    assert (code, "outside the contact" in out) == (0, True), err
    code, _, err = run_command(capsys, "score", made, "--metric", "histogram_intersection")
    assert (code, "two sensors" in err) == (1, True)
    noise = write_loader_store(tmp_path / "alone.zarr", n_sources=1)  # noise: no pixel is like the background
    code, _, err = run_command(capsys, "score", noise.location, *typed)
    assert (code, "something outside the contact" in " ".join(err.split())) == (1, True)
