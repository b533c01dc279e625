"""The check of a manifest against its schema, which is not repeated for the same bytes of the same file."""

import json

import pytest

from tactiledata.errors import StoreError
from tactiledata.store.layout import manifest as manifests
from tactiledata.store.layout.manifest import empty_manifest, parse_manifest, read_manifest, write_manifest
from tactiledata.store.layout.places import MANIFEST, Settings


@pytest.fixture(autouse=True)
def nothing_remembered():
    """No test finds what another one has left behind."""
    manifests._check.cache_clear()


@pytest.fixture
def checks(monkeypatch):
    """The files of all manifests that were held against the schema, in order."""
    seen, check_document = [], manifests.check_document

    def counted(document, schema, where):
        seen.append(where)
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
    assert checks == [str(tmp_path / MANIFEST)]
    write_manifest(tmp_path, sound(sources="none"))
    with pytest.raises(StoreError, match="sources") as told:
        read_manifest(tmp_path)
    assert told.value.expected == "a manifest that fits schemas/store.json"
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


def test_the_same_bytes_elsewhere_are_checked_under_their_own_name(checks):
    """Two files with the same wrong bytes are each named by their own error."""
    content = json.dumps(sound(sources="none")).encode()
    for place in ("first/manifest.json", "second/manifest.json"):
        with pytest.raises(StoreError, match=place):
            parse_manifest(content, place)
    assert checks == ["first/manifest.json", "second/manifest.json"]


def test_what_is_returned_may_be_changed(tmp_path):
    """A manifest that a caller changes in memory is not what the next reader of the same file gets."""
    write_manifest(tmp_path, sound())
    read_manifest(tmp_path)["sources"] = "none"
    assert read_manifest(tmp_path)["sources"] == []
