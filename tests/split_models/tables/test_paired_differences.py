"""Differences of rows on the same frames."""

import numpy as np

from split_models.tables.paired_differences import difference_part, difference_rows, differences
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY

TOUCHES = np.arange(40) // 4


def planted():
    """Scores that vary far more from touch to touch than methods differ."""
    rng = np.random.default_rng(0)
    base = rng.normal(0, 5, 10)[TOUCHES]
    return {
        "split": {"l1": base, "psnr": np.where(TOUCHES == 0, np.inf, base)},
        "other": {"l1": base + 0.5 + rng.normal(0, 0.05, 40), "psnr": base},
        "same": {"l1": base.copy(), "psnr": base},
    }


def test_a_small_difference_is_found_where_touches_vary_more():
    """0.5 planted below a spread of 5: the interval of the differences holds it and not 0."""
    rows = difference_rows("test", planted(), "split", "SPLIT", TOUCHES, 200, IMAGE_SIMILARITY.scores)
    assert [row["method"] for row in rows] == ["other", "same"]
    assert {row["part"] for row in rows} == {difference_part("test", "SPLIT")}
    found = rows[0]["scores"]["l1"]
    assert 0.4 < found["low"] <= found["value"] <= found["high"] < 0.6
    assert found["better"] == "lower"
    assert rows[1]["scores"]["l1"]["value"] == 0.0  # negative control


def test_infinite_scores_have_no_difference():
    """Frames on which either PSNR is infinite are left out."""
    less = differences(planted(), "split")["same"]["psnr"]
    assert np.isnan(less[TOUCHES == 0]).all()
    assert (less[TOUCHES > 0] == 0).all()


def test_without_the_reference_there_is_nothing_to_compare_with():
    """No rows rather than rows against another method."""
    assert differences(planted(), "missing") == {}
    assert difference_rows("test", planted(), "missing", "", TOUCHES, 50, IMAGE_SIMILARITY.scores) == []
