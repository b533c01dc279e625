"""A blank text after an option, or in the place of an argument, is wrong usage in every command."""

import inspect

import pytest
import typer
from bench import command

from tactiledata.cli.main import app

COMMANDS = typer.main.get_command(app).commands
BLANK_BY_DEFAULT = {("sensors", "--licence"), ("sensors", "--source")}
"""Options whose default is blank: it says that there is none."""


def option(parameter):
    return max(parameter.opts, key=len)


def text_parameters(name):
    """Options and arguments of a command that take a text, a path or several."""
    hints = inspect.signature(COMMANDS[name].callback.__wrapped__).parameters
    kinds = {
        parameter.name: str(hints[parameter.name].annotation)
        for parameter in COMMANDS[name].params
        if parameter.name in hints
    }
    return [
        parameter
        for parameter in COMMANDS[name].params
        if kinds.get(parameter.name, "").removeprefix("list[").removesuffix("]") in ("str", "Path")
    ]


PLACES = [
    (name, parameter.name)
    for name in sorted(COMMANDS)
    for parameter in text_parameters(name)
    if (name, option(parameter)) not in BLANK_BY_DEFAULT
]


@pytest.mark.parametrize("blank", ["", " \t"])
@pytest.mark.parametrize(("name", "place"), PLACES)
def test_blank_is_refused_by_name(name, place, blank, tmp_path, monkeypatch, capsys):
    """Every blank text and path of every command gives exit 2, names the option, and writes nothing."""
    monkeypatch.chdir(tmp_path)
    parameter = next(one for one in COMMANDS[name].params if one.name == place)
    is_option = option(parameter).startswith("-")
    code, text = command(capsys, name, *([option(parameter)] if is_option else []), blank)
    assert code == 2, text
    is_word = parameter.nargs == -1 and not is_option
    named = f"a word after `tactiledata {name}`" if is_word else option(parameter)
    assert f"{named} is empty; expected a " in " ".join(text.split())
    assert list(tmp_path.iterdir()) == []


def test_many_places_are_tried():
    """The sweep sees options and arguments of the verbs that both packages add."""
    assert len(PLACES) > 60
    assert {"score", "transfer", "diagnose", "ingest", "split"} <= {name for name, _ in PLACES}


@pytest.mark.parametrize(
    "words",
    [
        ["score", "--metric", ","],
        ["score", "--metric", "histogram_intersection", "--against", " , "],
        ["transfer", "--to", "ycb-sensorA", "--from", ","],
        ["calibrate", "--indenter", ","],
        ["diagnose", "--indenter", ",,"],
        ["diagnose", "--effects", ","],
    ],
)
def test_a_list_of_nothing_is_refused(words, bench, capsys):
    """Commas alone name nothing: no empty table, and not all where some were asked for."""
    code, text = command(capsys, *words[:1], bench.store, *words[1:])
    assert code == 2, text
    assert "names nothing" in " ".join(text.split())


def test_a_default_that_is_blank_may_be_typed(bench, capsys):
    """Negative control: a licence that is said to be none is what it is by default."""
    code, text = command(capsys, "sensors", "add", "D1", "--licence", "", "--store", bench.store)
    assert code == 2
    assert "needs one name and a picture" in text
