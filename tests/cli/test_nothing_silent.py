"""What once passed without a word, tried through the commands alone: each has its word, and exits as it should."""

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from command import run_command
from generators.folder_log import write

import tactiledata
from tactiledata.cli.output import TRUTH, findings, say_left_alone
from tactiledata.contract.records import Finding
from tactiledata.loaders.torch import TactileDataset
from tactiledata.rig import record

SIZE = (320, 240)


@pytest.fixture
def log(tmp_path, monkeypatch):
    """A folder log of twelve touches with four pictures each, of a DIGIT's size, in the working folder."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "log", touches=12, size=SIZE)
    return tmp_path / "log"


def ingested(capsys, log):
    """Exit code and everything that an ingest of a log prints."""
    code, out, err = run_command(capsys, "ingest", log, "--store", log.parent / "ds.zarr")
    assert "Traceback" not in out + err
    return code, out + err


def save(path, picture):
    assert cv2.imwrite(str(path), picture)


def noise(shape, top=255, dtype=np.uint8):
    return np.random.default_rng(1).integers(0, top, shape, dtype)


PICTURES = {
    "nothing": (None, "", 0),
    "16 bits": (noise((*SIZE, 3), 65_535, np.uint16), "image-depth", 0),
    "16-bit grey": (noise(SIZE, 65_535, np.uint16), "image-encoding", 1),
    "grey": (noise(SIZE), "greyscale-image", 0),
    "alpha": (noise((*SIZE, 4)), "image-alpha", 0),
    "one colour": (np.zeros((*SIZE, 3), np.uint8), "image-blank", 0),
    "another size": (noise((100, 80, 3)), "image-stray-size", 0),
    "25 million pixels": (np.zeros((5000, 5000, 3), np.uint8), "image-too-large", 1),
}
"""A picture that stands in the place of one of 48, the code of what is said of it, and the exit code."""
CODES = sorted({code for _, code, _ in PICTURES.values() if code})


@pytest.mark.slow
@pytest.mark.parametrize("kind", PICTURES)
def test_an_odd_picture_is_said(kind, log, capsys):
    """One picture of another kind among 48: the ingest names the kind, and nothing of a picture like the others."""
    picture, code, exits = PICTURES[kind]
    if picture is not None:
        save(log / "frames" / "t3_2.png", picture)
    ended, said = ingested(capsys, log)
    assert ended == exits
    assert [known for known in CODES if f"[{known}]" in said] == [code] * bool(code)


@pytest.mark.slow
def test_one_stray_size_keeps_no_dataset_from_the_others(log, capsys):
    """The dataset leaves out the one of 48 pictures that has another size, and the finding speaks of one."""
    save(log / "frames" / "t3_2.png", noise((100, 80, 3)))
    _, said = ingested(capsys, log)
    store = log.parent / "ds.zarr"
    code, _, _ = run_command(capsys, "split", store, "--force", "none", "--fractions", "0.99,0.005,0.005")
    assert code == 0
    train = TactileDataset(store, split="default/train", streams=["digit"])
    shapes = {tuple(train[row]["digit"].shape) for row in range(len(train))}
    assert shapes == {(3, *SIZE)}
    assert "images of 'D20542' have 100 rows" not in said


@pytest.mark.slow
def test_tables_without_a_description_are_said(log, capsys):
    """A folder log that lost its log.yaml, beside a whole one, is named and not passed over."""
    shutil.copytree(log, log.parent / "logs" / "whole")
    shutil.copytree(log, log.parent / "logs" / "other")
    (log.parent / "logs" / "other" / "log.yaml").unlink()
    _, said = ingested(capsys, log.parent / "logs")
    assert "[log-undescribed]" in said
    shutil.rmtree(log.parent / "logs" / "other")
    shutil.rmtree(log.parent / "ds.zarr")
    _, said = ingested(capsys, log.parent / "logs")
    assert "[log-undescribed]" not in said


def turned(text, place):
    """A text with one bit of one of its characters turned: x becomes y, 4 becomes 5."""
    return text[:place] + bytes([text[place] ^ 1]) + text[place + 1 :]


@pytest.mark.slow
def test_any_letter_of_a_document_that_turns_is_damage(log, capsys):
    """`check` exits 1 for each of twelve letters and digits of a document of which one bit turned, and 0 without."""
    ingested(capsys, log)
    store = log.parent / "ds.zarr"
    run_command(capsys, "split", store, "--force", "none")
    assert run_command(capsys, "check", store)[0] == 0
    for document in ("manifest.json", "splits/default.json", "signals/wrench/zarr.json"):
        content = (store / document).read_bytes()
        places = [place for place, letter in enumerate(content) if chr(letter).isalnum() and letter < 128]
        for place in np.random.default_rng(0).choice(places, 12, replace=False).tolist():
            (store / document).write_bytes(turned(content, place))
            code, out, err = run_command(capsys, "check", store)
            assert code == 1, f"{document}: {content[max(0, place - 30) : place + 30]!r} at {place}\n{out}{err}"
        (store / document).write_bytes(content)
        assert run_command(capsys, "check", store)[0] == 0, document


@pytest.mark.slow
def test_a_synthetic_set_is_called_synthetic_wherever_it_stands(tmp_path, tiny_store, capsys, monkeypatch):
    """Transferred pictures are called synthetic in every row of `score`, in the first and in the second place."""
    monkeypatch.chdir(tmp_path)
    method = ("--method", "background-swap")
    for command in (
        ("transfer", tiny_store, "--to", "ycb-sensorB", *method, "--out", "made.zarr"),
        ("merge", tiny_store, "made.zarr", "--into", "both.zarr"),
    ):
        code, out, err = run_command(capsys, *command)
        assert code == 0, out + err
    code, out, err = run_command(capsys, "score", "both.zarr", "--metric", "histogram_intersection")
    assert code == 0, out + err
    rows = [line for line in out.splitlines() if line.startswith("histogram intersection ")]
    made = [row.count("ycb-sensorB of") for row in rows]
    assert {0, 1, 2} == set(made)
    assert [row.count("synthetic") for row in rows] == made
    assert not any("Real" in row or " real" in row for row in rows)


def test_the_tiny_world_has_another_picture_than_a_transfers_target(tiny_folders):
    """No sensor of the tiny world has the picture without contact of `ycb-sensorA`."""
    bundled = Path(tactiledata.__file__).parent / "sensors" / "digit_backgrounds"
    target = cv2.imread(str(bundled / "bg_0.jpg")).astype(int)
    count = 0
    for described in (folder / "log.yaml" for folder in tiny_folders):
        for facts in yaml.safe_load(described.read_text())["sensors"].values():
            own = cv2.imread(str(described.parent / facts["background"])).astype(int)
            count += 1
            assert np.abs(own - target).mean() > 3
    assert count == 2


def test_a_finding_names_its_recording_once(capsys):
    """A message that begins with the recording is not named twice; one of a stream of the same name keeps both."""
    findings(
        [
            ("wrench", Finding("gap", "info", "wrench: one gap", "wrench")),
            ("run.csv", Finding("clock", "info", "run.csv: another clock")),
            ("run.csv", Finding("late", "info", "wrench: late", "wrench")),
        ]
    )
    assert [line.split(None, 1)[1] for line in capsys.readouterr().out.splitlines()] == [
        "run.csv: another clock [clock]",
        "wrench: wrench: one gap [gap]",
        "run.csv: wrench: late [late]",
    ]


def test_the_truth_of_a_simulated_world_is_told_from_other_files(capsys):
    """A newcomer need not wonder why part of what `record` wrote is left alone; a note there is another file."""
    assert TRUTH == record.TRUTH
    say_left_alone(["rec/truth/D1.json", "rec/truth/D1.parquet", "rec/notes/truth.json"])
    say_left_alone(["rec/truth/labels.json", "rec/truth/masks.parquet"])
    truth, notes, labels = capsys.readouterr().out.splitlines()
    assert truth == (
        "  left alone in rec/truth: D1.json, D1.parquet; the truth of simulated recordings, which no dataset holds"
    )
    assert notes.endswith("no format claims them")
    assert labels.endswith("no format claims them")
