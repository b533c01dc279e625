"""Finished plays are counted one by one, while whoever plays them is busy."""

import threading

from tactiledata.calibrate.play_progress import PlayProgress

SECONDS = 10.0


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


def test_without_a_cache_batches_move_the_count(tmp_path):
    """Where no file can be kept, the end of a batch is reported, and never less than before."""
    counts = []
    with PlayProgress([tmp_path / "none" / str(k) for k in range(6)], lambda *news: counts.append(news)) as progress:
        progress.finished(3, "first")
        progress.finished(6, "second")
    assert counts == [(0, 6), (3, 6, "first"), (6, 6, "second")]
