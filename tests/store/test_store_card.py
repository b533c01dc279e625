"""The dataset card and the statistics say what the store holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from random_takes import SMALL, staged_take

from tactiledata.store.layout.statistics import added, no_statistics, standard_deviation
from tactiledata.store.read.reader import Store
from tactiledata.store.write.card import card
from tactiledata.store.write.commit import commit, commit_groups, create

NUMBERS = arrays(
    float, st.tuples(st.integers(0, 30), st.just(2)), elements=st.floats(-1e6, 1e6) | st.sampled_from([np.nan, np.inf])
)


@given(st.lists(NUMBERS, max_size=5))
def test_statistics_grow_as_if_all_were_seen_at_once(blocks: list[np.ndarray]) -> None:
    """Block by block gives what numpy gives over all finite values."""
    statistics = no_statistics(2)
    for block in blocks:
        statistics = added(statistics, block)
    everything = np.concatenate([np.empty((0, 2)), *blocks])
    for column in range(2):
        values = everything[np.isfinite(everything[:, column]), column]
        assert statistics["count"][column] == len(values)
        if len(values):
            assert statistics["mean"][column] == pytest.approx(values.mean(), abs=1e-6)
            assert standard_deviation(statistics)[column] == pytest.approx(values.std(), abs=1e-3, rel=1e-6)
            assert (statistics["min"][column], statistics["max"][column]) == (values.min(), values.max())


def test_statistics_of_huge_numbers_stay_json() -> None:
    """Numbers at the end of the range do not turn statistics into infinities."""
    statistics = added(no_statistics(1), np.array([[1e308], [-1e308], [1e308]]))
    assert all(np.isfinite(statistics[key]).all() for key in statistics)


@pytest.mark.slow
def test_manifest_statistics_are_those_of_the_values(tmp_path: Path) -> None:
    """What the manifest says of a signal is what its values give."""
    create(tmp_path, SMALL)
    for seed in (1, 2, 3):
        commit(tmp_path, [staged_take(tmp_path, seed)[0]])
    store = Store.open(tmp_path)
    signal = store.signal("wrench")
    statistics = signal.meaning.statistics
    values = signal.values(0, signal.n_rows)
    assert statistics["mean"] == pytest.approx(values.mean(axis=0).tolist())
    assert statistics["max"] == values.max(axis=0).tolist()
    aligned = store.aligned("wrench")[0]
    assert store.meaning("aligned", "wrench").statistics["count"] == np.isfinite(aligned).sum(axis=0).tolist()


def test_card_counts_and_escapes(tmp_path: Path) -> None:
    """The card has the counts, and a name cannot break its tables."""
    create(tmp_path, SMALL)
    commit_groups(tmp_path, [staged_take(tmp_path, seed, cameras=("left | right\n# x",))[0] for seed in (1, 2)])
    store = Store.open(tmp_path)
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert text == card(tmp_path, store.manifest)
    assert f"{store.n_frames:,} frames" in text
    assert "left \\| right # x" in text
    assert "\n# x" not in text


def test_card_of_an_empty_store(tmp_path: Path) -> None:
    """A new store has a card."""
    create(tmp_path, SMALL)
    assert "0 frames" in (tmp_path / "README.md").read_text(encoding="utf-8")
