"""Names of trajectories that look like paths are names: no command writes outside of the folder that it works in."""

import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.store.read.reader import Store

NAMES = ("../../up", "/tmp/absolute", "a/b", "..", "c\\d")
"""Names that recordings without a log.yaml can give; a log.yaml with such a name in a table gives the same."""


@pytest.fixture
def workplace(tmp_path, tiny_folders, monkeypatch, capsys):
    """A folder deep in others, with a store whose trajectories are called like paths."""
    deep = tmp_path / "1" / "2" / "3"
    deep.mkdir(parents=True)
    monkeypatch.chdir(deep)
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "cache"))
    names = iter(NAMES)
    for number, folder in enumerate(tiny_folders):
        log = copy_tree(folder, deep / f"log{number}")
        table = log / "trajectories.csv"
        head, *rows = table.read_text(encoding="utf-8").splitlines()
        renamed = [f"{next(names)},{row.partition(',')[2]}" for row in rows]
        table.write_text("\n".join([head, *renamed]) + "\n", encoding="utf-8")
    code, _, err = run_command(capsys, "ingest", "log0", "log1", "--store", "ds.zarr")
    assert code in (0, 1), err
    return deep


def outside(workplace):
    """Files that do not lie below the folder, the cache apart."""
    above = workplace.parents[2]
    return {
        path.relative_to(above).as_posix()
        for path in above.rglob("*")
        if not path.is_relative_to(workplace) and not path.is_relative_to(above / "cache") and path.is_file()
    }


@pytest.mark.slow
def test_names_arrive_as_they_are(workplace):
    """The store keeps the names, slashes and all, so that what follows is about them."""
    kept = set(Store.open(workplace / "ds.zarr").trajectories(["trajectory"])["trajectory"].to_pylist())
    assert kept == set(NAMES[: len(kept)])
    assert len(kept) == 4


@pytest.mark.slow
def test_no_command_leaves_its_folder(workplace, capsys):
    """What a command writes lies below the working folder."""
    assert outside(workplace) == set()
    for call in (
        ["split", "ds.zarr"],
        ["report", "ds.zarr"],
        ["info", "ds.zarr"],
        ["check", "ds.zarr"],
        ["scene", "ds.zarr", "--trajectory", NAMES[0], "--out", "scene.xml"],
        ["merge", "ds.zarr", "--into", "both.zarr"],
    ):
        code, out, err = run_command(capsys, *call)
        assert code in (0, 1), out + err
        assert "a fault of tactiledata" not in out + err
        assert outside(workplace) == set(), call


@pytest.mark.slow
@pytest.mark.parametrize(
    "call",
    [
        ["replay", "ds.zarr", "--fidelity", "linear", "--youngs-modulus", "0.88e6", "--poisson-ratio", "0.45",
         "--friction", "0.8", "--out", "replayed"],
        ["transfer", "ds.zarr", "--to", "digit-bg-3"],
        ["diagnose", "ds.zarr", "--fidelity", "linear", "--out", "diagnosed"],
    ],
    ids=lambda call: call[0],
)  # fmt: skip
def test_no_long_command_leaves_its_folder(call, workplace, capsys):
    """Nor do those that play touches or draw pictures."""
    run_command(capsys, "split", "ds.zarr")
    code, out, err = run_command(capsys, *call)
    assert code in (0, 1), out + err
    assert "a fault of tactiledata" not in out + err
    assert outside(workplace) == set()
