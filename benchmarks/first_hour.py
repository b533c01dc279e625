"""How long each step of a newcomer's first hour takes, from recordings to a diagnosis.

    python benchmarks/first_hour.py [--cluster] [--owners .venv/owners] [--folder KEEP] [--write docs/first-hour.md]

Each step is a process of its own in an empty folder, as docs/first-hour.md tells it, start of Python included. In place
of recordings of a laboratory stand the ten touches of the bundled world `concealed`. Simulations are previews (linear).
Seconds of a processor hardly feel other work on the machine; seconds on the clock do, so the load is printed, too. With
``--cluster`` the steps that take ``--scheduler`` are done again by two workers of a Dask cluster, which share that
machine; their processor seconds are not those of the command and are not printed. The workers' start is not in these
times. LeRobot's loader is looked for in ``--owners``, where `make owners` installs it; no other step sees that folder.
How far it is, is said on standard error.
"""

from __future__ import annotations

import argparse
import datetime
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
import yaml
from distributed import Client
from timing import table

from tactiledata.contract.atomic import write_atomic
from tactiledata.rig.scenario.worlds import find_scenario

START, STOP = "<!-- printed -->\n", "<!-- end of printed -->\n"
ADDRESS = "tcp://127.0.0.1:8799"
"""Address at which the Dask scheduler of the benchmark accepts connections."""

HUGGINGFACE = """
import torch
from datasets import load_dataset
rows = load_dataset("for-datasets", split="train").select_columns(["digit", "contact_wrench"]).with_format("torch")
network = torch.nn.Sequential(torch.nn.AvgPool2d(16), torch.nn.Flatten(), torch.nn.Linear(900, 1))
for batch in torch.utils.data.DataLoader(rows, batch_size=16, shuffle=True):
    loss = (network(batch["digit"].float() / 255)[:, 0] - batch["contact_wrench"][:, 2].float()).square().mean()
    loss.backward()
"""
LEROBOT = """
import torch
library = torch.library.Library("torchvision", "DEF")
for operator in ("nms", "qnms"):  # of a torchvision compiled for another torch; nobody calls them
    library.define(operator + "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
from lerobot.datasets.lerobot_dataset import LeRobotDataset
train = LeRobotDataset("tactile", root="for-lerobot")
network = torch.nn.Sequential(torch.nn.AvgPool2d(16), torch.nn.Flatten(), torch.nn.Linear(900, 1))
for batch in torch.utils.data.DataLoader(train, batch_size=16, shuffle=True):
    wrench = batch["observation.contact_wrench"]
    loss = (network(batch["observation.images.digit"])[:, 0] - wrench[:, 2]).square().mean()
    loss.backward()
"""


def steps(scheduler: str | None) -> list[tuple[str, str]]:
    """Each step by its name, with the words of its command; those that a cluster can do where there is one."""
    many = f" --scheduler {scheduler}" if scheduler else ""
    store = "cluster.zarr" if scheduler else "mine.zarr"
    shared = [
        ("ingest", f"ingest recordings --store {store}{many}"),
        ("transfer", f"transfer {store} --to ycb-sensorB --method relit --out moved-{store}{many}"),
        ("calibrate, linear", f"calibrate {store} --fidelity linear --out {store}.json{many}"),
        ("replay, linear", f"replay {store} --fidelity linear --calibration {store}.json{many}"),
        (
            "diagnose, linear, no pairs",
            f"diagnose {store} --fidelity linear --no-pairs --calibration {store}.json --out {store}-diagnosis{many}",
        ),
    ]
    if scheduler:
        return shared
    return [
        ("record the stand-in", "record world.yaml --out recordings --format mcap"),
        ("inspect", "inspect recordings"),
        shared[0],
        ("split", "split mine.zarr --by trajectory,sensor --fractions 0.6,0.2,0.2 --hold-out none"),
        ("audit", "audit mine.zarr"),
        ("report", "report mine.zarr --out page"),
        ("view", "view mine.zarr --no-open"),
        ("export to Hugging Face", "export-data mine.zarr --to huggingface --out for-datasets"),
        ("a pass of training in `datasets`", HUGGINGFACE),
        ("export to LeRobot", "export-data mine.zarr --to lerobot --out for-lerobot"),
        ("a pass of training in `lerobot`", LEROBOT),
        *shared[1:],
    ]


def timed(words: str, folder: Path, environment: dict[str, str]) -> tuple[float, float, float]:
    """Seconds on the clock, processor seconds and peak of memory in bytes, of a command or a program; all processes.

    Raises
    ------
    SystemExit
        The step failed; its last lines are printed.
    """
    program = ["-c", words] if "\n" in words else ["-m", "tactiledata", *words.split()]
    print("…", words.strip().splitlines()[0] if "\n" in words else words, file=sys.stderr, flush=True)
    began = time.perf_counter()
    with (folder / "said.txt").open("wb") as said:
        process = subprocess.Popen(
            [sys.executable, *program], cwd=folder, env=environment, stdout=said, stderr=subprocess.STDOUT
        )
        _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        lines = (folder / "said.txt").read_text(encoding="utf-8", errors="replace").splitlines()
        raise SystemExit(f"exit code {process.returncode}: {words}\n" + "\n".join(lines[-15:]))
    return time.perf_counter() - began, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024.0


@contextmanager
def cluster(folder: Path, environment: dict[str, str]) -> Iterator[str]:
    """A Dask scheduler and two workers of one thread, all processes of this machine, ready for work; their address."""
    command = [sys.executable, "-m", "dask", "scheduler", "--port", ADDRESS.rpartition(":")[2]]
    workers = [sys.executable, "-m", "dask", "worker", ADDRESS, "--nworkers", "2", "--nthreads", "1"]
    quiet = {"cwd": folder, "env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    running = [subprocess.Popen([*words, "--no-dashboard"], **quiet) for words in (command, workers)]
    try:
        with Client(ADDRESS, timeout=120) as client:
            client.wait_for_workers(2, timeout=120)
        yield ADDRESS
    finally:
        for process in reversed(running):
            process.terminate()
        for process in running:
            process.wait()


def told(folder: Path, owners: Path | None, with_cluster: bool) -> None:
    """Do all steps in the folder, and print what each took."""
    environment = {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "HF_HOME": str(folder / "hf"),
        "HF_HUB_OFFLINE": "1",
        "TACTILEDATA_CACHE": str(folder / "cache"),
    }
    path = [str(owners or ""), environment.get("PYTHONPATH", "")]
    of_owners = {**environment, "PYTHONPATH": os.pathsep.join(word for word in path if word)}
    before, began = psutil.getloadavg()[2], time.perf_counter()
    (folder / "world.yaml").write_text(yaml.safe_dump(dict(find_scenario("concealed"))), encoding="utf-8")
    rows = []
    for name, words in steps(None):
        if words == LEROBOT and owners is None:
            continue
        wall, cpu, memory = timed(words, folder, of_owners if words == LEROBOT else environment)
        rows.append((name, f"{cpu:.1f}", f"{wall:.1f}", f"{memory / 1e6:.0f}"))
    if with_cluster:
        environment["TACTILEDATA_CACHE"] = str(folder / "cache-cluster")
        with cluster(folder, environment) as address:
            for name, words in steps(address):
                wall, _, memory = timed(words, folder, environment)
                rows.append((f"{name}, on a cluster", "", f"{wall:.1f}", f"{memory / 1e6:.0f}"))
    table(("step", "processor, s", "clock, s", "most memory, MB"), rows)
    cores = len(psutil.Process().cpu_affinity() or []) or os.cpu_count()
    print(f"{cores} cores, {(time.perf_counter() - began) / 60:.0f} minutes in all")
    print("processes that ran or waited for a core, mean of the 15 minutes before:")
    print(f"{before:.1f} at the first step, {psutil.getloadavg()[2]:.1f} at the end, these steps included")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cluster", action="store_true", help="do again what a Dask cluster can do")
    parser.add_argument("--owners", type=Path, help="folder with LeRobot's packages (`make owners`)")
    parser.add_argument("--folder", type=Path, help="an empty folder that keeps what the steps wrote")
    parser.add_argument("--write", type=Path, help="page that takes the output between its marks")
    given = parser.parse_args()
    owners = given.owners.resolve() if given.owners else None
    if given.write:
        words = [*(["--cluster"] if given.cluster else []), *(["--owners", str(owners)] if owners else [])]
        words += ["--folder", str(given.folder)] if given.folder else []
        told_by = subprocess.run([sys.executable, __file__, *words], check=False, stdout=subprocess.PIPE, text=True)
        if told_by.returncode:
            raise SystemExit(told_by.returncode)
        commit = subprocess.run(["git", "rev-parse", "--short=8", "HEAD"], check=True, capture_output=True, text=True)
        shown = " ".join(word for word in ("--cluster", "--owners .venv/owners") if word.split()[0] in words)
        said = (
            f"`python benchmarks/first_hour.py {shown}` at {commit.stdout.strip()}, "
            f"{datetime.date.today():%d %B %Y}, simulated recordings:\n\n```text\n{told_by.stdout}```\n"
        )
        head, _, rest = given.write.read_text(encoding="utf-8").partition(START)
        write_atomic(given.write, f"{head}{START}{said}{STOP}{rest.partition(STOP)[2]}".encode())
        return
    if given.folder:
        given.folder.mkdir(parents=True)
        told(given.folder.resolve(), owners, given.cluster)
        return
    with tempfile.TemporaryDirectory() as folder:
        told(Path(folder), owners, given.cluster)


if __name__ == "__main__":
    main()
