"""Pairs of sensors: who is compared with whom, on which frames and pixels, and what the command says."""

import json

import cv2
import numpy as np
import pyarrow as pa
import pytest
from cli.command import run_command
from loaders.loader_stores import write_loader_store

from split_models.transfer.latent_vectors import picture_vectors
from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.transfer_store import transfer_store
from tactiledata.errors import MissingFile, StoreError, UnknownName, UsageError
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import Score, metric
from tactiledata.scoring.chosen_scores import chosen_scores
from tactiledata.scoring.embedding_picture import draw_embedding, embed_sets
from tactiledata.scoring.sensor_pairs import load_touches, score_pairs
from tactiledata.scoring.sensor_sets import load_pictures, sensor_sets, size_sentences
from tactiledata.store.change.merge import merge
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import find_target

CHILDREN = "D2 of D1 by background_swap"


def shade_gap(first, second, mask=None, others_mask=None):
    """Distance of each picture's mean from the mean of the other set."""
    if mask is None:
        return np.abs(first.mean(axis=(1, 2, 3)) - second.mean())
    inside = np.array([p[m].mean() if m.any() else np.nan for p, m in zip(first, mask, strict=True)])
    return np.abs(inside - second[others_mask].mean())


SHADE = metric(
    "shade", "shade", "image sets", [Score("shade_gap", "shade gap", "grey levels", "lower", 0.0, shade_gap)]
)
TRUTH = metric("truth", "needs truths", "images", [Score("l1", "l1", "", "lower", 0.0, shade_gap)])


@pytest.fixture(autouse=True)
def _a_metric_of_sets(monkeypatch):
    for module in ("sensor_pairs", "chosen_scores", "background_targets"):
        known = {"shade": SHADE, "truth": TRUTH, "embedding": METRICS["embedding"], "gram_style": METRICS["gram_style"]}
        monkeypatch.setattr(f"tactiledata.scoring.{module}.METRICS", known)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Two sensors, and the first one's touches transferred to the second."""
    folder = tmp_path_factory.mktemp("scored")
    parents = write_loader_store(folder / "parents.zarr", damaged=(1, 2))
    transfer_store(
        parents, find_target("D2", parents), PIXEL_TRANSFERS["background_swap"], folder / "c.zarr", sensors=["D1"]
    )
    merge([parents, folder / "c.zarr"], folder / "both.zarr")
    return Store.open(folder / "both.zarr")


@pytest.mark.slow
def test_sets_keep_recorded_and_transferred_apart(store):
    """Two sensors and what was made of one: three sets, of whole frames in contact, each with its own trajectories."""
    sets = {one.name: one for one in sensor_sets(store, 1000)}
    assert set(sets) == {"D1", "D2", CHILDREN}
    assert [one.name for one in sets.values() if one.is_derived] == [CHILDREN]
    assert len(sets[CHILDREN].rows) == len(sets["D1"].rows) == 6 * 4 - 2
    forces = store.frames()["contact_force"].to_numpy()
    for one in sets.values():
        assert ((forces[one.rows] >= 1) & (forces[one.rows] <= 13)).all()
    assert not set(sets["D1"].trajectories) & set(sets[CHILDREN].trajectories)


def test_few_frames_are_spread_over_a_set(store):
    """A limit takes frames from the first trajectory to the last."""
    one = sensor_sets(store, 5)[0]
    whole = sensor_sets(store, 1000)[0]
    assert len(one.rows) == 5
    assert (one.rows[0], one.rows[-1]) == (whole.rows[0], whole.rows[-1])


def test_large_pictures_are_fewer(store, monkeypatch):
    """A set takes so many pixels at most, spread as ever, and says how many frames that leaves out; small ones none."""
    whole = {one.name: one for one in sensor_sets(store, 20)}
    assert {one.left_out for one in whole.values()} == {0}
    assert size_sentences(list(whole.values())) == []
    monkeypatch.setattr("tactiledata.scoring.sensor_sets.PIXELS_OF_SET", 7 * 16 * 12 + 5)
    fewer = sensor_sets(store, 20)
    for one in fewer:
        assert load_pictures(store, one).nbytes == 3 * 7 * 16 * 12
        assert one.left_out == len(whole[one.name].rows) - 7
        assert (one.rows[0], one.rows[-1]) == (whole[one.name].rows[0], whole[one.name].rows[-1])
    assert any("D1: 7 of 20 frames are scored" in sentence for sentence in size_sentences(fewer))
    monkeypatch.setattr("tactiledata.scoring.sensor_sets.PIXELS_OF_SET", 1)
    assert {len(one.rows) for one in sensor_sets(store, 20)} == {1}


def test_what_is_left_out_is_told(store, monkeypatch, capsys):
    """The command says so, for people and for machines."""
    monkeypatch.setattr("tactiledata.scoring.sensor_sets.PIXELS_OF_SET", 5 * 16 * 12)
    for words in ((), ("--json",)):
        code, out, _ = run_command(capsys, "score", store.location, "--metric", "shade", "--frames", 20, *words)
        assert code == 0
        assert "D1: 5 of 20 frames are scored" in " ".join(out.split())


def test_sizes_are_compared_before_anything_is_decoded(store, monkeypatch):
    """Pictures of two sizes are refused by what the table says."""
    frames = store.frames()
    height = frames["height"].to_numpy().copy()
    one = next(one for one in sensor_sets(store, 20) if one.name == "D1")
    height[one.rows[3]] = 999
    field = frames.schema.field("height")
    other = frames.set_column(frames.schema.get_field_index("height"), field, pa.array(height).cast(field.type))
    monkeypatch.setattr(Store, "frames", lambda self, columns=None: other.select(columns or other.column_names))
    monkeypatch.setattr(Store, "images", None)
    with pytest.raises(StoreError, match="have sizes 16 x 12, 999 x 12"):
        load_pictures(store, one)


def test_a_style_distance_runs_on_the_named_device():
    """The device is handed to the score; on the processor the values are those of the score itself."""
    (_, score), (_, plain) = (*chosen_scores(["gram_style"], device="cpu"), *chosen_scores(["gram_style"]))
    pictures = np.random.default_rng(0).integers(0, 255, (2, 32, 32, 3)).astype(np.uint8)
    np.testing.assert_array_equal(score.compute(pictures, pictures[::-1]), plain.compute(pictures, pictures[::-1]))
    assert chosen_scores(["gram_style"], device="cuda")[0][1].compute.keywords["device"] == "cuda"


def test_all_pairs_or_all_against_one(store):
    """Unnamed, every pair once; against one, every other set once, and it is the second."""
    sets, scores = sensor_sets(store, 1000), chosen_scores(["shade"])
    every = list(score_pairs(store, scores, sets))
    assert {frozenset((one.first, one.second)) for one in every if one.looked_at == "frame"} == {
        frozenset(pair) for pair in (("D1", "D2"), ("D1", CHILDREN), ("D2", CHILDREN))
    }
    against = [one for one in score_pairs(store, scores, sets, ["D2"]) if one.looked_at == "frame"]
    assert [(one.first, one.second, one.first_kind, one.second_kind) for one in against] == [
        ("D1", "D2", "recorded", "recorded"),
        (CHILDREN, "D2", "synthetic", "recorded"),
    ]
    # whichever stands second says what it is
    kinds = {(one.first, one.second): (one.first_kind, one.second_kind) for one in every}
    assert kinds["D1", CHILDREN] == ("recorded", "synthetic")


def test_values_are_the_scores_own(store):
    """Each value is what the score gives for the two sets, in the frame and inside their contacts."""
    sets = {one.name: one for one in sensor_sets(store, 1000)}
    touches = {name: load_touches(store, one) for name, one in sets.items()}
    assert touches["D1"].masks.any()
    for one in score_pairs(store, chosen_scores(["shade_gap"]), list(sets.values())):
        ours, theirs = touches[one.first], touches[one.second]
        masks = () if one.looked_at == "frame" else (ours.masks, theirs.masks)
        values = shade_gap(ours.pictures, theirs.pictures, *masks)
        assert one.interval.value == pytest.approx(np.nanmean(values))
        assert one.interval.trajectories == len(set(sets[one.first].trajectories))


def test_latent_scores_look_at_each_kind_of_vector(store):
    """Silhouettes of what the touches are encoded to: apart for the pixels, as the sensors' backgrounds are."""
    sets, scores = sensor_sets(store, 1000), chosen_scores(["silhouette"])
    found = list(score_pairs(store, scores, sets, encode=picture_vectors))
    assert {one.looked_at for one in found} == {"pixels", "pixels - background"}
    values = {(one.first, one.second, one.looked_at): one.interval.value for one in found}
    # the same touches, moved by the difference of two flat backgrounds: in one place once it is subtracted
    assert abs(values["D1", CHILDREN, "pixels - background"]) < 0.1
    assert list(score_pairs(store, scores, sets)) == []


@pytest.mark.slow
def test_embedding_is_drawn(store, tmp_path):
    """The picture has a panel for each kind of vector, and a place for each touch."""
    pytest.importorskip("matplotlib")
    sets = sensor_sets(store, 8)
    drawn = embed_sets(store, sets, picture_vectors)
    assert set(drawn) == {"pixels", "pixels - background"}
    assert {name: places.shape for name, places in drawn["pixels"].items()} == {one.name: (8, 2) for one in sets}
    assert draw_embedding(drawn, tmp_path / "new" / "tsne.png").stat().st_size > 1000


def test_a_set_that_another_covers_is_still_seen(tmp_path):
    """The picture of two sets whose points are in the same places shows the colours of both."""
    pytest.importorskip("matplotlib")
    places = np.array([[x, y] for x in range(4) for y in range(3)], float)
    picture = cv2.imread(str(draw_embedding({"pixels": {"a": places, "b": places}}, tmp_path / "tsne.png")))
    panel = picture[: int(0.8 * len(picture))].astype(int)
    blue, orange = (panel[..., 0] - panel[..., 2] > 60).sum(), (panel[..., 2] - panel[..., 0] > 60).sum()
    assert min(blue, orange) > 30


def test_the_help_names_every_score_of_sets(capsys):
    """What `--metric` takes stands in its help, whole."""
    _, out, _ = run_command(capsys, "score", "--help")
    shown = " ".join(out.replace("│", " ").split())
    able = [kind for kind in METRICS if METRICS[kind].takes in ("image sets", "latent sets")]
    scores = {name for kind in able for name in METRICS[kind].scores} - {"shade_gap"}
    assert [name for name in sorted(scores) if name not in shown] == []


def test_names_of_scores_and_metrics():
    """A score by its own name or its metric's, once; those that need truths and unknown ones are refused."""
    assert [score.name for _, score in chosen_scores(["shade", "shade_gap"])] == ["shade_gap"]
    for name in ("truth", "l1", "shadow"):
        with pytest.raises(UnknownName, match=r"one of: .*kept_touch, .*shade, shade_gap"):
            chosen_scores([name])
    assert [score.name for _, score in chosen_scores(["kept_touch", "shade"])] == ["shade_gap"]


def test_style_is_one_of_two_scales(tmp_path, monkeypatch):
    """Without VGG-19's weights the labelled random network is taken; both in one table are refused."""
    monkeypatch.setattr(pytest.importorskip("torch").hub, "_hub_dir", str(tmp_path))
    assert [score.name for _, score in chosen_scores(["gram_style"])] == ["gram_style_random"]
    (tmp_path / "checkpoints").mkdir()
    (tmp_path / "checkpoints" / "vgg19-dcbb9e9d.pth").write_bytes(b"")
    assert [score.name for _, score in chosen_scores(["gram_style"])] == ["gram_style"]
    with pytest.raises(UsageError, match="cannot be compared"):
        chosen_scores(["gram_style", "gram_style_random"])
    with pytest.raises(MissingFile, match=r"nowhere\.pth"):
        chosen_scores(["gram_style"], tmp_path / "nowhere.pth")


def test_one_sensor_alone_is_refused(tmp_path):
    """A store of one sensor has no pair: what to do is said."""
    alone = write_loader_store(tmp_path / "alone.zarr", n_sources=1)
    with pytest.raises(StoreError, match=r"touches of D1; expected two sensors.*merge"):
        sensor_sets(alone, 10)


def test_command(store, capsys):
    """A table for people, a document for machines, exit 2 for a set that is not there."""
    words = ("score", store.location, "--metric", "shade", "--against", "D2")
    code, out, _ = run_command(capsys, *words)
    assert code == 0
    assert "synthetic" in out
    assert "recorded" in out
    code, out, _ = run_command(capsys, *words, "--json")
    found = json.loads(out)["scores"]
    assert {(one["first"], one["second"], one["looked_at"]) for one in found} >= {(CHILDREN, "D2", "frame")}
    assert all(np.isfinite(one["value"]) for one in found)
    code, _, err = run_command(capsys, "score", store.location, "--metric", "shade", "--against", "D3")
    assert code == 2
    assert "one of: D1, D2" in err
