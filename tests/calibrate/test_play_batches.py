"""Batches are begun longest first and answered in the order in which they were asked for."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from small_plays import PAD, press

from tactiledata.calibrate.plays.play_batches import effort_of, play_batches
from tactiledata.calibrate.plays.player import PlayBatch, play_at
from tactiledata.contract.progress import following
from tactiledata.contract.worker_pool import worker_died
from tactiledata.diagnose.touches.variant_plays import VariantBatch
from tactiledata.effects.touch.response import GelVariant

BEGUN = []


@dataclass(frozen=True)
class NamedBatch:
    """A batch of as many plays as it has touches, each its name and number."""

    words: str
    effort: float
    touches: tuple[int, ...]

    @property
    def paths(self):
        return [Path("/nowhere") / f"{self.words}{touch}" for touch in self.touches]

    def play(self):
        BEGUN.append(self.words)
        return [f"{self.words}{touch}" for touch in self.touches]


def test_the_longest_begin_first_and_answers_keep_the_order_asked_for():
    """Three batches of which the last takes longest: it begins, counts for most, and the plays come back as asked."""
    BEGUN.clear()
    told = []
    batches = [NamedBatch("a", 2.0, (0, 1)), NamedBatch("b", 1.0, (0,)), NamedBatch("c", 9.0, (0, 1, 2))]
    plays = play_batches(batches, None, lambda *news: told.append(news))
    assert BEGUN == ["c", "a", "b"]
    assert plays == [["a0", "a1"], ["b0"], ["c0", "c1", "c2"]]
    assert [news for news in told if news[2:]] == [(4, 6, "c"), (5, 6, "a"), (6, 6, "b")]


@dataclass(frozen=True)
class CountedBatch(NamedBatch):
    """A batch that counts how often the files of its touches are asked for."""

    asked: list[int] = field(default_factory=list)

    @property
    def paths(self):
        self.asked.append(1)
        return super().paths


def test_the_files_of_a_batch_are_asked_for_once_however_many_touches_it_has():
    """They are digests: asked for with each touch, they would take the square of the number of touches."""
    batch = CountedBatch("a", 1.0, tuple(range(50)))
    play_batches([batch])
    assert len(batch.asked) == 1


def test_nothing_to_play_is_answered_with_nothing():
    """No batch, no play, no error."""
    assert play_batches([]) == []


def test_finite_strain_and_nearly_incompressible_gels_take_longer():
    """A frame counts 1 by the linear engine, 15 at finite strain, and more where nu is near 0.5."""
    touches = [press(0).touch]
    frames = len(touches[0].poses)
    assert effort_of(touches, True, 0.49) == frames
    assert effort_of(touches, False, 0.46) == 15 * frames
    assert effort_of(touches, False, 0.4925) > 40 * frames


def test_counts_of_further_work_go_on_from_the_work_before():
    """Two of three further pieces after seven are nine of ten."""
    told = []
    following(lambda *news: told.append(news), 7)(2, 3, "last")
    assert told == [(9, 10, "last")]


@pytest.mark.slow
def test_touches_at_their_own_offsets_are_dealt_out_and_come_back_in_order(tmp_path, monkeypatch):
    """Five touches in parts of at most two: each has the forces that it has in one batch of all."""
    touches, offsets = [press(number) for number in range(5)], 1e-5 * np.arange(5)
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "one"))
    shifted = tuple(touch.deeper(float(offset)) for touch, offset in zip(touches, offsets, strict=True))
    together = PlayBatch(PAD, "linear", 0.46, 0.7, shifted).play()
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "parts"))
    in_parts = play_at(PAD, "linear", touches, 0.46, 0.7, offsets, most_together=2)
    loads = [float(np.nanmax(play.wrench[:, 2])) for play in together]
    assert len(set(loads)) == 5
    for one, other in zip(together, in_parts, strict=True):
        np.testing.assert_array_equal(one.wrench, other.wrench)
        np.testing.assert_array_equal(one.area, other.area)


def test_a_batch_says_what_it_plays_where_its_worker_dies():
    """The error names touches, nu and mu, or the change; not the vertices of a pad."""
    touches = (press(0).touch, press(1).touch)
    nominal = PlayBatch(PAD, "linear", 0.46, 0.7, touches)
    moved = VariantBatch(PAD, "linear", 0.46, 0.7, GelVariant(), touches)
    assert "at plays of 2 touches at nu 0.460, mu 0.70" in str(worker_died(nominal))
    assert "at plays of 2 touches, moved along the gel" in str(worker_died(moved))
