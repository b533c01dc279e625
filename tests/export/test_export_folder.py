"""An export is there as a whole or not at all, whatever happens on the way, and takes nothing else's place."""

import itertools
import json
import os
import shutil
import signal
from pathlib import Path

import pytest
from copied_trees import copy_tree
from exported import digests, export

from tactiledata.contract.sealed import sealed_json
from tactiledata.errors import StoreBusy, UsageError
from tactiledata.export import EXPORTERS
from tactiledata.export import folder as folders
from tactiledata.export.export import export_data
from tactiledata.export.folder import DOCUMENT, read_export
from tactiledata.export.plan import ExportPlan
from tactiledata.store.read.reader import Store

CALLS = ("replace", "rename", "fsync", "unlink", "rmdir", "open")
"""Calls that change the disk, at each of which a run is killed."""


def counting(patch, at_call):
    """Each call that changes the disk is counted; the function is told its number."""
    number = itertools.count()

    def counted(function):
        def call(*arguments, **options):
            at_call(next(number))
            return function(*arguments, **options)

        return call

    for name in CALLS:
        patch.setattr(os, name, counted(getattr(os, name)))


def killed(parted, to, out, moment):
    """Whether an export in a process that is killed at its n-th call that changes the disk came to that call."""
    child = os.fork()
    if child == 0:
        try:
            counting(pytest.MonkeyPatch(), lambda number: number < moment or os.kill(os.getpid(), signal.SIGKILL))
            export(parted, to, out, file_mb=1)
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


@pytest.mark.slow
@pytest.mark.parametrize("to", EXPORTERS)
def test_equal_exports_have_equal_bytes(to, parted, tmp_path):
    """Two exports of one store are the same files, and their documents name each with its digest."""
    first, document = export(parted, to, tmp_path / "a")
    second, _ = export(parted, to, tmp_path / "b")
    assert digests(first) == digests(second)
    named = {name: facts["sha256"] for name, facts in document["files"].items()}
    assert named == {name: digest for name, digest in digests(first).items() if name != DOCUMENT}


@pytest.mark.slow
@pytest.mark.parametrize("to", EXPORTERS)
def test_an_export_that_was_killed_ends_like_one_that_was_not(to, parted, tmp_path, monkeypatch):
    """Killed at moments all the way: nothing that looks finished is there, and the next run gives the same bytes."""
    monkeypatch.setattr("tactiledata.export.plan.MEGABYTE", 10_000)
    for name in ("lerobot", "huggingface", "webdataset"):
        monkeypatch.setattr(f"tactiledata.export.{name}.MEGABYTE", 10_000)
    calls = []
    with monkeypatch.context() as patch:
        counting(patch, calls.append)
        whole, document = export(parted, to, tmp_path / "whole", file_mb=1)
    large = [
        name
        for name in document["files"]
        if name.endswith((".parquet", ".tar", ".mcap")) and "tactiledata/" not in name
    ]
    assert len(large) > 3 or to == "robomimic"
    expected = digests(whole)
    # the first and the last calls one by one, where the folder is made and put in its place
    moments = {*range(3), *range(0, len(calls), max(1, len(calls) // 6)), *range(len(calls) - 4, len(calls))}
    for moment in sorted(moments):
        out = tmp_path / "killed"
        assert killed(parted, to, out, moment), moment
        assert not out.exists() or read_export(out) is not None, moment
        export(parted, to, out, file_mb=1)
        assert digests(out) == expected, moment
        assert {path.name for path in tmp_path.iterdir()} == {"whole", "killed"}, moment
        shutil.rmtree(out)


def test_finished_files_are_kept(parted, tmp_path, monkeypatch):
    """Control of the above: the run after an interruption writes only what was not finished."""
    monkeypatch.setattr("tactiledata.export.webdataset.MEGABYTE", 3000)
    written = []
    exporter = EXPORTERS["webdataset"]
    write = exporter.write

    def failing(self, episodes, file, path, advance):
        if len(written) == 3:
            raise KeyboardInterrupt
        written.append(file.path)
        return write(self, episodes, file, path, advance)

    monkeypatch.setattr(exporter, "write", failing)
    with pytest.raises(KeyboardInterrupt):
        export(parted, "webdataset", tmp_path / "out", file_mb=1)
    assert not (tmp_path / "out").exists()
    monkeypatch.setattr(exporter, "write", lambda *given: (written.append(given[2].path), write(*given))[1])
    export(parted, "webdataset", tmp_path / "out", file_mb=1)
    assert len(written) == len(set(written)) > 4


def test_a_file_that_shrank_is_written_again(parted, tmp_path, monkeypatch):
    """A note of a file that is not as long as it says does not count."""
    monkeypatch.setattr("tactiledata.export.webdataset.MEGABYTE", 3000)
    exporter, write = EXPORTERS["webdataset"], EXPORTERS["webdataset"].write
    monkeypatch.setattr(exporter, "finish", lambda *given: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        export(parted, "webdataset", tmp_path / "out", file_mb=1)
    monkeypatch.undo()
    monkeypatch.setattr("tactiledata.export.webdataset.MEGABYTE", 3000)
    shard = next((tmp_path / ".out.exporting").glob("*.tar"))
    shard.write_bytes(shard.read_bytes()[:-512])
    written = []
    monkeypatch.setattr(exporter, "write", lambda *given: (written.append(given[2].path), write(*given))[1])
    export(parted, "webdataset", tmp_path / "out", file_mb=1)
    assert written == [shard.name]


def test_the_same_export_again_writes_nothing(parted, tmp_path):
    """A finished export is recognised; one that lacks a file is not, and is replaced only when asked."""
    out, _ = export(parted, "webdataset", tmp_path / "out")
    again = export_data(parted, ExportPlan("webdataset"), out)
    assert again.was_there
    next(out.glob("*.tar")).unlink()
    with pytest.raises(UsageError, match=r"lacks .*tar"):
        export_data(parted, ExportPlan("webdataset"), out)
    assert not export_data(parted, ExportPlan("webdataset"), out, replace_other=True).was_there
    assert list(out.glob("*.tar"))


@pytest.mark.slow
@pytest.mark.parametrize("what", ["a file", "other files", "another export", "a damaged export"])
def test_nothing_else_is_overwritten(what, parted, tmp_path):
    """What is no export of ours stays, with --replace too; another export stays without it."""
    out = tmp_path / "out"
    if what == "a file":
        out.write_text("mine")
    else:
        export(parted, "webdataset", out)
    if what == "other files":
        (out / DOCUMENT).unlink()
    if what == "a damaged export":
        (out / DOCUMENT).write_text((out / DOCUMENT).read_text().replace("train", "trian", 1))
    before = digests(out) if out.is_dir() else out.read_text()
    with pytest.raises(UsageError, match=str(out)):
        export_data(parted, ExportPlan("huggingface"), out)
    assert (digests(out) if out.is_dir() else out.read_text()) == before
    if what == "another export":
        export_data(parted, ExportPlan("huggingface"), out, replace_other=True)
        assert (out / "data").is_dir()
        assert not list(out.glob("*.tar"))
    else:
        with pytest.raises(UsageError, match=str(out)):
            export_data(parted, ExportPlan("huggingface"), out, replace_other=True)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, r"the split default has the same parts and was drawn with seed 0 instead of 7"),
        ({"split": "none"}, r"--split is none"),
        ({"streams": ("wrench",)}, r"--streams is wrench and was left out"),
        ({"file_mb": 7}, r"--file-mb is 7 and was 100"),
        ({"to": "huggingface"}, r"--to is huggingface and was webdataset"),
    ],
    ids=["a split drawn again", "no split", "streams", "size of files", "format"],
)
def test_what_differs_from_the_export_there_is_said(change, words, parted, tmp_path):
    """An export that finds another one in its folder says in what the two differ; an equal one is no change."""
    out, document = export(parted, "webdataset", tmp_path / "out")
    assert export_data(parted, ExportPlan("webdataset"), out).was_there
    if not change:
        document["split"]["options"]["seed"], document["key"] = 7, "0" * 64
        document.pop("file_sha256", None)
        (out / DOCUMENT).write_bytes(sealed_json(document))
    with pytest.raises(UsageError, match=words) as caught:
        export_data(parted, ExportPlan(**{"to": "webdataset", **change}), out)
    assert "--replace" in caught.value.remedy
    if change:
        assert "was drawn" not in str(caught.value)


def test_files_that_somebody_added_are_not_replaced(parted, tmp_path, monkeypatch):
    """What lies in an export and is not of it stays, with --replace too; so does the working folder."""
    out, _ = export(parted, "webdataset", tmp_path / "out")
    (out / "notes.txt").write_text("mine")
    with pytest.raises(UsageError, match=r"notes\.txt"):
        export_data(parted, ExportPlan("huggingface"), out, replace_other=True)
    assert (out / "notes.txt").read_text() == "mine"
    (tmp_path / "here" / "deep").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "here" / "deep")
    for place in (".", "..", str(tmp_path / "here")):
        with pytest.raises(UsageError, match="working folder"):
            export_data(parted, ExportPlan("huggingface"), Path(place))


def test_an_export_killed_while_it_takes_anothers_place(parted, tmp_path):
    """Between the two renamings the finished folder waits; the next run puts it in its place and clears the old one."""
    out, _ = export(parted, "webdataset", tmp_path / "out")
    expected = digests(out)
    out.rename(tmp_path / ".out.exporting")
    copy_tree(tmp_path / ".out.exporting", tmp_path / ".out.replaced")
    export(parted, "webdataset", out)
    assert digests(out) == expected
    assert {path.name for path in tmp_path.iterdir()} == {"out"}


def test_two_at_one_place(parted, tmp_path):
    """A second export at a place is refused while the first is made; a folder of somebody else's is left alone."""
    with folders.export_folder(tmp_path / "out", "0" * 64), pytest.raises(StoreBusy, match="another process"):
        export(parted, "webdataset", tmp_path / "out")
    (tmp_path / ".other.exporting").mkdir()
    (tmp_path / ".other.exporting" / "mine.txt").write_text("mine")
    with pytest.raises(UsageError, match=r"mine\.txt"):
        export(parted, "webdataset", tmp_path / "other")
    assert (tmp_path / ".other.exporting" / "mine.txt").read_text() == "mine"


@pytest.mark.slow
def test_what_another_plan_left_is_not_taken(parted, tmp_path, monkeypatch):
    """Files of an interrupted export with other options do not get into the next."""
    exporter = EXPORTERS["webdataset"]
    with monkeypatch.context() as patch:
        patch.setattr(exporter, "finish", lambda *given: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            export(parted, "webdataset", tmp_path / "out", action="wrench")
    out, _ = export(parted, "webdataset", tmp_path / "out", action="none")
    expected, _ = export(parted, "webdataset", tmp_path / "fresh", action="none")
    assert digests(out) == digests(expected)


def test_damage_in_the_store_ends_an_export(parted, tmp_path):
    """A picture that no longer fits its checksum is named, and no export appears."""
    copy_tree(parted.location, tmp_path / "ds.zarr")
    heap = tmp_path / "ds.zarr" / "streams" / "digit" / "heap" / "c.0"
    frame = parted.frames(["offset", "length"]).slice(20, 1).to_pylist()[0]
    with heap.open("r+b") as stream:
        stream.seek(frame["offset"] + frame["length"] // 2)
        byte = stream.read(1)[0]
        stream.seek(-1, 1)
        stream.write(bytes([byte ^ 1]))
    with pytest.raises(ValueError, match="does not fit its CRC-32C"):
        export(Store.open(tmp_path / "ds.zarr"), "huggingface", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_document_says_when_it_was_changed(parted, tmp_path):
    """Control of the seal: as written it is read, with one digit changed it is not."""
    out, document = export(parted, "webdataset", tmp_path / "out")
    found = read_export(out)
    assert {name: found[name] for name in document} == json.loads(json.dumps(document))
    text = (out / DOCUMENT).read_text()
    (out / DOCUMENT).write_text(text.replace('"frames": ', '"frames": 1', 1))
    assert read_export(out) is None
