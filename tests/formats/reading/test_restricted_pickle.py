"""Pickles of corpora are data or are refused: nothing in them runs, nothing is lost without a word."""

import collections
import fractions
import os
import pickle
import struct
import sys
import types

import numpy as np
import pytest
from few_examples import few
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tactiledata.errors import BrokenLog, MissingFile, UnsafeContent
from tactiledata.formats.reading.natural_order import last_number, natural_key, natural_sorted
from tactiledata.formats.reading.pickled_list import index_bytes_list
from tactiledata.formats.reading.restricted_pickle import load_npy, load_pickle, loads
from tactiledata.formats.reading.unread_object import UnreadObject

PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)
PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False)
    | st.text()
    | st.binary()
    | st.complex_numbers(),
    lambda inner: st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


class Evil:
    """An object that runs a command when it is unpickled."""

    def __init__(self, function, *arguments):
        self.content = (function, arguments)

    def __reduce__(self):
        return self.content


@few(60)
@given(PLAIN, st.sampled_from(PROTOCOLS))
def test_plain_values_come_back(value, protocol):
    """Numbers, text, bytes and containers are what they were, in every protocol."""
    back = loads(pickle.dumps(value, protocol), "x")
    assert repr(back) == repr(value)


NUMBERS = st.one_of(
    hnp.boolean_dtypes(),
    hnp.integer_dtypes(),
    hnp.unsigned_integer_dtypes(),
    hnp.floating_dtypes(),
    hnp.complex_number_dtypes(),
)
TEXTS = st.one_of(hnp.byte_string_dtypes(max_len=6), hnp.unicode_string_dtypes(max_len=6))
SHAPES = hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4)


@few(60)
@given(hnp.arrays(NUMBERS | TEXTS, SHAPES), st.sampled_from(PROTOCOLS))
def test_arrays_come_back(array, protocol):
    """Arrays of numbers and text keep values, type, byte order and shape, in every protocol and both memory orders."""
    for given_array in (array, array.copy(order="F")):
        back = loads(pickle.dumps({"a": given_array, "b": given_array}, protocol), "x")
        assert back["a"].dtype == array.dtype
        assert back["a"].shape == array.shape
        assert back["a"].tobytes() == array.tobytes()
        assert back["b"] is back["a"]


def test_objects_arrays_scalars_and_structures_come_back():
    """Object arrays of data, numpy scalars, structured arrays, sets and ordered dicts are admitted."""
    value = {
        "objects": np.array([{"x": np.arange(3)}, None, b"z"], dtype=object),
        "scalar": np.float32(3.5),
        "structure": np.array([(1, 2.5)], dtype=[("a", "i4"), ("b", ">f8")]),
        "sets": ({1, 2}, frozenset({3}), collections.OrderedDict(a=1), bytearray(b"q")),
    }
    for protocol in PROTOCOLS:
        back = loads(pickle.dumps(value, protocol), "x")
        assert back["objects"][0]["x"].tolist() == [0, 1, 2]
        assert back["scalar"] == 3.5
        assert back["structure"].tolist() == [(1, 2.5)]
        assert back["structure"].dtype == value["structure"].dtype
        assert back["sets"] == value["sets"]


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (os.system, ("touch MARK",)),
        (eval, ("open('MARK', 'w')",)),
        (getattr, ("", "join")),
        (np.load, ("MARK",)),
        (np.ndarray.__new__, (np.ndarray, (10**9,))),
        (bytearray, (10**12,)),
        (bytes, (10**12,)),
    ],
)
def test_nothing_runs(function, arguments, protocol, tmp_path, monkeypatch):
    """An object that calls something is refused and leaves no mark."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "evil.pkl"
    path.write_bytes(pickle.dumps([1, Evil(function, *arguments)], protocol))
    with pytest.raises((UnsafeContent, BrokenLog)):
        load_pickle(path)
    assert [file.name for file in tmp_path.iterdir()] == ["evil.pkl"]


def test_refused_name_is_told(tmp_path):
    """The error names what the pickle asked for, also inside a .npy file."""
    np.save(tmp_path / "evil.npy", np.array({"poses": Evil(os.system, "true")}, dtype=object), allow_pickle=True)
    with pytest.raises(UnsafeContent, match=r"posix\.system") as caught:
        load_npy(tmp_path / "evil.npy")
    assert caught.value.facts["name"] == "posix.system"


class Plain:
    """An ordinary class, whose instances are not data."""


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_instances_are_refused(protocol):
    """Instances of classes are refused, whatever opcode makes them."""
    with pytest.raises(UnsafeContent, match=r"Plain|copy_?reg|instance"):
        loads(pickle.dumps(Plain(), protocol), "x")


@pytest.mark.parametrize(
    "program",
    [
        b"cnumpy\nndarray\n(I3\ntR.",  # a call of the array type
        b"cnumpy.core.multiarray\n_reconstruct\n(tR.",  # an array without content
        b"cnumpy.core.multiarray\n_reconstruct\n(tR(I1\n(I3\ntcnumpy\ndtype\n(S'f8'\ntRI00\nS'short'\ntb.",
        b"cnumpy\ndtype\n(S'M8[ns]'\ntR.",
        b"cos\nsystem\n(S'true'\ntR.",
        b"(S'true'\nios\nsystem\n.",  # INST
        b"\x82\x01.",  # an extension
        b"Ppersistent\n.",
        b"}S'a'\nb.",  # BUILD on a dict
        b"\x80\x04\x95" + struct.pack("<Q", 2**60) + b"N",  # a frame of an exabyte
        b"\x80\x04\x8e" + struct.pack("<Q", 2**60) + b"x.",  # bytes of an exabyte
        b"\x80\x05\x97.",  # an out-of-band buffer
        b"",
        b".",
        b"0",
        b"garbage",
    ],
)
def test_hostile_programs_are_refused(program):
    """Handwritten opcodes that make, call or claim something end in a clear error, at once and in little memory."""
    with pytest.raises((UnsafeContent, BrokenLog)):
        loads(program, "x")


@given(st.binary(max_size=200))
def test_random_bytes_never_crash(content):
    """Random bytes are a value or a clear error."""
    try:
        loads(content, "x")
    except (UnsafeContent, BrokenLog):
        return


@given(st.integers(0, 10_000), st.sampled_from(PROTOCOLS))
def test_truncated_pickles_are_broken_logs(cut, protocol):
    """A pickle without its end is no value (a name that is cut may be refused as a name)."""
    whole = pickle.dumps({"a": np.arange(50), "b": [b"x" * 30] * 3}, protocol)
    with pytest.raises(BrokenLog if protocol > 3 else (BrokenLog, UnsafeContent)):
        loads(whole[: cut % len(whole)], "x")


def test_npy_that_lies_about_its_size(tmp_path):
    """A header that claims more numbers than the file has is refused before memory is taken."""
    path = tmp_path / "big.npy"
    np.save(path, np.arange(10.0))
    path.write_bytes(path.read_bytes().replace(b"(10,)", b"(99999999999999,)"[:5].ljust(5)).replace(b"(9999", b"(10,)"))
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(BrokenLog, match="need"):
        load_npy(path)


def test_files_that_are_not_there_or_too_large(tmp_path):
    """A missing file and one beyond the limit are told apart."""
    with pytest.raises(MissingFile):
        load_pickle(tmp_path / "no.pkl")
    (tmp_path / "big.pkl").write_bytes(pickle.dumps(b"x" * 1000))
    with pytest.raises(BrokenLog, match="at most 100 bytes"):
        load_pickle(tmp_path / "big.pkl", max_bytes=100)
    (tmp_path / "text.npy").write_text("not an array")
    with pytest.raises(BrokenLog, match="npy"):
        load_npy(tmp_path / "text.npy")


@pytest.mark.parametrize(
    "header", [b"{'descr': '<f8', (", b"\0" * 30, b"__import__('os').system('true')", b"{}", b"[" * 90]
)
def test_npy_headers_that_are_no_headers(tmp_path, header):
    """A header that does not parse, or asks for something, is a clear error."""
    content = header + b" " * (118 - len(header) - 1) + b"\n"
    (tmp_path / "odd.npy").write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(content)) + content)
    with pytest.raises(BrokenLog):
        load_npy(tmp_path / "odd.npy")


@given(st.lists(st.binary(max_size=400), min_size=1), st.sampled_from([3, 4, 5]))
def test_index_gives_the_list(tmp_path_factory, items, protocol):
    """Items read through the index are the items of the list, repeated objects included."""
    items = [*items, items[0]]
    path = tmp_path_factory.mktemp("list") / "list.pkl"
    path.write_bytes(pickle.dumps(items, protocol))
    indexed = index_bytes_list(path)
    assert indexed is not None
    assert indexed.complete
    assert [indexed[row] for row in range(len(indexed))] == items


def test_index_of_a_cut_list(tmp_path):
    """A cut list gives the whole items before the cut and says that it is cut."""
    items = [bytes([number]) * 1000 for number in range(50)]
    path = tmp_path / "list.pkl"
    path.write_bytes(pickle.dumps(items)[:20_500])
    indexed = index_bytes_list(path)
    assert not indexed.complete
    assert 0 < len(indexed) < 21
    assert [indexed[row] for row in range(len(indexed))] == items[: len(indexed)]


@pytest.mark.parametrize(
    "value", [{"a": b"x"}, [b"x", 1], [[b"x"], [b"y"]], b"x", [np.zeros(3)], Evil(os.system, "true")]
)
def test_index_of_something_else(tmp_path, value):
    """What is not one list of bytes is not indexed, and is not run either."""
    path = tmp_path / "other.pkl"
    path.write_bytes(pickle.dumps(value))
    assert index_bytes_list(path) is None


@given(st.lists(st.integers(0, 10**12), unique=True))
def test_natural_order_counts(numbers):
    """Unpadded numbers sort as numbers."""
    names = natural_sorted([f"{number}.png" for number in numbers])
    assert [last_number(name) for name in names] == sorted(numbers)


@given(st.lists(st.text(max_size=12)))
def test_natural_order_is_total(names):
    """Any names can be ordered, the order does not depend on the start, and equal keys mean equal names."""
    assert natural_sorted(names) == natural_sorted(reversed(names))
    assert len({natural_key(name) for name in names}) == len(set(names))


class Dill:
    """A value that dill would have written: by functions of its own."""

    def __init__(self, *content):
        self.content = content

    def __reduce__(self):
        return self.content


def dill_module():
    """A module that pickles under the names of dill; its functions run nothing but what they are asked to."""
    module = types.ModuleType("dill._dill")
    for name in ("_import_module", "_get_attr", "_create_array", "_load_type"):
        exec(f"def {name}(*given): return given", module.__dict__)
        module.__dict__[name].__module__ = "dill._dill"
    return module


@pytest.fixture
def dill(monkeypatch):
    """The module, importable while the test writes its pickle."""
    module = dill_module()
    monkeypatch.setitem(sys.modules, "dill", types.ModuleType("dill"))
    monkeypatch.setitem(sys.modules, "dill._dill", module)
    return module


def test_dill_reaches_numpy_only(dill):
    """A pickle that calls dill's functions imports no module, and reaches nothing but what begins an array."""
    for module, name in (("os", "system"), ("numpy.core.multiarray", "fromfile"), ("numpyx.core.", "_reconstruct")):
        home = Dill(dill._import_module, (module,))
        with pytest.raises((BrokenLog, UnsafeContent), match="not data"):
            loads(pickle.dumps(Dill(dill._get_attr, (home, name))), "x")
    for state in ((os.getcwd, (), None), (collections.OrderedDict, (), None)):
        with pytest.raises((BrokenLog, UnsafeContent)):
            loads(pickle.dumps(Dill(dill._create_array, state)), "x")
    # a whole array comes through
    begin, given, state = np.arange(6.0).reshape(2, 3).__reduce__()
    back = loads(pickle.dumps(Dill(dill._create_array, (begin, given, state, None))), "x")
    np.testing.assert_array_equal(back, np.arange(6.0).reshape(2, 3))


def test_only_named_packages_are_passed_over(tmp_path):
    """Objects of a package are passed over where a caller names it; any other is refused as ever."""
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps({"kept": np.arange(3), "left": fractions.Fraction(1, 2), "last": 7}))
    with pytest.raises(UnsafeContent, match="fractions"):
        load_pickle(path)
    back = load_pickle(path, unread=frozenset({"fractions"}))
    assert back["kept"].tolist() == [0, 1, 2]
    assert isinstance(back["left"], UnreadObject)
    assert back["last"] == 7
    path.write_bytes(pickle.dumps([fractions.Fraction(1, 2), Evil(os.system, "true")]))
    with pytest.raises(UnsafeContent, match="system"):
        load_pickle(path, unread=frozenset({"fractions"}))
