"""Runs of tests in forked processes over a copy of the repository, so that a change never touches the original."""

from __future__ import annotations

import importlib
import os
import shutil
import signal
import subprocess
import sys
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

LIBRARIES = (
    "numpy", "scipy.spatial.transform", "scipy.optimize", "scipy.signal", "scipy.sparse", "pandas", "pyarrow.parquet",
    "pyarrow.compute", "zarr", "cv2", "jsonschema", "hypothesis", "hypothesis.extra.numpy", "pytest", "torch",
    "numba", "trimesh", "sklearn", "typer", "rich", "h5py", "fsspec", "mcap.reader", "skimage.metrics",
)  # fmt: skip
"""What tests import most: loaded once, before the forks."""

PROJECT = ("tactiledata", "split_models")
"""Packages of which the copy is tested."""
BROKEN = 99
"""Exit code of a run that raised outside of pytest."""


def load_libraries() -> None:
    """Load what tests import, of other projects only."""
    sys.dont_write_bytecode = True
    for name in LIBRARIES:
        with suppress(ImportError):
            importlib.import_module(name)


class Copy:
    """A copy of the repository's files."""

    def __init__(self, root: Path, place: Path) -> None:
        self.place = place
        shutil.rmtree(place, ignore_errors=True)
        listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        names = subprocess.run(listed, cwd=root, capture_output=True, check=True).stdout.decode().split("\0")
        for name in filter(None, names):
            if (root / name).is_file():
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, place / name)
        subprocess.run([sys.executable, "-m", "compileall", "-q", "tactiledata", "split_models"], cwd=place, check=True)

    @contextmanager
    def changed(self, file: str, text: str) -> Iterator[None]:
        """Within, a file of the copy holds another text."""
        path = self.place / file
        before, times = path.read_bytes(), path.stat()
        try:
            path.write_text(text)
            # another time than the compiled file remembers
            os.utime(path, (times.st_atime, times.st_mtime + 10))
            yield
        finally:
            path.write_bytes(before)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


class FirstFailure:
    """A plugin of pytest that writes down the first test that does not pass."""

    def __init__(self, kept: Path) -> None:
        self.kept = kept

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note the failure of a test or of its fixtures."""
        self._note(report)

    def pytest_collectreport(self, report: Any) -> None:
        """Note a file of tests that cannot be imported."""
        self._note(report)

    def _note(self, report: Any) -> None:
        if report.failed and not self.kept.exists():
            self.kept.write_text(report.nodeid)


def fork_tests(place: Path, chosen: list[str], limit: float, recorder: Any = None) -> tuple[int | None, str]:
    """Exit code of pytest for chosen tests at a place, None where the time ran out, and the first that did not pass.

    Exit code 0: all pass.

    Parameters
    ----------
    place : Path
        The copy of the repository.
    chosen : list of str
        Node ids.
    limit : float
        Seconds.
    recorder : optional
        A plugin of pytest with ``begin`` and ``end``; without one, the first failure ends the run.
    """
    failure = place / "first-failure.txt"
    failure.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        code = BROKEN
        try:
            code = _run_pytest(place, chosen, recorder, FirstFailure(failure))
        finally:
            # whatever a changed module raises, the child ends here
            if code == BROKEN:
                traceback.print_exc()
            sys.stderr.flush()
            os._exit(code)
    end = time.monotonic() + limit
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status), failure.read_text() if failure.exists() else ""
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None, ""


def _run_pytest(place: Path, chosen: list[str], recorder: Any, first_failure: FirstFailure) -> int:
    os.setsid()
    with (place / "last-run.txt").open("w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    os.chdir(place)
    sys.path.insert(0, str(place))
    # what this process loaded of the project is that of the repository, not that of the copy
    for name in [name for name in sys.modules if name.partition(".")[0] in PROJECT]:
        del sys.modules[name]
    os.environ |= {"PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    import pytest

    loaded = "ignore::pytest.PytestAssertRewriteWarning"
    options = ["-q", "-p", "no:cacheprovider", "-W", loaded, "-m", "not slow", *([] if recorder else ["-x"])]
    plugins = [recorder] if recorder else [first_failure]
    if recorder:
        recorder.begin()
    code = int(pytest.main([*options, *chosen], plugins=plugins))
    if recorder:
        recorder.end()
    return code
