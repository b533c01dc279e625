"""docs/findings.md lists every finding that the toolkit can emit, with its severity, and no other."""

import ast
import importlib
import itertools
import re
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import get_args

import pytest
from parsed_sources import tree_of

from tactiledata.contract.records import Severity

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "findings.md"
SOURCES = sorted((ROOT / "tactiledata").rglob("*.py"))
SEVERITIES = set(get_args(Severity))
KEBAB = re.compile(r"[a-z0-9]+(-[a-z0-9]+)+|gap")
ROW = re.compile(r"\| `(?P<code>[a-z0-9-]+)` \| (?P<severity>\w+) \| (?P<meaning>[^|]+) \| (?P<remedy>[^|]+) \|")
CARRIERS = {"BrokenLog"}
"""Errors that carry a finding's code as the keyword ``code`` to whoever turns them into a finding."""


@dataclass(frozen=True)
class Wrapper:
    """A function or class that takes a finding's code: where among its arguments, and the severity that it gives."""

    position: int
    severity: str | None


@dataclass(frozen=True)
class Emission:
    code: str
    severity: str | None
    place: str


@cache
def wrappers():
    """The functions with a text parameter, and classes with a text field, called ``code``: by file and name.

    Names that begin with an underscore are known in their own file only; all others everywhere (file ``None``).
    """
    found = {}
    for path in SOURCES:
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.ClassDef):
                fields = [one for one in node.body if isinstance(one, ast.AnnAssign)]
                names = [one.target.id for one in fields if getattr(one.annotation, "id", "") == "str"]
                # what carries a code and no severity of its own is a loss, which becomes a finding of severity damage
                has_own = any(one.target.id == "severity" for one in fields)
                note(found, path, node, names, [one.target.id for one in fields], None if has_own else "damage")
    for path in SOURCES:
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.FunctionDef):
                arguments = [one for one in node.args.args if one.arg != "self"]
                names = [one.arg for one in arguments if getattr(one.annotation, "id", "") == "str"]
                note(found, path, node, names, [one.arg for one in arguments], own_severity(node, found, path))
    return found


def note(found, path, node, texts, names, severity):
    if "code" not in texts:
        return
    wrapper = Wrapper(names.index("code"), severity)
    place = (path if node.name.startswith("_") else None, node.name)
    known = found.setdefault(place, wrapper)
    assert known.position == wrapper.position, f"two functions {node.name} take the code at different places"
    found[place] = Wrapper(known.position, known.severity or wrapper.severity)


def wrapper_of(call, path):
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    return wrappers().get((path, name)) or wrappers().get((None, name))


def own_severity(function, known, path):
    """The severity that a wrapper gives: the default of its parameter, a constant, or that of what it calls."""
    names = [argument.arg for argument in function.args.args]
    if "severity" in names:
        behind = len(names) - names.index("severity")
        defaults = function.args.defaults
        return defaults[-behind].value if behind <= len(defaults) else None
    texts = {node.value for node in ast.walk(function) if isinstance(node, ast.Constant) and is_text(node.value)}
    calls = [node.func.id for node in ast.walk(function) if isinstance(node, ast.Call) and hasattr(node.func, "id")]
    given = (texts & SEVERITIES) | {known[None, name].severity for name in calls if (None, name) in known} - {None}
    return given.pop() if len(given) == 1 else None


def is_text(value):
    return isinstance(value, str)


@cache
def emissions():
    """Every code that a call gives away, and the places where this search cannot tell it."""
    found, lost = [], []
    for path in SOURCES:
        tree = tree_of(path)
        parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}
        for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
            argument = code_argument(call, path)
            if argument is None or is_passed_on(argument):
                continue
            place = f"{path.relative_to(ROOT)}:{call.lineno}"
            codes = constants_of(argument, path, parents)
            if codes is None:
                lost.append(f"{place}: {ast.unparse(argument)}")
                continue
            given = severity_of(call, path, parents)
            severities = given if isinstance(given, dict) else dict.fromkeys(codes, given)
            found += [Emission(code, severities.get(code), place) for code in codes]
    return found, lost


def code_argument(call, path):
    wrapper = wrapper_of(call, path)
    if wrapper is None and getattr(call.func, "id", "") not in CARRIERS:
        return None
    for keyword in call.keywords:
        if keyword.arg == "code":
            return keyword.value
    # a namesake takes fewer arguments: every wrapper takes a code and a message
    is_long = wrapper is not None and len(call.args) + len(call.keywords) > 1
    return call.args[wrapper.position] if is_long and len(call.args) > wrapper.position else None


def is_passed_on(node):
    """Whether a code that was given elsewhere only goes through here: one of an error, a loss or a stored row."""
    if isinstance(node, ast.Attribute):
        return node.attr == "code"
    return isinstance(node, ast.Subscript) and getattr(node.slice, "value", None) == "code"


def constants_of(node, path, parents):
    """All texts that an expression can be; ``None`` where that cannot be told, none where a parameter is passed on."""
    if isinstance(node, ast.Constant):
        return {node.value}
    if isinstance(node, ast.IfExp):
        both = [constants_of(part, path, parents) for part in (node.body, node.orelse)]
        return None if None in both else both[0] | both[1]
    if isinstance(node, ast.JoinedStr):
        parts = [constants_of(getattr(part, "value", part) if isinstance(part, ast.FormattedValue) else part,
                              path, parents) for part in node.values]  # fmt: skip
        return None if None in parts else {"".join(texts) for texts in itertools.product(*parts)}
    return names_value(node, path, parents) if isinstance(node, ast.Name) else None


def names_value(name, path, parents):
    node = name
    while node in parents:
        node = parents[node]
        if isinstance(node, ast.For):
            values = loop_values(node, name.id, path)
            if values is not None:
                return values
        if isinstance(node, ast.FunctionDef):
            if name.id in [argument.arg for argument in node.args.args]:
                return set()
            assigned = [
                constants_of(one.value, path, parents)
                for one in ast.walk(node)
                if isinstance(one, ast.Assign) and getattr(one.targets[0], "id", "") == name.id
            ]
            if assigned:
                return None if None in assigned else set().union(*assigned)
    value = getattr(module_of(path), name.id, None)
    return {value} if isinstance(value, str) else None


def loop_values(loop, name, path):
    """Texts that a loop's variable takes from a table written in the code, or from a tuple that the module knows."""
    names = [getattr(one, "id", "") for one in getattr(loop.target, "elts", [loop.target])]
    if name not in names:
        return None
    if isinstance(loop.iter, ast.Name):
        rows = getattr(module_of(path), loop.iter.id)
        return set(rows)
    if not isinstance(loop.iter, ast.Tuple):
        return None
    column = names.index(name)
    cells = [row.elts[column] if isinstance(row, ast.Tuple) else row for row in loop.iter.elts]
    return {cell.value for cell in cells}


def module_of(path):
    return importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))


def severity_of(call, path, parents):
    """The severity of a call; by code where both come from one table; ``None`` where it is worked out."""
    arguments = [*call.args, *(keyword.value for keyword in call.keywords)]
    for argument in arguments:
        if isinstance(argument, ast.Constant) and is_text(argument.value) and argument.value in SEVERITIES:
            return argument.value
    if any(isinstance(argument, ast.Name) and argument.id == "severity" for argument in arguments):
        return severities_of_table(call, parents)
    wrapper = wrapper_of(call, path)
    return "damage" if wrapper is None or getattr(call.func, "id", "") in CARRIERS else wrapper.severity


def severities_of_table(call, parents):
    node = call
    while node in parents:
        node = parents[node]
        if isinstance(node, ast.For) and isinstance(node.iter, ast.Tuple):
            names = [getattr(one, "id", "") for one in getattr(node.target, "elts", [])]
            if {"severity", "code"} <= set(names):
                code, severity = names.index("code"), names.index("severity")
                return {row.elts[code].value: row.elts[severity].value for row in node.iter.elts}
    return None


def emitted():
    by_code = defaultdict(lambda: defaultdict(list))
    for emission in emissions()[0]:
        by_code[emission.code][emission.severity].append(emission.place)
    return {code: dict(places) for code, places in by_code.items()}


def listed():
    return [match.groupdict() for match in ROW.finditer(PAGE.read_text(encoding="utf-8"))]


@pytest.mark.slow
def test_the_search_can_follow_every_code():
    """Every code that is given to a finding is a text that this test finds, and a word-with-hyphens."""
    found, lost = emissions()
    assert not lost
    assert len(found) > 100
    assert not [emission for emission in found if not KEBAB.fullmatch(emission.code)]


@pytest.mark.slow
def test_a_code_has_one_severity():
    """No code means damage here and a warning there."""
    torn = {code: places for code, places in emitted().items() if len(places) > 1 or None in places}
    assert not torn


@pytest.mark.slow
def test_the_page_lists_exactly_the_codes():
    """None is missing, none is stale, none stands twice."""
    codes = [row["code"] for row in listed()]
    assert sorted(set(codes)) == sorted(codes)
    assert set(emitted()) - set(codes) == set()
    assert set(codes) - set(emitted()) == set()


@pytest.mark.slow
def test_the_page_states_the_severity_of_the_code():
    """What the page calls damage is damage."""
    stated = {row["code"]: row["severity"] for row in listed()}
    assert stated == {code: next(iter(places)) for code, places in emitted().items()}


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda page: page.name)
def test_other_pages_name_no_stale_code(page):
    """A table row or sentence of another page that speaks of findings names codes that exist."""
    codes = {row["code"] for row in listed()}
    rows = re.findall(r"^\|.*\| (?:info|warning|damage) \|$", page.read_text(encoding="utf-8"), re.MULTILINE)
    named = {code for row in rows for code in re.findall(r"`([a-z]+(?:-[a-z0-9]+)+)`", row)}
    assert named <= codes
