"""The check of a manifest against its schema, which is not repeated for the same bytes."""

import json

import pytest

from tactiledata.errors import SchemaError, StoreError
from tactiledata.store.layout import manifest as manifests
from tactiledata.store.layout.manifest import (
    CHECKED_ENTRIES,
    empty_manifest,
    need_manifest_schema,
    parse_manifest,
    read_manifest,
    write_manifest,
)
from tactiledata.store.layout.places import Settings


@pytest.fixture(autouse=True)
def nothing_remembered():
    """No test finds what another one has left behind."""
    manifests._need_schema.cache_clear()


@pytest.fixture
def checks(monkeypatch):
    """The numbers of sources of all manifests that were held against the schema, in order."""
    seen, check_document = [], manifests.check_document

    def counted(document, schema, where):
        seen.append(len(document["sources"]))
        return check_document(document, schema, where)

    monkeypatch.setattr(manifests, "check_document", counted)
    return seen


def sound(**changed):
    """The manifest of an empty store, with changed fields."""
    return {**empty_manifest(Settings()), **changed}


def test_a_manifest_that_changes_is_checked_again(tmp_path, checks):
    """In one process, the same file is checked once; after a change it is checked again, and a wrong one is refused."""
    write_manifest(tmp_path, sound())
    assert read_manifest(tmp_path)["cameras"] == read_manifest(tmp_path)["cameras"] == {}
    assert checks == [0]
    write_manifest(tmp_path, sound(sources="none"))
    with pytest.raises(StoreError, match="sources") as told:
        read_manifest(tmp_path)
    assert told.value.expected == "a manifest that fits schemas/store.json"
    assert "copy of the store" in told.value.remedy  # `check` says the same, and cannot look further
    assert len(checks) == 2
    write_manifest(tmp_path, sound())
    assert read_manifest(tmp_path)["sources"] == []


def test_a_wrong_manifest_is_refused_every_time(tmp_path, checks):
    """A refusal is not remembered as a pass: each opening of a wrong manifest ends in the error."""
    write_manifest(tmp_path, sound(rows=[]))
    for _ in range(3):
        with pytest.raises(StoreError, match="rows"):
            read_manifest(tmp_path)
    assert len(checks) == 3


def test_the_same_wrong_bytes_elsewhere_are_refused_by_their_own_name(tmp_path):
    """Two files with the same wrong bytes are each named by their own error, and by its facts."""
    content = json.dumps(sound(sources="none")).encode()
    for place in ("first/manifest.json", "second/manifest.json"):
        with pytest.raises(StoreError, match=f"^{place} does not fit schema 'store'") as told:
            parse_manifest(content, place)
        assert told.value.facts["file"] == place


def test_the_same_sound_bytes_elsewhere_are_not_checked_again(tmp_path, checks):
    """A copy of a store opens without another check."""
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        write_manifest(tmp_path / name, sound())
        assert read_manifest(tmp_path / name)["sources"] == []
    assert checks == [0]


def test_all_sources_are_checked_when_asked_for(checks):
    """An opening checks the first hundred sources, a check of the store all of them; neither counts as the other."""
    many = sound(sources=[f"{number:064x}" for number in range(CHECKED_ENTRIES)] + ["wrong"])
    content = json.dumps(many).encode()
    with pytest.raises(SchemaError, match=rf"sources\[{CHECKED_ENTRIES}\]"):
        need_manifest_schema(many)
    assert checks == [CHECKED_ENTRIES + 1]
    parse_manifest(content, "manifest.json")
    with pytest.raises(SchemaError):
        need_manifest_schema(many)
    assert checks == [CHECKED_ENTRIES + 1, CHECKED_ENTRIES, CHECKED_ENTRIES + 1]


def test_what_is_returned_may_be_changed(tmp_path):
    """A manifest that a caller changes in memory is not what the next reader of the same file gets."""
    write_manifest(tmp_path, sound())
    read_manifest(tmp_path)["sources"] = "none"
    assert read_manifest(tmp_path)["sources"] == []
