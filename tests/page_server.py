"""Runs what a page shows in processes that have imported the package already: each is a fork of this one.

Starting Python and importing the package anew took longer than most blocks of a page do. A job is a line of JSON on
standard input; its answer is a line with the exit code.
"""

import atexit
import gc
import importlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
import traceback
import types
import warnings
from pathlib import Path

IMPORTED = (
    "pandas", "scipy.spatial.transform", "scipy.optimize", "zarr", "torch", "matplotlib.figure", "trimesh", "numba",
    "tactiledata.cli.main", "tactiledata.store", "tactiledata.ingest.pipeline", "tactiledata.splits.audit",
    "tactiledata.loaders.torch", "tactiledata.rig.record", "tactiledata.replay.attach", "tactiledata.diagnose.store",
)  # fmt: skip
"""Modules that are imported once for all blocks."""
LONGEST = 900
"""Longest time that a block may take, s: then it is killed."""
PLAIN = re.compile(r"tactiledata [^|&;<>()$`\\*?~#{}\[\]]*")
"""A line that a shell would hand on to the command as it is, quotes apart."""


class PageServer:
    """The process that runs blocks, as a test sees it."""

    def __init__(self, environment):
        command = [sys.executable, __file__]
        self._process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, arguments, code, folder, said):
        """Run a command, or a program where there are no arguments, in a folder.

        Returns the exit code; what is printed is added to the files ``out`` and ``err`` in the folder ``said``.
        """
        job = {"arguments": arguments, "code": code, "folder": str(folder), "said": str(said)}
        self._process.stdin.write(json.dumps(job) + "\n")
        self._process.stdin.flush()
        return int(self._process.stdout.readline())

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


def serve():
    """Take jobs until there are none; each is run by a fork.

    A fork ends without taking apart all that was imported, which takes longer than most jobs; what programs ask to be
    done at their end is done.
    """
    warnings.simplefilter("error")
    for name in IMPORTED:
        importlib.import_module(name)
    gc.collect()
    gc.freeze()
    for line in sys.stdin:
        job = json.loads(line)
        child = os.fork()
        if child == 0:
            signal.alarm(LONGEST)
            code = run(job)
            threading._shutdown()
            atexit._run_exitfuncs()
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


def run(job):
    """Run a job in this process, as if it had been started for it alone; returns its exit code."""
    os.chdir(job["folder"])
    for descriptor, name in ((1, "out"), (2, "err")):
        file = os.open(Path(job["said"]) / name, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(file, descriptor)
        os.close(file)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.modules["__main__"] = main = types.ModuleType("__main__")
    sys.path[0] = ""
    try:
        if job["arguments"]:
            sys.argv = job["arguments"]
            sys.modules["tactiledata.cli.main"].run()
        else:
            sys.argv = ["-c"]
            exec(compile(job["code"], "<string>", "exec"), main.__dict__)
    except SystemExit as end:
        return end.code or 0
    except Exception:  # noqa: BLE001 - as Python itself ends a program
        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    serve()
