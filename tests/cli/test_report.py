"""The page about a store says who may learn from what, in an order that people expect, and when that is out of date."""

import hashlib
import json
import re
import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import yaml
from command import run_command
from copied_trees import copy_tree

from tactiledata.contract.sealed import sealed_json
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.overview import page, touch_picture
from tactiledata.store.read.reader import Store


@pytest.fixture
def written(tiny_store, tmp_path):
    """A function that gives the text of a store's page, without pictures, after the store's split was changed."""

    def made(change=lambda store: None):
        store = copy_tree(tiny_store, tmp_path / "ds.zarr")
        change(store)
        return page(Store.open(store), None, "default")

    return made


@pytest.mark.slow
def test_the_command_writes_the_page_with_its_picture(tiny_store, tmp_path, capsys):
    """One file that stands alone, and the picture beside it."""
    code, out, err = run_command(capsys, "report", tiny_store, "--out", tmp_path / "page", "--json")
    assert code == 0, err
    document = json.loads(out)
    assert document.pop("simulated_recordings") == {"simulated": 2, "real": 0, "not_stated": 0}
    files = {name: Path(path) for name, path in document.items()}
    assert files["picture"].read_bytes().startswith(b"\x89PNG")
    text = files["page"].read_text(encoding="utf-8")
    assert "data:image/png;base64," in text
    assert not re.search(r'(src|href)="http', text)


def test_parts_come_in_the_order_of_their_use(written):
    """Train, val, test, test_unseen, and last what is in no part."""
    cells = re.findall(r"<td>(train|val|test|test_unseen|excluded)</td>", written())
    assert cells == ["train", "val", "test", "test_unseen", "excluded"]


def test_counts_are_in_words(written):
    """The first sentence counts what the tiny world holds."""
    text = written()
    assert "2 recordings with 4 trajectories" in text
    assert "2 recordings are whole" in text
    assert "out of date" not in text


def test_a_split_of_another_state_of_the_store_is_said(written):
    """A split that does not know all trajectories is shown as out of date."""

    def forget_one(store):
        table, document = store / "splits" / "default.parquet", store / "splits" / "default.json"
        pq.write_table(pq.read_table(table).slice(1), table)
        facts = json.loads(document.read_text())
        facts["table"] |= {"sha256": hashlib.sha256(table.read_bytes()).hexdigest(), "rows": 3}
        document.write_bytes(sealed_json(facts))

    assert "The split is out of date: the store has 1 new trajectory" in written(forget_one)


def test_no_split_is_said(written):
    """Without a split the page says so, and how to make one."""
    text = written(lambda store: shutil.rmtree(store / "splits"))
    assert "There is no split yet" in text
    assert "tactiledata split" in text


def test_a_force_in_another_frame_is_drawn(tiny_mcaps, tiny_folders, tmp_path):
    """A recording whose force stays in the sensor's frame, beside one in the gel frame, is drawn with its own force."""
    log = copy_tree(tiny_folders[0], tmp_path / "log")
    described = yaml.safe_load((log / "log.yaml").read_text())
    del described["robot"]["tcp_from_gel"]
    (log / "log.yaml").write_text(yaml.safe_dump(described))
    ingest([tiny_mcaps[1], log], tmp_path / "ds.zarr")
    store = Store.open(tmp_path / "ds.zarr")
    assert "contact_wrench@ft" in store.signal_names
    drawn = [touch_picture(store, row) for row in range(store.trajectories().num_rows)]
    assert all(touch.has_force for touch in drawn)
    assert {touch.force_frame for touch in drawn} == {"gel", "ft"}
