"""What Arrow reads from memory is memory of its own, and no thread of it outlives a table that is read."""

import sys

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from test_layers import SOURCES

from tactiledata.contract.arrow_memory import arrow_reader, read_parquet


def test_a_reader_has_a_copy_that_holds_nothing_of_pythons():
    """The reader gives the same bytes and does not refer to Python's; one of Arrow's usual readers does (control)."""
    content = bytes(range(256)) * 40
    alone = sys.getrefcount(content)
    reader = arrow_reader(content)
    assert sys.getrefcount(content) == alone
    assert reader.read() == content
    assert arrow_reader(b"").read() == b""
    usual = pa.BufferReader(content)
    assert sys.getrefcount(content) > alone
    usual.close()


def test_nothing_else_lends_arrow_bytes_to_read():
    """No module of the packages but this one makes a reader of Python's bytes: threads of Arrow outlive its use."""
    makers = {
        path.as_posix().rpartition("/contract/")[2] for path in SOURCES if "BufferReader(" in path.read_text("utf-8")
    }
    assert makers == {"arrow_memory.py"}


def test_a_table_is_read_as_arrow_reads_it(tmp_path):
    """A table with dictionaries and several row groups is read as it was written, from a file and from its bytes."""
    table = pa.table({"name": pa.array(["a", "b", None] * 5).dictionary_encode(), "count": range(15)})
    pq.write_table(table, tmp_path / "t.parquet", row_group_size=4)
    content = (tmp_path / "t.parquet").read_bytes()
    for source in (tmp_path / "t.parquet", arrow_reader(content)):
        assert read_parquet(source, table.schema).equals(pq.read_table(tmp_path / "t.parquet"))


def test_columns_are_those_of_the_schema(tmp_path):
    """Others are left out, the order is the schema's, and a column that lacks is a KeyError."""
    pq.write_table(pa.table({"b": [1], "a": [2], "c": [3]}), tmp_path / "t.parquet")
    schema = pa.schema([("a", pa.int32()), ("b", pa.float64())])
    assert read_parquet(tmp_path / "t.parquet", schema).equals(pa.table({"a": [2], "b": [1.0]}, schema=schema))
    with pytest.raises(KeyError):
        read_parquet(tmp_path / "t.parquet", pa.schema([("d", pa.int32())]))


def test_only_tables_of_users_are_scanned():
    """No module reads tables by a scan of datasets, whose threads outlive it, but where minutes of work follow."""
    scans = ("pq.read_table(", "parquet.read_table(", "pyarrow.dataset", "ParquetDataset(", "pd.read_parquet(")
    found = {path.as_posix() for path in SOURCES if any(scan in path.read_text("utf-8") for scan in scans)}
    assert [path.rpartition("/tactiledata/")[2] for path in found] == ["diagnose/table_input/read.py"]
