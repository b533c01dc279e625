"""A bench of things to spoil, and a table of the ways to spoil them."""

import shutil
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from command import run_command
from copied_trees import copy_tree


class Bench:
    """A folder with a tiny folder log, a tiny MCAP and a store to spoil, each copied when it is first asked for."""

    def __init__(self, folder, folder_log, mcap, store, patch):
        self.folder = folder
        self.patch = patch
        self._folder_log, self._mcap, self._store = folder_log, mcap, store

    @cached_property
    def log(self):
        return copy_tree(self._folder_log, self.folder / "log")

    @cached_property
    def mcap(self):
        return Path(shutil.copy(self._mcap, self.folder / "run.mcap"))

    @cached_property
    def store(self):
        return copy_tree(self._store, self.folder / "ds.zarr")

    def edit(self, name, old, new, count=1):
        path = self.log / name
        text = path.read_text(encoding="utf-8")
        assert old in text, f"{name} does not hold {old!r}"
        path.write_text(text.replace(old, new, count), encoding="utf-8")

    def lines(self, name, change):
        path = self.log / name
        rows = path.read_text(encoding="utf-8").splitlines()
        path.write_text("\n".join(change(rows)) + "\n", encoding="utf-8")

    def ingest(self, path=None):
        return ["ingest", path or self.log, "--store", self.folder / "new.zarr"]


class Case(NamedTuple):
    """A way to spoil the bench, which gives the command to run; its exit code, and words that the message must hold."""

    spoil: Callable[[Bench], list[Any]]
    code: int
    words: tuple[str, ...]


class Cases(dict[str, Case]):
    """Ways to spoil the bench, by name."""

    def case(self, code, *words):
        """Register one."""

        def register(function):
            self[function.__name__] = Case(function, code, words)
            return function

        return register


def command(capsys, *arguments):
    """Exit code and everything printed by one command."""
    code, out, err = run_command(capsys, *arguments)
    return code, out + err


def assert_answered_in_words(case, bench, capsys):
    """The exit code is right, the message names what was wrong, no traceback, and the store is untouched."""
    arguments = case.spoil(bench)
    manifest = bench.folder / "ds.zarr" / "manifest.json"
    before = manifest.read_bytes() if manifest.exists() else None
    found, text = command(capsys, *arguments)
    assert "Traceback" not in text
    assert "a fault of tactiledata" not in text, text
    assert found == case.code, text
    flat = " ".join(text.split())
    for word in case.words:
        assert word in flat, text
    assert before == (manifest.read_bytes() if manifest.exists() else None)
    assert not (bench.folder / "ran").exists()
    assert not (bench.folder.parent / "evil.jpg").exists()
