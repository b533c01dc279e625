"""A folder that mixes kinds of recordings: each is found as it would be alone, and nothing beside them is hidden."""

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from generators import across_hdf5, fota, objectfolder_real, rtde_csv, sparsh_force, tvl, ycb_slide
from generators.folder_log import write as write_log
from generators.mcap_files import touch

from tactiledata.ingest.sources.discover import find_sources

CORPORA = {
    "across": across_hdf5,
    "fota": fota,
    "objectfolder": objectfolder_real,
    "sparsh": sparsh_force,
    "tvl": tvl,
    "ycb": ycb_slide,
}


def found(path):
    """Format and files of the recordings below a path, and the names of files that are left."""
    sources, left = find_sources([path])
    return sorted((source.format, source.part, *source.files) for source in sources), sorted(item.name for item in left)


def picture(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.random.default_rng(0).integers(0, 255, (32, 24, 3), dtype=np.uint8))


def bag(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    touch(path, count=4)


@pytest.fixture(scope="module")
def corpora(tmp_path_factory):
    """A folder with a small fake of each public corpus; read only."""
    root = tmp_path_factory.mktemp("corpora")
    for name, module in CORPORA.items():
        module.write(root / name, np.random.default_rng(12))
    return root


@pytest.mark.parametrize("name", CORPORA)
def test_a_corpus_alone_is_read_by_its_own_format(corpora, name):
    """Beside the recordings of a corpus no other format finds any in it."""
    sources, _ = found(corpora / name)
    assert len({form for form, *_ in sources}) == 1


def test_corpora_beside_one_another_are_all_found(corpora):
    """A folder of several corpora gives what each of them gives alone."""
    alone = [found(corpora / name) for name in CORPORA]
    together, left = found(corpora)
    assert together == sorted(source for sources, _ in alone for source in sources)
    assert left == sorted(name for _, names in alone for name in names)


def test_logs_beside_a_corpus_are_found(tmp_path):
    """An HDF5 result claims neither the logs beside it nor those beside the folder that it lies in."""
    across_hdf5.write(tmp_path / "sim" / "results", np.random.default_rng(0), trials=1)
    bag(tmp_path / "run.mcap")
    bag(tmp_path / "sim" / "other.mcap")
    write_log(tmp_path / "sim" / "log")
    rtde_csv.write(tmp_path / "robot.csv")
    picture(tmp_path / "pictures" / "0.png")
    (tmp_path / "sim" / "results" / "notes.txt").write_text("words")
    (tmp_path / ".hidden").write_text("words")
    sources, left = find_sources([tmp_path])
    forms = sorted((source.format, Path(source.path).name) for source in sources)
    assert forms == [
        ("across_hdf5", "results_digit_job_7.hdf5"),
        ("folder", "log"),
        ("image_folder", "pictures"),
        ("mcap", "other.mcap"),
        ("mcap", "run.mcap"),
        ("rtde_csv", "robot.csv"),
    ]
    assert [path.name for path in left] == ["notes.txt"]


def test_a_photograph_hides_no_recordings(tmp_path):
    """A picture beside folders of recordings makes a folder of images, and the folders are searched all the same."""
    picture(tmp_path / "rig.jpg")
    bag(tmp_path / "monday" / "run.mcap")
    picture(tmp_path / "tuesday" / "0.png")
    assert [(source.format, Path(source.path).name) for source in find_sources([tmp_path])[0]] == [
        ("image_folder", tmp_path.name),
        ("mcap", "run.mcap"),
        ("image_folder", "tuesday"),
    ]


def test_what_a_recording_keeps_in_folders_is_no_recording(tmp_path):
    """Pictures of a folder log, and pictures without contact beside MCAP files, stay parts of these."""
    write_log(tmp_path / "logs" / "log")
    bag(tmp_path / "bags" / "run.mcap")
    picture(tmp_path / "bags" / "backgrounds" / "D1.png")
    shutil.copytree(tmp_path / "logs" / "log", tmp_path / "again")
    sources, left = find_sources([tmp_path])
    assert [source.format for source in sources] == ["folder", "mcap", "folder"]
    assert not left


def test_a_named_format_searches_for_no_other(tmp_path):
    """With --format only recordings of that format are taken."""
    across_hdf5.write(tmp_path / "sim", np.random.default_rng(0), trials=1)
    bag(tmp_path / "run.mcap")
    assert {source.format for source in find_sources([tmp_path], "across_hdf5")[0]} == {"across_hdf5"}
