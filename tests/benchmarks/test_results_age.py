"""A section of docs/results.md that is older than the program behind its figures says so."""

import ast
import importlib.util
import re
from pathlib import Path

import pytest
from parsed_sources import tree_of

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def age():
    """The program that knows the age of results."""
    spec = importlib.util.spec_from_file_location("results_age", ROOT / "benchmarks" / "results_age.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def page(age):
    return age.PAGE.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_section_older_than_the_code_is_marked(age):
    """The page has exactly the marks that its list of digests gives it; else `results_age.py --mark` writes them."""
    assert age.marked(page(age), age.marks(age.listed())) == page(age), "run `python benchmarks/results_age.py --mark`"


def test_every_section_is_listed_with_its_command(age):
    """Page and list have the same sections in the same order; scripts, dependencies and kept JSON exist."""
    sections = age.listed()
    assert [one["heading"] for one in sections] == age.headings(page(age))
    for one in sections:
        assert re.fullmatch(r"[0-9a-f]{8}", one["commit"]), one["heading"]
        assert set(one["digests"]) == set(one["depends"]), one["heading"]
        for path in [*one["depends"], *one.get("json", [])]:
            assert (ROOT / path).exists(), f"{one['heading']}: {path}"
        script = next((word for word in one["command"].split() if word.endswith(".py")), None)
        recipe = re.search(r"tactiledata run (\w+)", one["command"])
        named = script or f"recipes/{recipe[1]}.yaml"
        assert named in one["depends"], one["heading"]


def test_words_do_not_age_a_program(age, tmp_path, monkeypatch):
    """Comments and docstrings leave a digest as it is, a changed number does not; other files count by their bytes."""
    monkeypatch.setattr(age, "ROOT", tmp_path)
    file = tmp_path / "a.py"

    def digest(text):
        file.write_text(text)
        age.digest_now.cache_clear()
        return age.digest_now("a.py")

    plain = digest("X = 1\n\ndef f(a):\n    return a + 1\n")
    assert (
        digest('"""Words."""\nX = 1  # why\n"""What X is."""\n\ndef f(a):\n    """Words."""\n    return a + 1\n')
        == plain
    )
    assert digest("X = 1\n\ndef f(a):\n    return a + 2\n") != plain
    assert digest("X = 2\n\ndef f(a):\n    return a + 1\n") != plain
    (tmp_path / "b.yaml").write_text("a: 1\n")
    before = age.digest_now("b.yaml")
    (tmp_path / "b.yaml").write_text("a: 2\n")
    age.digest_now.cache_clear()
    assert age.digest_now("b.yaml") != before
    age.digest_now.cache_clear()


def test_empty_fields_are_no_program(age):
    """Newer versions of Python know more fields, empty in older programs: they change nothing."""
    tree = ast.parse("def f():\n    return 1\n")
    before = age._program(tree)
    tree.body[0].type_params = []
    tree.body[0].returns = None
    assert age._program(tree) == before


def test_marks_come_and_go(age):
    """A section with a wrong digest is marked, once; with the right one the mark goes; printed headings are none."""
    text = "# R\n\n## one\n\nwords\n\n```text\n## two\n*Older than the code: x*\n```\n\n## three\n\nwords\n"
    assert age.headings(text) == ["one", "three"]
    path = "benchmarks/timing.py"
    old = {"heading": "one", "commit": "abcdef01", "depends": [path], "digests": {path: "0" * 12}}
    new = {"heading": "three", "commit": "abcdef01", "depends": [path], "digests": {path: age.digest_now(path)}}
    assert age.changed_paths(old) == [path]
    assert age.changed_paths(new) == []
    marked = age.marked(text, age.marks([old, new]))
    assert marked.splitlines()[2:5] == [
        "## one",
        "",
        "*Older than the code: printed at abcdef01 or before, and changed since: `benchmarks/timing.py`.*",
    ]
    assert marked.count("Older than the code: printed") == 1
    assert age.marked(marked, age.marks([old, new])) == marked
    assert age.marked(marked, {}) == text


def test_digests_at_a_commit_are_those_of_its_files(age):
    """The digest of a file that is committed as it lies there is the same from either side; of none, another."""
    path = "benchmarks/timing.py"
    if not (ROOT / ".git").exists() or age._git("status", "--porcelain", "--", path):
        pytest.skip("no clone, or the file is changed")
    assert age.digest_at("HEAD", path) == age.digest_now(path)
    assert age.digest_at("HEAD", "benchmarks/nowhere.py") != age.digest_now(path)


def test_a_section_that_names_modules_of_the_calibration_names_all_that_it_reaches(age):
    """A diagnosis rests on some modules of the calibration: a section lists all that its script imports, or the room.

    The front door of the package counts for nothing: it imports what somebody asks it for. Neither do remarks, which
    say something of a fit and change nothing of it; no table prints them.
    """
    room, no_figures = "tactiledata/calibrate", "tactiledata/calibrate/remarks.py"
    sections = [one for one in age.listed() if any(path.startswith(f"{room}/") for path in one["depends"])]
    assert sections
    for one in sections:
        scripts = [path for path in one["depends"] if path.startswith("benchmarks/")]
        for path in [path for path in reached(scripts) if path.startswith(f"{room}/") and path != no_figures]:
            is_named = any(path == named or path.startswith(f"{named}/") for named in one["depends"])
            assert is_named, f"{one['heading']}: {path}"


def reached(scripts):
    """Modules of the toolkit that scripts import, directly or by others, as paths from the root; packages left out."""
    seen, todo = set(), [ROOT / script for script in scripts]
    while todo:
        path = todo.pop()
        if path in seen or path == ROOT / "tactiledata" / "__init__.py":
            continue
        seen.add(path)
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            else:
                continue
            places = [folder / name.replace(".", "/") for name in names for folder in (ROOT, ROOT / "benchmarks")]
            todo += [
                file for place in places for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file()
            ]
    return [path.relative_to(ROOT).as_posix() for path in sorted(seen) if path.name != "__init__.py"]
