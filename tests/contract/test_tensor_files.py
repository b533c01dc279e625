"""Files of tensors: what is read, and why a file is refused, from pickles written byte by byte."""

import os
import pickle
import struct
import zipfile

import pytest

from tactiledata.contract import tensor_files
from tactiledata.contract.tensor_files import read_tensors, refusal
from tactiledata.errors import CheckpointError

torch = pytest.importorskip("torch")

FETCH = "Remove it, and fetch or train the weights again."
NO_NAME = pickle.UnpicklingError("no name is said")
HARM = b"cos\nsystem\n"
"""The opcode that looks up os.system."""


def names(content):
    return list(tensor_files._names_in(content))


def text(word):
    """The opcode that puts a short text on the stack."""
    return b"\x8c" + bytes([len(word)]) + word.encode()


def test_tensors_and_plain_values_come_back(tmp_path):
    """What PyTorch wrote is read, without a warning that would end a strict run."""
    path = tmp_path / "x.pt"
    torch.save({"weights": torch.arange(3.0), "names": ["a"]}, path)
    found = read_tensors(path, "cannot be read", CheckpointError)
    assert found["names"] == ["a"]
    assert found["weights"].tolist() == [0.0, 1.0, 2.0]
    assert found["weights"].device.type == "cpu"


@pytest.mark.parametrize("bit", [0, 7])
@pytest.mark.parametrize("row", [0, 999])
def test_a_flipped_bit_of_a_weight_is_found(tmp_path, row, bit):
    """PyTorch reads such a file without a word, and the weight is another number."""
    path = tmp_path / "x.pt"
    weights = torch.arange(1.0, 1001.0)
    torch.save({"weights": weights}, path)
    content = bytearray(path.read_bytes())
    content[content.index(weights.numpy().tobytes()) + 4 * row + 3] ^= 1 << bit
    path.write_bytes(content)
    assert torch.load(path, weights_only=True)["weights"][row] != weights[row]
    with pytest.raises(CheckpointError, match=r"x\.pt cannot be read: its part \S+ does not fit its CRC-32") as caught:
        read_tensors(path, "cannot be read", CheckpointError)
    assert caught.value.facts["path"] == str(path)
    assert str(caught.value).endswith(FETCH)


def test_a_refusal_names_the_file_and_hides_what_pytorch_said(tmp_path):
    """The error's class is the one asked for, its facts hold the path, and no other error is shown with it."""
    path = tmp_path / "x.pt"
    path.write_bytes(b"\x80\x02" + HARM + b".")
    with pytest.raises(CheckpointError, match=r"x\.pt cannot be read: it names os\.system, which is code") as caught:
        read_tensors(path, "cannot be read", CheckpointError)
    assert caught.value.facts["path"] == str(path)
    assert caught.value.__cause__ is None
    assert caught.value.__suppress_context__


class Leaver:
    """What makes a folder when it is unpickled."""

    def __init__(self, place):
        self.place = place

    def __reduce__(self):
        return os.mkdir, (str(self.place),)


def test_code_in_a_file_is_not_run(tmp_path):
    """A file as PyTorch writes it, whose object would make a folder: it is refused, and there is no folder."""
    torch.save({"weights": Leaver(tmp_path / "made")}, tmp_path / "x.pt")
    with pytest.raises(CheckpointError, match="which is code"):
        read_tensors(tmp_path / "x.pt", "cannot be read", CheckpointError)
    assert not (tmp_path / "made").exists()


def test_what_the_system_refuses_is_said_in_its_words(tmp_path):
    """No such file: by the error itself, or found when the refused file is looked at again."""
    there = ("the system refused (No such file or directory)", "Check the path and its permissions.")
    assert refusal(tmp_path / "x", FileNotFoundError(2, "No such file or directory")) == there
    assert refusal(tmp_path / "x", NO_NAME) == there
    # an error of the system without words says nothing of the file
    (tmp_path / "x").touch()
    assert refusal(tmp_path / "x", OSError("no words"))[0] == "it is empty (0 bytes)"


def archive(content):
    """An archive of one member, with bytes in front."""

    def write(path):
        with zipfile.ZipFile(path, "w") as out:
            out.writestr("data.pkl", b"x")
        path.write_bytes(content + path.read_bytes())

    return write


@pytest.mark.parametrize(
    ("write", "why"),
    [
        (lambda path: path.write_bytes(b""), "it is empty (0 bytes)"),
        (lambda path: path.write_bytes(b"x"), "it is torn, or PyTorch did not write it"),
        (archive(b""), "it is damaged, or holds more than tensors"),
        # an archive is not taken apart as a pickle, whatever stands before it
        (archive(HARM + b"."), "it is damaged, or holds more than tensors"),
    ],
)
def test_files_without_a_name_of_code(tmp_path, write, why):
    """An empty file, a torn one and an archive, each in its words; the remedy is to fetch it again."""
    write(tmp_path / "x")
    assert refusal(tmp_path / "x", NO_NAME) == (why, FETCH)


@pytest.mark.parametrize(
    ("said", "code"),
    [
        ("Unsupported global: GLOBAL os.system was not allowed", "os.system"),
        ("GLOBAL my_module.Class", "my_module.Class"),
        ("nothing", "posix.rmdir"),
    ],
)
def test_the_name_that_pytorch_said_comes_first(tmp_path, said, code):
    """What the error names is shown; where it names nothing, what the file names."""
    (tmp_path / "x").write_bytes(b"cposix\nrmdir\n.")
    found, remedy = refusal(tmp_path / "x", pickle.UnpicklingError(said))
    assert found == f"it names {code}, which is code and no tensor; the code was not run"
    assert "can harm your machine" in remedy


def test_only_an_unpickling_error_names_code(tmp_path):
    """The same words in another error are no name: it may be a text of the file."""
    (tmp_path / "x").write_bytes(b"x")
    assert refusal(tmp_path / "x", RuntimeError("GLOBAL os.system"))[0] == "it is torn, or PyTorch did not write it"


@pytest.mark.parametrize(("before", "is_found"), [(0, True), (-1, True), (1, False), (500, False)])
def test_a_mebibyte_is_searched_for_the_name(tmp_path, before, is_found):
    """A name whose last byte is the 1,048,576th of the file is found, one that ends behind it is not."""
    padding = 2**20 - len(HARM) - 5 + before
    # a block of bytes, put on the stack
    (tmp_path / "x").write_bytes(b"B" + struct.pack("<I", padding) + bytes(padding) + HARM + b".")
    assert refusal(tmp_path / "x", NO_NAME)[0].startswith("it names os.system" if is_found else "it is torn")


def test_names_are_found_in_every_form():
    """A name by its own opcode, as an instance, and by the last two texts on the stack, however many came before."""
    assert names(HARM + b"cposix\nrmdir\n.") == ["os.system", "posix.rmdir"]
    assert names(b"(ios\nsystem\n.") == ["os.system"]
    assert names(text("os") + text("system") + b"\x93.") == ["os.system"]
    assert names(text("a") + text("b") + text("os") + text("system") + b"\x93.") == ["os.system"]
    assert names(text("a") + b"K\x01" + text("b") + b"\x93.") == ["a.b"]
    assert names(b"\x93.") == ["."]
    assert names(HARM + b"\xff") == ["os.system"]
    assert names(b"") == []


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"ctorch\nload\n" + b"ccollections\nOrderedDict\n.", ""),
        (b"ctorch\nload\n" + HARM + b".", "os.system"),
        (b"ca-b\nc\n" + HARM + b".", "os.system"),
        (text("x" * 100) + text("y" * 101) + b"\x93.", ""),
        (text("x" * 100) + text("y" * 100) + b"\x93.", "x" * 100 + "." + "y" * 100),
    ],
)
def test_names_of_tensors_and_names_that_cannot_be_shown_are_passed_over(tmp_path, content, code):
    """What PyTorch itself writes is harmless; a name of more than 201 characters is not repeated."""
    (tmp_path / "x").write_bytes(content)
    words = refusal(tmp_path / "x", NO_NAME)[0]
    assert words.startswith(f"it names {code}," if code else "it is torn")
