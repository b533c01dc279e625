"""Who inspects a folder before it is ingested meets nothing new at ingest, but for what decoded pictures show."""

import json

import cv2
import numpy as np
import pytest
import yaml
from command import run_command
from copied_trees import copy_tree
from generators import across_hdf5, rtde_csv
from generators.mcap_files import START, STEP, Tape, numbers

from tactiledata.contract.lfs_pointer import START as POINTER

DECODED = {"image-blank"}
"""Codes that need decoded pictures."""


def spoilt_log(log):
    """State an impossible tool, a model and a shape that nobody knows, and a clock of no stream."""
    document = yaml.safe_load((log / "log.yaml").read_text())
    document["robot"]["tool"]["mass"] = 900
    document["sensors"] = {name: {**facts, "model": "digitt"} for name, facts in document["sensors"].items()}
    document["indenters"] = {name: {"shape": "ball"} for name in document["indenters"]}
    document["clocks"] = {"wrenches": {"offset_ns": 5}}
    (log / "log.yaml").write_text(yaml.safe_dump(document, sort_keys=False))


def spoilt_pictures(log):
    """Cut a picture, turn one to text, blacken and shrink one each."""
    files = sorted((log / "frames").iterdir())
    files[3].write_bytes(files[3].read_bytes()[:500])
    files[5].write_bytes(b"no picture")
    cv2.imwrite(str(files[9]), np.zeros((320, 240, 3), np.uint8))
    cv2.imwrite(str(files[11]), np.zeros((20, 24, 3), np.uint8))


@pytest.fixture(scope="module")
def mixed(tiny_mcaps, tiny_folders, tmp_path_factory):
    """A folder of MCAP files, folder logs, HDF5, CSV and pictures, whole and broken; read only."""
    root = tmp_path_factory.mktemp("mixed")
    content = tiny_mcaps[1].read_bytes()
    (root / "cut.mcap").write_bytes(content[: len(content) * 2 // 3])
    (root / "empty.mcap").touch()
    (root / "pointer.mcap").write_bytes(POINTER + b"\n")
    for index, name in enumerate(("errors", "pictures", "gap", "nameless")):
        copy_tree(tiny_folders[index % 2], root / name)
    spoilt_log(root / "errors")
    spoilt_pictures(root / "pictures")
    rows = (root / "gap" / "wrench.csv").read_text().splitlines(keepends=True)
    (root / "gap" / "wrench.csv").write_text("".join(rows[: len(rows) // 3] + rows[len(rows) // 2 :]))
    (root / "nameless" / "log.yaml").unlink()
    across_hdf5.write(root / "sim", np.random.default_rng(0))
    rtde_csv.write(root / "robot.csv")
    (root / "table.csv").write_text("a,b\n1,2\n")
    (root / "loose").mkdir()
    cv2.imwrite(str(root / "loose" / "0.png"), np.random.default_rng(1).integers(0, 255, (320, 240, 3), np.uint8))
    return root


def documents(capsys, path, store):
    """Exit codes and JSON documents of inspect and of ingest."""
    looked, looked_out, _ = run_command(capsys, "inspect", path, "--json")
    taken, taken_out, _ = run_command(capsys, "ingest", path, "--store", store, "--json")
    return (looked, taken), json.loads(looked_out), json.loads(taken_out)


def said(source):
    return {(finding["code"], finding["stream"]) for finding in source["findings"]}


@pytest.mark.slow
def test_ingest_says_nothing_that_inspect_did_not(mixed, tmp_path, capsys):
    """Findings, failures, files left alone, numbers of frames and exit codes are the same, but for blank pictures."""
    codes, looked, taken = documents(capsys, mixed, tmp_path / "ds.zarr")
    assert codes == (1, 1)
    inspected = {source["key"]: source for source in looked["sources"]}
    assert {failure["key"] for failure in looked["failed"]} == {
        source["key"] for source in taken["sources"] if source["state"] == "failed"
    }
    met = set()
    for source in taken["sources"]:
        if source["state"] == "failed":
            continue
        met |= said(source)
        new = said(source) - said(inspected[source["key"]])
        assert {code for code, _ in new} <= DECODED, source["key"]
        for fact in ("status", "frames", "trajectories"):
            assert inspected[source["key"]][fact] == source[fact], (source["key"], fact)
    assert {"gap", "no-background", "recording-twin", "sensor-conflict", "stated-implausible"} <= {
        code for code, _ in met
    }
    assert looked["unclaimed"] == taken["unclaimed"]
    assert looked["findings"] == taken["findings"]
    assert {finding["code"] for finding in looked["findings"]} == {"not-fetched", "log-undescribed"}


def test_a_whole_recording_gets_no_finding_from_inspect_alone(tiny_mcaps, tmp_path, capsys):
    """Inspect invents nothing: what it says of a sound recording is what ingest says."""
    codes, looked, taken = documents(capsys, tiny_mcaps[0], tmp_path / "ds.zarr")
    assert codes == (0, 0)
    assert said(looked["sources"][0]) == said(taken["sources"][0])
    assert looked["sources"][0]["status"] == "ok"


def test_inspect_says_what_only_ingest_checks(tiny_mcaps, capsys):
    """People read what would be made, and which checks were not."""
    code, out, _ = run_command(capsys, "inspect", tiny_mcaps[0])
    assert code == 0
    assert "ingest would make: 2 trajectories and" in out
    assert "Only ingest decodes pictures" in " ".join(out.split())


def test_inspect_says_that_ingest_would_refuse(tmp_path, capsys):
    """A recording whose topics nobody knows is shown, with the reason for which ingest would not read it."""
    with Tape(tmp_path / "own.mcap") as tape:
        for index, values in enumerate(numbers(4, 6)):
            tape.signal("wrench", START + index * STEP, START, values, topic="/lab/x")
    code, out, _ = run_command(capsys, "inspect", tmp_path / "own.mcap")
    assert code == 0
    assert "/lab/x" in out
    assert "ingest would not read it" in out
    assert run_command(capsys, "ingest", tmp_path / "own.mcap", "--store", tmp_path / "ds.zarr")[0] == 1


def test_several_recordings_end_with_a_line_each(mixed, capsys):
    """After many screens of streams, one table says of each recording what ingest would make of it."""
    _, out, _ = run_command(capsys, "inspect", str(mixed))
    lines = [" ".join(line.split()) for line in out.splitlines()]
    head = lines.index("recording format duration, s trajectories frames status at ingest")
    rows = {line.split()[0]: line for line in lines[head + 1 :]}
    assert rows["cut.mcap"].endswith(" damaged")
    assert rows["empty.mcap"].endswith("- - - - cannot be read")
    assert rows["gap"].startswith("gap folder ")
    _, out, _ = run_command(capsys, "inspect", str(mixed / "gap"))
    assert "status at ingest" not in out
    assert "trajectories stated: " in out
