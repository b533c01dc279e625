"""Entries of documents become solids, or an error that says what is wrong."""

import json
import math
from pathlib import Path

import jsonschema
import pytest

from tactiledata.errors import SchemaError, UsageError
from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.indenters.sphere import Sphere


def test_sizes_not_given_have_defaults():
    """A shape alone is the usual print of it."""
    assert make_indenter({"shape": "ring"}, None, "test") == INDENTERS["ring"]()


def test_pose_is_no_size():
    """Keys of an entry that are not sizes do not reach the solid."""
    entry = {"shape": "sphere", "radius": 0.003, "base_from_indenter": {"xyz": [0, 0, 0]}}
    assert make_indenter(entry, None, "test") == Sphere(radius=0.003)


@pytest.mark.parametrize("value", [0, -0.004, math.nan, math.inf, "4 mm", None, True, [0.004]])
def test_impossible_size_is_refused(value):
    """A size that is not a positive finite number is an error that names it and the place."""
    with pytest.raises(SchemaError, match=r"log\.yaml.*'radius'"):
        make_indenter({"shape": "sphere", "radius": value}, None, "log.yaml: $.indenters.ball")


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ({}, "neither a shape nor a mesh"),
        ({"shape": 7}, "neither a shape nor a mesh"),
        ({"shape": "spere"}, "Did you mean sphere"),
        ({"shape": "sphere", "diameter": 0.004}, "sizes of sphere: radius"),
        ({"shape": "sphere", "radius": 4.0}, "4 mm is 0.004"),
        ({"shape": "sphere", "radius": 1e-6}, "between 0.0002 m"),
        ({"shape": "sphere", "radius": 4.0, "unit": "mm"}, "a unit belongs to a mesh"),
        ({"shape": "ring", "outer_radius": 0.002, "inner_radius": 0.002}, "inner_radius < outer_radius"),
        ({"shape": "torus", "tube_radius": 0.005}, "tube_radius < ring_radius"),
        ({"shape": "cross", "bar": 0.02}, "bar < span"),
        ({"shape": "dome", "radius": 0.02}, "radius <= curvature_radius"),
        ({"shape": "dome", "length": 0.001}, "length above the height of the cap"),
        ({"shape": "cone", "half_angle": 1.6}, "half_angle < pi / 2"),
        ({"shape": "cone", "half_angle": 40}, "half_angle < pi / 2"),
        ({"shape": "edge", "edge_radius": 0.004}, "2 \\* edge_radius < length"),
        ({"shape": "dots", "pitch": 0.001}, "2 \\* pin_radius < pitch"),
        ({"shape": "dots", "length": 0.003}, "pin_length \\+ pin_radius <= length"),
        ({"mesh": "part.stl"}, "without its unit"),
        ({"mesh": "part.stl", "unit": "mm"}, "without a folder; expected the folder .* --indenters FOLDER"),
    ],
)
def test_bad_entry_says_what_is_wrong(entry, says):
    """Each wrong entry gives its own message, with the place in the document."""
    with pytest.raises(SchemaError, match=says) as caught:
        make_indenter(entry, None, "log.yaml: $.indenters.x")
    assert "log.yaml: $.indenters.x" in str(caught.value)


def test_constructor_refuses_too():
    """The classes themselves refuse what a document may not say."""
    with pytest.raises(UsageError, match="positive finite"):
        Sphere(radius=-1.0)


@pytest.mark.parametrize("name", INDENTERS)
def test_documents_fit_the_schema(name):
    """What an indenter says of itself is what schemas/log.json lets an indenter say."""
    schema = json.loads((Path(__file__).parents[2] / "schemas" / "log.json").read_text(encoding="utf-8"))
    part = {"$defs": schema["$defs"], "$ref": "#/$defs/indenter"}
    jsonschema.validate(INDENTERS[name]().document, part)
