"""The page about a store says who may learn from what, in an order that people expect, and when that is out of date."""

import hashlib
import json
import re
import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from command import run_command


@pytest.fixture
def page(tiny_store, tmp_path, capsys):
    """A function that gives the text of a store's page after the store's split was changed."""

    def made(change=lambda store: None):
        store = tmp_path / "ds.zarr"
        shutil.copytree(tiny_store, store)
        change(store)
        code, out, err = run_command(capsys, "report", store, "--out", tmp_path / "page", "--json")
        assert code == 0, err
        return Path(json.loads(out)["page"]).read_text(encoding="utf-8")

    return made


def test_parts_come_in_the_order_of_their_use(page):
    """Train, val, test, test_unseen, and last what is in no part."""
    cells = re.findall(r"<td>(train|val|test|test_unseen|excluded)</td>", page())
    assert cells == ["train", "val", "test", "test_unseen", "excluded"]


def test_counts_are_in_words(page):
    """The first sentence counts what the tiny world holds."""
    text = page()
    assert "2 recordings with 4 trajectories" in text
    assert "2 recordings whole" in text
    assert "out of date" not in text


def test_a_split_of_another_state_of_the_store_is_said(page):
    """A split that does not know all trajectories is shown as out of date."""

    def forget_one(store):
        table, document = store / "splits" / "default.parquet", store / "splits" / "default.json"
        pq.write_table(pq.read_table(table).slice(1), table)
        facts = json.loads(document.read_text())
        facts["table"] |= {"sha256": hashlib.sha256(table.read_bytes()).hexdigest(), "rows": 3}
        document.write_text(json.dumps(facts))

    assert "The split is out of date: the store has 1 new trajectory" in page(forget_one)


def test_no_split_is_said(page):
    """Without a split the page says so, and how to make one."""
    text = page(lambda store: shutil.rmtree(store / "splits"))
    assert "There is no split yet" in text
    assert "tactiledata split" in text
