"""A second diagnosis in the same folder: nothing of the first stays that the second does not say."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from tactiledata.contract.own_files import is_ours, marked_yaml
from tactiledata.diagnose.answer import documents
from tactiledata.diagnose.answer.earlier_files import EFFECTS, NEXT, remove_earlier, trial_files

MARKED = '{"provenance": {"tool": "tactiledata"}}'


@pytest.fixture
def folder(tmp_path):
    """The folder of a diagnosis that claimed effects and proposed two trials; a file of a user is in it."""
    (tmp_path / NEXT).mkdir()
    (tmp_path / EFFECTS).write_text(MARKED)
    for name in ("hold.yaml", "slides.yaml"):
        (tmp_path / NEXT / name).write_bytes(marked_yaml("sensors: {}\n", "diagnose"))
    (tmp_path / NEXT / "mine.yaml").write_text("sensors: {}\n")
    return tmp_path


def test_what_the_new_one_does_not_write_is_removed(folder):
    """Effects and scenarios go, those that are written anew stay until then, and files of others stay for good."""
    assert is_ours(folder / NEXT / "hold.yaml")
    assert {"hold.yaml", "slides.yaml"} < set(trial_files())
    remove_earlier(folder, [folder / NEXT / "hold.yaml"])
    assert not (folder / EFFECTS).exists()
    assert {path.name for path in (folder / NEXT).iterdir()} == {"hold.yaml", "mine.yaml"}
    remove_earlier(folder, [])
    assert [path.name for path in (folder / NEXT).iterdir()] == ["mine.yaml"]


def test_effects_and_scenarios_of_others_stay(folder):
    """Negative control: what carries no mark is nobody's to remove; an empty folder is no fault."""
    (folder / EFFECTS).write_text('{"mine": 1}')
    (folder / NEXT / "hold.yaml").write_text("sensors: {}\n")
    remove_earlier(folder, [])
    assert (folder / EFFECTS).is_file()
    assert (folder / NEXT / "hold.yaml").is_file()
    remove_earlier(folder / "nowhere", [])


def test_an_old_claim_never_stands_beside_a_new_page(folder, monkeypatch):
    """Whenever a file is written, also where the call ends there, effects that are not claimed are gone already."""
    seen: list[tuple[str, bool]] = []

    def note(path: Path, content: object) -> None:
        seen.append((path.name, (folder / EFFECTS).exists()))

    monkeypatch.setattr(documents, "effects_file", lambda done, document: None)
    monkeypatch.setattr(documents, "naming_page", lambda *given, **named: "page")
    for name in ("_further", "_sensor_sentences", "other_steps_section"):
        monkeypatch.setattr(documents, name, lambda *given: [])
    for name in ("write_atomic", "write_json_atomic"):
        monkeypatch.setattr(documents, name, note)
    played = SimpleNamespace(start=None)
    done = SimpleNamespace(naming=None, shown=SimpleNamespace(located=None), simulated=None, played=played, stated=())
    proposal = {"trial": "slides", "title": "Slide", "scenario": {"sensors": {}}}
    document = {
        "next_trials": {"proposals": [proposal]},
        "source": {"groups": 1, "rows": 1},
        "notes": [],
    }
    written = documents.write_store_diagnosis(folder, "x", done, document)
    assert seen == [("slides.yaml", False), ("report.html", False), ("diagnosis.json", False)]
    assert [path.name for path in written] == ["report.html", "diagnosis.json", "slides.yaml"]
    assert not (folder / NEXT / "hold.yaml").exists()
