"""What Arrow reads from memory is memory of its own."""

import sys

import pyarrow as pa
from test_layers import SOURCES

from tactiledata.contract.arrow_memory import arrow_reader


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
