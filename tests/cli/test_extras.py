"""Commands where only some packages are installed: each works, or says in one line which extra it lacks."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import distribution, packages_distributions
from pathlib import Path

import pytest
from copied_trees import copy_tree
from packaging.requirements import Requirement

from tactiledata.contract.extras import EXTRAS

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def needed(extras):
    """Names of all distributions that the base install and some extras bring, those that these need included."""
    found, waiting = {}, [Requirement(text) for text in PROJECT["dependencies"]]
    for extra in extras:
        waiting += [Requirement(text) for text in PROJECT["optional-dependencies"][extra]]
    while waiting:
        wanted = waiting.pop()
        known = found.setdefault(re.sub(r"[-_.]+", "-", wanted.name).lower(), set())
        if known and wanted.extras <= known:
            continue
        known |= {"", *wanted.extras}
        for text in distribution(wanted.name).requires or ():
            one = Requirement(text)
            if one.marker is None or any(one.marker.evaluate({"extra": extra}) for extra in known):
                waiting.append(one)
    return sorted(found)


FILTER = """\"\"\"Python imports no package but those of some extras.\"\"\"

import sys
from importlib.machinery import PathFinder

HIDDEN = frozenset({hidden})


class OnlySome(PathFinder):
    \"\"\"Finds modules as Python does, those of hidden packages excepted.\"\"\"

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        \"\"\"Return where a module is; None for a hidden one.\"\"\"
        return None if name.partition(".")[0] in HIDDEN else PathFinder.find_spec(name, path, target)


sys.meta_path[:] = [OnlySome if finder is PathFinder else finder for finder in sys.meta_path]
"""


def hide_packages(folder, extras):
    """Fill a folder with a start of Python that hides every package which the base install and some extras lack."""
    brought = {"tactiledata", *needed(extras)}
    hidden = [
        module
        for module, owners in packages_distributions().items()
        if not {re.sub(r"[-_.]+", "-", owner).lower() for owner in owners} & brought
    ]
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(FILTER.replace("{hidden}", repr(sorted(hidden))))
    return folder


def run(folder, packages, *words):
    """What a command prints and its exit code, where only the packages in a folder are installed."""
    done = subprocess.run(
        [sys.executable, "-P", "-m", "tactiledata", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": f"{packages}{os.pathsep}{ROOT}", "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    """A folder with a start of Python that has the packages of the base install alone."""
    return hide_packages(tmp_path_factory.mktemp("base") / "packages", [])


@pytest.fixture(scope="module")
def place(tmp_path_factory, tiny_store, tiny_mcaps):
    """A folder with a store and a recording."""
    folder = tmp_path_factory.mktemp("place")
    (folder / "recordings").mkdir()
    shutil.copy(tiny_mcaps[0], folder / "recordings")
    copy_tree(tiny_store, folder / "tiny.zarr")
    return folder


def test_the_table_of_extras_is_that_of_the_project():
    """Each package that the table names is in the extra that the table names, and only in extras."""
    extras = {
        extra: {Requirement(text).name for text in wanted} for extra, wanted in PROJECT["optional-dependencies"].items()
    }
    for module, (package, extra) in EXTRAS.items():
        assert package in extras[extra], module
        assert package not in {Requirement(text).name for text in PROJECT["dependencies"]}
    for extra in {*extras} - {"dev", "site", "mutants"}:
        assert extras[extra] <= {package for package, _ in EXTRAS.values()}, extra


@pytest.mark.slow
def test_the_base_install_makes_checks_splits_and_exports_stores(tmp_path, base):
    """Commands from recordings to an export need nothing but the base install."""
    for words in (
        "formats", "indenters", "effects", "record tiny --out recordings", "inspect recordings",
        "ingest recordings --store tiny.zarr", "info tiny.zarr", "check tiny.zarr", "sensors tiny.zarr",
        "split tiny.zarr --by trajectory", "audit tiny.zarr", "flag tiny.zarr D20002.mcap/t00001 --reason bent",
        "export-data tiny.zarr --to webdataset --out shards",
    ):  # fmt: skip
        code, text = run(tmp_path, base, *words.split())
        assert code == 0, text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "package", "extra"),
    [
        ("report tiny.zarr --out page", "jinja2", "report"),
        ("indenters --picture indenters.png", "matplotlib", "report"),
        ("calibrate tiny.zarr", "meshio", "sim"),
        ("replay tiny.zarr", "meshio", "sim"),
        ("diagnose tiny.zarr", "scikit-learn", "sim"),
        ("prove --quick --out proof", "scikit-learn", "sim"),
        ("plant tiny.zarr --effect any --into planted.zarr", "meshio", "sim"),
        ("demo --out demo", "scikit-learn", "sim"),
        ("scene tiny.zarr --trajectory D20002.mcap/t00001", "mujoco", "sim"),
        ("view tiny.zarr", "rerun-sdk", "view"),
        ("transfer tiny.zarr --to ycb-sensorA", "torch", "models"),
        ("score tiny.zarr --metric gram_style", "torch", "models"),
        ("run table_mesh", "torch", "models"),
        ("train table_mesh", "torch", "models"),
        ("fine-tune tiny.zarr --out model", "torch", "models"),
        ("ingest recordings --store other.zarr --scheduler tcp://127.0.0.1:1", "distributed", "dask"),
    ],
)
def test_a_command_without_its_extra_says_which(place, base, words, package, extra):
    """It ends in a line with the package and the extra, before it has done or written anything."""
    before = sorted(place.iterdir())
    code, text = run(place, base, *words.split())
    assert code == 2, text
    assert f"needs {package}, which is not installed" in text
    assert f"tactiledata[{extra}]" in text
    assert len(text.splitlines()) == 1
    assert sorted(place.iterdir()) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("extras", "words"),
    [
        (["report"], "report tiny.zarr --out page"),
        (
            ["sim", "report"],
            "replay tiny.zarr --fidelity linear --youngs-modulus 9e5 --poisson-ratio 0.4 --friction 0.6",
        ),
        pytest.param(
            ["sim", "report"], "calibrate tiny.zarr --fidelity linear --trajectories 4", marks=pytest.mark.nightly
        ),
        (["view"], "view tiny.zarr --no-open"),
        (["models"], "transfer tiny.zarr --to ycb-sensorB --method relit --out other.zarr"),
    ],
)
def test_an_extra_is_enough_for_what_it_is_for(place, tmp_path, extras, words):
    """A command ends well where only the base install and the extras that it needs are installed."""
    code, text = run(place, hide_packages(tmp_path / "packages", extras), *words.split())
    assert code == 0, text
