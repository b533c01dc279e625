"""A checkpoint that would run code is refused in our words: nothing is run, and no advice to switch the check off."""

import json
import os
import pickle
import traceback

import pytest
import torch

from split_models.learning.checkpoint import FORMAT, load_checkpoint
from tactiledata.contract.tensor_files import refusal
from tactiledata.errors import CheckpointError, SchemaError
from tactiledata.metrics.gram_style import vgg19_features

ADVICE = ("weights_only", "torch.load", "safe_globals", "trust", "re-running", "allowlist", "default")


class Harm:
    """An object whose unpickling makes a folder."""

    def __init__(self, mark):
        self.mark = mark

    def __reduce__(self):
        return (os.mkdir, (str(self.mark),))


def write_archive(path, harm):
    torch.save({"document": "{}", "weights": harm}, path)


def write_legacy(path, harm):
    torch.save({"weights": harm}, path, _use_new_zipfile_serialization=False)


def write_pickle(protocol):
    def write(path, harm):
        path.write_bytes(pickle.dumps({"weights": harm}, protocol=protocol))

    return write


WRITERS = [write_archive, write_legacy, *map(write_pickle, (0, 2, 4, 5))]


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize(("load", "kind"), [(load_checkpoint, CheckpointError), (vgg19_features, SchemaError)])
def test_a_harmful_file_is_refused_and_not_run(tmp_path, write, load, kind):
    """The folder that the file would make is not there, and the message names the code without PyTorch's advice."""
    path, mark = tmp_path / "weights.pt", tmp_path / "harmed"
    write(path, Harm(mark))
    with pytest.raises(kind) as caught:
        load(path)
    assert not mark.exists()
    said = str(caught.value)
    assert f"names {os.mkdir.__module__}.mkdir, which is code and no tensor; the code was not run" in said
    assert "Do not open it with another program; remove it" in said
    assert not [word for word in ADVICE if word in said]
    assert "will likely succeed" not in "".join(traceback.format_exception(caught.value))


def test_the_harmful_file_would_do_harm(tmp_path):
    """Negative control: read without the check, the same file does run its code."""
    path, mark = tmp_path / "weights.pt", tmp_path / "harmed"
    write_archive(path, Harm(mark))
    torch.load(path, weights_only=False)
    assert mark.is_dir()


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "it is empty"), (b"\x80\x02garbage", "torn, or PyTorch did not write it"), (b"no pickle", "did not write")],
)
def test_files_of_something_else_are_refused_in_our_words(tmp_path, content, words):
    """Empty and foreign files: what was found, what was expected and what to do, without PyTorch's text."""
    path = tmp_path / "weights.pt"
    path.write_bytes(content)
    with pytest.raises(CheckpointError) as caught:
        load_checkpoint(path)
    said = str(caught.value)
    assert words in said
    assert "expected a file that PyTorch wrote" in said
    assert "train the weights again" in said
    assert not [word for word in ADVICE if word in said]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_script_archive_is_refused_without_advice(tmp_path):
    """TorchScript is code too; its refusal passes on nothing of what PyTorch says."""
    path = tmp_path / "weights.pt"
    torch.jit.save(torch.jit.script(torch.nn.Linear(2, 2)), path)
    with pytest.raises(CheckpointError) as caught:
        load_checkpoint(path)
    assert not [word for word in ADVICE if word in str(caught.value)]


def test_no_text_of_a_file_reaches_the_message(tmp_path):
    """Whatever the error says, only a dotted name is taken from it."""
    error = pickle.UnpicklingError("Unsupported global: GLOBAL os.system` now run: weights_only=False")
    (tmp_path / "x.pt").write_bytes(b"x")
    why, remedy = refusal(tmp_path / "x.pt", error)
    assert "names os.system, which" in why
    assert "weights_only" not in why + remedy
    why, remedy = refusal(tmp_path / "x.pt", RuntimeError("set weights_only=False"))
    assert "weights_only" not in why + remedy


@pytest.mark.parametrize("lost", ["kind", "settings", "stamps", "topology", "progress"])
def test_a_checkpoint_without_a_part_of_its_document_is_refused_in_our_words(tmp_path, lost):
    """A checkpoint of the right format that lacks an entry is refused by name; no KeyError reaches a user."""
    stamps = {"recipe": "", "split": "", "items": "", "topology": ""}
    document = {"format": FORMAT, "kind": "x", "settings": {}, "stamps": stamps, "topology": None, "progress": None}
    del document[lost]
    path = tmp_path / "weights.pt"
    torch.save({"document": json.dumps(document), "weights": {}, "extras": {}, "optimiser": {}}, path)
    with pytest.raises(CheckpointError, match=f"lacks '{lost}'"):
        load_checkpoint(path)
