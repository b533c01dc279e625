"""Documents from strangers: every fault is a SchemaError with its place, and none exhausts time or memory."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract import schema as schemas
from tactiledata.contract.schema import MAX_DOCUMENT_BYTES, check_document, parse_document, read_document
from tactiledata.errors import MissingFile, SchemaError

GOOD = {"format": "tactiledata-log/1", "sensors": {"D20542": {"model": "digit"}}}
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)


@pytest.mark.parametrize(
    ("document", "path"),
    [
        ({**GOOD, "sensors": {"D20542": {"model": "digit", "shore_00": "soft"}}}, "$.sensors.D20542.shore_00"),
        ({**GOOD, "wrench": {"tare_ns": [1, "two"]}}, "$.wrench.tare_ns[1]"),
        ({**GOOD, "format": "tactiledata-log/2"}, "$.format"),
        ([], "$"),
        (None, "$"),
    ],
)
def test_a_fault_names_its_place(document, path):
    """The error carries the path inside the document and the file, and says both in words."""
    with pytest.raises(SchemaError) as caught:
        check_document(document, "log", "press/log.yaml")
    assert caught.value.facts == {"path": path, "file": "press/log.yaml"}
    assert f"at {path}:" in str(caught.value)
    assert "press/log.yaml" in str(caught.value)


def test_a_text_in_place_of_keys_is_explained():
    """What a schema calls an object is said in words: whoever writes YAML by hand knows keys and values."""
    with pytest.raises(SchemaError, match=r"'x' is not of type 'object', which means keys with values"):
        check_document("x", "log", "log.yaml")


@pytest.mark.parametrize(
    ("document", "schema", "said"),
    [
        ({"topics": {}}, "mapping", "the key 'format' is missing; write format: tactiledata-mapping/1;"),
        (
            {"format": "tactiledata-mapping/1", "topics": {}},
            "mapping",
            "'topics' is not known; expected one of: clock, ",
        ),
        ({**GOOD, "units": {"wrensh": []}}, "log", "'wrensh' is not known (did you mean wrench?); expected one of: j"),
        ({**GOOD, "sensors": {"D20542": {}}}, "log", "at $.sensors.D20542: the key 'model' is missing."),
        ({**GOOD, "units": {"wrench": ["N"]}}, "log", "at $.units.wrench: the list has 1 entry; expected 6."),
        (
            {"format": "tactiledata-mapping/1", "signals": {"wrench": {"topic": "/a", "fields": []}}},
            "mapping",
            "at $.signals.wrench.fields: the list has 0 entries; expected at least 1.",
        ),
    ],
)
def test_a_fault_says_what_is_expected(document, schema, said):
    """Whoever mistypes a key or writes too few units is told which keys there are, and how many units."""
    with pytest.raises(SchemaError) as caught:
        check_document(document, schema, "x.yaml")
    assert said.partition("; expected")[0].rstrip(".;") in caught.value.found
    assert "expected" not in caught.value.found
    assert said.partition("; expected ")[2].rstrip(".") in caught.value.expected


def test_a_document_of_another_kind_is_called_that():
    """Effects in the place of a calibration are no calibration that lacks all its keys."""
    with pytest.raises(SchemaError) as caught:
        check_document({"format": "tactiledata-effects/1", "effects": []}, "calibration", "effects.json")
    assert str(caught.value) == (
        "effects.json is another kind of document: its format is tactiledata-effects/1; expected format "
        "tactiledata-calibration/1. Name another file; docs/calibration.md shows how it is written."
    )
    with pytest.raises(SchemaError, match="does not fit schema"):
        check_document({"format": "tactiledata-nothing/1"}, "calibration", "x.json")


@pytest.mark.parametrize("text", ["{", "a: b: c", "a: [1, 2"])
def test_a_line_that_is_no_yaml_is_named_without_a_name_of_the_library(text):
    """The message has the line and the column, and does not call the file an unknown string."""
    with pytest.raises(SchemaError, match=r"x.yaml is not valid YAML: .* at line \d, column \d") as caught:
        parse_document(text, "x.yaml")
    assert "unicode string" not in str(caught.value)


def test_many_faults_are_counted_and_cut():
    """Five faults are shown, the others counted, and a huge value does not fill the message."""
    document = {**GOOD, "sensors": {f"S{number}": {"model": "digit", "shore_00": "x" * 10_000} for number in range(20)}}
    with pytest.raises(SchemaError, match=r"and 15 more") as caught:
        check_document(document, "log", "log.yaml")
    assert len(str(caught.value)) < 3000


@pytest.mark.parametrize(("count", "end"), [(4, None), (5, None), (6, " (and 1 more)")])
def test_up_to_five_faults_are_all_shown(count, end):
    """Four and five faults are shown one by one, with nothing after them; of six, five are shown and one counted."""
    document = {**GOOD, "sensors": {f"S{number}": {"model": "digit", "shore_00": "soft"} for number in range(count)}}
    with pytest.raises(SchemaError) as caught:
        check_document(document, "log", "log.yaml")
    assert str(caught.value).count("at $.sensors.S") == min(count, 5)
    assert (" more)" in str(caught.value)) == (end is not None)
    assert end is None or end in str(caught.value)


@pytest.mark.parametrize("text", ["a: 1\na: 2\n", '{"a": 1, "a": 2}', "b: {c: 1, c: 1}", "1: x\n1: y\n"])
def test_a_key_given_twice_is_refused(text):
    """The last of two values never wins silently."""
    with pytest.raises(SchemaError, match="given twice"):
        parse_document(text, "log.yaml")


@pytest.mark.parametrize(
    "text",
    [
        "!!python/object/apply:os.system ['true']",
        "!!python/name:os.system",
        "a: [1, 2",
        "a: b: c",
        "\x00",
        "? [1, 2]\n: 3",
        "&a [*a]: 1",
        "%YAML 9.9\n---\n!unknown x",
    ],
)
def test_what_is_no_plain_document_is_refused(text):
    """Objects, open brackets, keys that are lists: refused with the file's name, never executed."""
    with pytest.raises(SchemaError, match=r"log\.yaml"):
        parse_document(text, "log.yaml")


@pytest.mark.parametrize("text", ["[" * 100_000, "[" * 500 + "]" * 500, "{a: " * 50_000, "- " * 100_000 + "x"])
def test_deep_nesting_is_refused(text):
    """A document nested a hundred thousand times is an error, not a crash of the interpreter."""
    with pytest.raises(SchemaError):
        parse_document(text, "log.yaml")


@pytest.mark.parametrize("before", ["", "# YAML\n"], ids=["json", "yaml"])
@pytest.mark.parametrize("inner", ["", "1"])
def test_a_hundred_levels_are_the_limit(before, inner):
    """A hundred lists inside one another are read, a hundred and one refused, as JSON and as YAML, empty or not."""
    read = parse_document(before + "[" * 100 + inner + "]" * 100, "log.json")
    for _ in range(99):
        (read,) = read
    assert read == ([1] if inner else [])
    with pytest.raises(SchemaError, match="more than 100 levels"):
        parse_document(before + "[" * 101 + inner + "]" * 101, "log.json")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a: &x 1\nb: *x", 5),  # the mapping, two keys, the number twice
        ("a: &x [1, 2]\nb: *x", 9),  # the mapping, two keys, the list and its two numbers twice
        ("a: &x [1, 2]\nb: &y [*x]\nc: *y", 15),  # the mapping, three keys, the list three times, b and c
        ("- []\n- {}", 3),
    ],
)
def test_values_are_counted_with_their_aliases(text, values, monkeypatch):
    """A document that stands for as many values as are allowed is read; with one fewer allowed it is refused."""
    monkeypatch.setattr(schemas, "MAX_VALUES", values)
    parse_document(text, "log.yaml")
    monkeypatch.setattr(schemas, "MAX_VALUES", values - 1)
    with pytest.raises(SchemaError, match=f"more than {values - 1} values"):
        parse_document(text, "log.yaml")


def test_a_yaml_bomb_is_refused():
    """Aliases of aliases that stand for billions of values are refused; a few aliases are fine."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 9)]
    with pytest.raises(SchemaError, match="stands for more than"):
        parse_document("\n".join(lines), "log.yaml")
    assert parse_document("\n".join(lines[:2]), "log.yaml")["a1"] == [["x"] * 9] * 9


def test_bytes_that_are_no_text(tmp_path):
    """Bytes that are not UTF-8 are refused with their place, and a byte order mark is accepted."""
    (tmp_path / "latin.yaml").write_bytes("title: Prüfung\n".encode("latin-1"))
    with pytest.raises(SchemaError, match="byte 9"):
        read_document(tmp_path / "latin.yaml")
    (tmp_path / "bom.yaml").write_bytes("title: Prüfung\n".encode("utf-8-sig"))
    assert read_document(tmp_path / "bom.yaml") == {"title": "Prüfung"}


def test_a_huge_file_is_refused_before_it_is_read(tmp_path, monkeypatch):
    """A file beyond the limit is refused by its size; a sparse one of terabytes costs nothing."""
    path = tmp_path / "huge.yaml"
    with path.open("wb") as stream:
        stream.truncate(MAX_DOCUMENT_BYTES + 1)
    monkeypatch.setattr(type(path), "read_text", lambda *_, **__: pytest.fail("it was read"))
    with pytest.raises(SchemaError, match=f"{MAX_DOCUMENT_BYTES + 1} bytes"):
        read_document(path)


def test_a_document_of_64_mebibytes_is_the_largest(tmp_path, monkeypatch):
    """67,108,864 bytes are read, one byte more is not."""
    path = tmp_path / "large.yaml"
    monkeypatch.setattr(type(path), "read_text", lambda *_, **__: "a: 1")
    for size, is_read in ((67_108_864, True), (67_108_865, False)):
        with path.open("wb") as stream:
            stream.truncate(size)
        if is_read:
            assert read_document(path) == {"a": 1}
        else:
            with pytest.raises(SchemaError, match="a document of at most 67108864 bytes"):
                read_document(path)


def test_no_file_there(tmp_path):
    """A path without a file is a missing file; a folder in its place is no document."""
    with pytest.raises(MissingFile, match=r"log\.yaml does not exist"):
        read_document(tmp_path / "log.yaml")
    (tmp_path / "log.yaml").mkdir()
    with pytest.raises(SchemaError, match=r"log\.yaml is no file"):
        read_document(tmp_path / "log.yaml")


@pytest.mark.parametrize("number", ["1e-5", "-2E+3", "1.5e3", "+.5e1", "3.e2"])
def test_numbers_with_an_exponent_are_numbers(number):
    """Small lengths are written so, and YAML 1.1 would take them for texts."""
    assert parse_document(f"a: {number}", "x.yaml") == {"a": float(number)}
    assert parse_document(f"a: '{number}'", "x.yaml") == {"a": number}


@pytest.mark.slow
@given(PLAIN)
def test_json_is_read_as_it_is(value):
    """Whatever a JSON document holds comes back from the parser of documents, escapes and exponents included."""
    assert parse_document(json.dumps({"value": value}), "x.json") == {"value": value}
    assert parse_document(json.dumps([value], ensure_ascii=False), "x.json") == [value]


@given(st.text(max_size=200))
def test_any_text_is_a_document_or_a_schema_error(text):
    """No text raises anything else."""
    try:
        parse_document(text, "log.yaml")
    except SchemaError as error:
        assert error.facts["file"] == "log.yaml"  # noqa: PT017


@pytest.mark.slow
def test_every_schema_is_a_schema():
    """Each file in schemas/ is valid Draft 2020-12, and an empty list fits none of them."""
    names = [place.name.removesuffix(".json") for place in schemas.shipped_folder("schemas").iterdir()]
    assert {"log", "mapping", "store", "split"} <= set(names)
    for name in names:
        schemas.jsonschema.Draft202012Validator.check_schema(schemas.load_schema(name))
        with pytest.raises(SchemaError):
            check_document([], name, "x")


def test_a_fault_points_to_the_page_that_explains_it():
    """Every schema has a page, the page is there, and the message names it."""
    root = Path(__file__).resolve().parents[2]
    assert set(schemas.PAGES) == {path.stem for path in (root / "schemas").glob("*.json")}
    for name, page in schemas.PAGES.items():
        assert (root / page).is_file()
        with pytest.raises(SchemaError, match=page):
            check_document({}, name, "test")


@pytest.mark.parametrize("number", [".nan", ".inf", "-.inf", "1e300", "-1e300"])
@pytest.mark.parametrize(
    ("around", "place"),
    [("a: {{b: {}}}", r"\$\.a\.b"), ("a: [0, {}]", r"\$\.a\[1\]"), ("[{}]", r"\$\[0\]"), ("{}", r"\$")],
)
def test_a_number_beyond_the_largest_is_refused_wherever_it_stands(number, around, place, tmp_path):
    """In mappings, in lists and alone: the message names the place; 9.9e299 is read."""
    path = tmp_path / "x.yaml"
    path.write_text(around.format(number))
    with pytest.raises(SchemaError, match=rf" at {place}, no number"):
        read_document(path)
    path.write_text(around.format("9.9e299"))
    read_document(path)


@pytest.mark.parametrize(("length", "shown"), [(299, 299), (300, 300), (301, 300), (5000, 300)])
def test_a_long_message_is_cut_to_300_characters(length, shown):
    """Up to 300 characters stay as they are; of longer ones 299 and an ellipsis are shown."""
    short = schemas._short("x" * length)
    assert len(short) == shown
    assert short.strip("x") == ("" if length <= 300 else "…")


@pytest.mark.parametrize("text", ["a: &x {b: *x}", "&x [1, *x]", "a: &x\n  - {c: [*x]}"])
def test_a_value_that_contains_itself_is_refused(text):
    """An alias inside its own anchor stands for a document without end; beside it, it is a copy."""
    with pytest.raises(SchemaError, match="contains itself"):
        parse_document(text, "log.yaml")
    assert parse_document("a: &x {b: 1}\nc: *x", "log.yaml") == {"a": {"b": 1}, "c": {"b": 1}}
