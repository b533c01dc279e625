"""Directions in which a simulation may err: each kind by hand, for three frames under one indenter."""

import numpy as np
import pytest

from tactiledata.diagnose.touches.error_wrenches import ErrorFrames
from tactiledata.diagnose.touches.simulation_errors import (
    FAMILIES,
    KINDS,
    NumericalErrors,
    error_list,
)

ERRORS = NumericalErrors(shape=0.05, law=0.03, shear=0.04, centre=5e-5)
FRICTION = 0.5
TIPS = np.array([[1e-3, 2e-3, -4e-4], [-2e-3, 1e-3, -6e-4], [0.0, -1e-3, -2e-4]])
FORCES = np.array([[0.5, 0.0, 2.0], [0.0, 2.0, 4.0], [0.1, -0.1, 1.0]])
"""The first sticks at half of its friction limit, the second slides, the third sticks, three quarters taken off."""
USED = np.array([0.5, 1.0, np.hypot(0.1, 0.1) / 0.5])
STICKS, SLIDES = np.array([1.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
UNLOADED = np.array([0.0, 0.0, 0.75])
LEAN = np.array([0.1, 0.0, -0.2])
"""Angles about y by which the indenter leans in each frame."""


def at_tips(forces, tips=TIPS):
    """Wrenches (n, 6) of forces (n, 3) at the tips."""
    return np.hstack([forces, np.cross(tips, forces)])


def poses(tips=TIPS, lean=LEAN):
    """Poses (n, 4, 4) of an indenter that leans."""
    found = np.tile(np.eye(4), (len(tips), 1, 1))
    found[:, :3, 3] = tips
    found[:, 0, 0] = found[:, 2, 2] = np.cos(lean)
    found[:, 0, 2], found[:, 2, 0] = np.sin(lean), -np.sin(lean)
    return found


def fields(forces=FORCES, names=("ball",), owner=None, errors=ERRORS, starts=(0,), tips=TIPS, lean=LEAN, real=1.0):
    """Fields (n, 6, e) of forces at the tips, where the measured forces are ``real`` times as large."""
    owner = np.zeros(len(forces), dtype=np.int64) if owner is None else np.asarray(owner)
    frames = ErrorFrames(errors, real * at_tips(forces, tips), poses(tips, lean), names, owner, np.asarray(starts))
    return frames.wrenches(at_tips(forces, tips), np.full(len(forces), FRICTION))


def moved(ways):
    """Change (3, 6) of the wrench where its centre moves by one metre along ways (3, 3)."""
    return np.hstack([np.zeros((3, 3)), np.cross(ways, FORCES)])


def expected():
    """Every kind of error of size 1, in words: force, growth and shear as numpy has them."""
    size = np.linalg.norm(FORCES, axis=1)
    growth = np.log(size) - np.average(np.log(size), weights=size)
    shear, load = FORCES * [1.0, 1.0, 0.0], FORCES[:, 2]
    whole = at_tips(FORCES)

    def of(forces, factor=1.0):
        return at_tips(forces * np.broadcast_to(factor, 3)[:, None])

    stuck, slid = shear * STICKS[:, None], shear * SLIDES[:, None]
    x_axis, leaning = np.eye(3)[[0, 0, 0]], np.column_stack([np.sin(LEAN), np.zeros(3), np.zeros(3)])
    pushed = np.zeros((3, 6))
    pushed[:, 2] = load * USED**2
    return {
        "all forces": whole,
        "the growth of force with depth": whole * growth[:, None],
        "the curve of force over depth": whole * (growth**2 - np.average(growth**2, weights=size))[:, None],
        "force while it is taken off": whole * UNLOADED[:, None],
        "normal force under shear": pushed,
        "shear that sticks": of(stuck),
        "the growth of shear with depth": of(stuck, growth),
        "shear that begins to slide": of(stuck, USED**2),
        "shear that sticks while the force is taken off": of(stuck, UNLOADED),
        # the shear was largest in the second frame, at the friction limit; a quarter of its load is left in the third
        "shear after a turn": of(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.1, -0.1 - 0.25 * 2.0, 0.0]])),
        "shear that slides": of(slid),
        "the growth of sliding shear with depth": of(slid, growth),
        "sliding shear while the force is taken off": of(slid, UNLOADED),
        # the indenter leans and is not turned: its x is the gel's
        "shear along the indenter's x against its y": of(shear * [1.0, -1.0, 0.0]),
        "the push aside by a tilt": of(leaning, load),
        "the centre of pressure along the indenter's x": moved(x_axis),
        "the centre of pressure along the indenter's y": moved(np.eye(3)[[1, 1, 1]]),
        "the centre of pressure under a tilt": moved(leaning),
    }


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.what)
def test_each_kind_is_what_it_says(kind):
    """The field over one standard deviation is the error by hand, times the stated multiple of the stated size."""
    place = KINDS.index(kind)
    found = fields()[:, :, place]
    deviation = kind.times * getattr(ERRORS, kind.of)
    np.testing.assert_allclose(found, deviation * expected()[kind.what], atol=1e-12)


def test_sliding_shear_may_be_off_while_the_force_is_taken_off():
    """A contact that slides at a quarter of its largest load may be wrong by three quarters of the shear."""
    place = next(number for number, kind in enumerate(KINDS) if kind.what.startswith("sliding shear while"))
    forces = FORCES.copy()
    forces[2] = [0.5, 0.0, 1.0]
    along = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.75 * 0.5, 0.0, 0.0]])
    np.testing.assert_allclose(fields(forces)[:, :, place], KINDS[place].times * 0.04 * at_tips(along), atol=1e-12)


@pytest.mark.parametrize("names", [("ball",), ("ball", "bar"), ("ball", "bar", "box")])
def test_the_list_and_the_fields_agree(names):
    """Every indenter has each kind, then come the errors that all have in common; each has a label of its own."""
    listed = error_list(ERRORS, names)
    common = [kind for kind in KINDS if kind.is_common]
    assert common
    assert len(listed) == len(names) * len(KINDS) + len(common)
    assert fields(names=names).shape == (3, 6, len(listed))
    assert len({error.label for error in listed}) == len(listed)
    assert {error.family for error in listed} == set(FAMILIES)
    assert [error.indenter for error in listed if not error.indenter] == [""] * len(common)


def two_indenters():
    """Six frames, three under each of two indenters, and the errors by indenter."""
    names, owner = ("ball", "bar"), np.repeat([0, 1], 3)
    forces = np.vstack([FORCES, 3.0 * FORCES])
    found = fields(forces, names, owner, starts=(0, 3), tips=np.vstack([TIPS, TIPS]), lean=np.tile(LEAN, 2))
    return found, error_list(ERRORS, names), owner


def test_errors_of_an_indenter_act_on_its_frames_only():
    """Errors of an indenter act on its frames only, and errors in common act on all frames."""
    found, listed, owner = two_indenters()
    for number, error in enumerate(listed):
        acts = np.array([found[owner == which, :, number].any() for which in (0, 1)])
        if not error.indenter:
            assert acts.all()
        else:
            assert not acts[1 - ("ball", "bar").index(error.indenter)]


CURVE = "the curve of force over depth"


def test_errors_of_an_indenter_are_as_if_it_were_alone():
    """Frames that another indenter presses change none of an indenter's errors."""
    found, _, _ = two_indenters()
    kept = [number for number, kind in enumerate(KINDS) if kind.what != CURVE]
    assert len(kept) == len(KINDS) - 1
    np.testing.assert_allclose(found[:3, :, kept], fields()[:, :, kept], atol=1e-12)


def test_the_curve_of_an_indenter_is_as_if_it_were_alone():
    """The curve has no mean over the frames of its own indenter, so that it is no factor on all of its forces."""
    found, _, _ = two_indenters()
    place = [kind.what for kind in KINDS].index(CURVE)
    np.testing.assert_allclose(found[:3, :, place], fields()[:, :, place], atol=1e-12)


def test_growth_in_common_is_about_the_force_of_all_and_that_of_an_indenter_about_its_own():
    """Three times the force under the second indenter is growth in common, and none of its own."""
    found, listed, _ = two_indenters()
    labels = [error.label for error in listed]
    own, common = (found[:, 2, labels.index(f"the growth of force with depth{of}")] for of in (" of bar", ""))
    size = np.linalg.norm(FORCES, axis=1)
    about = np.log(size) - np.average(np.log(size), weights=size)
    assert own[3:] == pytest.approx(ERRORS.law * 3.0 * FORCES[:, 2] * about)
    # frames are weighted by their force: three quarters of all force are under the second indenter
    below, above = 0.75 * np.log(3.0), 0.25 * np.log(3.0)
    assert common[:3] == pytest.approx(ERRORS.law * FORCES[:, 2] * (about - below))
    assert common[3:] == pytest.approx(ERRORS.law * 3.0 * FORCES[:, 2] * (about + above))


def test_errors_scale_with_the_forces():
    """A gel that is twice as stiff has twice the errors: growth has no unit."""
    np.testing.assert_allclose(fields(2.0 * FORCES), 2.0 * fields(), atol=1e-12)


def test_errors_are_shares_of_forces_as_large_as_the_measured_ones():
    """A gel that is simulated twice too stiff has no larger errors, or it would be a cheap explanation."""
    np.testing.assert_allclose(fields(2.0 * FORCES, real=0.5), fields(), atol=1e-12)
    np.testing.assert_allclose(fields(real=3.0), 3.0 * fields(), atol=1e-12)


def test_free_air_has_no_error():
    """Nor does a frame without contact change the typical force of the others."""
    forces, tips = np.vstack([FORCES[:2], np.zeros(3), FORCES[2:]]), np.vstack([TIPS[:2], np.zeros(3), TIPS[2:]])
    found = fields(forces, tips=tips, lean=np.insert(LEAN, 2, 0.3))
    assert not found[2].any()
    np.testing.assert_allclose(found[[0, 1, 3]], fields(), atol=1e-12)
    assert not fields(np.zeros((3, 3))).any()


def test_a_contact_that_hardly_begins_changes_no_error():
    """A frame with a force of rounding errors has no part in the typical force of the others."""
    forces, tips = np.vstack([FORCES[:2], [0.0, 0.0, 1e-17], FORCES[2:]]), np.vstack([TIPS[:2], np.zeros(3), TIPS[2:]])
    found = fields(forces, tips=tips, lean=np.insert(LEAN, 2, 0.3))
    np.testing.assert_allclose(found[[0, 1, 3]], fields(), atol=1e-12)


def test_a_pull_after_hardly_any_load_is_an_error_of_its_own_size():
    """A sensor that mixes components shows pulls; they take off no more than all of the load before them."""
    pull = [1e-3, 0.0, -1e-3]
    forces = np.vstack([[0.0, 0.0, 1e-18], pull, FORCES])
    tips = np.vstack([np.zeros((2, 3)), TIPS])
    found = fields(forces, tips=tips, lean=np.concatenate([[0.3, 0.3], LEAN]))
    assert np.abs(found[1]).max() <= np.linalg.norm(pull)


def test_erred_wrenches_are_the_sum_of_all_errors():
    """Beside the simulated ones, whose unknown components stay unknown."""
    names, owner = ("ball", "bar"), np.repeat([0, 1], 3)
    simulated = at_tips(np.vstack([FORCES, 3.0 * FORCES]), np.vstack([TIPS, TIPS]))
    frames = ErrorFrames(
        ERRORS, simulated.copy(), poses(np.vstack([TIPS, TIPS]), np.tile(LEAN, 2)), names, owner, np.array([0, 3])
    )
    friction = np.full(6, FRICTION)
    wrenches = frames.wrenches(simulated, friction)
    errors = np.random.default_rng(0).normal(size=wrenches.shape[2])
    np.testing.assert_allclose(frames.erred(simulated, friction, errors), simulated + wrenches @ errors, atol=1e-12)
    simulated[:, 5] = np.nan
    assert np.isnan(frames.erred(simulated, friction, errors)[:, 5]).all()
    assert np.isfinite(frames.erred(simulated, friction, errors)[:, :5]).all()


@pytest.mark.parametrize("indenter", ["ball", ""])
@pytest.mark.parametrize("family", FAMILIES)
def test_a_size_multiplies_the_errors_of_its_family_and_indenter(family, indenter):
    """It multiplies no other error: neither of another family, nor of another indenter, nor one that all share."""
    sized = ERRORS.with_sizes({(family, indenter): 2.5})
    larger, before = fields(errors=sized), fields()
    listed = error_list(ERRORS, ("ball",))
    assert any(error.family == family for error in listed)
    for number, error in enumerate(listed):
        factor = 2.5 if (error.family, error.indenter) == (family, indenter) else 1.0
        np.testing.assert_allclose(larger[:, :, number], factor * before[:, :, number], atol=1e-15)
        (scaled,) = error_list(sized, ("ball",))[number : number + 1]
        assert scaled.deviation == pytest.approx(factor * error.deviation)
