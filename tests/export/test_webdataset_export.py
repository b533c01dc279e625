"""What WebDataset's own loader streams of an export is what the store holds."""

import json
import tarfile

import numpy as np
import pytest
from exported import expected_frames, export, nan_equal
from loader_stores import write_loader_store
from owner_loaders import run_program, snippet_of

# in a process of its own: the loader leaves its files to the collector of garbage
READ = """
import glob
import webdataset
result = {}
for part in ("train", "val", "test"):
    shards = sorted(glob.glob(part + "-*.tar"))
    dataset = webdataset.WebDataset(shards, shardshuffle=False).decode("rgb8")
    read = list(dataset.to_tuple("__key__", "jpg;png", "json"))
    result[part] = [len(shards), [[key, picture.tolist(), facts] for key, picture, facts in read]]
"""


@pytest.mark.slow
def test_webdataset_reads_what_the_store_holds(parted, tmp_path, monkeypatch):
    """Every shard, sample, number and picture, after the lines under Loading, which run as they stand."""
    monkeypatch.setattr("tactiledata.export.webdataset.MEGABYTE", 5000)
    out, document = export(parted, "webdataset", tmp_path / "out", file_mb=1)
    read = run_program(snippet_of(out) + READ, out, tmp_path / "hf")
    assert set(read) == set(document["parts"])
    for part, (shards, samples) in read.items():
        rows = expected_frames(parted, part)
        assert shards > 1
        assert [facts["frame"] for _, _, facts in samples] == rows
        assert nan_equal([facts["values"]["wrench"] for _, _, facts in samples], parted.aligned("wrench", rows)[0])
        assert np.array_equal([picture for _, picture, _ in samples], parted.images(rows))
        assert len({key for key, _, _ in samples}) == len(samples)
        assert {facts["part"] for _, _, facts in samples} == {part}
        assert all(key == f"{facts['trajectory']}_{facts['frame_index']:06d}" for key, _, facts in samples)


def test_values_that_were_not_recorded_are_null(tmp_path, monkeypatch):
    """NaN becomes null, is counted in the document, and is said."""
    store = write_loader_store(tmp_path / "ds.zarr", n_sources=1)
    aligned = store.aligned

    def with_gap(name, rows=None):
        values, gaps = aligned(name, rows)
        values = values.copy()
        values[np.asarray(rows) == 2] = np.nan
        return values, gaps

    monkeypatch.setattr(store, "aligned", with_gap)
    out, document = export(store, "webdataset", tmp_path / "out", split="none")
    with tarfile.open(out / "unsplit-00000.tar") as shard:
        facts = [json.load(shard.extractfile(each)) for each in shard if each.name.endswith(".json")]
    assert [each["frame"] for each in facts if each["values"]["wrench"] == [None] * 6] == [2]
    assert document["streams"]["wrench"]["missing"] == 1
    assert document["streams"]["wrench"]["missing_in"] == {"unsplit": 1}
    assert any("`wrench` has no value at 1 frame (unsplit 1):" in sentence for sentence in document["remarks"])


def test_tar_files_say_nothing_of_the_machine(parted, tmp_path):
    """No time, owner or right of this machine stands in a shard."""
    out, _ = export(parted, "webdataset", tmp_path / "out")
    with tarfile.open(next(out.glob("*.tar"))) as shard:
        assert {(each.mtime, each.uid, each.gid, each.uname) for each in shard} == {(0, 0, 0, "")}
