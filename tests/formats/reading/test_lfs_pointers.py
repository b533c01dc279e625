"""A Git LFS pointer in the place of any file that is read is named as one, with what to do."""

import shutil

import pytest
from generators.collect import read
from generators.folder_log import SENSOR, write

from tactiledata.cli.families import inspect
from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.contract.lfs_pointer import is_lfs_pointer
from tactiledata.contract.schema import read_document
from tactiledata.diagnose.table_input.read import read_table
from tactiledata.errors import BrokenLog, NotFetched
from tactiledata.formats.folder.folder import FolderFormat
from tactiledata.formats.mcap.survey import survey
from tactiledata.formats.reading.csv_tables import read_csv_table
from tactiledata.formats.reading.npz_members import load_members
from tactiledata.formats.reading.restricted_pickle import load_npy, load_pickle
from tactiledata.gel.mesh.mesh_file import pad_from_file
from tactiledata.indenters.mesh_indenter import load_mesh_indenter
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.discover import find_sources
from tactiledata.store.change.add_sensor import read_picture
from tactiledata.store.read.reader import Store

POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a214614ab2935c943f9e0ff69d22e\nsize 12345\n"
READERS = {
    "a.csv": read_csv_table,
    "b.mcap": survey,
    "c.npz": lambda path: load_members(path, ["a"]),
    "d.pkl": load_pickle,
    "e.npy": load_npy,
    "f.msh": lambda path: pad_from_file(path, "mm"),
    "g.stl": lambda path: load_mesh_indenter({"mesh": path.name, "unit": "mm"}, path.parent, "log.yaml"),
    "h.png": read_picture,
    "i.jpg": lambda path: decode_rgb(path.read_bytes()),
    "j.parquet": read_table,
    "k.yaml": read_document,
    "m.zarr/manifest.json": lambda path: Store.open(path.parent),
    "n.mcap": lambda path: find_sources([path]),
    "o.xyz": lambda path: find_sources([path.parent]),
}


def pointer(path):
    """A pointer in the place of a file."""
    path.parent.mkdir(exist_ok=True, parents=True)
    path.write_bytes(POINTER)
    return path


@pytest.mark.parametrize("name", READERS)
def test_every_reader_names_a_pointer(tmp_path, name):
    """The error is of its own kind and says what to run."""
    with pytest.raises(NotFetched, match="is a Git LFS pointer, not the file") as caught:
        READERS[name](pointer(tmp_path / name))
    # the way out once, in the part of the message that is for it
    assert str(caught.value).count("git lfs pull") == caught.value.remedy.count("git lfs pull") == 1


@pytest.mark.slow
def test_weights_that_are_a_pointer_are_named(tmp_path):
    """Weights that are a pointer are named as one; PyTorch would call them broken."""
    from split_models.learning.checkpoint import load_checkpoint
    from tactiledata.metrics.gram_style import vgg19_features

    for load in (load_checkpoint, vgg19_features):
        with pytest.raises(NotFetched, match="git lfs pull"):
            load(pointer(tmp_path / "weights.pth"))


@pytest.mark.parametrize("file", ["frames/t0_1.png", "wrench.csv", f"backgrounds/{SENSOR}.png"])
def test_a_pointer_inside_a_log_is_said(tmp_path, file):
    """A log of which one file is a pointer says so, as a finding or as the error that refuses it."""
    write(tmp_path / "log")
    pointer(tmp_path / "log" / file)
    try:
        [(recording, _)] = read(FolderFormat(), tmp_path / "log")
        said = " ".join(finding.message for finding in recording.findings)
    except BrokenLog as error:
        said = str(error)
    assert "Git LFS pointer" in said
    assert "git lfs pull" in said


def test_inspect_names_pointers(tmp_path, capsys):
    """What `inspect` says of a file that was not fetched is not that no format claims it."""
    write(tmp_path / "logs" / "a")
    inspect([pointer(tmp_path / "logs" / "b.mcap").parent], False, None, None, False)
    said = " ".join(capsys.readouterr().out.split())
    assert "b.mcap is a Git LFS pointer" in said
    assert "no format claims" not in said


@pytest.mark.slow
def test_pointers_beside_recordings_are_not_files_of_no_format(tmp_path):
    """An ingest says which files were not fetched, and goes on with the others; without pointers it says nothing."""
    write(tmp_path / "logs" / "a")
    assert ingest([tmp_path / "logs"], tmp_path / "none.zarr").findings == ()
    pointer(tmp_path / "logs" / "b.mcap")
    shutil.copy(tmp_path / "logs" / "b.mcap", tmp_path / "logs" / "c.mcap")
    report = ingest([tmp_path / "logs"], tmp_path / "ds.zarr")
    assert [source.state for source in report.sources] == ["added"]
    [finding] = report.findings
    assert (finding.code, finding.count) == ("not-fetched", 2)
    assert "b.mcap (and 1 more) is a Git LFS pointer" in finding.message
    assert report.unclaimed == ()


def test_other_texts_are_no_pointers(tmp_path):
    """A text that mentions the address, an empty file and a folder are none."""
    (tmp_path / "a.txt").write_bytes(b"see version https://git-lfs.github.com/spec/v1")
    (tmp_path / "b.txt").touch()
    assert not any(is_lfs_pointer(path) for path in (tmp_path / "a.txt", tmp_path / "b.txt", tmp_path))
