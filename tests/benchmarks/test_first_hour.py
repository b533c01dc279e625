"""The benchmark of the first hour gives commands and options that exist."""

from pathlib import Path

import pytest
import typer

from tactiledata.cli.main import app

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.mark.parametrize("scheduler", [None, "tcp://127.0.0.1:8799"])
def test_its_steps_are_commands_of_today(monkeypatch, scheduler):
    """Each step is a command with options that it has, or a program that compiles; a cluster gets the address."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    from first_hour import steps

    commands = typer.main.get_command(app).commands
    for name, words in steps(scheduler):
        if "\n" in words:
            compile(words, name, "exec")
            continue
        command, *given = words.split()
        known = {
            word for parameter in commands[command].params for word in (*parameter.opts, *parameter.secondary_opts)
        }
        assert {word for word in given if word.startswith("--")} <= known, name
        assert (scheduler in given) == (scheduler is not None)
