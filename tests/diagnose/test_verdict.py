"""One vocabulary of verdicts: code, schema and docs have the same words with the same meanings."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from tactiledata.contract.schema import load_schema
from tactiledata.diagnose.answer.diagnosis import StoreDiagnosis
from tactiledata.diagnose.answer.glossary import FIRST, STORE_TERMS, with_explanations
from tactiledata.diagnose.naming.decide import Decision
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.verdict import MEANINGS, Verdict

PAGE = Path(__file__).resolve().parents[2] / "docs" / "diagnose.md"


def diagnosis(verdict, zeros=(), formula=None, is_left=False):
    """A store's diagnosis whose decision, zeros and formula are given."""
    best = SimpleNamespace(names=("lag",))
    decision = Decision(verdict, best, (), {}, (), RemainingStructure(1.0, 1.0), is_left)
    parts = dict.fromkeys(("store", "options", "played", "shown", "proposals", "limits"))
    naming = SimpleNamespace(decision=decision)
    return StoreDiagnosis(**parts, naming=naming, formula=formula, zeros=list(zeros))


def test_schema_and_page_have_the_words_of_the_code():
    """The schema and the page have each word once, in the order of the code, and with its meaning."""
    schema = load_schema("diagnosis")
    known = schema["$defs"]["verdict"]
    assert known["enum"] == [verdict.value for verdict in Verdict] == [verdict.value for verdict in MEANINGS]
    assert known["description"] == "; ".join(f"{verdict}: {verdict.meaning}" for verdict in Verdict)
    assert schema["properties"]["answer"]["$ref"] == "#/$defs/verdict"
    assert schema["$defs"]["naming"]["properties"]["verdict"]["$ref"] == "#/$defs/verdict"
    rows = re.findall(r"^\| ([a-z, ]+) \| (.+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert [row for row in rows if row[0] in known["enum"]] == [(v.value, v.meaning) for v in Verdict]


@pytest.mark.parametrize("verdict", [v for v in Verdict if "calib" not in v and "structured" not in v])
def test_a_store_has_the_verdict_of_the_known_effects(verdict):
    """Without causes of zeros and without a formula, a store's verdict is that of the known effects."""
    found = diagnosis(verdict)
    assert found.verdict is verdict
    assert found.is_missing == (verdict not in ("nothing found", "below detection"))


def test_zeros_and_formulas_explain_as_well():
    """A cause of the zeros that matters explains where nothing else is found, a formula where no known effect does."""
    cause, formula = SimpleNamespace(matters=True), SimpleNamespace(answer=Verdict.PARTLY_EXPLAINED)
    harmless = diagnosis(Verdict.NOTHING_FOUND, [SimpleNamespace(matters=False)])
    assert harmless.verdict is Verdict.NOTHING_FOUND
    assert not harmless.is_missing
    assert diagnosis(Verdict.NOTHING_FOUND, [cause]).verdict is Verdict.EXPLAINED
    assert diagnosis(Verdict.BELOW_DETECTION, [cause], is_left=True).verdict is Verdict.PARTLY_EXPLAINED
    assert diagnosis(Verdict.NOT_EXPLAINED, [cause]).verdict is Verdict.NOT_EXPLAINED
    assert diagnosis(Verdict.NOT_EXPLAINED, formula=formula).verdict is Verdict.PARTLY_EXPLAINED
    assert diagnosis(Verdict.EXPLAINED, formula=formula).verdict is Verdict.EXPLAINED
    nothing = SimpleNamespace(answer=Verdict.NOTHING_FOUND)
    assert diagnosis(Verdict.NOT_EXPLAINED, formula=nothing).verdict is Verdict.NOT_EXPLAINED


def test_terms_are_explained_once_and_after_the_answer():
    """The first three sentences stay together; a term that returns is not explained again."""
    sentences = [
        "The simulation lacks lag (probability 0.9).",
        "Second.",
        "Third.",
        "E falls (p < 0.001).",
        "E (p = 0.01).",
    ]
    paragraphs = with_explanations(sentences, STORE_TERMS)
    assert [text for kind, text in paragraphs if not kind] == sentences
    page = [text for _, text in paragraphs]
    assert page[:FIRST] == sentences[:FIRST]
    assert [sentence for sentence in page if sentence in sentences] == sentences
    assert [line.split()[0] for line in page if line not in sentences] == ["Probability:", "E", "p"]
    assert with_explanations(["A black box explains nothing."])[1][1].startswith("A black box predicts")
    assert with_explanations(["E falls."]) == [("", "E falls.")]
