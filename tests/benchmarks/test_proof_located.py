"""Tests of how the findings of locators on sealed worlds are counted and printed."""

import numpy as np
import pytest
from proof_located import print_errors, print_tables


def case(kind, hidden, told, by_chance=0.25, is_structured=True, generator="layer"):
    """What was located in a case."""
    return {
        "kind": kind, "hidden": hidden, "told": told, "by_chance": by_chance, "is_structured": is_structured,
        "is_right": hidden == "lag" and "loading rate" in told, "generator": generator,
    }  # fmt: skip


def test_right_words_are_counted_beside_what_chance_would_give(capsys):
    """The table counts worlds whose place is right, the number expected by chance, and nulls with any finding."""
    print_tables([
        case("visible", "lag", ["indenter", "loading rate"]),
        case("visible", "lag", ["indenter"]),
        case("nulls", "nothing", [], is_structured=False),
        case("nulls", "nothing", ["depth"]),
        case("nulls", "nothing", [], is_structured=False, generator="analytic"),
    ])  # fmt: skip
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["layer", "lag", "loading", "rate", "2", "0.25"] in lines
    assert ["layer", "lag", "-", "1", "0.25"] in lines
    assert ["layer", "2", "of", "2", "1", "of", "2", "0.5", "1", "of", "2"] in lines
    assert ["analytic", "0", "of", "0", "0", "of", "0", "0.0", "0", "of", "1"] in lines


def test_errors_of_a_simulation_are_those_of_nine_of_ten_worlds(capsys):
    """Contrasts scatter by 0 in nine worlds and by 3 in one, beyond noise of 1: the median is 0, the most is 3."""
    rng = np.random.default_rng(0)
    quiet = [{"E": (rng.normal(size=400) * 0.5, np.ones(400))} for _ in range(19)]
    loud = {"E": (rng.normal(size=4000) * np.sqrt(10.0), np.ones(4000))}
    print_errors([*quiet, loud])
    row = next(line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("E "))
    assert row[1:3] == ["0", "0"]
    assert float(row[3]) == pytest.approx(3.0, abs=0.15)
