"""Wrong calls and spoilt stores of many kinds: a clear error, the right exit code, never a traceback."""

import json

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from bench import Cases, assert_answered_in_words
from copied_trees import copy_tree

from tactiledata.export.export import export_data
from tactiledata.export.plan import ExportPlan
from tactiledata.store.read.reader import Store

CASES = Cases()
case = CASES.case


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
def a_scheduler_that_is_not_there(bench):
    bench.patch.setattr("tactiledata.compute.dask.CONNECT_TIMEOUT", 0.5)
    return [*bench.ingest(), "--scheduler", "tcp://127.0.0.1:9"]


@case(2, "holds")
def store_path_that_is_another_folder(bench):
    return ["ingest", bench.log, "--store", bench.log]


@case(2, "is a file")
def store_path_that_is_a_file(bench):
    return ["ingest", bench.log, "--store", bench.mcap]


@case(2, "store")
def a_folder_that_is_no_store(bench):
    return ["info", bench.log]


@case(2, "is no folder")
def a_file_in_the_place_of_a_store(bench):
    return ["info", bench.mcap]


@case(2, "/dev/zero is a pipe or a device")
def a_device_in_the_place_of_a_recording(bench):
    return ["ingest", "/dev/zero", "--store", bench.folder / "new.zarr"]


@case(2, "/dev/zero is a pipe or a device")
def a_device_to_inspect(bench):
    return ["inspect", "/dev/zero"]


@case(2, "no store at")
def a_store_that_is_not_there(bench):
    return ["info", bench.folder / "nowhere.zarr"]


@case(2, "no store at", "Did you mean ds.zarr?")
def a_store_with_a_slip(bench):
    assert bench.store.is_dir()
    return ["info", "ds.zar"]


@case(2, "does not exist", "Did you mean run.mcap?")
def a_recording_with_a_slip(bench):
    assert bench.mcap.is_file()
    return bench.ingest("runn.mcap")


def export_of(bench, form):
    """The folder of an export of the bench's store, without a split."""
    return export_data(Store.open(bench.store), ExportPlan(form, "none"), bench.folder / form).folder


@case(2, "wrote as huggingface", "Train from it")
def an_export_in_the_place_of_recordings(bench):
    return bench.ingest(export_of(bench, "huggingface"))


@case(2, "does not exist", "`tactiledata calibrate STORE` writes one")
def a_calibration_that_is_not_there(bench):
    return ["replay", bench.store, "--calibration", "nowhere.json"]


@case(2, "does not exist", "Did you mean effects.json?", "`tactiledata diagnose STORE --out FOLDER` writes one")
def effects_with_a_slip(bench):
    (bench.folder / "effects.json").write_text("{}")
    return ["replay", bench.store, "--effects", "efects.json"]


@case(2, "does not exist", "--suggest-mapping")
def a_mapping_that_is_not_there(bench):
    return [*bench.ingest(bench.mcap), "--mapping", "nowhere.yaml"]


@case(2, "error: no such option: --resolutoin", "Possible options: --resolution", "Run `tactiledata replay --help`")
def an_option_with_a_slip(bench):
    return ["replay", bench.store, "--resolutoin", "low"]


@case(2, "error: no such command 'a. b'. Run `tactiledata --help`")
def a_command_with_a_full_stop(bench):
    return ["a. b"]


@case(2, "Usage: tactiledata [OPTIONS] COMMAND")
def no_command_at_all(bench):
    return []


@case(2, "requires an argument", "See --help of the command")
def an_option_without_its_value(bench):
    return ["split", bench.store, "--by"]


@case(2, "huggingface is what", "wrote as huggingface")
def a_folder_inside_an_export(bench):
    return bench.ingest(export_of(bench, "huggingface") / "data")


@case(2, "wrote as mcap", "copy it again")
def an_export_that_lost_its_logs(bench):
    folder = export_of(bench, "mcap")
    for log in folder.rglob("*.mcap"):
        log.unlink()
    return bench.ingest(folder)


@case(2, "error: no such command 'infoo'. Did you mean 'info'? Run `tactiledata --help`")
def a_command_with_a_slip(bench):
    return ["infoo"]


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


@case(1, "are not those that were written", "tactiledata check")
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


@case(2, "several stores")
def two_stores_and_none_named(bench):
    copy_tree(bench.store, bench.folder / "other.zarr")
    return ["split", "--by", "trajectory,sensor"]


@case(2, "tear trajectories apart")
def split_by_frame(bench):
    return ["split", bench.store, "--by", "frame"]


@case(2, "D20099", "one of: D2")
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


@case(2, "has no manifest.json", "makes a store of recordings")
def recordings_in_place_of_a_store(bench):
    return ["split", bench.log]


@case(1, "other files of a store", "Restore manifest.json from a copy")
def recordings_into_a_store_that_lost_its_manifest(bench):
    (bench.store / "manifest.json").unlink()
    return ["ingest", bench.log, "--store", bench.store]


@case(1, "other files of a store", "Restore manifest.json from a copy")
def a_store_that_lost_its_manifest(bench):
    (bench.store / "manifest.json").unlink()
    return ["split", bench.store]


@case(2, "0.9 Pa", "0.9 MPa is 0.9e6")
def a_modulus_in_another_unit(bench):
    return [
        "replay", bench.store, "--youngs-modulus", "0.9", "--poisson-ratio", "0.48", "--friction", "0.8",
    ]  # fmt: skip


@case(2, "needs no mapping")
def mapping_for_a_log_that_needs_none(bench):
    return ["inspect", bench.log, "--suggest-mapping"]


@pytest.mark.parametrize("name", CASES)
def test_bad_calls_are_answered_in_words(name, bench, capsys):
    """Each is answered as the table says, and leaves nothing spoilt behind."""
    assert_answered_in_words(CASES[name], bench, capsys)


def test_the_table_stays_wide():
    """The table has at least 25 kinds of bad calls."""
    assert len(CASES) >= 25
