"""Ingest of an MCAP, checks included, against a plain loop of the `mcap` package that decodes the same messages.

    python benchmarks/ingest_mcap.py [--quick] [--images 2000] [--seconds 60] [--repeats 3]

For raw images the loop compresses each with the codec that the store uses. The loop keeps what it decodes in memory and
checks nothing; ingest checks CRCs, sorts out clocks, aligns, finds contacts and leaves a store on disk.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import sys
import tempfile
from pathlib import Path
from typing import Any

import zstandard
from bag import write_bag
from timing import MEGABYTE, Seat, header, interleaved, median_ratio, table, verdict

from tactiledata.ingest.pipeline import ingest
from tactiledata.store.layout.arrays import ZSTD_LEVEL

TARGET = 1.5


class PlainLoop:
    """What one writes first: decode every message, keep the values, compress raw images."""

    def run(self, bag: str) -> tuple[int, int]:
        """Messages and images that were decoded."""
        from mcap.reader import make_reader
        from mcap_ros2.decoder import DecoderFactory

        values: dict[str, list[Any]] = {}
        compress = zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress
        images = 0
        with Path(bag).open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            for schema, channel, message, decoded in reader.iter_decoded_messages():
                kept = values.setdefault(channel.topic, [])
                stamp = decoded.header.stamp.sec * 10**9 + decoded.header.stamp.nanosec
                kept.append((message.log_time, message.publish_time, stamp, _content(schema.name, decoded, compress)))
                images += schema.name.endswith("Image")
        return sum(len(kept) for kept in values.values()), images


def _content(kind: str, decoded: Any, compress: Any) -> Any:
    if kind == "sensor_msgs/msg/Image":
        return compress(bytes(decoded.data))
    if kind == "sensor_msgs/msg/CompressedImage":
        return bytes(decoded.data)
    if kind == "sensor_msgs/msg/JointState":
        return list(decoded.position)
    if kind == "geometry_msgs/msg/PoseStamped":
        position, turn = decoded.pose.position, decoded.pose.orientation
        return [position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w]
    force, torque = decoded.wrench.force, decoded.wrench.torque
    return [force.x, force.y, force.z, torque.x, torque.y, torque.z]


class Ingest:
    """Ours, into a new store each time."""

    def __init__(self, folder: str) -> None:
        self._folder = Path(folder)

    def run(self, bag: str) -> tuple[int, int]:
        """Images that the store holds, twice."""
        store = self._folder / "ds.zarr"
        if store.exists():
            shutil.rmtree(store)
        (source,) = ingest([bag], store=store).sources
        if source.state != "added" or source.status != "ok":
            raise RuntimeError(f"ingest: {source.state} {source.status} {source.error} {source.findings}")
        return source.frames, source.frames


def contest(kind: str, seconds: float, n_images: int, repeats: int) -> bool:
    """Print the table for JPEG or raw images; whether the target was met."""
    with tempfile.TemporaryDirectory() as scratch:
        bag = Path(scratch) / f"{kind}.mcap"
        write_bag(bag, seconds, n_images, raw=kind == "raw")
        seats = {"tactiledata ingest": Seat(Ingest, scratch), "plain loop of mcap": Seat(PlainLoop)}
        try:
            counts = {name: seat.call("run", str(bag))[-1] for name, seat in seats.items()}
            times, cpu_seconds = interleaved(seats, [("run", (str(bag),))] * repeats)
            memory = {name: seat.memory("run", str(bag)) for name, seat in seats.items()}
        finally:
            for seat in seats.values():
                seat.close()
        size = bag.stat().st_size
    messages, images = counts["plain loop of mcap"]
    if counts["tactiledata ingest"][0] != images:
        raise SystemExit(f"ingest kept {counts['tactiledata ingest'][0]} images, the loop decoded {images}")
    header(
        f"ingest, {kind} images: {messages} messages, {images} images, {size / MEGABYTE:.0f} MB, median of {repeats}",
        ["mcap", "mcap-ros2-support", "zarr", "zstandard"],
    )
    rows = [
        (
            name,
            f"{statistics.median(taken):.2f}",
            f"{statistics.median(cpu_seconds[name]):.2f}",
            f"{messages / statistics.median(taken):,.0f}",
            *_megabytes(memory[name]),
        )
        for name, taken in times.items()
    ]
    table(["way", "seconds", "CPU seconds", "messages/s", "own MB", "mapped MB"], rows)
    return verdict(
        "ingest against the loop, by time",
        median_ratio(times["plain loop of mcap"], times["tactiledata ingest"]),
        TARGET,
        at_most=True,
    )


def _megabytes(memory: dict[str, float]) -> tuple[str, str]:
    return f"{memory['own'] / MEGABYTE:.0f}", f"{memory['mapped'] / MEGABYTE:.0f}"


def main(arguments: list[str] | None = None) -> bool:
    """Run both contests; whether both targets were met."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a run of seconds that only shows that it works")
    parser.add_argument("--images", type=int, default=2000)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--repeats", type=int, default=3)
    chosen = parser.parse_args(arguments)
    size = (5.0, 60, 1) if chosen.quick else (chosen.seconds, chosen.images, chosen.repeats)
    met = [contest(kind, *size) for kind in ("jpeg", "raw")]
    if chosen.quick:
        print("\nquick: this shows that it runs; so few frames measure caches and starting costs, not the ways")
    return all(met)


if __name__ == "__main__":
    main(sys.argv[1:])
