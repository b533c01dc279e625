"""Stores of earlier versions that hold an image too large to decode: each command says so, and none decodes it."""

import json
import re

import cv2
import numpy as np
import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.contract import image_bytes
from tactiledata.contract.take import UNUSABLE
from tactiledata.errors import TactileDataError
from tactiledata.ingest.checks import image_sizes
from tactiledata.ingest.pipeline import ingest
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store


@pytest.fixture(params=["one image", "all images"])
def store(request, kept_before, tiny_store, tmp_path, monkeypatch):
    """A store of which one image, or every one, is beyond the limit; decoders fail the test when given such an image.

    The limit of these tests, in pixels, is above 320 x 240 and below 400 x 300, or below both.
    """
    before, limit = (kept_before, 100_000) if request.param == "one image" else (tiny_store, 70_000)
    decode = cv2.imdecode

    def guarded(content, flags):
        header = image_bytes.read_header(content.tobytes())
        assert header.height * header.width <= limit, "decoded"
        return decode(content, flags)

    monkeypatch.setattr(image_bytes, "MAX_DECODED_PIXELS", limit)
    monkeypatch.setattr(cv2, "imdecode", guarded)
    monkeypatch.chdir(tmp_path)
    return copy_tree(before, tmp_path / "ds.zarr")


@pytest.fixture(scope="module")
def kept_before(tiny_folders, tmp_path_factory):
    """A store with one large image, at the greatest force of its first touch, that nothing marks."""
    folder = tmp_path_factory.mktemp("large")
    logs = [copy_tree(log, folder / log.name) for log in tiny_folders]
    ingest(logs, folder / "plain.zarr")
    frames = Store.open(folder / "plain.zarr").frames(["trajectory", "contact_force"])
    first = frames["trajectory"].to_numpy() == 0
    row = int(np.nanargmax(np.where(first, frames["contact_force"].to_numpy(), np.nan)))
    payload = Store.open(folder / "plain.zarr").encoded([row])[0]
    place = next(path for log in logs for path in log.rglob("*.*") if path.is_file() and path.read_bytes() == payload)
    picture = cv2.resize(cv2.imread(str(place)), (300, 400))
    assert cv2.imwrite(str(place), picture)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(image_sizes, "stray_sizes", lambda counts: set())
        ingest(logs, folder / "ds.zarr")
    make_split(Store.open(folder / "ds.zarr"), hold_out="none")
    return folder / "ds.zarr"


FAILURES = {
    "check": ["check"],
    "check --decode": ["check", "--decode"],
    "report": ["report"],
    "score": ["score", "--metric", "histogram_intersection"],
    "transfer": ["transfer", "--to", "D20001", "--method", "no-contact"],
}
"""Commands that need every image that nothing marks."""


@pytest.mark.parametrize("name", FAILURES)
def test_a_command_that_needs_the_image_says_what_to_do(name, store, capsys):
    """Without decoding, exit 1 names the frame and its size, the limit, and the command that marks it."""
    verb, *options = FAILURES[name]
    code, out, err = run_command(capsys, verb, store, *options)
    said = out + err
    assert code == 1
    assert re.search(r"frame \d+", said)
    assert re.search(r"(400|320) rows x (300|240) columns are 0\.1 million pixels, and at most 0\.1 million", said)
    assert re.search("check (--decode )?--repair", said)
    assert "Traceback" not in said


def test_an_audit_names_what_it_did_not_compare(store, capsys):
    """The audit goes on without images that are too large; it does not count them as looked at, and says so."""
    code, out, _ = run_command(capsys, "audit", store, "--json")
    report = json.loads(out)
    # a tiny split has an empty part, which is another matter
    [finding] = [one for one in report["findings"] if one["code"] != "split-empty-part"]
    assert code == 0
    assert finding["code"] == "images-not-compared"
    assert (finding["count"], report["checked"]["images"]) in [(1, 34), (35, 0)]
    assert "too large to be decoded and not compared, first frame" in finding["message"]
    assert "check --repair" in finding["message"]


def test_a_dataset_names_the_image(store):
    """A batch with the image is an error that names the frame; sizes that do not stack are one before that."""
    with pytest.raises(TactileDataError) as caught:
        TactileArrays(store, "default/train", ["digit"]).batch(range(20))
    assert re.search(r"frame \d+", caught.value.found)
    assert "--re" in str(caught.value)  # check --repair, or ingest --replace


@pytest.mark.slow
def test_repair_leaves_the_image_out(store, capsys):
    """Marked, the image is a warning and no more; the other images of the store load, and the audit is without it."""
    code, out, _ = run_command(capsys, "check", store, "--repair")
    assert code == 0
    assert "marked as broken: damaged, or too large to be decoded" in out
    code, out, _ = run_command(capsys, "check", store, "--decode")
    assert code == 0
    assert "store-payload-marked" in out
    code, out, _ = run_command(capsys, "audit", store)
    assert "images-not-compared" not in out
    flags = Store.open(store).frames(["flags"])["flags"].to_numpy()
    if not (flags & UNUSABLE).all():
        arrays = TactileArrays(store, "default/train", ["digit"])
        assert arrays.batch(range(len(arrays)))["digit"].shape[1:] == (320, 240, 3)
        assert run_command(capsys, "report", store)[0] == 0


@pytest.mark.parametrize("name", ["score", "transfer"])
def test_an_unmarked_image_of_another_size_is_named(name, kept_before, capsys, tmp_path, monkeypatch):
    """Within the limit, an image of another size that nothing marks is an error as well, with both sizes and advice."""
    monkeypatch.chdir(tmp_path)
    verb, *options = FAILURES[name]
    written = ("--out", tmp_path / "out") if name == "transfer" else ()
    code, out, err = run_command(capsys, verb, kept_before, *options, *written)
    assert code == 1
    assert "400" in out + err
    assert "with --replace: " in out + err
    assert "Traceback" not in out + err
