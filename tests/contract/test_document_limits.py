"""How much a document may stand for, what lies inside itself, and what a refusal names first."""

import jsonschema
import pytest

from tactiledata.contract import schema as schemas
from tactiledata.contract.schema import check_document, parse_document, read_document
from tactiledata.errors import SchemaError

LARGEST = 33_554_432
"""Values that a document may stand for."""


def standing_for(values):
    """A list that stands for so many values: lists twice as long each, and aliases of them."""
    lines, sizes = ["- &b0 [x]"], [2]
    while 2 + sum(sizes) + 2 * sizes[-1] < values:
        lines.append(f"- &b{len(sizes)} [*b{len(sizes) - 1}, *b{len(sizes) - 1}]")
        sizes.append(1 + 2 * sizes[-1])
    left = values - 1 - sum(sizes)
    for number in reversed(range(len(sizes))):
        lines += [f"- *b{number}"] * (left // sizes[number])
        left %= sizes[number]
    return "\n".join(lines + ["- x"] * left)


def test_thirty_three_million_values_are_the_limit():
    """A few lines of aliases that stand for 2^25 values are read; for one more they are refused."""
    assert len(parse_document(standing_for(LARGEST), "log.yaml")) < 100
    with pytest.raises(SchemaError, match="stands for more than 33554432 values"):
        parse_document(standing_for(LARGEST + 1), "log.yaml")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("[[[1]]]", 4),
        ("a: &x [[1]]\nb: *x", 9),  # the mapping, two keys, and twice two lists and a number
        ("a: &x [[[1, 2], 3]]\nb: {c: *x}", 17),  # the mapping, two keys, twice six, the inner mapping and its key
        ("- &x {a: [1]}\n- [*x, *x]", 14),  # the list, three times four, the list of aliases
    ],
)
def test_what_lies_deeper_is_counted_where_it_is_repeated(text, values, monkeypatch):
    """An alias of collections in collections stands for all that they hold."""
    monkeypatch.setattr(schemas, "MAX_VALUES", values)
    parse_document("# YAML\n" + text, "log.yaml")
    monkeypatch.setattr(schemas, "MAX_VALUES", values - 1)
    with pytest.raises(SchemaError, match=f"more than {values - 1} values"):
        parse_document("# YAML\n" + text, "log.yaml")


@pytest.mark.parametrize("text", ["a: &x {b: *x}", "&x [1, *x]", "a: &x [[{b: *x}]]", "- &x [1]\n- &y [*x, *y]"])
def test_a_value_inside_itself_is_refused(text, tmp_path):
    """An alias of a collection that is still open would have no end."""
    path = tmp_path / "log.yaml"
    path.write_text(text)
    with pytest.raises(SchemaError, match=r"log\.yaml holds a value that contains itself: \*[xy]"):
        read_document(path)


@pytest.mark.parametrize(
    ("schema", "value", "words"),
    [
        ({"not": {"const": 1}, "refusal": "is no unit"}, 1, "1 is no unit"),
        ({"not": {"const": 1}}, 1, "1 should not be valid under {'const': 1}"),
        # other faults of a schema that has a refusal are told by the checker, before and behind "not" in the alphabet
        ({"type": "string", "refusal": "is no unit"}, 1, "1 is not of type 'string'"),
        ({"enum": [2], "refusal": "is no unit"}, 1, "1 is not one of [2]"),
        (False, 1, "False schema does not allow 1"),
    ],
)
def test_a_schemas_own_refusal_is_said_for_what_it_excludes(schema, value, words):
    """The schema's own sentence is given for an excluded value alone, and otherwise the checker's."""
    (fault,) = jsonschema.Draft202012Validator(schema).iter_errors(value)
    assert schemas._words(fault) == (words, "")


def test_the_first_fault_by_its_place_is_the_fact():
    """A program that catches an error gets the path of the first of several faults, in the order of places."""
    soft = {"model": "digit", "shore_00": "soft"}
    document = {"format": "tactiledata-log/1", "sensors": {"C": soft, "A": soft, "B": soft}}
    with pytest.raises(SchemaError) as caught:
        check_document(document, "log", "log.yaml")
    assert caught.value.facts["path"] == "$.sensors.A.shore_00"
    assert str(caught.value).index("sensors.A") < str(caught.value).index("sensors.B") < str(caught.value).index("s.C")


@pytest.mark.parametrize(
    ("text", "key"),
    [('{"b": 1, "a": 2, "a": 3}', "a"), ('{"b": 1, "a": 2, "c": {}, "b": 3}', "b"), ('[{"x": 1, "x": 1}]', "x")],
)
def test_the_key_that_is_given_twice_is_named(text, key):
    """The error names the key that comes again, not the first key of the document."""
    with pytest.raises(SchemaError, match=f"the key '{key}' is given twice"):
        parse_document(text, "log.json")


@pytest.mark.parametrize("digits", [301, 400])
def test_a_number_of_many_digits_does_not_fill_the_message(digits, tmp_path):
    """A message shows the first 39 characters of a number of more than 40, and an ellipsis."""
    path = tmp_path / "x.yaml"
    path.write_text("a: [1, " + "9" * digits + "]")
    with pytest.raises(SchemaError, match=r"holds 9{39}… at \$\.a\[1\], no number a machine can keep") as caught:
        read_document(path)
    assert caught.value.facts["path"] == "$.a[1]"
