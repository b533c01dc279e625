"""Finished plays are counted one by one, while whoever plays them is busy."""

import threading
from functools import partial
from types import SimpleNamespace
from typing import ClassVar

import numpy as np

from tactiledata.calibrate.plan import Node
from tactiledata.calibrate.plays import play_batches, player
from tactiledata.calibrate.plays.kept_plays import play_path
from tactiledata.calibrate.plays.play_progress import PlayProgress

SECONDS = 10.0


class Solid:
    """A shape that counts how often its mesh is made."""

    document: ClassVar = {"shape": "sphere"}

    def __init__(self):
        self.made = 0

    def mesh(self):
        self.made += 1
        return SimpleNamespace(vertices=np.zeros((3, 3)), faces=np.zeros((1, 3), int))


class Touch:
    """A touch of two frames, at a height of its own."""

    def __init__(self, height, indenter=None):
        self.indenter = indenter or Solid()
        self.poses = np.full((2, 4, 4), height)

    def deeper(self, offset):
        return Touch(self.poses[0, 0, 0] + offset, self.indenter)


def test_plays_of_one_indenter_share_its_mesh():
    """Six plays of three touches: the mesh is made once, and every play has a file of its own."""
    solid = Solid()
    touches = [Touch(0.1 * number, solid) for number in range(3)]
    paths = {play_path(touch, "ab" * 32, "linear", ratio, 0.5) for touch in touches for ratio in (0.45, 0.46)}
    assert solid.made == 1
    assert len(paths) == 6


def test_touches_of_a_batch_are_counted_before_it_ends(tmp_path, monkeypatch):
    """Two touches at two offsets are one batch of four plays: the count is of plays, and moves after each of them."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path))
    counts, news, in_time = [], threading.Condition(), []

    def report(done, total, what=""):
        with news:
            counts.append((done, total))
            news.notify_all()

    class Engine:
        surface = SimpleNamespace(patch_areas=np.ones(1))

        def play(self, touches, material, keep):
            for place in range(len(touches)):
                yield (
                    place,
                    SimpleNamespace(wrench=np.zeros((2, 6)), status=np.zeros(2, np.int8), pressed=np.ones((2, 1))),
                )
                with news:
                    in_time.append(news.wait_for(lambda place=place: (place + 1, 4) in counts, SECONDS))

    monkeypatch.setattr(player, "make_engine", lambda *_: Engine())
    monkeypatch.setattr(play_batches, "PlayProgress", partial(PlayProgress, interval=0.01))
    nodes = [Node(0.45, 0.5, 0.0), Node(0.45, 0.5, 1e-4)]
    mesh = SimpleNamespace(digest="ab" * 32)
    found = player.play_nodes(mesh, "linear", [Touch(0.0), Touch(1.0)], nodes, None, report)
    assert [len(plays) for plays in found.values()] == [2, 2]
    assert in_time == [True] * 4
    assert counts[0] == (0, 4)
    assert [done for done, _ in counts] == sorted(done for done, _ in counts)


def test_each_file_that_appears_is_reported(tmp_path):
    """Five plays of one batch move the count five times before the batch ends; kept ones count from the start."""
    paths = [tmp_path / f"{number}.npz" for number in range(6)]
    paths[0].touch()
    counts, seen = [], threading.Condition()

    def report(done, total, what=""):
        with seen:
            counts.append((done, total))
            seen.notify_all()

    with PlayProgress(paths, report, interval=0.01):
        for number, path in enumerate(paths[1:], start=2):
            path.touch()
            with seen:
                assert seen.wait_for(lambda number=number: (number, 6) in counts, SECONDS)
    assert counts == sorted(counts)


def test_plays_that_take_longer_count_for_more(tmp_path):
    """Two plays that take eight times as long as the other eight are two thirds of the work, and of the count."""
    paths = [tmp_path / f"{number}.npz" for number in range(10)]
    counts, seen = [], threading.Condition()

    def report(done, total, what=""):
        with seen:
            counts.append((done, total))
            seen.notify_all()

    efforts = [8.0, 8.0] + [1.0] * 8
    with PlayProgress(paths, report, efforts, interval=0.01) as progress:
        for finished, expected in ((1, 3), (2, 6), (6, 8), (9, 9), (10, 10)):
            for path in paths[:finished]:
                path.touch()
            with seen:
                assert seen.wait_for(lambda expected=expected: (expected, 10) in counts, SECONDS), counts
        progress.finished(10, "all")
    assert counts == sorted(counts)
    alone = []
    with PlayProgress(
        [tmp_path / "none" / str(k) for k in range(10)], lambda *news: alone.append(news), efforts
    ) as slow:
        slow.finished(2, "long")
        slow.finished(10, "short")
    assert alone == [(0, 10), (6, 10, "long"), (10, 10, "short")]
    idle = []
    with PlayProgress([tmp_path / "none"] * 2, lambda *news: idle.append(news), [0.0, 0.0]) as nothing:
        nothing.finished(2, "of no length")
    assert idle == [(0, 2), (2, 2, "of no length")]


def test_without_a_cache_batches_move_the_count(tmp_path):
    """Where no file can be kept, the end of a batch is reported, and never less than before."""
    counts = []
    with PlayProgress([tmp_path / "none" / str(k) for k in range(6)], lambda *news: counts.append(news)) as progress:
        progress.finished(3, "first")
        progress.finished(6, "second")
    assert counts == [(0, 6), (3, 6, "first"), (6, 6, "second")]
