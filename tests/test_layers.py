"""Imports go down the list of layers only, never sideways inside a row, and every module has a place in it."""

import ast
from functools import cache
from pathlib import Path

import pytest
from parsed_sources import tree_of

ROOT = Path(__file__).resolve().parents[1]
LAYERS = [  # bottom first; packages of one row never import one another
    ["tactiledata.errors", "tactiledata.arrays"],
    ["tactiledata.units", "tactiledata.registry", "tactiledata.transforms"],
    ["tactiledata.contract"],
    ["tactiledata.sensors", "tactiledata.indenters", "tactiledata.compute", "tactiledata.report"],
    ["tactiledata.formats", "tactiledata.store", "tactiledata.metrics", "tactiledata.gel"],
    ["tactiledata.splits", "tactiledata.nuisance", "tactiledata.effects"],
    ["tactiledata.ingest", "tactiledata.loaders", "tactiledata.replay", "tactiledata.optics"],
    ["tactiledata.calibrate", "tactiledata.scoring", "tactiledata.view", "tactiledata.export"],
    ["tactiledata.diagnose"],
    ["tactiledata.rig"],
    ["tactiledata.prove"],
    ["tactiledata.cli"],
    ["split_models"],
]
FAMILIES = {
    "tactiledata.compute": "tactiledata.compute",
    "tactiledata.diagnose.locate": "tactiledata.diagnose.locate",
    "tactiledata.effects": "tactiledata.effects",
    "tactiledata.export": "tactiledata.export",
    "tactiledata.formats": "tactiledata.formats",
    "tactiledata.indenters": "tactiledata.indenters",
    "tactiledata.metrics": "tactiledata.metrics",
    "tactiledata.sensors": "tactiledata.sensors",
    "split_models.methods": "split_models.methods.methods",
    "split_models.transfer": "split_models.transfer.methods",
    "split_models.transfer.pixels": "split_models.transfer.pixels",
}
"""Families whose members never import one another, each with the module that finds its members by name."""
RIG_MAY_IMPORT = {
    "tactiledata.arrays",
    "tactiledata.errors",
    "tactiledata.units",
    "tactiledata.registry",
    "tactiledata.transforms",
    "tactiledata.contract",
    "tactiledata.sensors",
    "tactiledata.indenters",
    "tactiledata.rig",
}
ABOVE_ALL = {"tactiledata", "tactiledata.__main__"}
"""Modules that have no layer and may import every one: the names of the package, and its command."""
SOURCES = sorted(path for package in ("tactiledata", "split_models") for path in (ROOT / package).rglob("*.py"))


def module_of(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def place(module):
    """Row and package of a module in the list of layers; None for the root package and for outsiders."""
    for row, packages in enumerate(LAYERS):
        for package in packages:
            if f"{module}.".startswith(f"{package}."):
                return row, package
    return None


@cache
def imported(path):
    """Dotted names that a module imports; parsed once for all tests."""
    names = []
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [f"{node.module}.{alias.name}" for alias in node.names]
    return names


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_down(path):
    """No import goes up, sideways in a row, or from the rig to what it must be independent of."""
    importer = module_of(path)
    here = place(importer)
    assert here is not None or importer in ABOVE_ALL, f"{importer} has no layer; add it to LAYERS"
    for target in imported(path):
        there = place(target)
        if here is None or there is None:
            continue
        assert there[0] <= here[0], f"{importer} imports {target}, above it"
        if there[0] == here[0]:
            assert there[1] == here[1], f"{importer} imports {target}, beside it in the same row"
        if here[1] == "tactiledata.rig":
            assert there[1] in RIG_MAY_IMPORT, f"the rig must not know {target}: its independence is the proof"


def members_of(family):
    """The members of a family: modules in its tables, and those that the functions beside the tables import."""
    import importlib

    from tactiledata.registry import Registry

    module = importlib.import_module(FAMILIES[family])
    tables = [value for value in vars(module).values() if isinstance(value, Registry)]
    listed = {target.partition(":")[0] for table in tables for target in table._targets().values()}
    tree = tree_of(Path(module.__file__))
    inside = [node for function in tree.body if isinstance(function, ast.FunctionDef) for node in ast.walk(function)]
    imports = {node.module for node in inside if isinstance(node, ast.ImportFrom)}
    return listed | {name for name in imports if name.startswith(f"{family}.")}


@pytest.mark.parametrize("family", FAMILIES)
def test_members_do_not_know_each_other(family):
    """A member of a family imports no other member; what two share lies in a module that is no member."""
    members = members_of(family)
    assert len(members) > 1
    for path in SOURCES:
        importer = module_of(path)
        if importer not in members:
            continue
        for target in imported(path):
            sibling = {member for member in members if f"{target}.".startswith(f"{member}.")} - {importer}
            assert not sibling, f"{importer} imports its sibling {sibling}"


def test_importing_the_package_imports_nothing_heavy():
    """`import tactiledata` and the command's help import neither torch nor mujoco nor matplotlib."""
    import subprocess
    import sys

    program = (
        "import sys, tactiledata, tactiledata.cli.main\n"
        "heavy = {'torch', 'mujoco', 'matplotlib', 'sklearn', 'dask', 'distributed'} & set(sys.modules)\n"
        "sys.exit(f'imported {heavy}' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
