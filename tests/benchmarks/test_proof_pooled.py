"""Targets over several sealed proofs."""

import json
import re
from dataclasses import replace
from pathlib import Path

import proof_pooled
import pytest
from proof_pooled import PAGES, TOLD_ALIKE, written_anew
from sealed_proofs import REQUEST, answered_proof

from tactiledata.contract.atomic import write_json_atomic
from tactiledata.effects import EFFECTS
from tactiledata.prove.cases.kinds import OUTSIDE, VISIBLE
from tactiledata.prove.cases.truth import OUTSIDE as OUTSIDE_EFFECTS
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.seal.folder import FORMAT
from tactiledata.prove.seal.published import opened_proof
from tactiledata.prove.seal.verify import verify

ROOT = Path(__file__).parents[2]
MACHINE = re.compile(r"\d+ cores, |numpy")
"""Lines that tell the machine and its packages."""


@pytest.fixture
def printed(tmp_path, monkeypatch, capsys):
    """Two proofs of six nulls and six effects with one miss each; the command of the second chose the effects."""
    paths, picture = [tmp_path / "first", tmp_path / "chosen"], tmp_path / "named.png"
    for path in paths:
        answered_proof(path)
    request = replace(REQUEST, only=("lag",)).document
    write_json_atomic(paths[1] / "proof.json", {"format": FORMAT, "request": request})
    monkeypatch.setattr("sys.argv", ["proof_pooled.py", *map(str, paths), "--picture", str(picture)])
    proof_pooled.main()
    assert picture.stat().st_size > 5000
    return [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]


def test_cases_of_all_proofs_are_counted_together(printed):
    """Nulls are those of both, effects those of the proof whose command chose none; what has no case has no row."""
    (nulls,) = [line for line in printed if line.startswith("false alarms")]
    (visible,) = [line for line in printed if line.startswith("visible")]
    assert "0 of 12 0 to 24 %" in nulls
    # Wilson's interval of five of six
    assert "5 of 6 44 to 97 %" in visible
    assert not any(line.startswith("both of a pair") for line in printed)


def test_each_clause_of_the_claim_has_its_counts(printed):
    """The counts of the one generator are those of all; a clause without a case has none."""
    generator = REQUEST.generators[0]
    start = printed.index(f"{generator} all target")
    rows = printed[start + 2 : start + 2 + len(proof_pooled.CLAUSES)]
    assert rows[:2] == [
        "a name where nothing is missing 0 of 12 0 of 12 at most 5 %",
        "says what was left out 5 of 6 5 of 6 at least 80 %",
    ]
    assert rows[-1] == "says it where it is concealed 0 of 0 0 of 0 at least 70 %"


def test_every_proof_is_told_with_its_root(printed, tmp_path):
    """A reader has to be able to look for the root that was published."""
    for name, taken in (("first", "12 of 12"), ("chosen", "6 of 12")):
        root = json.loads((tmp_path / name / "seal.json").read_text())["root"][:8]
        (row,) = [line for line in printed if line.startswith(f"{name} ")]
        assert row.endswith(f"{root} {taken}")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_have_what_their_commands_print(page):
    """Every command of a page that names archives has below it what it prints today; only the machine may differ."""
    text = page.read_text()
    again = written_anew(text)
    assert [line for line in again.splitlines() if not MACHINE.match(line)] == [
        line for line in text.splitlines() if not MACHINE.match(line)
    ]


def test_what_is_printed_takes_the_place_of_what_stood_there():
    """The block below the command and the clauses by themselves change; other blocks and words stay."""
    archive = sorted((ROOT / "docs" / "proofs").glob("*.zip"))[0].relative_to(ROOT)
    clauses, other = "```text\n    all target\n--- ---\nold\n```", "```text\nother\n```"
    command = f"`python benchmarks/proof_pooled.py {archive} --picture x.png`, words"
    page = f"{clauses}\nwords\n{command}\n```text\nold\n```\n{other}\n"
    again = written_anew(page)
    assert "old" not in again
    assert again.count("a wrong name") == 2
    assert again.count("false alarms on nulls") == 1
    assert again.endswith(f"```\n{other}\n")
    assert written_anew(again) == again
    assert written_anew(f"{clauses}\nno command\n") == f"{clauses}\nno command\n"


@pytest.mark.parametrize("archive", sorted((ROOT / "docs" / "proofs").glob("*.zip")), ids=lambda path: path.stem)
def test_published_proofs_fit_the_roots_that_were_published(archive):
    """Hashes and score of each archive fit, and its root stands on the page of ensembles."""
    with opened_proof(archive) as folder:
        found = verify(folder)
        assert verify(folder, found.root).faults == ()
    assert found.cases == found.answers > 0
    assert found.root in (ROOT / "docs" / "proof-ensembles.md").read_text()


def test_effects_are_counted_by_their_signal(printed):
    """All six have a signal of 20."""
    assert "20 to 40 5 of 6 5 of 6" in printed


def test_a_range_without_an_end_is_told_in_words():
    """The last range of signals has no end."""
    share = {"right": 2, "count": 3}
    score = {"strength": [{"signal": [80.0, None], "named": share, "named_or_in_set": share}]}
    assert proof_pooled.strength_rows(score) == [("80 and more", "2 of 3", "2 of 3")]


def test_an_interval_that_is_not_known_is_a_dash():
    """A bootstrap over fewer than three configurations gives none."""
    target = {"what": "a", "target": "b", "right": 1, "count": 2, "is_met": True, "is_certain": True}
    (row,) = proof_pooled.target_rows({"targets": [{**target, "interval": [0.1, 0.9], "over_configurations": None}]})
    assert row[3:5] == ("10 to 90 %", "-")


def answered(kind, hidden, names):
    """A case that hides an effect, and an answer with these names."""
    label = {"kind": kind, "hidden": [{"effect": hidden}], "truth": [] if kind == OUTSIDE else [hidden], "sight": {}}
    answer = {"verdict": "partly explained" if names else "not explained", "names": names, "set": names, "zeros": []}
    return ScoredCase("a1", label, answer, 1.0)


@pytest.mark.parametrize(
    ("kind", "hidden", "names", "row"),
    [
        (OUTSIDE, "drainage", ["relaxation"], "1 of 1"),
        (OUTSIDE, "drainage", ["lag"], "0 of 1"),
        (OUTSIDE, "anisotropy", ["soft_region"], "0 of 1"),
        # no name, and an effect of the catalogue: there is nothing to tell of
        (OUTSIDE, "drainage", [], None),
        (VISIBLE, "lag", ["relaxation"], None),
    ],
)
def test_wrong_names_that_the_answer_tells_of_are_counted(kind, hidden, names, row):
    """Water that drains is called relaxation, and that answer says so; of another name it says nothing."""
    assert [found for _, found in proof_pooled.outside_row([answered(kind, hidden, names)])] == [row] * bool(row)


def test_what_is_told_alike_is_outside_the_catalogue_and_told():
    """Each such effect is none of the catalogue, and the effect whose name it gets has words for it."""
    assert set(TOLD_ALIKE) <= set(OUTSIDE_EFFECTS)
    assert all(EFFECTS[name].unlisted_look_alike for name in TOLD_ALIKE.values())
