"""How far a long piece of work is, as it is told to whoever watches."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """A function that is called again and again while work goes on.

    Parameters
    ----------
    done : int
        Pieces of work that are done.
    total : int
        All pieces, as far as is known.
    what : str
        What is done now, in a few words; empty where the work has one step only.
    """

    def __call__(self, done: int, total: int, what: str = "", /) -> None:
        """Take notice of the progress."""


def no_progress(done: int, total: int, what: str = "") -> None:
    """Take no notice of the progress: the default where nobody watches.

    Parameters
    ----------
    done, total, what
        As `Progress` describes them; none is used.
    """


def following(progress: Progress, finished: int) -> Progress:
    """Return the progress of further work whose counts go on from those of earlier work.

    Parameters
    ----------
    progress : Progress
        Is called with the counts of both.
    finished : int
        Pieces of the earlier work.
    """

    def follow(done: int, total: int, what: str = "", /) -> None:
        progress(finished + done, finished + total, what)

    return follow
