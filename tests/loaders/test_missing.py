"""Values that were not recorded are counted by stream, warned of, and left out where that is asked."""

import json
import warnings

import loader_stores as made
import numpy as np
import pytest

from tactiledata.errors import UnknownName, UsageError
from tactiledata.loaders.missing import MissingValuesWarning
from tactiledata.loaders.numpy import TactileArrays

N_TRAJECTORIES = 8 * 3
EMPTY = {0, 5, 12}
"""Trajectories whose aligned wrench is NaN all through; of trajectory 7 one frame in contact is."""
ONE_FRAME = 7 * made.FRAMES + 2


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("missing") / "ds.zarr"
    whole = made.force_at

    def with_gaps(number):
        lost = number // made.FRAMES in EMPTY or number == ONE_FRAME
        return np.full(6, np.nan) if lost else whole(number)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(made, "force_at", with_gaps)
        made.split_store(folder)
    return folder


def everything(place, streams="wrench", missing="warn", **options):
    return TactileArrays(place, "all", streams, missing=missing, allow_leaks=True, **options)


def test_missing_values_are_warned_of_and_counted(place):
    """The report counts frames and trajectories by stream, and a warning names the ways out."""
    with pytest.warns(MissingValuesWarning, match=r"wrench: 4 trajectories.*missing='drop'"):
        report = everything(place, ["wrench", "centre", "digit"]).report
    rows = len(EMPTY) * made.FRAMES + 1
    assert report.document()["missing"] == {"wrench": {"rows": rows, "trajectories": 4, "empty": 3, "unit": "frames"}}
    assert json.dumps(report.document())
    assert "3 of the trajectories have none at all" in str(report)


def test_whole_streams_warn_of_nothing(place):
    """Negative control: no warning without gaps, by another stream or where they are meant."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert everything(place, ["centre", "digit"]).report.missing == {}
        assert everything(place, missing="keep").report.missing["wrench"].trajectories == 4


def test_dropped_items_are_those_with_nan_and_no_others(place):
    """Without them no value is NaN, the rest are the items of before, and the counts add up."""
    kept, dropped = everything(place, missing="keep"), everything(place, missing="drop")
    lost = {row for row in kept.index.rows.tolist() if row // made.FRAMES in EMPTY or row == ONE_FRAME}
    assert set(kept.index.rows.tolist()) - set(dropped.index.rows.tolist()) == lost
    assert np.isfinite(dropped.batch(range(len(dropped)))["wrench"]).all()
    assert np.isnan(kept.batch(range(len(kept)))["wrench"]).any(axis=1).sum() == len(lost)
    assert dropped.report.left_out == {"without values of wrench": len(lost)}
    assert (dropped.report.frames, dropped.report.trajectories) == (len(dropped), N_TRAJECTORIES - len(EMPTY))
    assert dropped.fingerprint != kept.fingerprint


def test_trajectories_without_samples_are_missing_too(place):
    """The last trajectory of each recording has no wrench samples: counted, and dropped whole."""
    kept = everything(place, missing="keep", unit="trajectory")
    assert vars(kept.report.missing["wrench"]) == {"rows": 0, "trajectories": 8, "empty": 8, "unit": "samples"}
    dropped = everything(place, missing="drop", unit="trajectory")
    assert len(dropped) == N_TRAJECTORIES - 8
    assert all(len(item["wrench"]) for item in dropped)
    assert [item["trajectory"] for item in dropped] == [item["trajectory"] for item in kept if len(item["wrench"])]


def test_normalisation_says_what_it_leaves_out(place):
    """Mean and spread are finite and those of the frames with values, and the report says how many had none."""
    arrays = TactileArrays(place, "default/train", "wrench", missing="keep", normalise=True)
    without = TactileArrays(place, "default/train", "wrench", missing="drop", normalise=True)
    lost = len(arrays) - len(without)
    assert lost
    assert arrays.normalisers == without.normalisers
    assert any(f"{lost} of {len(arrays)} train rows have no finite value" in note for note in arrays.report.notes)
    np.testing.assert_allclose(without.batch(range(len(without)))["wrench"].mean(axis=0), 0, atol=1e-4)


@pytest.mark.slow
def test_nothing_left_and_unknown_choices_are_refused(place, tmp_path):
    """A stream that no item has, and a word that is no choice."""
    with pytest.raises(UnknownName, match="drop"):
        everything(place, missing="skip")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(made, "force_at", lambda number: np.full(6, np.nan))
        made.split_store(tmp_path / "empty.zarr")
    with pytest.raises(UsageError, match="without values of wrench"):
        everything(tmp_path / "empty.zarr", missing="drop")
