"""What is shown on unseen data: nothing where nothing is missing, the way to the noise where something is."""

import asyncio
import dataclasses
import json

import jsonschema
import numpy as np
import pytest
from browser import BROWSER
from page_laws import faults_of
from touch_worlds import FORCE_NOISE, PLANTS, START, base, null, world_cases

from tactiledata.contract.schema import load_schema
from tactiledata.diagnose.answer.documents import naming_document
from tactiledata.diagnose.answer.naming_page import naming_page, naming_sentences
from tactiledata.diagnose.answer.other_steps import StatedMaterial, material_of_calibration, other_steps_section
from tactiledata.diagnose.answer.unseen_page import comparison_sections, doubts, same_digits, shown_sentences
from tactiledata.diagnose.naming.held_out import folds_of
from tactiledata.diagnose.naming.joint_fit import joint_fit
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.unseen.compare import show
from tactiledata.diagnose.unseen.errors import held_out_errors, held_out_wrenches
from tactiledata.gel.elasticity.material import GelMaterial

pytestmark = pytest.mark.slow

FEW = NamingOptions(effects=("relaxation", "thickness"), profile=False, pairs=False)


def diagnosed(cases):
    naming = name_effects(cases, START, FEW)
    return naming, show(naming)


@pytest.fixture(scope="module")
def nothing():
    return diagnosed(null(3000, trajectories=24))


@pytest.fixture(scope="module")
def relaxed():
    return diagnosed(world_cases(dataclasses.replace(PLANTS["relaxation"], relaxing=0.25), 1, trajectories=32))


def test_where_nothing_is_missing_nothing_is_shown(nothing):
    """No effect, no gap: the plain simulation is as good as the noise, and the nearest candidate would do no harm."""
    _, shown = nothing
    assert shown.names == ()
    assert shown.left_over is None
    assert shown.flattened is None
    for errors in shown.errors:
        assert errors.force.before == pytest.approx(errors.force.floor, rel=0.05)
        assert abs(errors.change) < 0.03
    assert not any("gap" in sentence for sentence in shown_sentences(shown))


def test_a_planted_effect_closes_the_gap(relaxed):
    """The effect closes the gap on unseen trajectories and indenters, certainly, and nothing speaks against it."""
    _, shown = relaxed
    assert shown.names == ("relaxation",)
    assert [one.unseen for one in shown.errors] == ["trajectories", "indenters"]
    for errors in shown.errors:
        assert errors.has_gap
        assert errors.force.closed > 0.6
        assert errors.force.interval[0] > 0.3
        assert errors.paper[1] < errors.paper[0]
    assert shown.errors[0].force.floor == pytest.approx(FORCE_NOISE, rel=0.1)
    said = shown_sentences(shown)
    assert said[0].startswith("On held-out trajectories the force error falls from ")
    assert said[1].startswith("On 4 held-out indenters, each in turn predicted from the others, the error falls from ")
    assert not any("speaks against" in sentence for sentence in said)
    assert shown.ceiling_force <= shown.errors[0].force.before


def test_what_was_sloped_is_flat(relaxed):
    """The strongest dependence of the plain simulation is certain, and with the effect it is gone."""
    _, shown = relaxed
    before, after = shown.flattened
    assert before.p <= 0.05 < after.p
    assert abs(after.change.value) < 0.5 * abs(before.change.value)


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no browser")
def test_a_real_browser_shows_it(relaxed, tmp_path):
    """The page of a store keeps the laws of all pages, light and dark, on a desk and on a phone."""
    pytest.importorskip("aiohttp")
    pytest.importorskip("axe_core_python")
    naming, shown = relaxed
    place = tmp_path / "report.html"
    place.write_text(naming_page("Diagnosis", naming, shown.located, shown, [("Dwell", "a.yaml")], ["2 frames"], "0"))
    faults, _ = asyncio.run(faults_of({"diagnosis": place}, tmp_path / "profile"))
    assert faults == []


@pytest.mark.parametrize("which", ["nothing", "relaxed"])
def test_document_and_page_say_it(which, request):
    """A document fits its schema; a page begins with picture, three sentences and the next trial; the rest folds."""
    naming, shown = request.getfixturevalue(which)
    document = json.loads(json.dumps(naming_document(naming, shown.located, shown), allow_nan=False))
    schema = load_schema("diagnosis")
    for part, value in document.items():
        if value is not None:
            jsonschema.validate(value, {**schema["properties"][part], "$defs": schema["$defs"]})
    closed = [errors["force"]["closed"] for errors in document["shown"]["held_out"]]
    assert all(share is None for share in closed) if which == "nothing" else min(closed) > 0.5
    trials = [("Dwell for 60 s", "trials/dwell.yaml")]
    calibrated = material_of_calibration(
        {
            "youngs_modulus": 9.7e5, "poisson_ratio": 0.46, "friction": 0.6, "bounds": {"name": "paper"},
            "losses": {"vector": {"start": 9.0, "fitted": 2.13, "held_out": None}}, "fidelity": "linear",
            "trajectories": {"fitted": ["a", "b"], "held_out": [], "left_out": {}, "frames": 20},
        },
        "calibration.json",
    )  # fmt: skip
    by_hand = StatedMaterial("mesh soft", GelMaterial(5e5, 0.47, 0.7), "by hand")
    steps = other_steps_section(naming, START, [by_hand, calibrated])
    html = naming_page(
        "Diagnosis", naming, shown.located, shown, trials, ["2 frames without a pose"], "seed 0", other_steps=steps
    )
    titles = ("All in words", "Where they differ", "What is missing", "How the simulation behaves",
              "E, nu and mu of other steps", "How much better", "What could be seen at all",
              "What was left out")  # fmt: skip
    claim = document["naming"]["sentences"][0]
    opened, _, folded = html.partition("<details>")
    # values of other steps stand beside the fitted ones, and each is held against the interval of the plain fit
    assert "E of mesh soft, 500 kPa, lies outside the 95 % interval of the plain fit, " in folded
    assert "<td>calibration</td><td>970</td><td>0.460</td><td>0.600</td>" in folded
    assert "calibration.json: fitted to 2 trajectories inside bounds (paper), linear" in folded
    assert "E of calibration, 970 kPa, lies outside the 95 % interval" in folded
    assert folded.count("times the noise. That is no measure of the fit here") == 1
    assert "The calibration leaves 2.1 times the noise." in folded
    plain = f"<td>this diagnosis, plain</td><td>{naming.base.model.material.youngs_modulus / 1e3:.0f}</td>"
    assert plain in folded
    assert ("<td>this diagnosis, with viscoelastic relaxation</td>" in folded) == (which == "relaxed")
    begin = [
        "</h1>",
        "<figure>",
        f"<p>{claim[:40]}",
        "<p>On held-out ",
        ">What to record next</h2>",
        "trials/dwell.yaml",
    ]
    for text, places in (
        (opened, [opened.index(mark) for mark in begin]),
        (folded, [folded.index(f"<summary><h2>{title}</h2></summary>") for title in titles]),
    ):
        assert places == sorted(places), text[:200]
    assert opened.count("<p>") == 3
    # what readings show by themselves comes after a name, and before "nothing is named"
    drift = "The zero drifts."
    told = naming_page("Diagnosis", naming, shown.located, shown, [], [], "", first=[drift]).partition("<details>")[0]
    assert (told.index(claim[:40]) < told.index(drift)) == (which == "relaxed")
    assert html.count("<details>") == html.count("</details>") == html.count("<summary>")
    parts = ("Where", "How", "How much better") if which == "relaxed" else ("Where", "How much better")
    words = folded.split("</details>")[0]
    places = [words.index(text) for text in (claim[:40], *(f"<p>{part}: " for part in parts))]
    assert places == sorted(places)
    assert ("(solid)" in opened) == (which == "relaxed")
    assert "nan" not in html.split("base64")[0]
    assert "simulated recordings" not in html.lower()


def test_touches_that_keep_what_is_left_are_drawn_even_where_others_have_larger_errors(nothing):
    """The page says to look at two touches, so it shows them."""
    naming, shown = nothing
    names = [case.name or str(number) for number, case in enumerate(naming.whitened.touch_set.touches)]
    small = shown.worst(len(names))[-2:]
    left = RemainingStructure(DEFAULT_THRESHOLDS.structure_dispersion + 0.2, 1.0, tuple(names[one] for one in small))
    odd = dataclasses.replace(naming, decision=dataclasses.replace(naming.decision, left=left))
    drawn = [
        [
            section
            for section in comparison_sections(one, shown.located, shown)
            if "single trajectories" in section.title
        ]
        for one in (naming, odd)
    ]
    (plain,), (with_both,) = drawn
    assert "hold nearly all" not in str(plain.pictures)
    assert f"{names[small[0]]} and {names[small[1]]} hold nearly all that the best fit leaves." in str(
        with_both.pictures
    )
    for name in left.worst_two:
        assert f"{name}, " in str(with_both.pictures)
        assert f"{name}, " not in str(plain.pictures)


def test_the_same_simulation_tells_what_it_has_not_seen():
    """Without noise, and with formulas of its own, every trajectory follows from the others but for its offset."""
    quiet = null(3000, trajectories=24)
    offsets = np.random.default_rng(0).normal(0, 2e-5, len(quiet.touches))
    truth = dataclasses.replace(START, youngs_modulus=0.95e6, friction=0.7)
    parts = np.split(quiet.play(truth, [], offsets), np.cumsum(quiet.counts)[:-1])
    sharp = [dataclasses.replace(case.noise, covariance=case.noise.covariance * 1e-4) for case in quiet.touches]
    cases = TouchSet(
        [dataclasses.replace(c, measured=w, noise=n) for c, w, n in zip(quiet.touches, parts, sharp, strict=True)], base
    )
    white = WhitenedTouches.of(cases)
    fit = joint_fit(white, joint_model(START, [], len(offsets), len(white.simulation_errors)), rounds=12)
    for groups in (folds_of(len(offsets)), white.indenter):
        told = held_out_wrenches(white, fit, groups)
        error = np.sqrt(((told - white.measured)[:, :3] ** 2).mean())
        assert error < 0.01 * np.sqrt((white.measured[:, :3] ** 2).mean())


def test_sensors_are_held_out_where_there_are_two():
    """Each in its turn; a fit beside itself changes nothing."""
    one = null(3000, trajectories=16)
    cases = [
        dataclasses.replace(case, touch=dataclasses.replace(case.touch, sensor=f"D{number % 2}"))
        for number, case in enumerate(one.touches)
    ]
    white = WhitenedTouches.of(TouchSet(cases, base))
    fit = joint_fit(white, joint_model(START, [], len(cases), len(white.simulation_errors)))
    found = held_out_errors(white, (fit, fit), 0)
    assert [(errors.unseen, errors.groups) for errors in found] == [
        ("trajectories", 16), ("indenters", 4), ("sensors", 2)
    ]  # fmt: skip
    assert all(errors.change == 0.0 for errors in found)


def test_whitened_rows_return_as_newtons():
    """Whitening loses nothing: what is marginalised in a trajectory is put back."""
    white = WhitenedTouches.of(null(3000, trajectories=8))
    assert not np.allclose(white.in_newtons(white.whiten(white.measured)), white.measured, atol=1e-3)
    returned = white.in_newtons(white.with_own(white.whiten(white.measured)))
    assert np.allclose(returned, white.measured, atol=1e-9)


def test_numbers_beside_one_another_have_the_same_digits():
    """Both numbers get as many decimals as the smaller one needs."""
    assert same_digits(0.2134, 0.0931) == ("0.213", "0.093")
    assert same_digits(12.34, 3.21) == ("12.3", "3.2")
    assert same_digits(0.0, 0.0) == ("0.0", "0.0")


def test_doubts_stand_beside_the_claim(relaxed):
    """None of a claim that helps on all that is unseen and leaves nothing; of one that leaves structure, at once."""
    naming, shown = relaxed
    assert doubts(dataclasses.replace(shown, left_over=None)) == []
    left = dataclasses.replace(shown, left_over=shown.located)
    assert naming_sentences(naming, left.located, left)[1] == "Take this claim with care: structure is left."


def test_a_rise_on_two_indenters_counts_where_trajectories_agree_on_it(relaxed):
    """Each of two is told by the other alone: only an interval below nothing makes a rise news."""
    _, shown = relaxed
    (indenters,) = (one for one in shown.errors if one.unseen == "indenters")
    gap = dataclasses.replace(indenters.force, after=1.1 * indenters.force.before, closed=-0.4)
    for interval, said in (((-0.7, -0.1), True), ((-0.7, 0.2), False)):
        worse = dataclasses.replace(indenters, groups=2, force=dataclasses.replace(gap, interval=interval))
        found = doubts(dataclasses.replace(shown, errors=[worse]))
        assert any("rises on held-out indenters" in sentence for sentence in found) is said
