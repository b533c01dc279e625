"""Mean and spread: of the train part only, exact however rows are cut, kept and tied to the split."""

import json

import loader_stores as made
import numpy as np
import pytest
from copied_trees import copy_tree
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.errors import UsageError
from tactiledata.loaders.normalise import IMAGE_SAMPLE, Normaliser, image_moments, measure
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.splits.make import make_split

KEPT = "splits/default.normalisation.json"


@given(st.integers(1, 200), st.integers(1, 50), st.floats(-1e6, 1e6), st.integers(0, 3))
def test_chunked_moments_equal_numpy(n, chunk, offset, seed):
    """Mean, spread and bounds do not depend on how the rows are cut, and agree with numpy far from zero."""
    values = np.random.default_rng(seed).standard_normal((n, 3)) + offset
    found = measure((values[start : start + chunk] for start in range(0, n, chunk)), ("a", "b", "c"), ("1",) * 3)
    np.testing.assert_allclose(found.mean, values.mean(axis=0), rtol=1e-12, atol=1e-9)
    expected = values.std(axis=0) if n > 1 else np.ones(3)
    np.testing.assert_allclose(found.std, expected, rtol=1e-6)
    np.testing.assert_array_equal(found.minimum, values.min(axis=0))
    np.testing.assert_array_equal(found.maximum, values.max(axis=0))


def test_rows_without_values_are_counted_and_left_out():
    """NaN rows change nothing but the count; only NaN rows are an error."""
    values = np.array([[1.0], [np.nan], [3.0], [np.inf]])
    found = measure([values], ("fz",), ("N",))
    assert (found.mean, found.rows, found.left_out) == ((2.0,), 2, 2)
    with pytest.raises(UsageError, match="none of 1 train rows"):
        measure([values[1:2]], ("fz",), ("N",))


def test_applied_and_inverted_is_the_identity():
    """Scaling and its way back give the values; a column that never changes is not blown up."""
    values = np.array([[1.0, 5.0], [3.0, 5.0]])
    found = measure([values], ("a", "b"), ("N", "N"))
    scaled = found.apply(values)
    np.testing.assert_allclose(scaled, [[-1, 0], [1, 0]])
    np.testing.assert_allclose(found.invert(scaled), values)
    assert Normaliser.from_document(json.loads(json.dumps(found.document()))) == found


def test_picture_moments_equal_numpy():
    """Moments by counting levels are those of the pixels in [0, 1]; long lists are sampled evenly."""
    pictures = np.random.default_rng(0).integers(0, 256, (5, 4, 6, 3)).astype(np.uint8)
    found = image_moments(lambda rows: pictures[rows], np.arange(5))
    np.testing.assert_allclose(found.mean, (pictures / 255).mean(axis=(0, 1, 2)))
    np.testing.assert_allclose(found.std, (pictures / 255).std(axis=(0, 1, 2)))
    read = []
    image_moments(lambda rows: read.extend(rows) or [pictures[0]] * len(rows), np.arange(100_000))
    assert len(read) == IMAGE_SAMPLE
    assert (read[0], read[-1]) == (0, 99_999)


@pytest.fixture(scope="module")
def untouched(tmp_path_factory):
    folder = tmp_path_factory.mktemp("normalise") / "ds.zarr"
    made.split_store(folder)
    return folder


@pytest.fixture
def place(untouched, tmp_path):
    """A store with a split, to write to."""
    return copy_tree(untouched, tmp_path / "ds.zarr")


@pytest.mark.slow
def test_train_has_mean_zero_and_others_take_its_scale(place):
    """Train is scaled to mean 0 and spread 1; val and test by the very same numbers."""
    parts = {
        part: TactileArrays(place, f"default/{part}", ("digit", "wrench"), normalise=("digit", "wrench"))
        for part in ("train", "val", "test")
    }
    batch = parts["train"].batch(range(len(parts["train"])))
    np.testing.assert_allclose(batch["wrench"].mean(axis=0), 0, atol=1e-4)
    np.testing.assert_allclose(batch["wrench"].std(axis=0), 1, atol=1e-4)
    np.testing.assert_allclose(batch["digit"].mean(axis=(0, 1, 2)), 0, atol=1e-4)
    assert parts["train"].normalisers == parts["val"].normalisers == parts["test"].normalisers
    plain = TactileArrays(place, "default/test", "wrench").batch([0])["wrench"]
    np.testing.assert_allclose(
        parts["test"].normalisers["wrench"].invert(parts["test"].batch([0])["wrench"]), plain, atol=1e-5
    )


@pytest.mark.slow
def test_values_outside_train_change_nothing(tmp_path, monkeypatch):
    """Wild values in val and test leave the normaliser as it is (negative control: in train they change it)."""
    made.split_store(tmp_path / "a.zarr")
    calm = TactileArrays(tmp_path / "a.zarr", "default/train", "wrench", normalise=True)
    train = set(calm.index.rows.tolist())
    tame = made.force_at
    monkeypatch.setattr(made, "force_at", lambda number: tame(number) * (1 if number in train else 1e6))
    made.split_store(tmp_path / "b.zarr")
    assert TactileArrays(tmp_path / "b.zarr", "default/train", "wrench", normalise=True).normalisers == calm.normalisers
    monkeypatch.setattr(made, "force_at", lambda number: tame(number) * (2 if number in train else 1))
    made.split_store(tmp_path / "c.zarr")
    assert TactileArrays(tmp_path / "c.zarr", "default/train", "wrench", normalise=True).normalisers != calm.normalisers


@pytest.mark.slow
def test_native_rate_signals_have_their_own_scale(place):
    """In trajectory mode a signal is scaled by its native samples in train trajectories."""
    arrays = TactileArrays(place, "default/train", "wrench", unit="trajectory", missing="keep", normalise=True)
    samples = np.concatenate([item["wrench"] for item in arrays])
    np.testing.assert_allclose(samples.mean(axis=0), 0, atol=1e-5)
    np.testing.assert_allclose(samples.std(axis=0), 1, atol=1e-5)


def test_the_kept_file_is_the_same_again_and_used(place, monkeypatch):
    """The file has the same bytes when computed again; once kept, nothing is computed."""
    first = TactileArrays(place, "default/train", "wrench", normalise=True)
    content = (place / KEPT).read_bytes()
    (place / KEPT).unlink()
    TactileArrays(place, "default/train", "wrench", normalise=True)
    assert (place / KEPT).read_bytes() == content
    monkeypatch.setattr("tactiledata.loaders.normalise.measure", None)
    again = TactileArrays(place, "default/val", "wrench", normalise=True)
    assert again.normalisers == first.normalisers
    assert first.store.split_names() == ["default"]


def test_a_second_stream_joins_the_kept_ones(place):
    """Normalisers of several streams share the file."""
    TactileArrays(place, "default/train", "wrench", normalise=True)
    TactileArrays(place, "default/train", "centre", normalise=True)
    assert set(json.loads((place / KEPT).read_text())["streams"]) == {"aligned:wrench", "frame_value:centre"}


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"null", b'{"format": "tactiledata-normalisation/1"}', b"\xff\xfe"]
)
def test_a_torn_file_is_made_anew(place, content):
    """A file that is not what it should be is replaced, not believed."""
    (place / KEPT).write_bytes(content)
    arrays = TactileArrays(place, "default/train", "wrench", normalise=True)
    assert arrays.normalisers["wrench"].rows == len(arrays)
    assert json.loads((place / KEPT).read_text())["split"] == "default"


def test_another_split_of_the_same_name_is_measured_anew(place):
    """After the split was made again, what was kept for the old one is not used."""
    old = TactileArrays(place, "default/train", "wrench", normalise=True)
    make_split(old.store, fractions=(0.3, 0.3, 0.4), hold_out="none", seed=5, replace=True)
    new = TactileArrays(place, "default/train", "wrench", normalise=True)
    assert len(new) != len(old)
    assert new.normalisers["wrench"].rows == len(new)


def test_a_store_that_cannot_be_written_still_normalises(place, monkeypatch):
    """Where the file cannot be kept, the report says so and the numbers are the same."""
    kept = TactileArrays(place, "default/train", "wrench", normalise=True)
    (place / KEPT).unlink()

    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tactiledata.loaders.normalise.write_atomic", refuse)
    arrays = TactileArrays(place, "default/train", "wrench", normalise=True)
    assert arrays.normalisers == kept.normalisers
    assert any("Permission denied" in note for note in arrays.report.notes)
