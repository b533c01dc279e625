"""What tactiledata, LeRobot, the `mcap` package and rerun make of the same recordings: damage, copies, kills, sizes.

    make owners && python benchmarks/comparison.py [--owners .venv/owners] [--touches 8]

The recordings are simulated (the world `tiny`). Each tool is asked in the way that its documentation has for the case.
LeRobot reads no MCAP: it gets our export of the same store. MCAP's own command line is in no registry that this
repository installs from, so the package `mcap` of the same authors stands for it.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import CompressionType, Writer

ROOT = Path(__file__).resolve().parents[1]
TOOLS = ("tactiledata", "LeRobot", "mcap", "rerun")
OWNERS = """
import json, os, sys
sys.path.append(sys.argv[1])
import torch
library = torch.library.Library("torchvision", "DEF")
for operator in ("nms", "qnms"):  # of a torchvision compiled for another torch; nobody calls them
    library.define(operator + "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
from lerobot.datasets.lerobot_dataset import LeRobotDataset
"""
"""The first lines of a program that uses LeRobot."""


def program(code: str, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python code in a folder, in a process of its own; ``folder`` is its home, and nothing goes to the network."""
    environment = {
        **os.environ, "PYTHONPATH": str(ROOT), "HF_HOME": str(folder / "home"), "HF_HUB_OFFLINE": "1",
        "OMP_NUM_THREADS": "1",
    }  # fmt: skip
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def recorded(folder: Path, touches: int) -> list[Path]:
    """Simulated recordings, as MCAP without compression, so that a flipped bit of a picture stays a picture."""
    from tactiledata.rig.record import record
    from tactiledata.rig.scenario.scenario import load_scenario
    from tactiledata.rig.scenario.worlds import find_scenario

    world: Any = dict(find_scenario("tiny"))  # type: ignore[arg-type]
    world["generate"] = {**world["generate"], "count": touches}
    logs = record(load_scenario(world), folder / "compressed", "mcap")
    plain = folder / "recordings"
    plain.mkdir()
    return [_without_compression(log, plain / log.name) for log in logs]


def _without_compression(source: Path, target: Path) -> Path:
    with source.open("rb") as stream, target.open("wb") as out:
        reader = make_reader(stream)
        writer = Writer(out, compression=CompressionType.NONE, chunk_size=2**16)
        writer.start(profile="ros2", library="comparison")
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                known = schemas[schema.id], channel.metadata
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, *known)
            times = {"log_time": message.log_time, "publish_time": message.publish_time}
            writer.add_message(channels[channel.id], data=message.data, sequence=message.sequence, **times)
        for attachment in reader.iter_attachments():
            given = attachment.create_time, attachment.log_time, attachment.name, attachment.media_type, attachment.data
            writer.add_attachment(*given)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        writer.finish()
    return target


def damaged(log: Path, folder: Path) -> tuple[Path, Path]:
    """The log with one flipped bit inside a picture, and the log cut after 60 % of its bytes."""
    content = bytearray(log.read_bytes())
    flipped, cut = folder / "flipped.mcap", folder / "cut.mcap"
    cut.write_bytes(content[: int(0.6 * len(content))])
    content[content.find(b"\xff\xd8\xff", len(content) // 2) + 3000] ^= 0x10
    flipped.write_bytes(content)
    return flipped, cut


def messages(path: Path, *, seeking: bool = True, check: bool = False) -> tuple[list[bytes], str]:
    """Contents of the messages that the `mcap` package gives, and the error at which it ends."""
    given: list[bytes] = []
    try:
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=check) if seeking else NonSeekingReader(stream, check)
            # a stream that is to be sorted is read to its end first, which a cut file does not have
            given.extend(message.data for _, _, message in reader.iter_messages(log_time_order=seeking))
    except Exception as error:  # noqa: BLE001 - what it raises is the result
        return given, type(error).__name__
    return given, ""


def ours(path: Path, folder: Path, recorded_messages: list[bytes]) -> str:
    """What an ingest keeps of a log, in words; pictures that no recorded message holds count as changed."""
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.store import Store

    store = folder / f"{path.stem}.zarr"
    (source,) = ingest([path], store).sources
    kept = Store.open(store)
    pictures = [content for content in kept.encoded(range(kept.n_frames)) if content is not None]
    long = [message for message in recorded_messages if len(message) > 2000]
    changed = sum(not any(picture in message for message in long) for picture in pictures)
    samples = sum(kept.signal(name).n_rows for name in kept.signal_names if name != "contact_wrench")
    codes = sorted({finding.code for finding in source.findings if finding.severity == "damage"})
    return f"{samples + len(pictures)} messages, {changed} changed; says {', '.join(codes) or 'nothing'}"


def rerun(*arguments: str) -> str:
    """What rerun's command line prints, without colours."""
    command = [str(Path(sys.executable).with_name("rerun")), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)


def row_of_damage(log: Path, folder: Path) -> Iterator[tuple[str, dict[str, str]]]:
    """A flipped bit, and a log that is cut."""
    flipped, cut = damaged(log, folder)
    whole, _ = messages(log)
    total = len(whole)
    plain, _ = messages(flipped)
    checked, error = messages(flipped, check=True)
    changed = len(set(plain) - set(whole))
    report = rerun("mcap", "check", "--full", str(flipped))
    verdict = "`mcap check` says ok" if "ok" in report and "Error" not in report else "`mcap check` refuses it"
    yield (
        f"one bit flipped in a picture, {total} messages",
        {
            "tactiledata": ours(flipped, folder, whole),
            "LeRobot": "reads no MCAP",
            "mcap": f"{len(plain)} messages, {changed} changed, says nothing; "
            f"with `validate_crcs` {len(checked)}, then {error}",
            "rerun": f"{verdict}; converts it, the changed picture too",
        },
    )
    seeking, error = messages(cut)
    streamed, ended = messages(cut, seeking=False, check=True)
    refused = "refuses" if "Error" in rerun("mcap", "check", str(cut)) else "reads"
    recovered = rerun("mcap", "convert", "--recover", str(cut), "-o", str(folder / "cut.rrd"))
    done = "converts with `--recover`" if "rror" not in recovered else "does not convert with `--recover`"
    yield (
        "cut after 60 % of its bytes",
        {
            "tactiledata": ours(cut, folder, whole),
            "LeRobot": "reads no MCAP",
            "mcap": f"{len(seeking)} messages ({error}); as a stream {len(streamed)}, then {ended or 'the end'}",
            "rerun": f"{refused} without `--recover`; {done}",
        },
    )


KILLED = {
    "LeRobot": OWNERS
    + """
import numpy as np
force = {"observation.force": {"dtype": "float32", "shape": (3,), "names": ["x", "y", "z"]}}
dataset = LeRobotDataset.create("killed", fps=30, features=force, root="killed-lerobot", use_videos=False)
for episode in range(3):
    for frame in range(20):
        dataset.add_frame({"observation.force": np.zeros(3, np.float32), "task": "press"})
    dataset.save_episode()
os.kill(os.getpid(), 9)
""",
    "mcap": """
import os
from mcap.reader import make_reader
from mcap.writer import Writer
stream = open("killed.mcap", "wb")
writer = Writer(stream, chunk_size=2**16)
writer.start()
schema = writer.register_schema("force", "jsonschema", b"{}")
channel = writer.register_channel("/force", "json", schema)
for number in range(20000):
    writer.add_message(channel, number, b'{"fz": 1.000000}', number)
stream.flush()
os.kill(os.getpid(), 9)
""",
    "rerun": """
import os, time
import rerun as rr
rr.init("killed")
rr.save("killed.rrd")
for number in range(3):
    rr.set_time("episode", sequence=number)
    rr.log("force", rr.Scalars(1.0))
    time.sleep(0.5)
os.kill(os.getpid(), 9)
""",
}
"""Programs that write with each tool and are killed before they end the file."""
OPENED = (
    OWNERS
    + """
print(json.dumps(LeRobotDataset("killed", root="killed-lerobot").meta.total_episodes))
"""
)


def row_of_kills(logs: list[Path], folder: Path, owners: str) -> tuple[str, dict[str, str]]:
    """Each writer killed by signal 9 before its end; what can be read then, and what the same command does."""
    from tactiledata.store import Store

    # ours: the second of two logs is under way; then the same command again
    command = [str(Path(sys.executable).with_name("tactiledata")), "ingest", *map(str, logs), "--store"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, "PYTHONPATH": str(ROOT)}}
    subprocess.run([*command, str(folder / "whole.zarr")], check=True, **quiet)  # type: ignore[call-overload]
    killed = folder / "killed.zarr"
    process = subprocess.Popen([*command, str(killed)], **quiet)  # type: ignore[call-overload]
    while process.poll() is None and not (killed / ".staging").exists():
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    was_killed = process.wait() == -signal.SIGKILL
    subprocess.run([*command, str(killed)], check=True, **quiet)  # type: ignore[call-overload]
    same = Store.open(killed).digest == Store.open(folder / "whole.zarr").digest
    said = {"tactiledata": f"killed: {was_killed}; the same command goes on, and the store is the same: {same}"}
    # theirs
    for code in KILLED.values():
        program(code, folder, owners)
    opened = program(OPENED, folder, owners)
    said["LeRobot"] = (
        f"opens with {opened.stdout.strip()} of 3 saved episodes"
        if opened.returncode == 0
        else "none of 3 saved episodes opens: its parquet files have no end before `finalize`"
    )
    streamed, _ = messages(folder / "killed.mcap", seeking=False)
    _, error = messages(folder / "killed.mcap")
    said["mcap"] = f"{len(streamed)} of 20000 messages as a stream; a seeking reader ends with {error}"
    verified, stats = (rerun("rrd", verb, str(folder / "killed.rrd")) for verb in ("verify", "stats"))
    counts = [int(number) for number in re.findall(r"^num_(?:rows|static) = (\d+)", stats, re.MULTILINE)]
    verdict = "misses its end" if "footer" in verified else "accepts it"
    said["rerun"] = f"`rrd verify` {verdict}; {counts[0] - counts[1]} of 3 rows are read" if counts else verified[-80:]
    return "killed by signal 9 while it writes", said


READ = (
    OWNERS
    + """
import time
import numpy as np
dataset = LeRobotDataset("tactile", root="for-lerobot")
order = np.random.default_rng(0).permutation(len(dataset)).tolist()
dataset[0]
start = time.process_time()
for number in order:
    dataset[number]
print(json.dumps(1e3 * (time.process_time() - start) / len(order)))
"""
)


def row_of_reading(log: Path, store: Any, folder: Path, owners: str) -> tuple[str, dict[str, str]]:
    """Processor time for a picture and the force at its moment, in random order."""
    import cv2
    import torch

    from tactiledata.loaders.torch import TactileDataset

    torch.set_num_threads(1)
    dataset = TactileDataset(
        store.location, "all", ["digit", "contact_wrench"], allow_leaks=True, missing="keep", threads=1
    )
    order = np.random.default_rng(0).permutation(len(dataset))
    dataset.__getitems__(order[:8].tolist())
    start = time.process_time()
    for rows in np.array_split(order, max(len(order) // 16, 1)):
        dataset.__getitems__(rows.tolist())
    said = {"tactiledata": f"{1e3 * (time.process_time() - start) / len(order):.2f} ms"}
    read = program(READ, folder, owners)
    said["LeRobot"] = f"{float(read.stdout.splitlines()[-1]):.2f} ms" if read.returncode == 0 else read.stderr[-200:]
    with log.open("rb") as stream:
        reader = make_reader(stream)
        pictures = [m.log_time for s, _, m in reader.iter_messages() if s is not None and "Image" in s.name]
        shuffled = np.random.default_rng(0).permutation(pictures)[:20].tolist()
        start = time.process_time()
        for moment in shuffled:
            for schema, _, message in reader.iter_messages(starting_at=moment, ending_before=moment + 1):
                if schema is not None and "Image" in schema.name:
                    content = message.data[message.data.find(b"\xff\xd8\xff") :]
                    cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB)
        said["mcap"] = f"{1e3 * (time.process_time() - start) / len(shuffled):.2f} ms, the picture alone"
    said["rerun"] = "not measured: its queries from Python need packages that are not installed here"
    return "a picture of 320 x 240 and its force, random order, processor time", said


def row_of_sizes(folder: Path, store: Path) -> tuple[str, dict[str, str]]:
    """Space on disk that the same recordings take; holes of files take none."""

    def size(place: Path) -> str:
        files = [place] if place.is_file() else [path for path in place.rglob("*") if path.is_file()]
        return f"{sum(512 * path.stat().st_blocks for path in files) / 1e6:.1f} MB"

    converted = folder / "rrd"
    converted.mkdir()
    for log in sorted((folder / "compressed").glob("*.mcap")):
        rerun("mcap", "convert", str(log), "-o", str(converted / f"{log.stem}.rrd"))
    logs = folder / "logs"
    logs.mkdir()
    for log in (folder / "compressed").glob("*.mcap"):
        shutil.copy(log, logs)
    return (
        "on disk",
        {
            "tactiledata": f"{size(store)}, signals at native rate and aligned",
            "LeRobot": f"{size(folder / 'for-lerobot')}, values at the frames only",
            "mcap": f"{size(logs)} (zstd)",
            "rerun": f"{size(converted)}, converted from MCAP",
        },
    )


def main() -> None:
    """Print the table."""
    from tactiledata.export.export import export_data
    from tactiledata.export.plan import ExportPlan
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.splits.make import make_split
    from tactiledata.store import Store

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--owners", default=str(ROOT / ".venv" / "owners"))
    parser.add_argument("--touches", type=int, default=8)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        logs = recorded(folder, options.touches)
        ingest(logs, folder / "all.zarr")
        store = Store.open(folder / "all.zarr")
        make_split(store, hold_out="none")
        export_data(Store.open(folder / "all.zarr"), ExportPlan(to="lerobot"), folder / "for-lerobot")
        rows = [
            *row_of_damage(logs[0], folder),
            row_of_kills(logs, folder, options.owners),
            row_of_reading(logs[0], store, folder, options.owners),
            row_of_sizes(folder, folder / "all.zarr"),
        ]
    names = {"mcap": "mcap", "rerun": "rerun-sdk"}
    versions = [f"{tool} {importlib.metadata.version(package)}" for tool, package in names.items()]
    found = next(Path(options.owners).glob("lerobot-*.dist-info"), None)
    versions.append(
        f"LeRobot {found.name.split('-')[1].removesuffix('.dist')}" if found else "no LeRobot: `make owners`"
    )
    print(f"{options.touches} simulated touches in {len(logs)} recordings; {', '.join(sorted(versions))}\n")
    print("| | " + " | ".join(TOOLS) + " |")
    print("|---" * (1 + len(TOOLS)) + "|")
    for case, said in rows:
        print(f"| {case} | " + " | ".join(said[tool] for tool in TOOLS) + " |")


if __name__ == "__main__":
    main()
