"""The table of all ensembles on the page of the proof."""

from proof_table import CHOSEN, PAGE, RULES, rows, slug, summed, table, with_table

SECTION = """## A third: x, y
`tactiledata prove --out a --generators layer,analytic --plans wedge-5 --nulls 2`, commit 1a2b3c4d, 2026-11-27. Words.
```text
false alarms on nulls   at most 5 %  1 of 8  0 to 32 %  missed so far
visible effects named   at least 80 %  4 of 16  10 to 50 %  missed
```
"""


def test_the_page_has_the_counts_that_were_printed():
    """The table on the page is the one that its sections give."""
    page = PAGE.read_text()
    assert table(page) in page
    assert with_table(page) == page


def test_a_row_has_what_a_section_printed():
    """Options, commit and counts of a section; a count that was not printed is a dash."""
    (row,) = rows(SECTION)
    assert row[0] == "[A third: x, y](#a-third-x-y)"
    assert row[1:] == ("layer, analytic", "wedge-5", "1a2b3c4d", "2026-11-27", "1 of 8", "-", "4 of 16")


def test_counts_of_chosen_effects_are_marked():
    """Effects that a command chose are no sample of all; worlds without effects hide none of them."""
    (row,) = rows(SECTION.replace("--nulls 2", "--nulls 2 --effects lag"))
    assert row[5:] == ("1 of 8", "-", f"4 of 16{CHOSEN}")


def test_a_section_without_a_score_has_no_row():
    """A run that was stopped before its score does not count."""
    assert rows(SECTION.partition("```")[0]) == []


def test_ensembles_of_one_set_of_rules_are_summed():
    """Rows from the first with a set of rules up to the next set; dashes count for nothing, nor do older rows."""
    row = ("layer", "wedge-5", "1a2b3c4d", "2026-11-27")
    newest, before, *_ = RULES
    found = [
        (f"[{newest}: w](#w)", *row, "0 of 2", "-", "1 of 2"),
        ("[A third](#a)", *row, "1 of 8", "-", "4 of 16"),
        ("[A fourth](#d)", *row, "0 of 1", f"1 of 1{CHOSEN}", f"1 of 1{CHOSEN}"),
        (f"[{before}: x](#b)", *row, "0 of 4", "2 of 9", "5 of 6"),
        ("[An old](#c)", *row, "3 of 3", "3 of 3", "0 of 3"),
    ]
    sums = {name: counts for name, *_, nulls, wrong, visible in summed(found) if (counts := (nulls, wrong, visible))}
    assert list(sums) == [f"**the ensemble with {RULES[newest]}**", f"**the 3 ensembles with {RULES[before]}**"]
    assert list(sums.values()) == [("0 of 2", "0 of 0", "1 of 2"), ("1 of 13", "2 of 9", "9 of 22")]
    assert len(summed(found[1:])) == 1
    assert summed(found[4:]) == []


def test_a_table_is_replaced_and_nothing_else():
    """An old row goes; the words before the table and the sections after it stay."""
    page = f"# Proof\n\n## All ensembles\nWords.\n\n| old |\n| --- |\n\n{SECTION}"
    changed = with_table(page)
    assert "| old |" not in changed
    assert "Words." in changed
    assert changed.endswith(SECTION)
    assert changed.count("1 of 8 |") == 1


def test_an_anchor_has_no_signs():
    """Commas, colons and points fall away; blanks become hyphens."""
    assert slug("A sixth: 0.1 and 0.01 N") == "a-sixth-01-and-001-n"
