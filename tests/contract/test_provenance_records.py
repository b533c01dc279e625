"""Equal values have equal digests, others have others; files are known by their names and contents."""

import hashlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract.provenance import digest_of, file_digest, files_digest, json_bytes, provenance

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
).filter(lambda value: "\ud800" not in repr(value))


@given(VALUES)
def test_canonical_json_is_json(value):
    """It parses back to the value, and its own parse gives the same bytes again."""
    once = json_bytes(value)
    assert json.loads(once) == value
    assert json_bytes(json.loads(once)) == once


@given(st.dictionaries(st.text(), st.integers(), min_size=2), st.randoms())
def test_the_order_of_keys_does_not_matter(value, random):
    """A mapping that was filled in another order has the same digest."""
    keys = list(value)
    random.shuffle(keys)
    assert digest_of({key: value[key] for key in keys}) == digest_of(value)


@given(VALUES, VALUES)
def test_digests_tell_values_apart(one, other):
    """Digests are equal exactly where the canonical bytes are."""
    assert (digest_of(one) == digest_of(other)) == (json_bytes(one) == json_bytes(other))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), {"a": [float("-inf")]}, {1, 2}, object(), b"x"])
def test_what_json_cannot_say_is_refused(value):
    """NaN, infinity, sets, objects and bytes never enter a digest silently."""
    with pytest.raises((ValueError, TypeError)):
        json_bytes(value)


def test_file_digests(tmp_path):
    """One file: its content alone. Several: names below the root and contents, in any order."""
    (tmp_path / "b").mkdir()
    files = [tmp_path / "a.bin", tmp_path / "b" / "a.bin"]
    for number, path in enumerate(files):
        path.write_bytes(bytes([number]) * 3_000_000)
    assert file_digest(files[0]) == hashlib.sha256(files[0].read_bytes()).hexdigest()
    both = files_digest(tmp_path, files)
    assert files_digest(tmp_path, reversed(files)) == both
    files[0].rename(tmp_path / "c.bin")
    assert files_digest(tmp_path, [tmp_path / "c.bin", files[1]]) != both


def test_contents_that_change_places_are_another_digest(tmp_path):
    """Two files that swap their contents are not the same recording."""
    files = [tmp_path / "a", tmp_path / "b"]
    files[0].write_bytes(b"1")
    files[1].write_bytes(b"2")
    before = files_digest(tmp_path, files)
    files[0].write_bytes(b"2")
    files[1].write_bytes(b"1")
    assert files_digest(tmp_path, files) != before


def test_provenance_holds_no_clock():
    """The same step on the same inputs gives the same record, whatever the order of the inputs."""
    one = provenance("ingest", {"b": "2", "a": "1"}, {"x": 1})
    assert one == provenance("ingest", {"a": "1", "b": "2"}, {"x": 1})
    assert list(one["inputs"]) == ["a", "b"]
    assert one["settings_sha256"] == digest_of({"x": 1})
    assert provenance("ingest", {}, {"x": 2})["settings_sha256"] != one["settings_sha256"]
