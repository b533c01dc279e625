"""No command writes into a store what is no part of it: pages, pictures, documents, other stores."""

import pytest
import typer
from bench import command

from tactiledata.cli.main import app

COMMANDS = typer.main.get_command(app).commands
WITH_OUT = sorted(name for name, one in COMMANDS.items() if any(parameter.name == "out" for parameter in one.params))


def content(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if not path.name.endswith(".lock"))


@pytest.mark.parametrize("name", [*WITH_OUT, "merge", "plant", "ingest"])
def test_output_to_an_address_is_refused(name, bench, capsys):
    """A store is read from an address; nothing is written there, nor into a folder of that name."""
    option = {"merge": "--into", "plant": "--into", "ingest": "--store"}.get(name, "--out")
    words = [str(bench.mcap)] if name == "ingest" else []
    code, text = command(capsys, name, *words, option, "s3://bucket/x")
    assert code == 2, text
    assert f"{option} 's3://bucket/x' is an address; expected a path on this machine" in " ".join(text.split())
    assert not (bench.folder / "s3:").exists()


@pytest.mark.parametrize("name", ["replay", "check", "sensors"])
def test_a_store_at_an_address_is_not_written_into(name, bench, capsys):
    """A command that changes the store says that the store must lie on a disk, and not that there is none."""
    words = {
        "replay": ["http://h/x", "--youngs-modulus", "9e5", "--poisson-ratio", "0.45", "--friction", "0.5"],
        "check": ["http://h/x", "--repair"],
        "sensors": ["remove", "X", "--store", "http://h/x"],
    }[name]
    code, text = command(capsys, name, *words)
    assert code == 2, text
    assert "the store http:/h/x is not on a local disk; expected a local store" in " ".join(text.split())


@pytest.mark.parametrize("place", ["ds.zarr", "ds.zarr/x", "ds.zarr/streams/../y", "link/z"])
@pytest.mark.parametrize("name", WITH_OUT)
def test_output_into_a_store_is_refused(name, place, bench, capsys):
    """Every command with --out gives exit 2, names the store, and leaves not a file more or less in it."""
    before = content(bench.store)
    (bench.folder / "link").symlink_to(bench.store)
    code, text = command(capsys, name, "--out", place)
    flat = " ".join(text.split())
    assert code == 2, text
    assert f"--out {place!r} lies in the store" in flat
    assert "a place outside any store" in flat
    assert content(bench.store) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        ("merge", "ds.zarr", "--into", "ds.zarr/x.zarr"),
        ("merge", "ds.zarr", "--into", "ds.zarr/index/deep/x.zarr"),
        ("ingest", "log", "--store", "ds.zarr/x.zarr"),
        ("transfer", "ds.zarr", "--to", "ycb-sensorA", "--method", "background-swap", "--out", "ds.zarr/x.zarr"),
    ],
)
def test_a_store_in_a_store_is_refused(arguments, bench, capsys):
    """Merge, ingest and transfer give exit 2, name the outer store, and leave not a file more or less in it."""
    assert bench.log.is_dir()
    before = content(bench.store)
    code, text = command(capsys, *arguments)
    assert code == 2, text
    assert "lies in the store" in " ".join(text.split())
    assert content(bench.store) == before
    code, text = command(capsys, "check", bench.store)
    assert code == 0, text


@pytest.mark.slow
def test_output_beside_a_store_is_written(bench, capsys):
    """Negative control: a page beside the store, and a merged store beside it, are written."""
    code, text = command(capsys, "report", bench.store, "--out", bench.folder / "page")
    assert code == 0, text
    code, text = command(capsys, "merge", bench.store, "--into", bench.folder / "more" / "x.zarr")
    assert code == 0, text


def test_many_commands_are_tried():
    """The sweep sees the commands of both packages."""
    assert {"report", "replay", "diagnose", "calibrate", "record", "score"} <= set(WITH_OUT)
