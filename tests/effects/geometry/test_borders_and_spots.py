"""The edge of a pad side by side, and a soft spot by numbers worked out by hand."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.geometry.pad_edge import PadEdge
from tactiledata.effects.geometry.soft_region import SoftRegion
from tactiledata.effects.touch.response import GelVariant, SoftSpot
from tactiledata.effects.touch.state import TouchState
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.sensors.base import GelGeometry

PAD = GelGeometry(outline=(0.020, 0.030), thickness=0.004, edge_thickness=0.003)
SIDES = {"+x": (0.009, 0.004), "-x": (-0.009, 0.004), "+y": (0.004, 0.014), "-y": (0.004, -0.014)}
"""Places one millimetre from one side of the pad, and farther from all others."""


@pytest.fixture
def press(touch, moved):
    """press(x, y, depth): free air, and a press there, on a pad of 20 by 30 mm that is 1 mm lower at its border."""

    def at(x, y, depth=5e-4, **fields):
        path = moved(touch, np.arange(2.0), np.array([-1e-3, depth]), x=x, y=y)
        return dataclasses.replace(path, geometry=PAD, **fields)

    return at


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("inset", "distance"), [(0.0, 1e-3), (4e-4, 6e-4), (2e-3, 0.0)])
def test_the_nearest_side_softens(press, play, side, inset, distance):
    """1 - drop exp(-b / a), b the way to the nearest side less the inset, never below 0; free air has no stiffness."""
    path = press(*SIDES[side])
    plain, state = play(on=path), play("pad_edge", on=path, drop=0.3, inset=inset)
    wanted = 1 - 0.3 * np.exp(-distance / plain.contact.radius[1])
    np.testing.assert_allclose(state.stiffness, [1.0, wanted])
    np.testing.assert_allclose(state.wrench[1], wanted * plain.wrench[1], atol=1e-12)


@pytest.mark.parametrize("side", SIDES)
def test_the_rim_pushes_at_its_side(press, play, side):
    """A punch 1.5 mm deep overlaps the rim, which is 1 mm lower, by 0.5 mm: 5 N at 10 N/mm, at the border."""
    x, y = SIDES[side]
    path = press(x, y, 1.5e-3, indenter=CylinderFlat(0.003))
    change = (play("pad_edge", on=path, housing=1e4).wrench - play(on=path).wrench)[1]
    at = {"+x": (0.010, y), "-x": (-0.010, y), "+y": (x, 0.015), "-y": (x, -0.015)}[side]
    np.testing.assert_allclose(change, [0, 0, 5.0, 5.0 * at[1], -5.0 * at[0], 0], atol=1e-9)


def test_a_body_that_ends_before_the_rim_or_above_it_is_not_pushed(press, play):
    """A punch of 3 mm 4 mm away, and one that is 0.9 mm deep over a rim 1 mm lower."""
    for path in (press(0.006, 0.0, 1.5e-3), press(0.009, 0.0, 9e-4)):
        path = dataclasses.replace(path, indenter=CylinderFlat(0.003))
        np.testing.assert_array_equal(play("pad_edge", on=path, housing=1e4).wrench, play(on=path).wrench)


def test_edges_and_spots_name_the_gel_that_e_is_of():
    """E is that of the gel away from them."""
    for effect in (PadEdge(), SoftRegion()):
        told = effect.material_of(effect.complete({}))
        assert list(told) == ["E"]
        assert told["E"].startswith("the gel away from")


def test_what_a_gel_with_a_spot_does_not_play_is_its_further_loss_of_shear():
    """A modulus of 0.6 loses 0.4 of both: shear of 0.7 has lost 0.5 of the rest, shear of 0.3 nothing more."""
    effect = SoftRegion()
    given = {"normal_loss": 0.4, "shear_loss": 0.7, "x": 1e-3}
    left = effect.parameters_not_played_by_gel(given)
    assert left["normal_loss"] == 0.0
    assert left["shear_loss"] == pytest.approx(0.5)
    assert (left["x"], left["radius"], left["onset"]) == (1e-3, 2e-3, 0.0)
    assert effect.parameters_not_played_by_gel({"normal_loss": 0.4, "shear_loss": 0.3})["shear_loss"] == 0.0
    assert effect.variant(given) == GelVariant(spots=(SoftSpot(1e-3, 0.0, 2e-3, 0.4),))


def test_a_loss_of_shear_begins_beyond_the_traction_of_the_onset(touch, moved, play):
    """While it sticks, the shear is 1 - loss w (1 - onset A / F) times as large, and its torque too; fz stays."""
    path = moved(touch, np.arange(3.0), np.array([0.0, 8e-4, 8e-4]), x=[0.0, 0.0, 5e-5], y=[0.0, 0.0, 2e-5])
    plain = play(on=path)
    shear, area = float(np.hypot(*plain.wrench[2, :2])), float(plain.contact.area[2])
    onset = 0.25 * shear / area
    state = play("soft_region", on=path, shear_loss=0.5, radius=3e-3, onset=onset)
    energy = 0.6 * plain.contact.radius[2] ** 2 + 0.03 * touch.geometry.thickness**2
    weight = 9e-6 / (9e-6 + energy) * np.exp(-(5e-5**2 + 2e-5**2) / (2 * (9e-6 + energy)))
    kept = 1 - 0.5 * weight * 0.75
    np.testing.assert_allclose(state.wrench[2, :2], kept * plain.wrench[2, :2], rtol=1e-9)
    np.testing.assert_allclose(state.wrench[2, 2:], plain.wrench[2, 2:] * [1, kept, kept, 1] + _lift(plain, kept))
    none = play("soft_region", on=path, shear_loss=0.5, radius=3e-3, onset=1.01 * shear / area)
    np.testing.assert_allclose(none.wrench[2], plain.wrench[2], rtol=1e-12)


def _lift(plain, kept):
    """What keeps the torque of the normal force while that of the shear is multiplied: (fz, tx, ty, tz)."""
    x, y = plain.contact.centre[2]
    fx, fy, fz = plain.wrench[2, :3]
    return [0.0, (1 - kept) * y * fz, -(1 - kept) * x * fz, (kept - 1) * (x * fy - y * fx)]


def test_a_spot_takes_its_share_of_a_gel_that_is_stiffer_already(touch):
    """On a gel of twice the stiffness the force is twice that on the simulated one, spot and shear included."""
    values = {"normal_loss": 0.3, "shear_loss": 0.5, "x": 2e-3}
    start = TouchState.start(touch, BallOnLayer(touch))
    once = SoftRegion().apply(start, values).contact.wrench
    twice = SoftRegion().apply(start.stiffened(np.full(len(touch), 2.0)), values).contact.wrench
    free = ~start.contact.sliding
    np.testing.assert_allclose(twice[free, 2], 2.0 * once[free, 2], rtol=1e-12)
