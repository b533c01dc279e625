"""Bad input of many kinds: a clear error, the right exit code, never a traceback, and nothing lost."""

import errno
import io
import json
import os
import pickle
import shutil
import sys
import tarfile
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tactiledata.cli.failure import DEBUG_VARIABLE
from tactiledata.cli.main import run


def command(capsys, *arguments):
    """Exit code and everything printed by one command, run in this process as the installed script runs it."""
    before = sys.argv
    sys.argv = ["tactiledata", *map(str, arguments)]
    code = 0
    try:
        run()
    except SystemExit as stop:
        code = stop.code or 0
    finally:
        sys.argv = before
    printed = capsys.readouterr()
    return code, printed.out + printed.err


class Bench:
    """A folder with a copy of a tiny folder log, a tiny MCAP and a store, to spoil."""

    def __init__(self, folder, folder_log, mcap, store):
        self.folder = folder
        self.log = folder / "log"
        shutil.copytree(folder_log, self.log)
        self.mcap = folder / "run.mcap"
        shutil.copy(mcap, self.mcap)
        self.store = folder / "ds.zarr"
        shutil.copytree(store, self.store)

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


@pytest.fixture
def bench(tmp_path, tiny_folders, tiny_mcaps, tiny_store, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(DEBUG_VARIABLE, raising=False)
    return Bench(tmp_path, tiny_folders[0], tiny_mcaps[0], tiny_store)


CASES = {}


def case(code, *words):
    """Register a way to spoil the bench: the exit code and the words that the message must hold."""

    def register(function):
        CASES[function.__name__] = (function, code, words)
        return function

    return register


@case(2, "does not exist")
def path_that_is_not_there(bench):
    return bench.ingest(bench.folder / "nowhere.mcap")


@case(1, "empty")
def empty_file(bench):
    bench.mcap.write_bytes(b"")
    return bench.ingest(bench.mcap)


@case(1, "no recording")
def folder_without_recordings(bench):
    (bench.folder / "nothing").mkdir()
    return bench.ingest(bench.folder / "nothing")


@case(1, "no recording")
def a_text_file(bench):
    (bench.folder / "notes.txt").write_text("pressed it a few times")
    return bench.ingest(bench.folder / "notes.txt")


@case(1, "damaged")
def mcap_cut_in_half(bench):
    content = bench.mcap.read_bytes()
    bench.mcap.write_bytes(content[: len(content) // 2])
    return bench.ingest(bench.mcap)


@case(1, "damaged")
def mcap_with_a_flipped_byte(bench):
    content = bytearray(bench.mcap.read_bytes())
    content[len(content) // 2] ^= 0xFF
    bench.mcap.write_bytes(content)
    return bench.ingest(bench.mcap)


@case(1, "--strict")
def damage_with_strict(bench):
    content = bench.mcap.read_bytes()
    bench.mcap.write_bytes(content[: len(content) // 2])
    return [*bench.ingest(bench.mcap), "--strict"]


@case(1, "mapping")
def bag_without_tactile_topics(bench):
    shutil.copy(Path(__file__).parents[1] / "data" / "mcap" / "ros2" / "talker.mcap", bench.mcap)
    return bench.ingest(bench.mcap)


@case(1, "not valid YAML")
def broken_yaml(bench):
    (bench.log / "log.yaml").write_text("format: [tactiledata-log/1\nsensors: }")
    return bench.ingest()


@case(1, "given twice")
def a_key_given_twice(bench):
    with (bench.log / "log.yaml").open("a") as stream:
        stream.write("\nformat: tactiledata-log/1\n")
    return bench.ingest()


@case(1, "tactiledata-log/99", "newer")
def description_of_another_version(bench):
    bench.edit("log.yaml", "tactiledata-log/1", "tactiledata-log/99")
    return bench.ingest()


@case(1, "leaves the folder")
def background_outside_the_folder(bench):
    text = (bench.log / "log.yaml").read_text()
    name = next(line.split("background:")[1].strip() for line in text.splitlines() if "background:" in line)
    bench.edit("log.yaml", name, "../../../etc/passwd")
    return bench.ingest()


@case(1, "leaves the folder")
def image_outside_the_folder(bench):
    bench.lines(
        "frames.csv", lambda rows: [*rows[:5], ",".join([*rows[5].split(",")[:-1], "../../secret.png"]), *rows[6:]]
    )
    return bench.ingest()


@case(1, "wrench.csv")
def missing_column(bench):
    bench.edit("wrench.csv", "fz", "force_z")
    return bench.ingest()


@case(1, "no finite number")
def not_a_number_in_the_wrench(bench):
    bench.lines("wrench.csv", lambda rows: [*rows[:50], ",".join([rows[50].split(",")[0], *["nan"] * 6]), *rows[51:]])
    return bench.ingest()


@case(0, "earlier than the one before")
def times_out_of_order(bench):
    bench.lines("wrench.csv", lambda rows: [*rows[:50], rows[60], *rows[50:60], *rows[61:]])
    return bench.ingest()


@case(1, "t_ns")
def times_in_float_seconds(bench):
    def seconds(rows):
        return [rows[0], *(",".join([f"{int(row.split(',')[0]) / 1e9:.6f}", *row.split(",")[1:]]) for row in rows[1:])]

    bench.lines("wrench.csv", seconds)
    return bench.ingest()


@case(1, "end before they start")
def trajectory_that_ends_before_it_starts(bench):
    def reverse(rows):
        head = rows[0].split(",")
        first = rows[1].split(",")
        start, end = head.index("start_ns"), head.index("end_ns")
        first[start], first[end] = first[end], first[start]
        return [rows[0], ",".join(first), *rows[2:]]

    bench.lines("trajectories.csv", reverse)
    return bench.ingest()


@case(1, "sensor")
def trajectory_of_an_unknown_sensor(bench):
    bench.edit("trajectories.csv", "D20001", "D99999")
    return bench.ingest()


@case(1, "which is not there", "count 3")
def frames_whose_files_are_gone(bench):
    for path in sorted((bench.log / "frames").iterdir())[:3]:
        path.unlink()
    return bench.ingest()


@case(1, "damage")
def image_that_is_cut(bench):
    path = sorted((bench.log / "frames").iterdir())[0]
    path.write_bytes(path.read_bytes()[:-500])
    return bench.ingest()


@case(1, "swapped")
def images_with_height_and_width_swapped(bench):
    for path in (bench.log / "frames").iterdir():
        cv2.imwrite(str(path), cv2.rotate(cv2.imread(str(path)), cv2.ROTATE_90_CLOCKWISE))
    return bench.ingest()


@case(0, "BGR")
def images_with_blue_for_red(bench):
    for path in (bench.log / "frames").iterdir():
        cv2.imwrite(str(path), cv2.imread(str(path))[..., ::-1])
    return bench.ingest()


@case(1, "rigid")
def a_transform_that_shears(bench):
    import yaml

    document = yaml.safe_load((bench.log / "log.yaml").read_text())
    document["robot"]["tcp_from_gel"] = [[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    (bench.log / "log.yaml").write_text(yaml.safe_dump(document))
    return bench.ingest()


@case(0, "wrench", "frame")
def no_robot_description(bench):
    import yaml

    document = yaml.safe_load((bench.log / "log.yaml").read_text())
    del document["robot"]
    (bench.log / "log.yaml").write_text(yaml.safe_dump(document))
    return bench.ingest()


@case(1, "posix.system", "could run code")
def a_pickle_that_would_run(bench):
    class Trap:
        def __reduce__(self):
            return os.system, (f"touch {bench.folder / 'ran'}",)

    home = bench.folder / "sphere" / "batch_1"
    home.mkdir(parents=True)
    (home / "dataset_digit_00.pkl").write_bytes(pickle.dumps([Trap()]))
    (home / "dataset_slip_forces.pkl").write_bytes(pickle.dumps({"in_contact": Trap()}))
    return bench.ingest(bench.folder / "sphere")


@case(1, "leads out of the archive")
def a_tar_that_climbs_out(bench):
    home = bench.folder / "fota" / "train"
    home.mkdir(parents=True)
    with tarfile.open(home / "data-000000.tar", "w") as archive:
        for name in ("../../evil.jpg", "../../evil.json"):
            content = b"{}"
            member = tarfile.TarInfo(name)
            member.size = len(content)
            archive.addfile(member, io.BytesIO(content))
    (home / "count.txt").write_text("1\n")
    return [*bench.ingest(bench.folder / "fota"), "--format", "fota"]


@case(2, "dataPack.npz", "not of format")
def a_zip_that_is_no_array(bench):
    with zipfile.ZipFile(bench.folder / "dataPack.npz", "w") as archive:
        archive.writestr("../../evil.npy", b"evil")
        archive.writestr("imgs.npy", b"no array")
    return [*bench.ingest(bench.folder / "dataPack.npz"), "--format", "gelsight_presses"]


@case(2, "unknown log format", "Did you mean mcap")
def format_with_a_slip(bench):
    return [*bench.ingest(bench.mcap), "--format", "mcapp"]


@case(2, "$.signals")
def mapping_that_does_not_fit(bench):
    (bench.folder / "mapping.yaml").write_text("format: tactiledata-mapping/1\nsignals: {wrench: {tpoic: /w}}\n")
    return [*bench.ingest(bench.mcap), "--mapping", "mapping.yaml"]


@case(0, "/nowhere, which is not there")
def mapping_to_a_topic_that_is_not_there(bench):
    (bench.folder / "mapping.yaml").write_text("format: tactiledata-mapping/1\nsignals: {wrench: {topic: /nowhere}}\n")
    return [*bench.ingest(bench.mcap), "--mapping", "mapping.yaml"]


@case(2, "at least 1")
def zero_workers(bench):
    return [*bench.ingest(), "--workers", "0"]


@case(2, "Dask")
def a_scheduler_that_is_not_there(bench, monkeypatch=None):
    import tactiledata.compute.dask as dask

    dask.CONNECT_TIMEOUT = 0.5
    return [*bench.ingest(), "--scheduler", "tcp://127.0.0.1:9"]


@case(1, "holds")
def store_path_that_is_another_folder(bench):
    return ["ingest", bench.log, "--store", bench.log]


@case(1, "is a file")
def store_path_that_is_a_file(bench):
    return ["ingest", bench.log, "--store", bench.mcap]


@case(1, "store")
def a_folder_that_is_no_store(bench):
    return ["info", bench.log]


@case(2, "no store at")
def a_store_that_is_not_there(bench):
    return ["info", bench.folder / "nowhere.zarr"]


@case(1, "newer")
def a_store_of_a_newer_version(bench):
    manifest = bench.store / "manifest.json"
    document = json.loads(manifest.read_text())
    name, _, _ = document["format"].partition("/")
    document["format"] = f"{name}/99"
    manifest.write_text(json.dumps(document))
    return ["info", bench.store]


@case(1, "JSON")
def a_manifest_that_is_cut(bench):
    manifest = bench.store / "manifest.json"
    manifest.write_bytes(manifest.read_bytes()[:100])
    return ["check", bench.store]


@case(1, "damage")
def a_store_with_a_flipped_byte(bench):
    heap = max(
        (path for path in (bench.store / "streams").rglob("*") if path.is_file()),
        key=lambda path: path.stat().st_blocks,
    )
    with heap.open("r+b") as stream:
        stream.seek(1000)
        byte = stream.read(1)
        stream.seek(1000)
        stream.write(bytes([byte[0] ^ 0xFF]))
    return ["check", bench.store]


@case(1, "is damaged")
def a_store_whose_sensors_were_edited_to_nonsense(bench):
    (bench.store / "sensors.json").write_text('{"D20001": 1, "D20002": []}')
    return ["info", bench.store]


@case(1, "is damaged")
def a_store_whose_tables_were_rewritten(bench):
    part = next((bench.store / "index" / "trajectories.parquet").glob("*.parquet"))
    table = pq.read_table(part)
    column = table.schema.get_field_index("signal_rows")
    pq.write_table(table.set_column(column, "signal_rows", pa.array(["1 2"] * len(table))), part)
    return ["report", bench.store, "--out", bench.folder / "page"]


@case(1, "no number a machine can keep")
def a_pose_with_a_number_beyond_all_machines(bench):
    import yaml

    document = yaml.safe_load((bench.log / "log.yaml").read_text())
    document["robot"]["tcp_from_gel"]["xyz"] = [10**400, 0, 0]
    (bench.log / "log.yaml").write_text(yaml.safe_dump(document))
    return bench.ingest()


@case(1, "a time beyond the year 2116")
def times_at_the_end_of_the_world(bench):
    bench.lines(
        "wrench.csv",
        lambda rows: [*rows[:20], ",".join(["-9223372036854775807", *rows[20].split(",")[1:]]), *rows[21:]],
    )
    return bench.ingest()


@case(0, "beyond 300 N")
def forces_beyond_all_sensors(bench):
    bench.lines(
        "wrench.csv",
        lambda rows: [*rows[:20], ",".join([rows[20].split(",")[0], "1e308", *rows[20].split(",")[2:]]), *rows[21:]],
    )
    return bench.ingest()


@case(2, "several stores")
def two_stores_and_none_named(bench):
    shutil.copytree(bench.store, bench.folder / "other.zarr")
    return ["split", "--by", "trajectory,sensor"]


@case(2, "tear trajectories apart")
def split_by_frame(bench):
    return ["split", bench.store, "--by", "frame"]


@case(2, "D20099", "Did you mean")
def hold_out_of_an_unknown_sensor(bench):
    return ["split", bench.store, "--name", "other", "--hold-out", "sensor=D20099"]


@case(2, "1.2")
def fractions_beyond_one(bench):
    return ["split", bench.store, "--name", "other", "--fractions", "0.8,0.2,0.2"]


@case(2, "name")
def split_name_that_is_a_path(bench):
    return ["split", bench.store, "--name", "../../evil"]


@case(2, "force")
def force_range_that_is_words(bench):
    return ["split", bench.store, "--name", "other", "--force", "gentle"]


@case(2, "nothing")
def audit_of_a_split_that_is_not_there(bench):
    return ["audit", bench.store, "--split", "nothing"]


@case(1, "")
def audit_of_a_tampered_split(bench):
    path = bench.store / "splits" / "default.parquet"
    path.write_bytes(path.read_bytes()[:-1] + b"X")
    return ["audit", bench.store]


@case(2, "scenario", "tiny")
def unknown_scenario(bench):
    return ["record", "tny", "--out", bench.folder / "out"]


@case(2, "$.")
def scenario_that_does_not_fit(bench):
    (bench.folder / "world.yaml").write_text("format: tactiledata-scenario/1\nseed: many\n")
    return ["record", bench.folder / "world.yaml", "--out", bench.folder / "out"]


@case(2, "mcap")
def unknown_form_of_log(bench):
    return ["record", "tiny", "--out", bench.folder / "out", "--format", "bag"]


@case(2, "holds files")
def demo_into_a_folder_of_yours(bench):
    return ["demo", "--out", bench.log]


@case(2, "NAME")
def sensor_without_a_picture(bench):
    return ["sensors", "add", "D1"]


@case(2, "does not exist")
def sensor_with_a_picture_that_is_not_there(bench):
    return ["sensors", "add", "D1", "--background", bench.folder / "none.png", "--store", bench.store]


@case(2, "--no-such-option")
def an_option_that_is_not_there(bench):
    return ["info", "--no-such-option"]


@case(2, "needs no mapping")
def mapping_for_a_log_that_needs_none(bench):
    return ["inspect", bench.log, "--suggest-mapping"]


@pytest.mark.parametrize("name", CASES)
def test_bad_input_is_answered_in_words(name, bench, capsys):
    """The exit code is right, the message names what was wrong, no traceback, and the store is untouched."""
    spoil, code, words = CASES[name]
    arguments = spoil(bench)
    before = (bench.store / "manifest.json").read_bytes()
    found, text = command(capsys, *arguments)
    assert "Traceback" not in text
    assert "a fault of tactiledata" not in text, text
    assert found == code, text
    flat = " ".join(text.split())
    for word in words:
        assert word in flat, text
    assert (bench.store / "manifest.json").read_bytes() == before
    assert not (bench.folder / "ran").exists()
    assert not (bench.folder.parent / "evil.jpg").exists()


def test_there_are_at_least_forty_kinds():
    """The table stays wide."""
    assert len(CASES) >= 40


def test_very_long_and_unicode_names_survive(bench, capsys):
    """A recording, a trajectory and a sensor with names of other scripts and 150 letters come through as they are."""
    name = "Prüfung-测试-🤖-" + "x" * 130
    bench.lines("trajectories.csv", lambda rows: [rows[0], ",".join([name, *rows[1].split(",")[1:]]), *rows[2:]])
    moved = bench.folder / f"log-{name}"
    bench.log.rename(moved)
    code, text = command(capsys, "ingest", moved, "--store", bench.folder / "new.zarr", "--json")
    assert code in (0, 1), text
    code, text = command(capsys, "info", bench.folder / "new.zarr")
    assert code == 0, text
    from tactiledata.store.reader import Store

    assert name in Store.open(bench.folder / "new.zarr").trajectories(["trajectory"])["trajectory"].to_pylist()


def test_a_full_disk_loses_nothing(bench, capsys, monkeypatch):
    """When the disk fills, the message says so, the store is as before, and a later run completes it."""
    before = (bench.store / "manifest.json").read_bytes()
    fsync = os.fsync
    calls = [0]

    def full(descriptor):
        calls[0] += 1
        if calls[0] > 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        return fsync(descriptor)

    (bench.log / "log.yaml").write_text((bench.log / "log.yaml").read_text() + "\n# another log\n")
    monkeypatch.setattr(os, "fsync", full)
    code, text = command(capsys, "ingest", bench.log, "--store", bench.store)
    assert code == 1
    assert "No space left" in text
    assert (bench.store / "manifest.json").read_bytes() == before
    monkeypatch.setattr(os, "fsync", fsync)
    code, text = command(capsys, "ingest", bench.log, "--store", bench.store)
    assert code == 0, text
    code, text = command(capsys, "check", bench.store)
    assert code == 0, text


def test_no_read_permission_is_said(bench, capsys, monkeypatch):
    """A file that may not be read is named, and the other recordings come in."""
    import builtins
    import pathlib

    real = pathlib.Path.open

    def guarded(self, *arguments, **options):
        if self.name == "run.mcap":
            raise PermissionError(errno.EACCES, "Permission denied", str(self))
        return real(self, *arguments, **options)

    monkeypatch.setattr(pathlib.Path, "open", guarded)
    monkeypatch.setattr(builtins, "open", builtins.open)
    code, text = command(capsys, "ingest", bench.mcap, bench.log, "--store", bench.folder / "new.zarr")
    assert code == 1
    assert "Permission denied" in text
    assert "Traceback" not in text


def test_a_picture_of_noise_is_still_a_picture(bench, capsys):
    """Negative control: an unusual but valid picture is taken without damage."""
    path = sorted((bench.log / "frames").iterdir())[0]
    image = np.random.default_rng(0).integers(0, 255, (320, 240, 3), dtype=np.uint8)
    cv2.imwrite(str(path), image)
    code, text = command(capsys, *bench.ingest())
    assert code == 0, text
