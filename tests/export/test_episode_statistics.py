"""Statistics of exported episodes agree with those of all rows at once."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as stn

from tactiledata.export.episode_statistics import combined, picture_statistics, statistics

ROWS = stn.arrays(np.float64, st.tuples(st.integers(1, 9), st.just(2)), elements=st.floats(-1e3, 1e3))


@given(st.lists(ROWS, min_size=1, max_size=5))
def test_episodes_together_are_all_rows(episodes):
    """Mean, spread, extremes and count of the whole follow exactly from those of the parts."""
    whole = np.concatenate(episodes)
    found = combined({"x": statistics(rows)} for rows in episodes)["x"]
    assert found["count"] == [len(whole)]
    np.testing.assert_allclose(found["mean"], whole.mean(axis=0), atol=1e-6)
    np.testing.assert_allclose(found["std"], whole.std(axis=0), atol=2e-4)
    assert found["min"] == whole.min(axis=0).tolist()
    assert found["max"] == whole.max(axis=0).tolist()
    assert (np.array(found["min"]) <= np.array(found["q50"]) + 1e-9).all()
    assert (np.array(found["q50"]) <= np.array(found["max"]) + 1e-9).all()


def test_rows_that_are_not_finite_do_not_count():
    """A row with NaN changes nothing but is not counted; where none is left, zeros stand with a count of zero."""
    rows = np.array([[1.0, 2.0], [3.0, 5.0]])
    with_gap = np.concatenate([rows, [[np.nan, 4.0]]])
    assert statistics(with_gap) == statistics(rows)
    nothing = statistics(np.full((3, 2), np.nan))
    assert nothing["count"] == [0]
    assert nothing["mean"] == [0.0, 0.0]
    for order in ([nothing, statistics(rows)], [statistics(rows), nothing]):
        assert combined({"x": found} for found in order)["x"]["mean"] == [2.0, 3.5]
        assert combined({"x": found} for found in order)["x"]["min"] == [1.0, 2.0]


@given(stn.arrays(np.uint8, st.tuples(st.integers(1, 3), st.just(4), st.just(5), st.just(3))))
def test_pictures_by_channel(pictures):
    """Statistics from counts of grey levels are those of the pixels, on the scale 0 to 1."""
    found = picture_statistics(pictures)
    pixels = pictures.reshape(-1, 3) / 255
    for name, slow in (("mean", pixels.mean), ("std", pixels.std), ("min", pixels.min), ("max", pixels.max)):
        np.testing.assert_allclose(np.ravel(found[name]), slow(axis=0), atol=1e-6)
    for name, quantile in (("q01", 0.01), ("q50", 0.5), ("q99", 0.99)):
        slow = np.quantile(pixels, quantile, axis=0, method="inverted_cdf")
        np.testing.assert_allclose(np.ravel(found[name]), slow, atol=1e-9)
    assert found["count"] == [len(pictures)]
