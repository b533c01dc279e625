"""The time that is left of a long command, from the time that it has taken."""

from types import SimpleNamespace

import pytest

from tactiledata.cli import output
from tactiledata.cli.output import progress, time_left


@pytest.mark.parametrize(
    ("done", "total", "seconds", "said"),
    [
        (10, 40, 60.0, ", about 3 min left"),
        (1, 3, 30.0, ", about 1 min left"),
        (1, 2, 59.0, ""),
        (40, 40, 600.0, ""),
        (0, 40, 600.0, ""),
        (1, 481, 4.0, ""),
        (24, 481, 96.0, ""),
        (25, 481, 96.0, ", about 29 min left"),
    ],
)
def test_the_time_left_is_in_proportion_to_the_steps_left(done, total, seconds, said):
    """A quarter done in a minute leaves three; nothing is said below a minute, at the end, before 25 of 481."""
    assert time_left(done, total, seconds) == said


def test_another_part_of_the_work_counts_its_own_time(monkeypatch, capsys):
    """Long plays do not make the cases after them seem long; steps that were kept from before take no time."""
    moments = iter([0.0, 3000.0, 3000.0, 3060.0, 3100.0, 3160.0])
    monkeypatch.setattr(output, "time", SimpleNamespace(monotonic=lambda: next(moments)))
    with progress("proving") as report:
        report(9, 10, "plays")
        report(0, 20, "cases")
        report(2, 20, "cases")
        report(40, 50, "pages")
        report(45, 50, "pages")
    assert capsys.readouterr().err.splitlines() == [
        "proving: 9/10 plays, about 6 min left",
        "proving: 0/20 cases",
        "proving: 2/20 cases, about 9 min left",
        "proving: 40/50 pages",
        "proving: 45/50 pages, about 1 min left",
    ]
