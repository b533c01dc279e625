"""What Hugging Face's own loader reads of an export is what the store holds."""

import json

import numpy as np
import pytest
from exported import expected_frames, export, nan_equal
from loader_stores import split_store
from owner_loaders import run_program, snippet_of

from tactiledata.store.read.reader import Store

READ = """
import numpy as np
from pathlib import Path
from datasets import load_dataset
parts = load_dataset(str(Path.cwd()))
result = {}
for part, frames in parts.items():
    result[part] = {name: frames[name][:] for name in frames.column_names if name != "digit"}
    pixels = [np.asarray(row["digit"]) for row in frames]
    result[part]["sums"] = [int(each.sum()) for each in pixels]
    result[part]["corners"] = [each[0, 0].tolist() for each in pixels]
"""


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["png", "raw"])
def test_datasets_reads_what_the_store_holds(encoding, tmp_path):
    """Every split, row, number and picture, through `datasets.load_dataset`, with a file for every few episodes."""
    store = split_store(tmp_path / "ds.zarr", encoding=encoding, damaged=(3, 10))
    out, document = export(store, "huggingface", tmp_path / "out", action="wrench")
    parts = run_program(READ, out, tmp_path / "hf")
    assert set(parts) == {"train", "val", "test"} == set(document["parts"])
    uids = store.trajectories(["uid"])["uid"].to_pylist()
    frames = store.frames(["trajectory", "t_ns", "sensor"]).to_pylist()
    for part, read in parts.items():
        rows = expected_frames(store, part)
        assert read["frame"] == rows
        assert read["trajectory"] == [uids[frames[row]["trajectory"]] for row in rows]
        assert read["t_ns"] == [frames[row]["t_ns"] for row in rows]
        assert read["sensor"] == [frames[row]["sensor"] for row in rows]
        assert nan_equal(read["wrench"], store.aligned("wrench", rows)[0])
        assert nan_equal(read["centre"], store.frame_values("centre", rows))
        pictures = np.asarray(store.images(rows))
        assert read["sums"] == pictures.sum(axis=(1, 2, 3), dtype=int).tolist()
        assert read["corners"] == pictures[:, 0, 0].tolist()
    from tactiledata.splits.manifest import frame_rows, load_split

    taken = set(frame_rows(store, load_split(store, "default"), "train").tolist())
    assert [row in taken for row in parts["train"]["frame"]] == parts["train"]["in_split"]
    assert 0 < sum(parts["train"]["in_split"]) < len(parts["train"]["in_split"])
    assert any("became PNG" in sentence for sentence in document["remarks"]) == (encoding == "raw")


@pytest.mark.slow
def test_another_export_of_the_same_name_is_read_anew(tmp_path):
    """The cache of `datasets` goes by the folder's name and its page: another export there is not answered from it."""
    store = split_store(tmp_path / "ds.zarr")
    code = (
        "from datasets import load_dataset\nframes = load_dataset('out', split='train')\n"
        "result = ['action' in frames.column_names, len(frames.filter(lambda row: row['in_split']))]"
    )
    export(store, "huggingface", tmp_path / "one" / "out", action="wrench")
    assert run_program(code, tmp_path / "one", tmp_path / "hf")[0]
    _, document = export(store, "huggingface", tmp_path / "two" / "out", action="none")
    assert run_program(code, tmp_path / "two", tmp_path / "hf") == [False, document["parts"]["train"]["in_split"]]


@pytest.mark.slow
def test_the_page_shows_lines_that_run(tiny_store, tmp_path):
    """The lines under Loading run as they stand, and find the frames in contact; the units stand in the schema."""
    import pyarrow.parquet as pq

    store = Store.open(tiny_store)
    out, document = export(store, "huggingface", tmp_path / "out")
    code = snippet_of(out) + "result = [len(frames), len(taken), frames[0]['digit'].size]"
    counts = document["parts"]["train"]
    assert run_program(code, out, tmp_path / "hf") == [counts["frames"], counts["in_split"], [240, 320]]
    field = pq.read_schema(next((out / "data").iterdir())).field("contact_wrench")
    assert field.metadata[b"units"] == b"N N N N m N m N m"
    assert field.metadata[b"frame"] == b"gel"


def test_names_that_every_row_uses(tmp_path):
    """A corpus may annotate something called like a column of ours: it gets an underscore, and neither is lost."""
    from tactiledata.export.huggingface import HuggingFaceExporter

    exporter = HuggingFaceExporter()
    assert exporter.kept_as("frame", None) == "frame_"
    assert exporter.kept_as("wrench", None) == "wrench"


def test_bytes_of_pictures_stay(parted, tmp_path):
    """PNG files of the store stand in the parquet files byte for byte, and their features are declared."""
    import pyarrow.parquet as pq

    out, _ = export(parted, "huggingface", tmp_path / "out")
    table = pq.read_table(out / "data" / "train-00000-of-00001.parquet")
    contents = [row["bytes"] for row in table["digit"].to_pylist()]
    assert contents == parted.encoded(table["frame"].to_numpy())
    features = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
    assert features["digit"] == {"_type": "Image"}
    assert set(features) == set(table.column_names)
