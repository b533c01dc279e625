"""Spoilt recordings of many kinds: a clear error, the right exit code, never a traceback, and nothing lost."""

import io
import os
import pickle
import shutil
import tarfile
import zipfile
from pathlib import Path

import cv2
import pytest
from bench import Cases, assert_answered_in_words

CASES = Cases()
case = CASES.case


@case(2, "does not exist")
def path_that_is_not_there(bench):
    return bench.ingest(bench.folder / "nowhere.mcap")


@case(2, "does not exist", "only stores are read from there")
def address_of_recordings(bench):
    return bench.ingest("s3://bucket/recordings")


@case(1, "empty", "no recording was added to")
def empty_file(bench):
    bench.mcap.write_bytes(b"")
    return bench.ingest(bench.mcap)


@case(1, "holds no recording and no file")
def folder_without_recordings(bench):
    (bench.folder / "nothing").mkdir()
    return bench.ingest(bench.folder / "nothing")


@case(1, "not a recording", "docs/formats-folder.md", "docs/formats-hdf5.md")
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


@case(1, "wrench: 1 of ", "a number that no sensor gives (beyond 1e+08; the first is fx = 1e+308 N); left out")
def forces_beyond_all_sensors(bench):
    bench.lines(
        "wrench.csv",
        lambda rows: [*rows[:20], ",".join([rows[20].split(",")[0], "1e308", *rows[20].split(",")[2:]]), *rows[21:]],
    )
    return bench.ingest()


WHOLE = (
    "forces_beyond_all_sensors",
    "frames_whose_files_are_gone",
    "image_that_is_cut",
    "images_with_blue_for_red",
    "images_with_height_and_width_swapped",
    "mcap_with_a_flipped_byte",
    "no_robot_description",
    "times_at_the_end_of_the_world",
    "times_out_of_order",
    "trajectory_of_an_unknown_sensor",
    "trajectory_that_ends_before_it_starts",
)
"""Cases in which a whole ingest runs before, or in spite of, the fault."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in WHOLE else ()) for name in CASES]
)
def test_bad_recordings_are_answered_in_words(name, bench, capsys):
    """Each is answered as the table says, and leaves nothing spoilt behind."""
    assert_answered_in_words(CASES[name], bench, capsys)


def test_the_table_stays_wide():
    """The table has at least 25 kinds of bad recordings."""
    assert len(CASES) >= 25
