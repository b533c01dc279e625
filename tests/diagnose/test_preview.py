"""What a few touches show is told while the others are played: once, early, and only where there are others."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactiledata.calibrate.plays.learned_plays import FEWEST_EXAMPLES, example_touches
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose import store
from tactiledata.diagnose.answer import sentences
from tactiledata.errors import TactileDataError
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere


def drawn(count):
    """Touches of one ball along a line, each a little deeper."""
    touches = []
    for number in range(count):
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[:, 0, 3] = 1e-4 * number
        poses[1, 2, 3] = -3e-4 - 1e-6 * number
        touch = GelTouch(Sphere(3e-3), poses)
        touches.append(MeasuredTouch(f"u{number}", "", "s", "ball", touch, np.zeros((2, 6)), np.arange(2.0), 40.0))
    return tuple(touches)


@pytest.fixture
def preview(monkeypatch):
    """Tells a preview of so many drawn touches; returns what was told, and which touches were played."""

    def tell(count, failing=None):
        asked, told = [], []

        def play(opened, calibration, progress, only=None, estimates="learned", runner=None):
            assert runner == "workers"
            asked.append((only, estimates))
            if failing:
                raise failing
            return only

        monkeypatch.setattr(store, "read_measured", lambda *_: SimpleNamespace(touches=drawn(count)))
        monkeypatch.setattr(store, "store_touches", play)
        monkeypatch.setattr(store, "preview_words", lambda named, of: f"{len(named)} of {of}")
        store._preview(None, None, None, lambda played: played, told.append, "workers")
        return told, asked

    return tell


def test_a_preview_is_of_the_touches_from_which_the_others_are_learned(preview):
    """A preview of 60 touches plays the eight examples and no others, and leaves to later what it can estimate."""
    told, ((only, estimates),) = preview(60)
    assert told == ["8 of 60"]
    assert estimates == "rough"
    assert only == [f"u{place}" for place in example_touches([touch.touch for touch in drawn(60)])]


def test_few_touches_have_no_preview(preview):
    """Nothing is told and nothing played beforehand where all touches are examples."""
    assert preview(2 * FEWEST_EXAMPLES - 1) == ([], [])


def test_a_preview_that_fails_says_so_and_stops_nothing(preview):
    """Too few of the examples may be usable; the diagnosis goes on."""
    told, _ = preview(60, TactileDataError("7 trajectories can be diagnosed", "at least 8"))
    assert told == ["There is no preview: 7 trajectories can be diagnosed."]


def test_its_words_are_the_plain_fit_and_the_answer(monkeypatch):
    """E in kPa, nu and mu, and the first sentence of the answer; how many touches of how many."""
    monkeypatch.setattr(sentences, "Answer", lambda naming: SimpleNamespace(what=["Nothing was found.", "More."]))
    naming = SimpleNamespace(
        base=SimpleNamespace(model=SimpleNamespace(material=GelMaterial(0.9123e6, 0.4721, 0.655))),
        whitened=SimpleNamespace(touch_set=SimpleNamespace(touches=[None] * 10)),
    )
    assert sentences.preview_words(naming, 60) == (
        "Preview, from 10 of 60 trajectories: E 912 kPa, nu 0.472 and mu 0.655. Nothing was found."
    )
