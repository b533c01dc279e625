"""Taxim's table: planted tables are found again, the published one is read right, real presses are predicted."""

from pathlib import Path

import numpy as np
import pytest

from tactiledata.errors import MissingFile, SchemaError, UsageError
from tactiledata.optics.taxim import TaximTable, _substituted, place_terms, published_digit_table, slope_bins
from tactiledata.optics.taxim_calibration import BINS, CalibrationPress, ball_press, calibrate

ROOT = Path(__file__).resolve().parents[1]
PACK = ROOT / "data" / "gelsight_r15" / "dataPack.npz"
BALL = 2.0 / 0.1245
"""px: the ball's radius by the pack's own pitch."""


def planted(bins=20, seed=0):
    """A table with values of its own in each bin, none for flat gel, its last direction the first again."""
    coefficients = np.random.default_rng(seed).normal(0, 20, (bins, bins, 3, 6))
    coefficients[0] = 0
    coefficients[:, -1] = coefficients[:, 0]
    return TaximTable(coefficients, "planted")


def random_press(table, rng, shape=(40, 30)):
    """A picture drawn by a table, of slopes of all angles and directions."""
    angle, direction = rng.uniform(0.0, 1.5, shape), rng.uniform(-np.pi, np.pi, shape)
    slopes = np.tan(angle)[..., None] * np.stack([np.cos(direction), np.sin(direction)], -1)
    slopes = slopes.astype(np.float32)
    return CalibrationPress(table.change(slopes), slopes, np.ones(shape, bool))


def test_a_planted_table_is_found():
    """From pictures that it drew, every bin that was seen comes back; each bin alone, without spread or ridge."""
    table, rng = planted(), np.random.default_rng(1)
    found = calibrate((random_press(table, rng) for _ in range(60)), "again", bins=20, spread=0, ridge=0)
    press = random_press(table, rng)
    seen = slope_bins(press.slopes, (20, 20))[0] < 19
    np.testing.assert_allclose(found.change(press.slopes)[seen], press.change[seen], atol=0.05)


def test_pixels_of_one_bin_all_count():
    """Two pixels of one slope at one place: the table says their mean, not the last one (the lost duplicates)."""
    slopes = np.full((2, 2, 2), 0.5, np.float32)
    presses = [
        CalibrationPress(np.full((2, 2, 3), level, np.float32), slopes, np.ones((2, 2), bool)) for level in (10, 40)
    ]
    for order in (presses, presses[::-1]):
        np.testing.assert_allclose(calibrate(order, "two").change(slopes), 25, rtol=1e-3)


def test_flat_gel_is_no_change():
    """Whatever was calibrated or published, a background stays what it is where nothing touches."""
    rng = np.random.default_rng(2)
    found = calibrate([random_press(planted(), rng)], "one", bins=20)
    for table in (found, published_digit_table()):
        np.testing.assert_allclose(table.change(np.zeros((8, 6, 2), np.float32)), 0, atol=1e-3)


def test_unseen_slopes_take_their_nearest_neighbour():
    """A press with slopes in one direction only answers finitely, and alike, for every other."""
    slopes = np.full((6, 6, 2), 0.4, np.float32)
    found = calibrate([CalibrationPress(np.full((6, 6, 3), 12.0, np.float32), slopes, np.ones((6, 6), bool))], "narrow")
    np.testing.assert_allclose(found.change(-2 * slopes), 12, rtol=0.02)


def test_bins_go_round_and_end_at_their_ends():
    """Flat is bin 0, directions of -pi and pi are the ends, and everything in between rises."""
    around = np.linspace(-np.pi, np.pi, 400)
    slopes = np.stack([np.cos(around), np.sin(around)], -1)
    _, direction = slope_bins(slopes, (9, 9))
    assert direction.min() == 0
    assert direction.max() == 8
    assert (np.diff(direction[:-1]) >= 0).all()
    assert slope_bins(np.array([1e9, 0.0]), (9, 9))[0] == 8
    assert slope_bins(np.zeros(2), (9, 9))[0] == 0


def test_quadratics_keep_their_values_under_a_change_of_coordinates():
    """Substitution is exact."""
    rng = np.random.default_rng(3)
    coefficients, (u, v) = rng.normal(0, 1, (5, 6)), rng.uniform(-1, 1, 2)
    x, y = 3 * u - 2 * v + 1, 0.5 * u + 4 * v - 2
    expected = coefficients @ [x * x, y * y, x * y, x, y, 1]
    found = _substituted(coefficients, (3, -2, 1), (0.5, 4, -2)) @ [u * u, v * v, u * v, u, v, 1]
    np.testing.assert_allclose(found, expected)


def test_the_published_table_is_turned_upright():
    """A pixel and slope of an upright picture have what the file says of them on the picture's side."""
    with np.load(Path(published_digit_table.__code__.co_filename).parent / "taxim_digit" / "polycalib.npz") as archive:
        blue = archive["grad_r"].astype(float)  # the file's pictures are BGR
    row, column = 37, 101
    slope = np.array([0.3, -0.7])
    lying_column, lying_row = 2 * (320 - row) - 1.5, 2 * column + 0.5  # of a 480 x 640 picture, turned clockwise
    terms = [lying_column**2, lying_row**2, lying_column * lying_row, lying_column, lying_row, 1]
    angle, direction = slope_bins(np.array([-slope[1], slope[0]]), (BINS, BINS))
    flat = slope_bins(np.zeros(2), (BINS, BINS))
    expected = (blue[angle, direction] - blue[flat]) @ terms
    slopes = np.zeros((320, 240, 2), np.float32)
    slopes[row, column] = slope
    assert published_digit_table().change(slopes)[row, column, 2] == pytest.approx(expected, abs=0.05)


def test_the_published_table_colours_a_ball_as_a_digit_does():
    """In real DIGIT contacts the upper side of an indenter is orange, the lower blue."""
    row, column = np.mgrid[:320, :240] - np.array([160, 120])[:, None, None]
    inside = np.hypot(row, column) < 40
    slopes = np.where(inside[..., None], -np.stack([column, row], -1) / 60.0, 0.0).astype(np.float32)
    change = published_digit_table().change(slopes)
    above, below = change[125:140, 110:130].mean((0, 1)), change[180:195, 110:130].mean((0, 1))
    assert above[0] > above[2] + 20
    assert below[2] > below[0] + 20


def real_presses():
    with np.load(PACK) as pack:
        background = pack["f0"][..., ::-1]
        return [
            ball_press(picture[..., ::-1], background, tuple(centre), radius, BALL)
            for picture, centre, radius in zip(pack["imgs"], pack["touch_center"], pack["touch_radius"], strict=True)
        ]


def test_real_presses_are_predicted():
    """GelSight R1.5: presses that took no part are predicted within 8 of 42 grey levels of change."""
    presses = real_presses()
    table = calibrate([press for index, press in enumerate(presses) if index % 5], "GelSight R1.5, 39 presses")
    errors, sizes = [], []
    for press in presses[::5]:
        known = press.is_known
        errors.append(np.abs(table.change(press.slopes) - press.change)[known].mean())
        sizes.append(np.abs(press.change)[known].mean())
    assert np.mean(errors) < 8
    assert np.mean(sizes) > 40


def test_the_annotated_radii_are_not_believed_beyond_the_ball():
    """Annotated 17 px of a ball of 16.06 px: slopes are taken to 0.9 of the ball only, all of them finite."""
    press = ball_press(np.zeros((60, 60, 3), np.uint8), np.zeros((60, 60, 3), np.uint8), (30, 30), 17, BALL)
    reach = np.sqrt(press.is_known.sum() / np.pi)
    assert reach == pytest.approx(0.9 * BALL, rel=0.02)
    edge = np.hypot(*press.slopes[30, 30 + 14])
    assert edge == pytest.approx(14 / np.sqrt(BALL**2 - 14**2), rel=1e-4)
    assert press.slopes[30, 36, 0] < 0 < press.slopes[30, 24, 0]  # deepest in the middle


def test_tables_go_to_disk_and_back(tmp_path):
    """A table that was written and read draws the same changes, and another file is refused."""
    table = planted()
    table.save(tmp_path / "table.npz")
    again = TaximTable.load(tmp_path / "table.npz")
    np.testing.assert_allclose(again.coefficients, table.coefficients, rtol=1e-6)
    assert again.origin == "planted"
    with pytest.raises(MissingFile):
        TaximTable.load(tmp_path / "none.npz")
    np.savez(tmp_path / "other.npz", a=1)
    with pytest.raises(SchemaError, match="no Taxim table"):
        TaximTable.load(tmp_path / "other.npz")
    with pytest.raises(SchemaError):
        published_digit_table(tmp_path / "other.npz")


def test_what_calibrates_nothing_is_refused():
    """No slopes, pictures of two sizes, and a radius of nothing are refused."""
    flat = CalibrationPress(np.zeros((5, 5, 3), np.float32), np.zeros((5, 5, 2), np.float32), np.ones((5, 5), bool))
    with pytest.raises(UsageError, match="no pixel"):
        calibrate([flat], "flat")
    with pytest.raises(UsageError, match="one shape"):
        ball_press(np.zeros((5, 5, 3)), np.zeros((6, 5, 3)), (2, 2), 2, 3)
    with pytest.raises(UsageError, match="radii"):
        ball_press(np.zeros((5, 5, 3)), np.zeros((5, 5, 3)), (2, 2), 0, 3)
    with pytest.raises(UsageError, match="shape"):
        TaximTable(np.zeros((3, 3, 3, 5)), "short")


def test_places_are_the_same_for_pictures_of_any_size():
    """The terms of the middle and of the corners are the same for pictures of any size."""
    assert place_terms((9, 7))[4, 3].tolist() == [0, 0, 0, 0, 0, 1]
    assert place_terms((2, 2))[0, 0].tolist() == [0.25, 0.25, 0.25, -0.5, -0.5, 1]
