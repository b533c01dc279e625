"""The names of `import tactiledata`, the site of the docs, and what is cited."""

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import tactiledata

ROOT = Path(__file__).resolve().parents[1]


def typed_places():
    """Where the imports for type checkers say that each name is: ``name -> (module, name there)``."""
    tree = ast.parse((ROOT / "tactiledata/__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    return {alias.asname or alias.name: (line.module, alias.name) for line in block.body for alias in line.names}


def test_each_name_is_what_type_checkers_take_it_for():
    """The lazy table and the imports for type checkers name the same objects; other names are refused."""
    places = typed_places()
    assert sorted(places) == sorted(tactiledata.__all__) == sorted(set(dir(tactiledata)) & set(places))
    for name, (module, there) in places.items():
        assert getattr(tactiledata, name) is getattr(importlib.import_module(module), there), name
    with pytest.raises(AttributeError, match="no attribute 'ingest_everything'"):
        _ = tactiledata.ingest_everything


def test_every_name_stands_on_both_pages():
    """The page and the reference hold all names of the package, and no other."""
    page, reference = ((ROOT / f"docs/{name}.md").read_text(encoding="utf-8") for name in ("python", "reference"))
    assert set(re.findall(r"^::: tactiledata\.(\w+)$", reference, re.MULTILINE)) == set(tactiledata.__all__)
    table = "\n".join(line for line in page.splitlines() if line.startswith("|"))
    assert set(re.findall(r"`td\.(\w+)`", table)) == set(tactiledata.__all__)


def test_the_citation_is_of_this_version():
    """CITATION.cff, pyproject.toml and the package state one version."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert cited["version"] == project["version"] == tactiledata.__version__
    assert cited["title"] == project["name"]


def test_every_page_is_in_the_menu_of_the_site():
    """No page of the docs is missing from the menu."""
    menu = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))["nav"]
    listed = [page for group in menu for pages in group.values() for page in _pages(pages)]
    notebooks = [page.with_suffix(".md").name for page in (ROOT / "docs").glob("*.ipynb")]
    assert sorted(listed) == sorted(["index.md", *notebooks, *(page.name for page in (ROOT / "docs").glob("*.md"))])


def _pages(pages):
    return [pages] if isinstance(pages, str) else [page for entry in pages for page in entry.values()]


@pytest.mark.slow
def test_the_site_is_built_without_a_warning_and_knows_the_code(tmp_path):
    """MkDocs builds the site strictly; the reference is filled, and the README's links stay within the site."""
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path / "site")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    reference = (tmp_path / "site/reference/index.html").read_text(encoding="utf-8")
    for name in tactiledata.__all__:
        assert f'id="tactiledata.{name}"' in reference, name
    assert "hold_out" in reference
    # the README's links lead to pages of the site
    start = (tmp_path / "site/index.html").read_text(encoding="utf-8")
    assert 'href="transfer/"' in start
    assert "docs/transfer.md" not in start
    # the notebook is a page with its code, and a file to be downloaded
    tutorial = (tmp_path / "site/tutorial/index.html").read_text(encoding="utf-8")
    assert 'href="../tutorial.ipynb"' in tutorial
    assert "DiagnosisOptions" in tutorial
    assert 'href="../why-splits-leak/"' in tutorial
    assert "%%bash" not in tutorial
    assert (tmp_path / "site/tutorial.ipynb").read_bytes() == (ROOT / "docs/tutorial.ipynb").read_bytes()
