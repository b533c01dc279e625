"""Missing physics named in touches of a rig that none of the simulations is; nulls first."""

import dataclasses

import numpy as np
import pytest
from touch_worlds import PLANTS, START, base, null, world_cases

import tactiledata
from tactiledata.contract.schema import load_schema
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.naming.identifiability import identifiability_of, nuisance
from tactiledata.diagnose.naming.joint_fit import joint_fit
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.signatures import effect_signatures
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.touches.simulation_errors import NumericalErrors
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.nuisance.numerical import SHAPE_ERROR

pytestmark = pytest.mark.slow

FEW = ("arm_compliance", "thickness", "relaxation", "lag", "rate_friction", "frame_rotation")


@pytest.fixture(scope="module")
def quiet():
    return null(3000, trajectories=24)


def answer(cases, effects=FEW, **options):
    return Answer(name_effects(cases, START, NamingOptions(effects=effects, profile=False, **options)))


def test_nothing_is_missing_where_only_the_contact_law_differs(quiet):
    """A null whose simulation is off by some per cent, with jitter and coloured noise, is given no name."""
    found = answer(quiet)
    assert found.naming.decision.verdict == "nothing found"
    assert found.names == ()
    assert found.sentences[0].startswith("Nothing found")


def test_relaxation_is_named_and_the_fix_can_be_used():
    """A power law is named relaxation, E and mu are what they are without it, and the settings are a simulator's."""
    found = answer(world_cases(PLANTS["relaxation"], 0, trajectories=24), pairs=False)
    assert "relaxation" in found.candidates
    assert found.is_missing
    effects = found.document["effects"]
    assert effects["effects"][0]["effect"] in found.candidates
    assert ("relaxation" in found.names) == ("E is then that of the gel once relaxed." in found.sentences)
    without = answer(null(0, 24), ("relaxation",), pairs=False).naming.intervals_before
    for place in (0, 2):
        fits = (found.naming.intervals_before, found.naming.intervals)
        before, after = (fit[place].value - without[place].value for fit in fits)
        assert abs(before) > 0.02 * without[place].value
        assert abs(after) < 0.4 * abs(before)


def test_one_odd_touch_takes_no_name_away():
    """Relaxation is named though the shear of one touch of 24 is lost, and that touch is said to be looked at."""
    cases = world_cases(PLANTS["relaxation"], 0, trajectories=24)
    lost = cases.touches[6].measured * [0.2, 0.2, 1.0, 1.0, 1.0, 1.0]
    listed = [*cases.touches[:6], dataclasses.replace(cases.touches[6], measured=lost), *cases.touches[7:]]
    found = answer(TouchSet(listed, base), ("relaxation", "lag"), pairs=False)
    assert found.names == ("relaxation",)
    (odd,) = found.naming.odd
    assert (odd.name, odd.unknown) == ("D-6", "factor on shear")
    assert odd.factor < 0.6
    assert any(sentence.startswith("Look at D-6: the factor on shear") for sentence in found.sentences)


def test_a_relaxation_that_grows_during_the_session_is_only_like_one():
    """Half as strong at first and half as strong again in the end: found as planted, said, and not named."""
    grows = dataclasses.replace(PLANTS["relaxation"], growth=0.5)
    found = answer(world_cases(grows, 0), ("relaxation", "lag"), pairs=False)
    (relaxation,) = [one for one in found.naming.scored if one.names == ("relaxation",)]
    assert relaxation.trend.share == pytest.approx(0.5, abs=3 * relaxation.trend.error)
    assert relaxation.trend.error < 0.15
    assert found.names == ()
    assert found.is_missing
    assert any("something else behaves like it" in sentence for sentence in found.sentences)


def test_a_preview_is_taken_to_err_more():
    """Errors of finite strain are those that claims were set with; linear gels differ more from shape to shape."""
    fine, preview = NumericalErrors.of("finite-strain"), NumericalErrors.of("linear")
    assert fine == NumericalErrors()
    assert preview.shape == SHAPE_ERROR["linear"] > fine.shape
    assert preview.law > fine.law


def test_the_document_fits_its_schema(quiet):
    """Both answers fit the part of the schema that is theirs, as JSON."""
    import json

    import jsonschema

    schema = load_schema("diagnosis")
    part = {"$ref": "#/$defs/naming", "$defs": schema["$defs"]}
    for cases in (quiet, world_cases(PLANTS["lag"], 0, trajectories=24)):
        jsonschema.validate(json.loads(json.dumps(answer(cases, ("lag", "thickness")).document)), part)


def test_a_world_without_the_true_effect_is_given_no_wrong_name():
    """Ripples along the gel are in no catalogue: what relaxation and lag offer is not taken for them."""
    found = answer(world_cases(dataclasses.replace(PLANTS["relaxation"], relaxing=0.0, ripple=0.15), 1, 24))
    assert found.naming.decision.verdict == "not explained"
    assert found.is_missing


def test_the_joint_fit_returns_what_the_same_simulator_played(quiet):
    """Without noise and with the same formulas, E, nu, mu, the strength and all offsets come back.

    As near as the scatter of 1 % lets them that any simulated force is taken to have.
    """
    truth, share = dataclasses.replace(START, youngs_modulus=0.95e6, friction=0.7), 0.1
    offsets = np.random.default_rng(0).normal(0, 2e-5, len(quiet.touches))
    wrench = quiet.play(truth, [EffectSetting("relaxation", {"share": share, "time": 2.0})], offsets)
    parts = np.split(wrench, np.cumsum(quiet.counts)[:-1])
    sharp = [dataclasses.replace(case.noise, covariance=case.noise.covariance * 1e-6) for case in quiet.touches]
    played = TouchSet(
        [dataclasses.replace(c, measured=w, noise=n) for c, w, n in zip(quiet.touches, parts, sharp, strict=True)], base
    )
    white = WhitenedTouches.of(played)
    guess = EffectSetting("relaxation", {"share": 0.05, "time": 1.0})
    start = joint_model(START, [guess], len(offsets), len(white.simulation_errors))
    errors = range(len(start.vector) - len(start.errors), len(start.vector))
    fit = joint_fit(white, start, held=errors, rounds=12)
    assert fit.model.settings[0].values["share"] == pytest.approx(share, rel=0.02)
    assert fit.model.settings[0].values["time"] == pytest.approx(2.0, rel=0.15)
    assert fit.model.material.youngs_modulus == pytest.approx(0.95e6, rel=0.01)
    assert fit.model.material.poisson_ratio == pytest.approx(START.poisson_ratio, abs=0.005)
    assert fit.model.material.friction == pytest.approx(0.7, rel=0.01)
    # their prior of 40 um draws them towards 0, most where a touch is shallow
    assert np.abs(fit.model.offsets - offsets).max() < 6e-6
    assert np.abs(fit.model.offsets - offsets).mean() < 1.5e-6


def test_gain_along_z_is_hidden_and_a_turned_frame_is_not(quiet):
    """E takes a gain of z; nothing takes a turn of the frame; a turn and its cross-talk are near one another."""
    white = WhitenedTouches.of(quiet)
    signatures = effect_signatures(white, START, ("gain_crosstalk", "frame_rotation", "thickness"))
    known = identifiability_of(nuisance(white, START), signatures, DEFAULT_THRESHOLDS)
    hidden = dict(zip(zip(known.effects, known.strengths, strict=True), known.concealment, strict=True))
    assert hidden["gain_crosstalk", "zz"] > 0.9
    assert hidden["thickness", "error"] > 0.9
    assert hidden["frame_rotation", "tilt_x"] < 0.2
    names = list(zip(known.effects, known.strengths, strict=True))
    turn, leak = names.index(("frame_rotation", "tilt_y")), names.index(("gain_crosstalk", "xz"))
    assert abs(known.confusability[turn, leak]) > 0.8
    assert np.allclose(np.diag(known.confusability), 1.0)


def test_identifiability_is_public_and_needs_no_data(quiet):
    """Wrenches that were never measured serve as well, and a clean ball's adhesion is said not to show."""
    blank = TouchSet(
        [dataclasses.replace(case, measured=np.zeros((len(case.touch), 6))) for case in quiet.touches], base
    )
    known = tactiledata.identifiability(blank, START, ("adhesion", "relaxation", "cable_drag"))
    assert "adhesion" in known.undetectable
    assert "relaxation" not in known.undetectable
    assert known.not_told == ("cable_drag",)


def test_too_little_is_refused(quiet):
    """Few trajectories, few frames and arrays that do not fit say what is wanted."""
    with pytest.raises(TactileDataError, match="at least 8"):
        answer(TouchSet(quiet.touches[:5], base))
    with pytest.raises(UsageError, match="measured wrenches of shape"):
        dataclasses.replace(quiet.touches[0], measured=np.zeros((3, 6)))


LIKE_A_SOLVER = ("arm_compliance", "thickness")
"""Planted effects that errors of the simulation of two per cent resemble: under balls alone they cannot be told."""

PLAIN = ("relaxation", "rate_friction", "frame_rotation", "lag")
"""Planted effects that 24 trajectories suffice to name."""


NIGHTLY = ("thickness", "relaxation", "gain_crosstalk")
"""Planted effects of the night: they take longest, and relaxation is named by another test, too."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.nightly) if name in NIGHTLY else name for name in PLANTS]
)
def test_planted_effects_are_named_or_in_the_set(name):
    """Each planted effect, in formulas of the rig's own, with the whole catalogue to choose from; none gets another."""
    trajectories = 24 if name in PLAIN else 30
    found = answer(world_cases(PLANTS[name], 0, trajectories), effects=None)
    nearest = found.naming.decision.best
    assert nearest is not None
    if name in LIKE_A_SOLVER:
        assert set(found.candidates) <= {name}
    else:
        assert name in (*found.candidates, *nearest.names)


@pytest.mark.nightly
def test_nulls_are_seldom_named():
    """A name is given to none of 7 nulls.

    Where 2 of 10 nulls are given one, it shows with a probability of 79 %; where 3 are, with 92 %.
    """
    assert [seed for seed in range(7) if answer(null(2000 + seed, 24), effects=None).is_missing] == []
