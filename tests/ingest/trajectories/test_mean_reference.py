"""A picture without contact, from a recording's background or from its frames in free air."""

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Source
from tactiledata.ingest.trajectories.reference import FREE_AIR, find_references

DOCUMENT = {"sensors": {"D1": {"model": "digit"}}, "licence": "MIT"}


def grey(level, size=(4, 3)):
    return np.full((*size, 3), level, np.uint8)


def found(forces, pictures, sensors=None, order=None, references=None, sources=None):
    """References, rows that were decoded, and findings; pictures by row in the sink."""
    count, asked, said = len(forces), [], []
    recording = Recording(
        Source("p", "k", "folder", ()), LogDescription(DOCUMENT), references=references or {},
        reference_sources=sources or {},
    )  # fmt: skip

    def decode(rows):
        asked.extend(rows.tolist())
        return [pictures[row] for row in rows]

    references = find_references(
        recording, sensors or ["D1"] * count, np.arange(count) if order is None else np.array(order),
        np.array(forces, np.float32), decode, said.append,
    )  # fmt: skip
    return references, asked, [(one.code, one.severity) for one in said]


def test_the_mean_of_three_frames_in_free_air():
    """Rounded to whole levels, with its origin, licence and model; frames in contact are left out."""
    references, asked, said = found([0.1, 5, 0.0, 0.1], [grey(10), grey(99), grey(11), grey(14)])
    assert asked == [0, 2, 3]
    assert said == []
    one = references["D1"]
    np.testing.assert_array_equal(one.image, grey(12))
    assert one.image.dtype == np.uint8
    assert (one.origin, one.licence, one.model) == ("mean of 3 frames below 0.2 N", "MIT", "digit")


def test_free_air_is_below_a_fifth_of_a_newton():
    """At 0.2 N it is not, nor where the force is not known."""
    limit = np.float32(FREE_AIR)
    below = np.nextafter(limit, np.float32(0))
    assert found([below] * 3, [grey(1)] * 3)[2] == []
    for force in (limit, np.nan):
        assert found([below, below, force], [grey(1)] * 3)[2] == [("no-background", "warning")]
    assert FREE_AIR == 0.2


@pytest.mark.parametrize(("pictures", "used"), [([1, 2], 0), ([1, None, 3], 0), ([1, None, 3, 5], 3)])
def test_three_pictures_are_needed(pictures, used):
    """Those that do not decode do not count."""
    made = [None if level is None else grey(level) for level in pictures]
    references, _, said = found([0.0] * len(made), made)
    assert [one.origin for one in references.values()] == [f"mean of {used} frames below 0.2 N"][: bool(used)]
    assert len(said) == (not used)


def test_pictures_of_another_size_than_the_first_are_left_out():
    """Three of the first size make a mean, two do not."""
    pictures = [grey(1), grey(50, (5, 5)), grey(2), grey(3), grey(50, (5, 5))]
    np.testing.assert_array_equal(found([0.0] * 5, pictures)[0]["D1"].image, grey(2))
    assert found([0.0] * 3, pictures[:3])[0] == {}


def test_at_most_32_frames_are_averaged_from_the_first_to_the_last():
    """Of 40 frames, 32 are averaged, spread over all of them; of 32 every one is."""
    references, asked, _ = found([0.0] * 40, [grey(level) for level in range(40)])
    assert len(asked) == 32
    assert (asked[0], asked[-1]) == (0, 39)
    assert np.diff(asked).max() == 2
    assert references["D1"].origin == "mean of 32 frames below 0.2 N"
    assert found([0.0] * 32, [grey(1)] * 32)[1] == list(range(32))
    assert len(found([0.0] * 33, [grey(1)] * 33)[1]) == 32


def test_each_sensor_has_its_own_frames_by_their_row_in_the_sink():
    """Frames in the store's order are decoded by their rows; a sensor without any is said, and the next goes on."""
    pictures = [grey(level) for level in (1, 2, 3, 40, 50, 60)]
    sensors = ["D2", "D2", "D2", "D1", "D1", "D0"]
    references, _, said = found([0.0] * 6, pictures, sensors, [5, 4, 3, 2, 1, 0])
    assert list(references) == ["D2"]
    np.testing.assert_array_equal(references["D2"].image, grey(50))
    assert references["D2"].model == ""
    assert said == [("no-background", "warning")] * 2


def test_a_stated_background_wins():
    """Nothing is decoded, and where it comes from is said; the sensors after it are looked at."""
    sensors = ["D1"] * 3 + ["D2"] * 3
    pictures = [grey(9)] * 6
    references, asked, _ = found([0.0] * 6, pictures, sensors, references={"D1": grey(7)})
    np.testing.assert_array_equal(references["D1"].image, grey(7))
    assert (references["D1"].origin, references["D1"].model) == ("the recording's background", "digit")
    assert asked == [3, 4, 5]
    assert "D2" in references
    stated = found([0.0] * 6, pictures, sensors, None, {"D1": grey(7)}, {"D1": "a.png"})[0]
    assert stated["D1"].origin == "a.png"
