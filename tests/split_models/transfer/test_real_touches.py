"""Real touches survive the transfer: contacts and backgrounds that nothing was trained on, and what must fail."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from split_models.transfer.latent_transfer import load_image_vae
from split_models.transfer.method_choice import KEEPING, LEARNED, TouchSample, choose_method, kept_by
from split_models.transfer.methods import BUNDLED_MODEL, transfer_method
from split_models.transfer.pixels.relight_change import light_ratio, noise_of, relit_change, without_noise
from tactiledata.scoring.kept_touches import KeptTouch, kept_touch, touch_findings
from tactiledata.sensors.backgrounds import load_background
from tactiledata.sensors.same_sensor import is_same_sensor

ROOT = Path(__file__).resolve().parents[3]
DATA = ROOT / "tests" / "data"
TARGETS = ("digit-bg-1", "digit-bg-16")
"""Backgrounds that neither the rule of `relit` was chosen on nor the bundled model learned from."""
STRENGTH = (0.85, 1.15)


@pytest.fixture(scope="module")
def bench():
    """The benchmark that prints the tables of real contacts."""
    spec = importlib.util.spec_from_file_location("bench", ROOT / "benchmarks" / "transfer_real_contacts.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.UNSEEN == TARGETS
    return module


@pytest.fixture(scope="module")
def samples(bench):
    """Two real DIGIT contacts and three real GelSight presses, with their sensors' pictures without contact."""
    digit, background = bench.digit_contacts(DATA / "digit_contact")
    presses, untouched = bench.gelsight_presses(DATA / "gelsight_r15" / "dataPack.npz")
    return [TouchSample("DIGIT", digit, background), TouchSample("GelSight", presses[[5, 21, 41]], untouched)]


@pytest.fixture(scope="module")
def default(samples):
    """The method that a user gets who names none."""
    return choose_method(None, None, samples).method


@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
def test_the_default_keeps_real_touches(default, samples, target):
    """Strength is 0.85 to 1.15, correlation at least 0.9, mask overlap at least 0.75, on targets never trained on."""
    for kept in kept_by(default, samples, load_background(target)):
        assert kept.frames
        assert STRENGTH[0] <= kept.strength <= STRENGTH[1], kept
        assert kept.correlation >= 0.9, kept
        assert kept.overlap >= 0.75, kept


def test_relit_itself_is_not_the_remedy_of_relit():
    """Where relit keeps no touch, the warning proposes to look, and not the method that was just used."""
    lost = [KeptTouch("D20001", 4, 0.1, 0.0, 0.5)]
    (other,) = touch_findings(lost, "reinhard", "T")
    (same,) = touch_findings(lost, "relit", "T")
    assert "`--method relit` keeps them" in other.message
    assert "--method relit" not in same.message
    assert "compare the pictures before and after" in same.message


@pytest.mark.slow
@pytest.mark.parametrize("name", ["no_contact", "latent_on_background", "adain"])
def test_methods_that_lose_real_touches_are_found(samples, name):
    """Negative control: the same measure finds that these methods do not keep the touch, and warns."""
    kept = kept_by(transfer_method(name), samples, load_background(TARGETS[0]))
    assert not any(one.is_kept for one in kept)
    assert {finding.code for finding in touch_findings(kept, name, "T")} == {"touch-not-kept"}
    assert len(list(touch_findings(kept, name, "T"))) == len(samples)


def test_no_warning_where_touches_are_kept(default, samples):
    """Negative control of the warning: the default gives none."""
    kept = kept_by(default, samples, load_background(TARGETS[0]))
    assert list(touch_findings(kept, default.name, "T")) == []


@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
def test_outside_the_contact_the_default_is_the_target(bench, default, samples, target):
    """Outside the contact the error is at most that of the plain swap and one grey level, and style is no worse."""
    goal = load_background(target)
    for sample in samples:
        contacts = (sample.pictures, sample.background)
        ours, swap = (bench.values(one, contacts, goal, True) for one in (default, transfer_method("background_swap")))
        outside, style = (bench.COLUMNS.index(name) for name in ("outside", "style"))
        assert (ours[outside] <= swap[outside] + 1.0).all()
        assert ours[style].mean() <= swap[style].mean()


def test_style_is_that_of_each_picture_beside_its_own_piece_of_the_target(bench, samples):
    """Pictures that are the target have its style to the last digit, however different their contacts are."""
    presses = next(sample for sample in samples if sample.sensor == "GelSight")
    method = transfer_method("no_contact")
    found = bench.values(method, (presses.pictures, presses.background), load_background(TARGETS[0]), True)
    assert found[bench.COLUMNS.index("style")].tolist() == [0.0] * len(presses.pictures)


def test_the_model_is_not_trusted_with_touches_that_it_does_not_draw(samples):
    """The bundled model draws less than 0.8 of real touches: arithmetic has no part, and the sentence names them."""
    choice = choose_method(None, None, samples)
    assert choice.method.name == KEEPING
    assert not any(kept.is_kept for kept in choice.drawn)
    assert "DIGIT" in choice.reason
    assert "GelSight" in choice.reason


def test_a_model_that_draws_the_touches_has_a_part(samples, monkeypatch):
    """Negative control of the choice: where decoding gives the touches back, arithmetic takes part."""

    def perfect(sensor, pictures, background, recorded, recorded_background):
        return kept_touch(sensor, recorded, recorded_background, recorded, recorded_background)

    monkeypatch.setattr("split_models.transfer.method_choice.kept_touch", perfect)
    choice = choose_method(None, None, samples)
    assert choice.method.name == LEARNED
    assert [kept.is_kept for kept in choice.drawn] == [True, True]


def test_without_a_touch_to_measure_no_model_is_trusted(samples):
    """No samples, or samples without a touch: the keeping method is taken, and said."""
    untouched = TouchSample("bare", samples[0].background[None], samples[0].background)
    for given in ([], [untouched]):
        choice = choose_method(None, None, given)
        assert choice.method.name == KEEPING
        assert choice.reason
    assert kept_by(choice.method, [untouched], load_background(TARGETS[0]))[0].frames == 0


def test_real_contacts_are_held_out_of_training(samples):
    """The bundled model learned from no sensor of these contacts, and from none of the targets."""
    vae, _, _ = load_image_vae(BUNDLED_MODEL)
    assert vae.learned_from
    held_out = [sample.background for sample in samples] + [load_background(name) for name in TARGETS]
    for picture in held_out:
        assert not [name for name, known in vae.learned_from if is_same_sensor(known, picture)]
    known = load_background("digit-bg-5")  # negative control: the model did learn from this one
    assert [name for name, picture in vae.learned_from if is_same_sensor(picture, known)]


# -- the parts of `relit` ----------------------------------------------------------------------------------------------


def test_noise_goes_and_edges_stay():
    """Noise of 2 grey levels on a square with a sharp edge: the noise falls to less than half, the edge stays sharp."""
    rng = np.random.default_rng(1)
    true = np.zeros((160, 120, 3), np.float32)
    true[50:110, 30:90] = 60.0
    noisy = true + rng.normal(0.0, 2.0, true.shape).astype(np.float32)
    clean = without_noise(noisy)
    far = np.zeros(true.shape[:2], bool)
    far[:40] = True
    assert clean[far].std() < 0.5 * noisy[far].std()
    assert np.abs(clean - true)[45:55, 60].max() < 8.0
    assert noise_of(noisy) == pytest.approx(2.0, rel=0.35)


def test_a_change_without_noise_stays_to_the_bit():
    """A plane has no second differences in both directions, and is returned as it is."""
    plane = np.broadcast_to(np.linspace(0, 50, 160, dtype=np.float32)[:, None, None], (160, 120, 3)).copy()
    np.testing.assert_array_equal(without_noise(plane), plane)


def test_light_goes_by_place_and_channel():
    """Twice the light on one half of the target doubles its share of the touch there, within the smooth border."""
    source, target = np.full((160, 120, 3), 80.0, np.float32), np.full((160, 120, 3), 80.0, np.float32)
    target[:80, :, 0] = 160.0
    ratio = light_ratio(source, target)
    assert ratio[10, 60] == pytest.approx([192 / 112, 1.0, 1.0], rel=1e-3)
    assert ratio[150, 60] == pytest.approx([1.0, 1.0, 1.0], rel=1e-3)


def test_a_dark_target_does_not_swallow_the_touch():
    """On a target of a quarter of the light the touch keeps 0.92 of its strength, as the span says."""
    change = np.zeros((1, 160, 120, 3), np.float32)
    change[0, 60:100, 40:80] = 40.0
    source, target = np.full((160, 120, 3), 120.0, np.float32), np.full((160, 120, 3), 30.0, np.float32)
    relit = relit_change(change, source, target)
    assert np.linalg.norm(relit) / np.linalg.norm(change) == pytest.approx(0.92, abs=0.01)
