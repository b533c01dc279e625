"""Changed bytes into every reader: each must end in a result or in an error of the toolkit, in time and in memory.

    python tests/fuzz/run_fuzz.py [--minutes 30] [--reader NAME ...] [--seed N] [--keep .fuzz]

Small whole files are changed at random (`fuzz_mutations`) and read (`fuzz_readers`) in processes of their own. Any
other error, the end of the process, more than `--seconds` for one case, or more than `--gib` of memory beyond what the
process had is a fault. Its files are kept in `--keep`, with the traceback; `--reader NAME --seed N --cases 1` runs that
case again. The exit code is 1 where there was a fault.
"""

from __future__ import annotations

import argparse
import faulthandler
import itertools
import json
import os
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

TESTS = Path(__file__).resolve().parents[1]
sys.path += [str(TESTS), str(TESTS / "prove")]

from fuzz_mutations import mutate_folder  # noqa: E402 - after the folders of what it imports
from fuzz_readers import READERS, Reader  # noqa: E402

GIB = 2**30
IDLE = 0.01
"""Share of the time of a processor below which a process that does not want to run is taken to wait for ever."""


@dataclass(frozen=True)
class Limits:
    """Bounds of one case.

    Parameters
    ----------
    seconds : float
        Longest time: of a processor, or of waiting for something else.
    memory : int
        Bytes beyond those that the process had before.
    """

    seconds: float = 60.0
    memory: int = 2 * GIB


@dataclass(frozen=True)
class Fault:
    """A case that did not end as it must.

    Parameters
    ----------
    reader : str
    seed : int
    what : str
        Kind of the fault, in a line.
    changes : str
        What was done to the files.
    details : str
        The traceback, where there is one.
    """

    reader: str
    seed: int
    what: str
    changes: str = ""
    details: str = ""


def run_cases(reader: Reader, fixture: Path, seeds: Iterable[int], limits: Limits, keep: Path | None) -> list[Fault]:
    """Faults of a reader on changes of its files, one for each seed at most."""
    left, faults = list(seeds), []
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        case = Path(folder) / "case"
        while left:
            fault, left = _in_child(reader, fixture, case, left, limits)
            if fault is not None:
                faults.append(fault)
                if keep is not None:
                    _keep(fault, case, keep)
    return faults


def _in_child(
    reader: Reader, fixture: Path, case: Path, seeds: list[int], limits: Limits
) -> tuple[Fault | None, list[int]]:
    """The first fault in a forked process that takes seeds one by one, and the seeds that it did not come to."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            _work(reader, fixture, case, seeds, limits.memory, writing)
        finally:
            os._exit(0)
    os.close(writing)
    fault, now, changes = None, seeds[0], ""
    done = 0
    with os.fdopen(reading) as stream:
        while True:
            began = last = _processor_seconds(child)
            while not (is_ready := select.select([stream], [], [], limits.seconds)[0]):
                now_spent = _processor_seconds(child)
                # on a busy machine a process may want to run and not be let
                is_idle = now_spent - last < IDLE * limits.seconds and not _wants_to_run(child)
                if now_spent - began >= limits.seconds or is_idle:
                    break
                last = now_spent
            if not is_ready:
                os.kill(child, signal.SIGKILL)
                fault = Fault(reader.name, now, f"more than {limits.seconds:g} s", changes)
                break
            line = stream.readline()
            if not line:
                break
            said = json.loads(line)
            now, changes = said["seed"], said["changes"]
            if "what" in said:
                fault = Fault(reader.name, now, said["what"], changes, said["details"])
            done += said["is_done"]
    status = os.waitpid(child, 0)[1]
    if fault is None and done < len(seeds):
        details = (case.parent / "stack").read_text(errors="replace") if (case.parent / "stack").exists() else ""
        fault = Fault(reader.name, now, f"the process ended: {os.waitstatus_to_exitcode(status)}", changes, details)
    return fault, [] if fault is None else seeds[seeds.index(fault.seed) + 1 :]


def _facts(place: Path) -> list[str]:
    """The facts of a process or of a thread that Linux tells, from its state on."""
    return (place / "stat").read_text().rpartition(")")[2].split()


def _processor_seconds(process: int) -> float:
    """Seconds of a processor that a process has taken."""
    user, system = _facts(Path(f"/proc/{process}"))[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def _wants_to_run(process: int) -> bool:
    """Whether a thread of a process runs, waits for a processor, or for a disk; else it waits for what may not come."""
    for thread in Path(f"/proc/{process}/task").iterdir():
        with suppress(FileNotFoundError, ProcessLookupError):  # it has ended since
            if _facts(thread)[0] in "RD":
                return True
    return False


def _work(reader: Reader, fixture: Path, case: Path, seeds: list[int], memory: int, pipe: int) -> None:
    """Read changed copies one by one, and tell each; the first fault ends it."""
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    stack = (case.parent / "stack").open("w")
    faulthandler.enable(stack)
    warnings.simplefilter("ignore")
    from tactiledata.errors import TactileDataError

    os.environ["TMPDIR"] = str(case.parent)
    tempfile.tempdir = str(case.parent)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + memory, used + memory))

    def tell(**said: object) -> None:
        os.write(pipe, (json.dumps({"seed": seed, "changes": changes, **said}) + "\n").encode())

    for seed in seeds:
        shutil.rmtree(case, ignore_errors=True)
        shutil.copytree(fixture, case)
        changes = mutate_folder(case, np.random.default_rng([seed, sum(reader.name.encode())]))[:300]
        tell(is_done=False)
        try:
            reader.read(case)
        except TactileDataError:
            pass
        except BaseException as error:  # noqa: BLE001 - whatever else comes out is what is looked for
            lines = "".join(traceback.format_tb(error.__traceback__, limit=-12))
            tell(is_done=True, what=f"{type(error).__name__}: {str(error)[:200]}", details=lines[-3000:])
            return
        tell(is_done=True)


def _keep(fault: Fault, case: Path, keep: Path) -> None:
    """Keep the files of a fault and what is known of it."""
    place = keep / f"{fault.reader}-{fault.seed}"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    shutil.copytree(case, place / "files", symlinks=True)
    (place / "fault.txt").write_text(f"{fault.what}\n{fault.changes}\n\n{fault.details}\n", encoding="utf-8")


def fuzz(readers: Iterable[Reader], seconds: float, start: int, limits: Limits, keep: Path | None, cases: int = 0):
    """Run readers in turn until the time is over; yield the name, the number of cases and the faults of each turn."""
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory(prefix="fuzz-whole-") as folder:
        fixtures = {}
        for reader in readers:
            place = Path(folder) / reader.name
            place.mkdir()
            reader.make(place)
            assert reader.read(place) or not reader.gives, f"the whole files of {reader.name} are refused"
            fixtures[reader] = place
        for turn in itertools.count():
            for reader, place in fixtures.items():
                if turn and time.monotonic() >= end:
                    return
                count = cases or 10
                seeds = range(start + turn * count, start + (turn + 1) * count)
                yield reader.name, count, run_cases(reader, place, seeds, limits, keep)
            if cases:
                return


def main() -> int:
    """Run from the command line; 1 where there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--reader", nargs="*", default=list(READERS), choices=list(READERS), metavar="NAME")
    parser.add_argument("--seed", type=int, default=int(time.time()) // 86400 * 100_000, help="of the first case")
    parser.add_argument("--cases", type=int, default=0, help="this many of each reader, in place of a time")
    parser.add_argument("--seconds", type=float, default=60.0, help="longest time of a case")
    parser.add_argument("--gib", type=float, default=2.0, help="memory of a case")
    parser.add_argument("--keep", type=Path, default=Path(".fuzz"))
    given = parser.parse_args()
    counts: Counter[str] = Counter()
    faults: list[Fault] = []
    limits = Limits(given.seconds, int(given.gib * GIB))
    chosen = [READERS[name] for name in given.reader]
    for name, count, found in fuzz(chosen, 60 * given.minutes, given.seed, limits, given.keep, given.cases):
        counts[name] += count
        faults += found
        for fault in found:
            print(f"{fault.reader} --seed {fault.seed}: {fault.what}", flush=True)
    print(", ".join(f"{name} {count}" for name, count in counts.items()))
    print(f"{sum(counts.values())} cases from seed {given.seed}, {len(faults)} faults; kept in {given.keep}")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
