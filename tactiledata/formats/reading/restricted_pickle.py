"""Pickles of public corpora, read without running anything that they ask for.

A pickle is a program. This reader runs a small part of its language only: numpy arrays, dtypes and scalars, str, bytes,
numbers, and the containers list, tuple, dict, set, frozenset and OrderedDict. Any other name is refused before it is
looked up. Arrays and dtypes are rebuilt by numpy's public functions from checked values, never by ``__setstate__``.
Objects of packages that a caller names as unread are passed over: nothing of them is looked up either.
"""

from __future__ import annotations

import collections
import io
import math
import pickle
import struct
import tokenize
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO, ClassVar

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.errors import BrokenLog, LostFile, UnsafeContent
from tactiledata.formats.reading.unread_object import COMPANIONS, UnreadObject, dill_names

MAX_PICKLE_BYTES = 8 * 2**30
"""Largest file that is unpickled whole; lists of images are indexed instead, see `pickled_list`."""
MAX_DIMENSIONS = 32
_KINDS = "biufcSUO"
PICKLE_FAULTS: tuple[type[Exception], ...] = (
    pickle.UnpicklingError,
    EOFError,
    struct.error,
    ValueError,
    TypeError,
    IndexError,
    KeyError,
    AttributeError,
    AssertionError,
    OverflowError,
    MemoryError,
    RecursionError,
)
"""What a damaged pickle can raise while it is read."""
NPY_FAULTS: tuple[type[Exception], ...] = (*PICKLE_FAULTS, SyntaxError, tokenize.TokenError)
"""The same for the header of a .npy file, which is Python text."""


def load_pickle(path: Path, max_bytes: int = MAX_PICKLE_BYTES, unread: frozenset[str] = frozenset()) -> Any:
    """The value in a pickle file.

    Parameters
    ----------
    path : Path
    max_bytes : int
        Largest file that is read.
    unread : set of str
        Packages whose objects are passed over (an `UnreadObject` stands in their place) rather than refused.

    Raises
    ------
    UnsafeContent
        It names a function or class that is not data; ``facts['name']`` says which.
    BrokenLog
        It is truncated, damaged, or larger than ``max_bytes``.
    """
    with open_named(path) as stream:
        return _read_value(_bounded(path, stream, max_bytes), str(path), unread)


def loads(payload: bytes, where: str) -> Any:
    """The value in a pickle of bytes; ``where`` names it in messages. Raises as `load_pickle`."""
    return _read_value(BoundedReader(io.BytesIO(payload), len(payload)), where)


def load_npy(path: Path, max_bytes: int = MAX_PICKLE_BYTES) -> Any:
    """The array in a .npy file, or the object where the file holds a single pickled one (a dict, usually).

    Raises
    ------
    UnsafeContent, BrokenLog
        As `load_pickle`.
    """
    with open_named(path) as stream:
        try:
            shape, dtype = _npy_header(stream)
        except NPY_FAULTS as error:
            raise broken_file(str(path), f"not a .npy file ({error})") from error
        if dtype.hasobject:
            value = _read_value(_bounded(path, stream, max_bytes), str(path))
            return value.item() if isinstance(value, np.ndarray) and value.shape == () else value
        needed = math.prod(shape) * dtype.itemsize
        rest = path.stat().st_size - stream.tell()
        if needed > min(rest, max_bytes):
            raise broken_file(str(path), f"an array of shape {shape} needs {needed} bytes, {rest} are there")
    try:
        return np.load(path, allow_pickle=False)
    except PICKLE_FAULTS as error:
        raise broken_file(str(path), str(error)) from error


def open_named(path: Path) -> BinaryIO:
    """A file opened for reading; `LostFile` where it is not there."""
    if not path.is_file():
        raise LostFile(f"{path} does not exist", "a file of the corpus", path=str(path))
    refuse_lfs_pointer(path)
    return path.open("rb")


def _npy_header(stream: BinaryIO) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = np.lib.format.read_magic(stream)
    if version == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
    else:
        shape, _, dtype = np.lib.format.read_array_header_2_0(stream)
    return shape, dtype


def _bounded(path: Path, stream: BinaryIO, max_bytes: int) -> BoundedReader:
    rest = path.stat().st_size - stream.tell()
    if rest > max_bytes:
        raise BrokenLog(
            f"{path} holds a pickle of {rest} bytes", f"at most {max_bytes} bytes", "Split the file.", file=str(path)
        )
    return BoundedReader(stream, rest)


def _read_value(stream: BoundedReader, where: str, unread: frozenset[str] = frozenset()) -> Any:
    try:
        value = _Reader(stream, where, unread).load()
    except UnsafeContent:
        raise
    except PICKLE_FAULTS as error:
        raise broken_file(where, str(error) or type(error).__name__) from error
    if isinstance(value, _Pending):
        raise broken_file(where, "an array without content")
    return value


def broken_file(where: str, reason: str) -> BrokenLog:
    """The error for a file that is not whole."""
    return BrokenLog(
        f"{where} cannot be read: {reason}", "a whole pickle or .npy file", "Fetch the file again.", file=where
    )


class BoundedReader:
    """A file that never reads (or allocates) more than what is left of it, whatever lengths the pickle claims."""

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream = stream
        self._end = stream.tell() + size

    def read(self, size: int = -1) -> bytes:
        """Read at most ``size`` bytes, and never more than are left."""
        left = max(self._end - self._stream.tell(), 0)
        return self._stream.read(left if size < 0 else min(size, left))

    def readline(self, size: int = -1) -> bytes:
        """Read one line, and never more than is left."""
        return self._stream.readline(size)

    def readinto(self, buffer: Any) -> int:
        """Bytes read into a buffer; how many."""
        chunk = self.read(len(buffer))
        buffer[: len(chunk)] = chunk
        return len(chunk)

    def tell(self) -> int:
        """The place in the underlying file."""
        return self._stream.tell()


class _Pending:
    """An array or dtype that the pickle has begun; the finished one takes its place."""

    def __init__(self, start: np.dtype[Any] | None = None) -> None:
        self.start = start
        self.finished: Any = None


def _finished(value: Any) -> Any:
    if isinstance(value, _Pending):
        if value.finished is None:
            raise pickle.UnpicklingError("an array or dtype is used before it is complete")
        return value.finished
    return value


def _checked_dtype(value: Any) -> np.dtype[Any]:
    dtype = _finished(value)
    if not isinstance(dtype, np.dtype):
        raise pickle.UnpicklingError(f"{type(dtype).__name__} where a dtype belongs")
    return dtype


def _checked_shape(shape: Any) -> tuple[int, ...]:
    sizes = (shape,) if isinstance(shape, int) else tuple(shape)
    if len(sizes) > MAX_DIMENSIONS or not all(isinstance(size, int) and size >= 0 for size in sizes):
        raise pickle.UnpicklingError(f"array shape {sizes!r}")
    return sizes


def _begin_array(*_: Any) -> _Pending:
    return _Pending()


def _begin_dtype(code: Any, *_: Any) -> _Pending:
    if not isinstance(code, str) or not code or (code[0].lower() != "v" and np.dtype(code).kind not in _KINDS):
        raise pickle.UnpicklingError(f"dtype {code!r}")
    return _Pending(np.dtype(code))


def _end_dtype(start: np.dtype[Any], state: Any) -> np.dtype[Any]:
    _, order, subarray, names, fields, itemsize = state[:6]
    if subarray is not None:
        base, shape = subarray
        return np.dtype((_checked_dtype(base), _checked_shape(shape)))
    if names:
        parts = [(_checked_dtype(fields[name][0]), int(fields[name][1])) for name in names]
        if any(dtype.hasobject for dtype, _ in parts):
            raise pickle.UnpicklingError("a structured dtype with objects")
        return np.dtype(
            {
                "names": list(names),
                "formats": [dtype for dtype, _ in parts],
                "offsets": [offset for _, offset in parts],
                "itemsize": int(itemsize),
            }
        )
    return start.newbyteorder(order) if order in ("<", ">") else start


def _array_of(raw: Any, dtype: np.dtype[Any], shape: tuple[int, ...], order: Any) -> NDArray[Any]:
    count = math.prod(shape)
    if dtype.hasobject:
        items = [_finished(item) for item in raw]
        if len(items) != count:
            raise pickle.UnpicklingError(f"{len(items)} objects for an array of shape {shape}")
        objects = np.empty(count, dtype=object)
        for index, item in enumerate(items):
            objects[index] = item
        return objects.reshape(shape, order=order)
    if not isinstance(raw, bytes | bytearray) or not dtype.itemsize or len(raw) != count * dtype.itemsize:
        raise pickle.UnpicklingError(f"content that does not fill an array of shape {shape} and dtype {dtype}")
    return np.frombuffer(bytearray(raw), dtype=dtype).reshape(shape, order=order)


def _end_array(state: Any) -> NDArray[Any]:
    _, shape, dtype, is_fortran, raw = state
    return _array_of(raw, _checked_dtype(dtype), _checked_shape(shape), "F" if is_fortran else "C")


def _array_from_buffer(buffer: Any, dtype: Any, shape: Any, order: Any) -> NDArray[Any]:
    checked = _checked_dtype(dtype)
    if checked.hasobject:
        raise pickle.UnpicklingError("a buffer of objects")
    return _array_of(buffer, checked, _checked_shape(shape), "F" if order == "F" else "C")


def _scalar(dtype: Any, raw: Any) -> Any:
    checked = _checked_dtype(dtype)
    if checked.hasobject:
        raise pickle.UnpicklingError("a scalar that is an object")
    return _array_of(raw, checked, (1,), "C")[0]


def _encode(text: Any, encoding: Any = "latin1") -> bytes:
    if not isinstance(text, str) or encoding not in ("latin1", "latin-1"):
        raise pickle.UnpicklingError(f"text in encoding {encoding!r}")
    return text.encode("latin1")


def _bytes(*content: Any) -> bytes:
    if not content:
        return b""
    if isinstance(content[0], int):
        raise pickle.UnpicklingError("bytes made by their length")
    return bytes(*content)


def _set(items: Any = ()) -> set[Any]:
    return set(items)


def _frozenset(items: Any = ()) -> frozenset[Any]:
    return frozenset(items)


def _ordered(items: Any = ()) -> collections.OrderedDict[Any, Any]:
    return collections.OrderedDict(items)


def _complex(real: Any, imaginary: Any = 0.0) -> complex:
    return complex(float(real), float(imaginary))


def _array_type(*_: Any) -> Any:
    raise pickle.UnpicklingError("numpy.ndarray is called directly")


_ALLOWED: dict[tuple[str, str], Callable[..., Any]] = {
    ("numpy", "ndarray"): _array_type,
    ("numpy", "dtype"): _begin_dtype,
    ("_codecs", "encode"): _encode,
    ("collections", "OrderedDict"): _ordered,
    **{(core, "_reconstruct"): _begin_array for core in ("numpy.core.multiarray", "numpy._core.multiarray")},
    **{(core, "scalar"): _scalar for core in ("numpy.core.multiarray", "numpy._core.multiarray")},
    **{(core, "_frombuffer"): _array_from_buffer for core in ("numpy.core.numeric", "numpy._core.numeric")},
    **{(module, "bytes"): _bytes for module in ("builtins", "__builtin__")},
    **{(module, "bytearray"): _bytes for module in ("builtins", "__builtin__")},
    **{(module, "set"): _set for module in ("builtins", "__builtin__")},
    **{(module, "frozenset"): _frozenset for module in ("builtins", "__builtin__")},
    **{(module, "complex"): _complex for module in ("builtins", "__builtin__")},
}
_ALLOWED |= dill_names(_ALLOWED, _begin_array, _end_array)


class _Reader(pickle._Unpickler):
    """The standard library's unpickler with everything that makes objects taken out."""

    stack: list[Any]
    memo: dict[int, Any]
    append: Callable[[Any], None]
    read: Callable[[int], bytes]
    readline: Callable[[], bytes]
    dispatch: ClassVar[dict[int, Callable[..., Any]]] = dict(pickle._Unpickler.dispatch)

    def __init__(self, stream: BoundedReader, where: str, unread: frozenset[str] = frozenset()) -> None:
        super().__init__(stream)
        self._where = where
        self._unread = unread

    def _refuse(self, name: str) -> UnsafeContent:
        return UnsafeContent(
            f"{self._where} asks for {name}, which could run code",
            "numpy arrays, text, bytes, numbers and containers only",
            "Do not load it otherwise unless you trust its origin; convert it to plain arrays there.",
            name=name,
            file=self._where,
        )

    def find_class(self, module: str, name: str) -> Any:
        if module.partition(".")[0] in self._unread or (self._unread and (module, name) in COMPANIONS):
            return UnreadObject()
        if (module, name) not in _ALLOWED:
            raise self._refuse(f"{module}.{name}")
        return _ALLOWED[module, name]

    def persistent_load(self, pid: Any) -> Any:
        raise self._refuse("a persistent object")

    def get_extension(self, code: int) -> Any:
        raise self._refuse(f"the registered extension {code}")

    def load_build(self) -> None:
        state = self.stack.pop()
        target = self.stack[-1]
        if isinstance(target, UnreadObject):
            return
        if not isinstance(target, _Pending) or target.finished is not None:
            raise self._refuse(f"changing a {type(target).__name__}")
        target.finished = _end_array(state) if target.start is None else _end_dtype(target.start, state)
        self.stack[-1] = target.finished

    def load_newobj(self) -> None:
        self.stack.pop()
        if not isinstance(self.stack.pop(), UnreadObject):
            raise self._refuse("an instance of a class")
        self.append(UnreadObject())

    def load_refused(self) -> None:
        raise self._refuse("an instance of a class")

    def _push_remembered(self, index: int) -> None:
        value = self.memo[index]
        self.append(value.finished if isinstance(value, _Pending) and value.finished is not None else value)

    def load_get(self) -> None:
        self._push_remembered(int(self.readline()[:-1]))

    def load_binget(self) -> None:
        self._push_remembered(self.read(1)[0])

    def load_long_binget(self) -> None:
        self._push_remembered(struct.unpack("<I", self.read(4))[0])

    dispatch[pickle.BUILD[0]] = load_build
    dispatch[pickle.NEWOBJ[0]] = load_newobj
    dispatch[pickle.GET[0]] = load_get
    dispatch[pickle.BINGET[0]] = load_binget
    dispatch[pickle.LONG_BINGET[0]] = load_long_binget
    for _opcode in (pickle.NEWOBJ_EX, pickle.INST, pickle.OBJ, pickle.NEXT_BUFFER):
        dispatch[_opcode[0]] = load_refused
    del _opcode
