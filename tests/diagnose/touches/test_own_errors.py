"""What may be off in one trajectory alone: each field by hand, for a touch of two frames."""

import numpy as np
import pytest

from tactiledata.diagnose.touches.own_errors import OwnErrors
from tactiledata.diagnose.touches.touch_case import TouchCase
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.nuisance.tare import tare_variance
from tactiledata.sensors.digit import DIGIT

ERRORS = OwnErrors(slope=0.3, lever=0.05, place=1e-4, force=0.1, shear=0.2, locked=0.5)
TIPS = np.array([[1e-3, -2e-3, -4e-4], [2e-3, 1e-3, -3e-4]])
FORCES = np.array([[1.0, 2.0, 10.0], [0.5, -1.0, 4.0]])
MIXED = np.diag([0.1, 0.1, 0.2, 1e-3, 1e-3, 2e-3]) + np.pad(np.full((2, 2), 2e-3), (1, 3))
COVARIANCE = MIXED @ MIXED.T


def case(free_air=(False, False), forces=FORCES, seconds=(10.0, 12.0)):
    """A trajectory whose forces attack at its tips."""
    poses = np.tile(np.eye(4), (len(forces), 1, 1))
    poses[:, :3, 3] = TIPS
    touch = Touch(np.array(seconds), poses, Sphere(), GelMaterial(9e5, 0.47, 0.7), DIGIT.gel)
    measured = np.hstack([forces, np.cross(TIPS, forces)])
    return TouchCase(touch, measured, WrenchNoise(COVARIANCE, 1.7, "planted", 1.5, (0.2,)), np.array(free_air), 50.0)


def fields(**changed):
    """Fields by their names: (2, 6) each."""
    one = case(**changed)
    found = ERRORS.fields(one, one.measured)
    return dict(zip(ERRORS.names(), np.moveaxis(found, 2, 0), strict=True))


def at(places, forces):
    """Wrenches (2, 6) of forces at places."""
    return np.hstack([forces, np.cross(places, forces)])


def test_names_and_fields_agree_in_number():
    """One name a field, and no name twice."""
    names, one = ERRORS.names(), case()
    assert ERRORS.fields(one, one.measured).shape == (2, 6, len(names))
    assert len(set(names)) == len(names)
    assert OwnErrors().fields(one, one.measured).shape == (2, 6, len(OwnErrors().names()))


def test_the_zero_is_the_same_in_all_frames_and_as_uncertain_as_its_median():
    """Its fields together have the covariance of the noise, times the variance of a median of so many readings.

    Readings that remember each other make it less certain.
    """
    found = np.stack([field for name, field in fields().items() if name.startswith("zero")], axis=2)
    np.testing.assert_array_equal(found[0], found[1])
    expected = float(tare_variance(np.array([50.0]), 1.5 * 1.4)[0]) * 1.7 * COVARIANCE
    np.testing.assert_allclose(found[0] @ found[0].T, expected, rtol=1e-9, atol=1e-12)


def test_the_drift_is_nothing_at_the_first_frame():
    """The drift is 0 at the first frame; at the last it is the stated change, which a torque has times the lever."""
    for place, name in enumerate(("fx", "fy", "fz", "tx", "ty", "tz")):
        field = fields()[f"drift of the zero of {name}"]
        expected = np.zeros((2, 6))
        expected[1, place] = 0.3 if place < 3 else 0.3 * 0.05
        np.testing.assert_allclose(field, expected)


def test_the_drift_grows_evenly_with_time():
    """In the middle of three frames a quarter of the time has passed, and a quarter of the drift."""
    poses = np.tile(np.eye(4), (3, 1, 1))
    touch = Touch(np.array([5.0, 6.0, 9.0]), poses, Sphere(), GelMaterial(9e5, 0.47, 0.7), DIGIT.gel)
    air = np.ones(3, dtype=bool)
    one = TouchCase(touch, np.zeros((3, 6)), WrenchNoise(COVARIANCE, 1.0, "planted"), air, 50.0)
    found = ERRORS.fields(one, one.measured)
    of_fz = found[:, :, ERRORS.names().index("drift of the zero of fz")]
    assert of_fz[:, 2] == pytest.approx([0.0, 0.3 / 4, 0.3])


@pytest.mark.parametrize(("name", "way"), [("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0))])
def test_a_place_that_is_shifted_turns_the_force(name, way):
    """The same force attacks elsewhere: its torque changes by the shift times the force."""
    shift = ERRORS.place * np.array(way)
    expected = at(TIPS + shift, FORCES) - at(TIPS, FORCES)
    found = fields()[f"place along {name}"]
    np.testing.assert_allclose(found, expected, atol=1e-15)
    assert np.abs(found).max() == pytest.approx(1e-4 * 10.0)


def test_factors_are_shares_of_the_forces():
    """One factor acts on all forces, and one on the shear with its torques about the gel's origin."""
    np.testing.assert_allclose(fields()["factor on forces"], 0.1 * at(TIPS, FORCES))
    along = FORCES * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(fields()["factor on shear"], 0.2 * at(TIPS, along), atol=1e-15)


@pytest.mark.parametrize(("name", "way"), [("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0))])
def test_shear_is_held_only_after_load_was_taken_off(name, way):
    """Six of ten newtons are off in the second frame, and half of that may still pull; while load rises, nothing."""
    expected = at(TIPS, np.outer([0.0, 0.5 * 6.0], way))
    np.testing.assert_allclose(fields()[f"held shear along {name}"], expected, atol=1e-15)
    rising = fields(forces=FORCES[::-1])[f"held shear along {name}"]
    assert not rising.any()


def test_nothing_is_held_or_scaled_in_free_air():
    """Once the indenter is off the gel, only the zero and its drift are left."""
    found = fields(free_air=(False, True))
    for name, field in found.items():
        assert field[1].any() == ("zero" in name), name


def test_an_unknown_wrench_changes_nothing_that_is_not_of_the_sensor():
    """A frame without a wrench has no force that could be scaled."""
    lost = case()
    lost.measured[1] = np.nan
    found = ERRORS.fields(lost, lost.measured)
    assert np.isfinite(found).all()
    assert not found[1][:, ERRORS.names().index("factor on forces")].any()


def test_factors_multiply_the_wrenches_that_are_given():
    """They are shares of the simulated wrenches where these are given, whatever was measured."""
    one = case()
    found = ERRORS.fields(one, 3.0 * one.measured)
    np.testing.assert_allclose(found[:, :, ERRORS.names().index("factor on forces")], 0.1 * 3.0 * at(TIPS, FORCES))


def test_a_size_multiplies_the_factors_of_its_indenter_alone():
    """The factors on forces and on shear are larger under that indenter; other unknowns and indenters are as before."""
    one = case()
    name = one.indenter
    before = ERRORS.fields(one, one.measured)
    of_it = ERRORS.with_sizes({name: 2.5}).fields(one, one.measured)
    of_another = ERRORS.with_sizes({f"not {name}": 2.5}).fields(one, one.measured)
    for number, unknown in enumerate(ERRORS.names()):
        factor = 2.5 if unknown in ("factor on forces", "factor on shear") else 1.0
        np.testing.assert_allclose(of_it[:, :, number], factor * before[:, :, number], atol=1e-15)
    np.testing.assert_array_equal(of_another, before)
