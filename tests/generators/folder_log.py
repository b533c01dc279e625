"""Small valid folder logs, and a table of faults to plant into them, each with what a reader must say about it.

Run as a script to look at one: ``python folder_log.py FOLDER [FAULT ...]``.
"""

import os
import sys
from pathlib import Path

import cv2
import numpy as np
import yaml

START = 1_700_000_000_123_456_789
"""Host time of the first sample, ns: odd on purpose, no float keeps it."""
STEP = 8_000_000
"""Period of wrench, tcp and joints, ns (125 Hz)."""
TOUCH = 400_000_000
"""Length of a trajectory, ns; pauses between them are as long."""
SENSOR = "D20542"


def description(sensors=(SENSOR,), background=True):
    """The content of a log.yaml."""
    pose = {"xyz": [0.4, -0.1, 0.02], "xyzw": [0, 0, 0, 1]}
    return {
        "format": "tactiledata-log/1",
        "sensors": {
            serial: {"model": "digit", **({"background": f"backgrounds/{serial}.png"} if background else {})}
            for serial in sensors
        },
        "indenters": {"ball4": {"shape": "sphere", "radius": 0.004, "base_from_indenter": pose}},
        "robot": {"model": "ur5e", "tcp_from_gel": pose, "tcp_from_ft": pose},
        "wrench": {"model": "robotiq_ft300s", "sign": "load_on_sensor", "gravity": "included", "tare_ns": [START]},
        "clocks": {"frames": {"offset_ns": 0, "known": True}},
    }


def write(folder, *, touches=2, frames=4, size=(32, 24), suffix=".png", sensors=(SENSOR,), seed=0, faults=()):
    """A folder log of ``touches`` trajectories with ``frames`` images each; returns the planted truth.

    ``size``: rows and columns of the images. ``faults``: names in `FAULTS`, planted after writing.
    """
    folder = Path(folder)
    rng = np.random.default_rng(seed)
    (folder / "frames").mkdir(parents=True)
    (folder / "backgrounds").mkdir()
    for serial in sensors:
        picture(folder / "backgrounds" / f"{serial}.png", rng, size)
    (folder / "log.yaml").write_text(yaml.safe_dump(description(sensors)), encoding="utf-8")
    starts = START + 2 * TOUCH * np.arange(touches)
    lines(
        folder / "trajectories.csv",
        "trajectory,start_ns,end_ns,sensor,indenter,depth,spot",
        [
            f"t{k},{start},{start + TOUCH},{sensors[k % len(sensors)]},ball4,0.{k + 1},{('rim', 'middle')[k % 2]}"
            for k, start in enumerate(starts)
        ],
    )
    truth = {"starts": starts, **tables(folder, rng, np.arange(START, starts[-1] + TOUCH, STEP))}
    rows, payloads = [], []
    for k, start in enumerate(starts):
        for f in range(frames):
            name = f"frames/t{k}_{f}{suffix}"
            payloads.append(picture(folder / name, rng, size))
            rows.append(f"{start + f * (TOUCH // frames)},t{k},{name}")
    lines(folder / "frames.csv", "t_ns,trajectory,file", rows)
    for fault in faults:
        FAULTS[fault][0](folder)
    return {**truth, "payloads": payloads}


def tables(folder, rng, times):
    """wrench.csv, tcp.csv and joints.csv; returns what was written."""
    wrench = rng.normal(0, 3, (len(times), 6)).round(6)
    quaternions = rng.normal(size=(len(times), 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    tcp = np.concatenate([rng.normal(0, 0.3, (len(times), 3)).round(7), quaternions], axis=1)
    joints = rng.uniform(-3, 3, (len(times), 6)).round(6)
    heads = {"wrench": "t_ns,fx,fy,fz,tx,ty,tz", "tcp": "t_ns,x,y,z,qx,qy,qz,qw", "joints": "t_ns,q0,q1,q2,q3,q4,q5"}
    values = {"wrench": wrench, "tcp": tcp, "joints": joints}
    for name, head in heads.items():
        rows = [f"{t}," + ",".join(repr(float(v)) for v in row) for t, row in zip(times, values[name], strict=True)]
        lines(folder / f"{name}.csv", head, rows)
    return {"times": times, **values}


def picture(path, rng, size):
    """An image file of random colours; returns its bytes."""
    done, payload = cv2.imencode(path.suffix, rng.integers(0, 256, (*size, 3), dtype=np.uint8))
    assert done
    path.write_bytes(payload.tobytes())
    return payload.tobytes()


def lines(path, head, rows):
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


def edit(name, change):
    """A fault that rewrites a table's lines."""

    def plant(folder):
        path = folder / name
        path.write_text("\n".join(change(path.read_text(encoding="utf-8").splitlines())) + "\n", encoding="utf-8")

    return plant


def cell(name, row, column, value):
    """A fault that replaces one cell of a table (row 1 is the first below the header)."""

    def change(rows):
        cells = rows[row].split(",")
        cells[column] = value
        return [*rows[:row], ",".join(cells), *rows[row + 1 :]]

    return edit(name, change)


def rewrite(name, change):
    """A fault that rewrites a file's bytes."""

    def plant(folder):
        path = folder / name
        path.write_bytes(change(path.read_bytes()))

    return plant


def describe(change):
    """A fault that changes log.yaml."""

    def plant(folder):
        path = folder / "log.yaml"
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
        change(document)
        path.write_text(yaml.safe_dump(document), encoding="utf-8")

    return plant


def remove(name):
    return lambda folder: (folder / name).unlink()


def link_out(name):
    """A fault that replaces a file by a link to a file outside the folder."""

    def plant(folder):
        secret = folder.parent / "secret"
        secret.write_bytes(b"t_ns,fx\n1,2\n")
        (folder / name).unlink()
        (folder / name).symlink_to(secret)

    return plant


def all_quaternions_half(rows):
    return [rows[0], *(",".join([*row.split(",")[:4], "0.5", "0", "0", "0"]) for row in rows[1:])]


def seconds(rows):
    return [rows[0], *(f"{int(row.split(',')[0]) / 1e9:.6f}," + row.partition(",")[2] for row in rows[1:])]


def last_line_open(content):
    return content.rstrip(b"\n")


FAULTS = {
    "wrench-nan": (cell("wrench.csv", 3, 2, "nan"), "csv-value", "damage"),
    "wrench-inf": (cell("wrench.csv", 3, 2, "-inf"), "csv-value", "damage"),
    "wrench-word": (cell("wrench.csv", 3, 2, "1.2.3"), "csv-value", "damage"),
    "wrench-empty-cell": (cell("wrench.csv", 3, 2, ""), "csv-value", "damage"),
    "wrench-time-word": (cell("wrench.csv", 3, 0, "noon"), "csv-time", "damage"),
    "wrench-time-float": (cell("wrench.csv", 3, 0, "1700000000123456789.0"), "csv-time", "damage"),
    "wrench-time-huge": (cell("wrench.csv", 3, 0, "9" * 25), "csv-time", "damage"),
    "wrench-short-row": (edit("wrench.csv", lambda r: [*r[:2], "1,2", *r[2:]]), "csv-row-length", "damage"),
    "wrench-long-row": (edit("wrench.csv", lambda r: [*r[:2], r[2] + ",9", *r[3:]]), "csv-row-length", "damage"),
    "wrench-open-quote": (edit("wrench.csv", lambda r: [*r[:2], '"' + r[2], *r[3:]]), "csv-row-length", "damage"),
    "wrench-cut": (rewrite("wrench.csv", lambda b: b[: len(b) - 60]), "csv-last-line-cut", "damage"),
    "wrench-last-line-open": (rewrite("wrench.csv", last_line_open), "csv-last-line-open", "warning"),
    "wrench-zero-tail": (rewrite("wrench.csv", lambda b: b + bytes(4096)), "csv-zero-bytes", "damage"),
    "wrench-bad-byte": (rewrite("wrench.csv", lambda b: b[:90] + b"\xff" + b[91:]), "csv-encoding", "damage"),
    "wrench-empty": (rewrite("wrench.csv", lambda b: b""), "csv-empty", "damage"),
    "wrench-header-only": (edit("wrench.csv", lambda r: r[:1]), "csv-no-rows", "warning"),
    "wrench-gone": (remove("wrench.csv"), "stream-missing", "damage"),
    "wrench-extra-column": (edit("wrench.csv", lambda r: [r[0] + ",mood", *(x + ",1" for x in r[1:])]),
                            "columns-ignored", "info"),
    "tcp-not-unit": (cell("tcp.csv", 3, 4, "7"), "quaternion-not-unit", "damage"),
    "tcp-all-not-unit": (edit("tcp.csv", all_quaternions_half), "quaternion-not-unit", "damage"),
    "tcp-zero": (edit("tcp.csv", lambda r: [*r[:2], r[2].split(",")[0] + ",0,0,0,0,0,0,0", *r[3:]]),
                 "quaternion-not-unit", "damage"),
    "tcp-rounded": (edit("tcp.csv", lambda r: [*r[:2], r[2].split(",")[0] + ",0,0,0,0.7071,0,0,0.7072", *r[3:]]),
                    "quaternion-normalised", "info"),
    "touch-reversed": (cell("trajectories.csv", 1, 2, str(START - 1)), "trajectory-reversed", "damage"),
    "touch-overlap": (cell("trajectories.csv", 1, 2, str(START + 3 * TOUCH)), "trajectory-overlap", "damage"),
    "touch-no-end": (cell("trajectories.csv", 1, 2, ""), "trajectory-time", "damage"),
    "touch-no-name": (cell("trajectories.csv", 1, 0, ""), "trajectory-name", "damage"),
    "touch-twice": (cell("trajectories.csv", 2, 0, "t0"), "trajectory-name-repeated", "warning"),
    "touch-unknown-sensor": (cell("trajectories.csv", 1, 3, "D2O542"), "sensor-not-described", "damage"),
    "touch-unknown-indenter": (cell("trajectories.csv", 1, 4, "bal4"), "indenter-not-described", "damage"),
    "touch-without-sensor": (cell("trajectories.csv", 1, 3, ""), "trajectory-sensor-taken", "info"),
    "touches-gone": (remove("trajectories.csv"), "no-trajectories", "info"),
    "frame-gone": (remove("frames/t0_1.png"), "image-missing", "damage"),
    "frame-cut": (rewrite("frames/t0_1.png", lambda b: b[: len(b) // 2]), "image-truncated", "damage"),
    "frame-cut-in-header": (rewrite("frames/t0_1.png", lambda b: b[:12]), "image-unreadable", "damage"),
    "frame-empty-file": (rewrite("frames/t0_1.png", lambda b: b""), "image-unreadable", "damage"),
    "frame-is-text": (rewrite("frames/t0_1.png", lambda b: b"<html>404</html>"), "image-unreadable", "damage"),
    "frame-is-folder": (lambda folder: ((folder / "frames/t0_1.png").unlink(), (folder / "frames/t0_1.png").mkdir()),
                        "image-unreadable", "damage"),
    "frame-is-pipe": (lambda folder: ((folder / "frames/t0_1.png").unlink(), os.mkfifo(folder / "frames/t0_1.png")),
                      "image-unreadable", "damage"),
    "frame-name-too-long": (cell("frames.csv", 2, 2, "frames/" + "x" * 4000 + ".png"), "image-missing", "damage"),
    "frame-unlisted": (edit("frames.csv", lambda r: r[:-1]), "frame-file-unlisted", "warning"),
    "frame-unknown-touch": (cell("frames.csv", 2, 1, "t99"), "frame-trajectory-unknown", "damage"),
    "frame-outside-its-touch": (cell("frames.csv", 2, 0, str(START - 5)), "frame-outside-trajectory", "warning"),
    "frame-outside-all": (edit("frames.csv", lambda r: [*r, f"{START - 5},,"]),
                          "frame-outside-trajectories", "warning"),
    "frames-gone": (remove("frames.csv"), "stream-missing", "damage"),
    "background-gone": (remove(f"backgrounds/{SENSOR}.png"), "background-missing", "damage"),
    "background-broken": (rewrite(f"backgrounds/{SENSOR}.png", lambda b: b[:30]), "background-broken", "damage"),
    "background-other-size": (
        lambda folder: picture(folder / f"backgrounds/{SENSOR}.png", np.random.default_rng(1), (24, 32)),
        "background-size", "damage"),
}  # fmt: skip
"""Survivable faults: how to plant them, and the code and severity of the finding that must name them."""

FATAL = {
    "not-yaml": (rewrite("log.yaml", lambda b: b + b"\n  - [broken"), "SchemaError", "not valid YAML"),
    "yaml-empty": (rewrite("log.yaml", lambda b: b""), "SchemaError", "schema 'log'"),
    "yaml-object": (rewrite("log.yaml", lambda b: b"a: !!python/object/apply:os.getcwd []\n" + b), "SchemaError",
                    "YAML"),
    "yaml-misspelt-key": (describe(lambda d: d["robot"].update(tcp_from_jel={"xyz": [0, 0, 0]})), "SchemaError",
                          r"\$\.robot"),
    "yaml-newer": (describe(lambda d: d.update(format="tactiledata-log/2")), "SchemaError", "newer tactiledata"),
    "yaml-sheared": (describe(lambda d: d["robot"].update(
        tcp_from_gel=[[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])), "SchemaError", "not a rigid"),
    "no-tables": (lambda folder: [path.unlink() for path in folder.glob("*.csv")], "BrokenLog", "none of"),
    "wrench-semicolons": (rewrite("wrench.csv", lambda b: b.replace(b",", b";")), "BrokenLog", "semicolons"),
    "wrench-tabs": (rewrite("wrench.csv", lambda b: b.replace(b",", b"\t")), "BrokenLog", "tabs"),
    "wrench-utf16": (rewrite("wrench.csv", lambda b: b.decode().encode("utf-16")), "BrokenLog", "UTF-16"),
    "wrench-no-fz": (edit("wrench.csv", lambda r: [r[0].replace("fz", "Fz"), *r[1:]]), "BrokenLog", "'fz' missing"),
    "wrench-no-header": (edit("wrench.csv", lambda r: r[1:]), "BrokenLog", "missing"),
    "wrench-column-twice": (edit("wrench.csv", lambda r: [r[0].replace("fz", "fy"), *r[1:]]), "BrokenLog", "twice"),
    "wrench-seconds": (edit("wrench.csv", seconds), "BrokenLog", "integer nanoseconds"),
    "touches-seconds": (edit("trajectories.csv", lambda r: [r[0], *(x.replace("789,", "789.0,") for x in r[1:])]),
                        "BrokenLog", "integer nanoseconds"),
    "touches-no-start": (edit("trajectories.csv", lambda r: [r[0].replace("start_ns", "start"), *r[1:]]), "BrokenLog",
                         "'start_ns' missing"),
    "frames-no-file": (edit("frames.csv", lambda r: [r[0].replace("file", "image"), *r[1:]]), "BrokenLog",
                       "'file' missing"),
    "wrench-is-folder": (lambda folder: ((folder / "wrench.csv").unlink(), (folder / "wrench.csv").mkdir()),
                         "BrokenLog", "not a file"),
    "frame-path-up": (cell("frames.csv", 2, 2, "../secret.png"), "UnsafeContent", "path '../secret.png', which leaves"),
    "frame-path-absolute": (cell("frames.csv", 2, 2, "/etc/passwd"), "UnsafeContent", "leaves the folder"),
    "frame-path-windows": (cell("frames.csv", 2, 2, "..\\secret.png"), "UnsafeContent", "leaves the folder"),
    "frame-link-out": (link_out("frames/t0_1.png"), "UnsafeContent", "leaves the folder"),
    "wrench-link-out": (link_out("wrench.csv"), "UnsafeContent", "leaves the folder"),
    "background-link-out": (link_out(f"backgrounds/{SENSOR}.png"), "UnsafeContent", "leaves the folder"),
    "background-path-up": (describe(lambda d: d["sensors"][SENSOR].update(background="../b.png")), "UnsafeContent",
                           "leaves the folder"),
}  # fmt: skip
"""Faults that refuse the whole log: how to plant them, the error's class, and words of its message."""

if __name__ == "__main__":
    write(sys.argv[1], faults=sys.argv[2:])
