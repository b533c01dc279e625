"""Which fast tests run which lines, measured once for each test file."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coverage
import pytest
from mutant_runs import fork_tests
from mutant_sites import Mutant

SECONDS = 900.0
"""Longest time (s) that a file of tests may take."""


class Recorder:
    """A plugin of pytest that notes lines by test, and how long each test took."""

    def __init__(self, place: Path, sources: list[str], kept: Path) -> None:
        self.place, self.sources, self.kept = place, sources, kept
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()

    def begin(self) -> None:
        """Start."""
        include = [str(self.place / file) for file in self.sources]
        self.coverage = coverage.Coverage(data_file=None, include=include, config_file=False)
        self.coverage.start()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: Any) -> None:
        """Lines of fixtures."""
        self.coverage.switch_context(f"{item.nodeid}|setup")

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_call(self, item: Any) -> None:
        """Lines of the test."""
        self.coverage.switch_context(f"{item.nodeid}|run")

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Outcome and duration."""
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration
        if report.outcome != "passed":
            self.failed.add(report.nodeid)

    def end(self) -> None:
        """Write what was noted."""
        self.coverage.stop()
        data = self.coverage.get_data()
        lines = {
            file: {row: sorted(names) for row, names in data.contexts_by_lineno(str(self.place / file)).items()}
            for file in self.sources
        }
        found = {"seconds": self.seconds, "failed": sorted(self.failed), "lines": lines}
        self.kept.write_text(json.dumps(found))


@dataclass
class TestMap:
    """Tests by the lines that they run.

    Parameters
    ----------
    lines : dict
        Names of tests, with ``|setup`` or ``|run``, by file and line; an empty name stands for an import.
    duration : dict
        Seconds by test.
    digests : dict
        SHA-256 by test file.
    """

    lines: dict[str, dict[int, set[str]]]
    duration: dict[str, float]
    digests: dict[str, str]

    @classmethod
    def measured(cls, place: Path, test_files: list[str], sources: list[str], kept: Path) -> TestMap:
        """The map of a repository; test files that were measured with the same sources are not measured again.

        Parameters
        ----------
        place : Path
            A copy of the repository.
        test_files, sources : list of str
            Relative to it.
        kept : Path
            A folder.
        """
        kept.mkdir(parents=True, exist_ok=True)
        state = hashlib.sha256(b"".join((place / file).read_bytes() for file in sources)).hexdigest()
        found = cls({file: {} for file in sources}, {}, {})
        for number, file in enumerate(test_files):
            found.digests[file] = hashlib.sha256((place / file).read_bytes()).hexdigest()
            path = kept / f"{hashlib.sha256(f'{state} {file} {found.digests[file]}'.encode()).hexdigest()[:20]}.json"
            if not path.exists():
                print(f"lines of {file} ({number + 1} of {len(test_files)})", file=sys.stderr, flush=True)
                fork_tests(place, [file], SECONDS, Recorder(place, sources, path))
            if path.exists():
                found._add(json.loads(path.read_text()))
            else:
                print(f"{file} did not come to its end and is left out", file=sys.stderr)
        return found

    def _add(self, measured: dict[str, Any]) -> None:
        failed = set(measured["failed"])
        for name in sorted(failed):
            print(f"{name} does not pass and is left out", file=sys.stderr)
        self.duration |= {name: value for name, value in measured["seconds"].items() if name not in failed}
        for file, lines in measured["lines"].items():
            for row, names in lines.items():
                kept = {name for name in names if name.rpartition("|")[0] not in failed}
                self.lines[file].setdefault(int(row), set()).update(kept)

    def running(self, mutant: Mutant, own: Sequence[str] = ()) -> list[str]:
        """Tests that run a mutant's statement, quick ones first.

        Parameters
        ----------
        mutant : Mutant
        own : sequence of str
            Test files that are run, too, for a statement that is run at import: the default of a dataclass is used by
            a constructor that has no lines.
        """
        rows = self.lines[mutant.file]
        names = set().union(*(rows.get(row, set()) for row in range(mutant.first, mutant.last + 1)))
        if "" in names:
            # run at import: every test that runs anything of the module
            names = set().union(*rows.values())
            names |= {f"{test}|run" for test in self.duration if test.partition("::")[0] in set(own)}
        chosen = {name.removesuffix("|run") for name in names if name.endswith("|run")}
        # what a fixture runs may matter to every test of the file
        files = {name.partition("::")[0] for name in names if name.endswith("|setup")}
        chosen |= {name for name in self.duration if name.partition("::")[0] in files}
        return sorted(chosen, key=lambda name: (self.duration[name], name))

    def seconds(self, chosen: list[str]) -> float:
        """How long tests took."""
        return sum(self.duration[name] for name in chosen)

    def digest(self, chosen: list[str]) -> str:
        """Return the digest of the files that hold the chosen tests."""
        files = sorted({name.partition("::")[0] for name in chosen})
        return hashlib.sha256(" ".join(self.digests.get(file, "") for file in files).encode()).hexdigest()
