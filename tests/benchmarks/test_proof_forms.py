"""Tests of how the likeness of hidden effects with the catalogue is counted and printed."""

from proof_forms import print_tables


def case(name, own, is_named, other=0.5, signal=20.0):
    """A case whose own effect has a cosine."""
    return {
        "case": f"{name}0123456789", "generator": "layer", "mismatch": 1.0, "hidden": "relaxation",
        "effect": "relaxation", "signal": signal, "absorbed": 0.9, "own": own, "is_named": is_named,
        "cosines": {"relaxation": own, "lag": other} if own >= other else {"lag": other, "relaxation": own},
    }  # fmt: skip


def test_named_effects_are_counted_by_ranges_of_the_cosine(capsys):
    """A cosine on an end of a range belongs to the range above it, and 1 to the last one."""
    cases = [case("a", 0.1, False, signal=40.0), case("b", 0.3, True), case("c", 0.6, True), case("d", 1.0, False)]
    print_tables(cases)
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["0", "to", "0.3", "0", "of", "1", "40"] in lines
    assert ["0.3", "to", "0.6", "1", "of", "1", "20"] in lines
    assert ["0.6", "to", "1", "1", "of", "2", "20"] in lines
    shown = [line[0][0] for line in lines if line and line[0].endswith("0123456")]
    assert shown == ["d", "c", "b", "a"]
    assert ["a0123456", "layer", "1", "relaxation", "40", "0.90", "0.10", "lag", "0.50", "-"] in lines


def test_a_range_without_cases_has_no_median(capsys):
    """No case in a range: a dash, and nothing fails."""
    print_tables([case("a", 0.9, True)])
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["0", "to", "0.3", "0", "of", "0", "-"] in lines
