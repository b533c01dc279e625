"""`python -m tactiledata` is the command."""

import runpy

import pytest

import tactiledata


def test_the_module_is_the_command(monkeypatch, capsys):
    """It prints what the command prints, and ends with its code; imported, it runs nothing."""
    for words, code in ((["--version"], 0), (["info", "nowhere.zarr"], 2)):
        monkeypatch.setattr("sys.argv", ["tactiledata", *words])
        with pytest.raises(SystemExit) as stop:
            runpy.run_module("tactiledata", run_name="__main__")
        assert stop.value.code == code
    printed = capsys.readouterr()
    assert printed.out == f"tactiledata {tactiledata.__version__}\n"
    assert "nowhere.zarr" in printed.err
    runpy.run_module("tactiledata.__main__", run_name="tactiledata.__main__")
    assert capsys.readouterr() == ("", "")
