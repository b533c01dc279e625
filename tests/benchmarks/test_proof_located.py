"""Where locators say that sealed worlds differ: how their words are counted."""

from proof_located import print_tables


def case(kind, hidden, told, by_chance=0.25, is_structured=True, generator="layer"):
    """What was located in a case."""
    return {
        "kind": kind, "hidden": hidden, "told": told, "by_chance": by_chance, "is_structured": is_structured,
        "is_right": hidden == "lag" and "loading rate" in told, "generator": generator,
    }  # fmt: skip


def test_right_words_are_counted_beside_what_chance_would_give(capsys):
    """Of two lags one is located; chance would locate half of one; a null without structure is counted as such."""
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
