"""How the code base is built: folders, docstrings, parameters, names. What is exempt is listed, and may only shrink."""

import ast
import doctest
import importlib
import re
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest
import yaml
from parsed_sources import tree_of

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("tactiledata", "split_models")
EXEMPT = yaml.safe_load((Path(__file__).parent / "house_exemptions.yaml").read_text(encoding="utf-8"))
MOST_MODULES = 25
"""Modules in a folder, beside its ``__init__``."""
TOUR_LINES = 5
"""Lines of the docstring of a folder's ``__init__``."""
MOST_LINES = 350
"""Lines of a module."""
MANY_PARAMETERS = 3
"""Parameters from which on a public function describes all of them."""
MOST_POSITIONAL = 8
"""Arguments that a call may give by position."""
MOST_ROOMS = 14
"""Folders and modules directly in ``diagnose``."""
ONE_WAY = (
    "tactiledata.diagnose", "tactiledata.effects", "tactiledata.gel", "tactiledata.ingest", "tactiledata.prove",
    "tactiledata.store", "split_models",
)  # fmt: skip
"""Packages in which no room imports, even through others, a room that imports it."""
FRAGMENT = re.compile(
    r"(Of|By|With|For|From|In|At|On|To|Through|See|As|The same|The other|Those|These|Such|Nothing|Beside|That|Which"
    r"|Up to|Not|Also|And|Or|But|Or else|So|Where|When|Until|Told|Asked|Hears)\b"
)
"""Words with which a fragment begins; a full sentence hardly does."""
SILENT_TEST = re.compile(r'^ *def (test_\w+)\((?:[^()]|\([^()]*\))*\)(?: -> None)?:\n(?! *r?""")', re.MULTILINE)
"""A test without a docstring."""
SOURCES = {
    path.relative_to(ROOT).as_posix(): path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))
}
FOLDERS = sorted({path.parent for path in SOURCES.values()})
Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


@cache
def trees():
    """The parsed source of every module, by its path; half a second and a million objects, so not at collection."""
    return {name: tree_of(path) for name, path in SOURCES.items()}


def definitions(tree, prefix=""):
    """Pairs of a dotted name and the node of every function and class, those within classes too."""
    for node in tree.body:
        if isinstance(node, Definition):
            yield f"{prefix}{node.name}", node
            if isinstance(node, ast.ClassDef):
                yield from definitions(node, f"{prefix}{node.name}.")


def first_line(node):
    """First line of a docstring; empty where there is none."""
    return (ast.get_docstring(node) or "").partition("\n")[0]


def sentence(node):
    """The first paragraph of a docstring on one line."""
    return " ".join((ast.get_docstring(node) or "").partition("\n\n")[0].split())


def parameters(node):
    """Names of a function's parameters, without ``self`` and ``cls``."""
    given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return [part.arg for part in given if part.arg not in ("self", "cls") and not part.arg.startswith("_")]


def is_public(name):
    """Whether no part of a dotted name begins with an underscore."""
    return not any(part.startswith("_") for part in name.split("."))


def shrinking(kind, offenders):
    """Fail where an offender is not exempt, or an exemption is no longer needed."""
    exempt = set(EXEMPT[kind] or [])
    new, done = sorted(set(offenders) - exempt), sorted(exempt - set(offenders))
    assert not new, f"{len(new)} not exempt in tests/house_exemptions.yaml, {kind}: {new[:20]}"
    assert not done, f"no longer needed in tests/house_exemptions.yaml, {kind}; remove: {done[:20]}"


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.relative_to(ROOT).as_posix())
def test_a_folder_is_small_and_has_a_tour(folder):
    """A folder has at most 25 modules, and its docstring leads through them in at least five lines."""
    modules = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
    assert len(modules) <= MOST_MODULES
    tour = ast.get_docstring(trees()[(folder / "__init__.py").relative_to(ROOT).as_posix()]) or ""
    lines = [line for line in tour.splitlines() if line.strip()]
    assert len(lines) >= TOUR_LINES, f"{folder.name}: {len(lines)} lines"


def unnamed_modules(folder):
    """Modules and rooms of a folder that neither its tour names, in backticks, nor a table beside the tour."""
    tree = ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))
    named = set(re.findall(r"\w+", " ".join(re.findall(r"`+([^`]+)`+", ast.get_docstring(tree) or ""))))
    targets = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    # a member of a family is in its table as "package.module:Object"
    named |= {target.partition(":")[0].rpartition(".")[2] for target in targets if re.fullmatch(r"[\w.]+:\w+", target)}
    modules = {path.stem for path in folder.glob("*.py")} | {path.parent.name for path in folder.glob("*/__init__.py")}
    return sorted(modules - named - {"__init__"})


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.relative_to(ROOT).as_posix())
def test_a_tour_names_every_module(folder):
    """Whoever reads a folder's tour learns of each of its modules and rooms; a family's members stand in its table."""
    assert not unnamed_modules(folder)


def test_a_module_that_no_tour_names_is_found(tmp_path):
    """Names in plain words and in other texts do not count, those in backticks and in tables do."""
    for name in ("spring", "damper", "mass", "room/__init__"):
        (tmp_path / f"{name}.py").parent.mkdir(exist_ok=True)
        (tmp_path / f"{name}.py").touch()
    (tmp_path / "__init__.py").write_text('"""A spring, ``mass``."""\nTABLE = {"damper": "a.damper:Damper"}\n')
    assert unnamed_modules(tmp_path) == ["room", "spring"]


def test_modules_are_short():
    """A module has at most 350 lines."""
    shrinking("long modules", [n for n, path in SOURCES.items() if len(path.read_text().splitlines()) > MOST_LINES])


def test_first_lines_are_no_fragments():
    """The first line of a docstring says what a thing is or does, for a reader who has not seen its caller."""
    found = []
    for name, tree in trees().items():
        for dotted, node in definitions(tree):
            said = sentence(node)
            if said and (FRAGMENT.match(said) or len(said.split()) < 3):
                found.append(f"{name}:{dotted}")
    shrinking("fragments", found)


def test_tests_say_what_they_show():
    """Every test has a docstring; its first line says what the test shows."""
    text = {path: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py")}
    silent = [f"{path.name}:{name}" for path, source in text.items() for name in SILENT_TEST.findall(source)]
    assert not silent


def test_parameters_are_described():
    """A public function with three or more parameters describes all of them."""
    found = []
    for name, tree in trees().items():
        for dotted, node in definitions(tree):
            # what a command's options mean is said by their help
            if isinstance(node, ast.ClassDef) or not is_public(dotted) or "typer." in ast.unparse(node.args):
                continue
            names = parameters(node)
            text = ast.get_docstring(node) or ""
            described = text.partition("Parameters\n")[2]
            if len(names) >= MANY_PARAMETERS and any(not re.search(rf"\b{part}\b", described) for part in names):
                found.append(f"{name}:{dotted}")
    shrinking("undescribed parameters", found)


@pytest.mark.slow
def test_calls_name_their_arguments():
    """No call gives nine or more arguments by position."""
    found = []
    for name, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and len(node.args) > MOST_POSITIONAL:
                called = ast.unparse(node.func)
                if called[:1].isupper() or called[:1].islower():
                    found.append(f"{name}:{called}")
    shrinking("positional arguments", found)


def test_a_class_name_means_one_thing():
    """No two public classes share a name."""
    places = defaultdict(list)
    for name, tree in trees().items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(name)
    shrinking("class names", [name for name, found in places.items() if len(found) > 1])


def test_records_are_frozen():
    """A dataclass cannot be changed after it was made, unless it is a listed buffer that fills."""
    found = []
    for name, tree in trees().items():
        for dotted, node in definitions(tree):
            for mark in getattr(node, "decorator_list", []):
                if "dataclass" in ast.unparse(mark) and "frozen=True" not in ast.unparse(mark):
                    found.append(f"{name}:{dotted}")
    shrinking("changing dataclasses", found)


def test_no_ghost_layers():
    """Every package in the list of layers exists."""
    from test_layers import FAMILIES, LAYERS, RIG_MAY_IMPORT

    for package in [*(package for row in LAYERS for package in row), *FAMILIES, *RIG_MAY_IMPORT]:
        place = ROOT / package.replace(".", "/")
        assert place.is_dir() or place.with_suffix(".py").is_file(), package


def rooms_of(package):
    """The rooms directly in a package, each with the rooms that its modules import when they are loaded."""
    inside = {name: tree for name, tree in trees().items() if name.startswith(f"{package.replace('.', '/')}/")}
    arrows = defaultdict(set)
    for name, tree in inside.items():
        room = name.removeprefix(f"{package.replace('.', '/')}/").split("/")[0].removesuffix(".py")
        if room == "__init__":
            continue
        arrows.setdefault(room, set())
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{package}."):
                arrows[room].add(node.module.removeprefix(f"{package}.").split(".")[0])
    return {room: targets - {room} for room, targets in arrows.items()}


@pytest.mark.parametrize("package", ONE_WAY)
def test_rooms_point_one_way(package):
    """What a room of a package imports never leads back to it; the rig's rooms are the exception."""
    left = rooms_of(package)
    while left:
        free = [room for room, targets in left.items() if not targets & set(left)]
        assert free, f"rooms that import one another: {sorted(left)}"
        for room in free:
            del left[room]


def test_the_diagnosis_has_few_rooms():
    """The diagnosis has at most 14 rooms."""
    assert len(rooms_of("tactiledata.diagnose")) <= MOST_ROOMS


DOCTESTS = sorted(name for name, path in SOURCES.items() if ">>> " in path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", DOCTESTS)
def test_examples_in_docstrings_run(name):
    """Examples in docstrings give what they say."""
    module = importlib.import_module(name.removesuffix(".py").removesuffix("/__init__").replace("/", "."))
    tried = doctest.testmod(module, optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    assert tried.attempted
    assert not tried.failed


@pytest.mark.slow
def test_the_picture_of_the_architecture_is_true():
    """docs/architecture.md shows the imports as they are; ``python tests/import_picture.py`` draws them anew."""
    from import_picture import PAGE, drawn_page

    text = PAGE.read_text(encoding="utf-8")
    assert drawn_page(text) == text


def test_files_that_the_architecture_names_exist():
    """Every file and folder in the tables of docs/architecture.md is there."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = {path for path in re.findall(r"`([\w/]+(?:\.py)?)(?::\w+)?`", text) if "/" in path}
    assert named
    for path in named:
        assert any((ROOT / start / path).exists() for start in ("", "tactiledata")), path
