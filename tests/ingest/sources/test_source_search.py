"""Which files below a path are recordings, with formats that are told by the ends of names."""

import os
from pathlib import Path

import pytest

from tactiledata.contract.lfs_pointer import START
from tactiledata.contract.records import Source
from tactiledata.errors import BrokenLog, MissingFile, NotFetched, UsageError
from tactiledata.ingest.sources import discover
from tactiledata.ingest.sources.discover import MAX_DEPTH, find_sources, format_of, undescribed_logs


def by_suffix(suffix, count=1):
    class Member:
        name = suffix

        def sniff(self, path):
            return path.suffix == f".{suffix}"

        def sources(self, path):
            parts = [""] if count == 1 else [str(part) for part in range(count)]
            files = (str(path), str(path.with_suffix(".side")))
            return [Source(str(path), path.name, suffix, files, part) for part in parts]

    return Member


@pytest.fixture(autouse=True)
def formats(monkeypatch):
    monkeypatch.setattr(discover, "FORMATS", {"log": by_suffix("log"), "bag": by_suffix("bag", 2)})


def tree(folder, *names):
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("content")
    return folder


def found(*paths, **options):
    sources, unclaimed = find_sources(list(paths), **options)
    return [(source.key, source.format, source.part) for source in sources], [path.name for path in unclaimed]


def test_the_first_format_that_claims_a_path_reads_it():
    """The first format that claims a path reads it, or the one that is named; none does if none claims it."""
    assert format_of(Path("a.log")).name == "log"
    assert format_of(Path("a.bag")).name == "bag"
    assert format_of(Path("a.txt")) is None
    assert format_of(Path("a.log"), "bag").name == "bag"


def test_recordings_come_in_natural_order(tmp_path):
    """Numbers in names count as numbers; every part of a file is one, and what nobody claims is told."""
    tree(tmp_path, "run10.log", "run9.log", "b/x.bag", "notes.txt", "b/y.txt")
    assert found(tmp_path) == (
        [("x.bag/0", "bag", "0"), ("x.bag/1", "bag", "1"), ("run9.log", "log", ""), ("run10.log", "log", "")],
        ["y.txt", "notes.txt"],
    )


def test_hidden_files_and_stores_are_passed_over(tmp_path):
    """Wherever they stand among the others."""
    tree(tmp_path, ".a.log", "b.zarr/c.log", "d.log", ".z/e.log", "y.log")
    assert found(tmp_path)[0] == [("d.log", "log", ""), ("y.log", "log", "")]


def test_four_folders_down_are_searched(tmp_path):
    """A fifth is named as unclaimed."""
    tree(tmp_path, "1/2/3/4.log", "1/2/3/x/5.log", "1/2/y.log")
    assert found(tmp_path) == ([("4.log", "log", ""), ("y.log", "log", "")], ["x"])
    tree(tmp_path / "deep", "1/2/3/x.log")
    assert found(tmp_path / "deep")[0] == [("x.log", "log", "")]
    tree(tmp_path / "lost", "1/2/3/4/x.log")
    with pytest.raises(BrokenLog, match="not a recording in a known format"):
        find_sources([tmp_path / "lost"])
    assert MAX_DEPTH == 4


def test_what_is_no_recording_is_told_apart(tmp_path):
    """A store, a file in one, an empty folder, and a table of one's own are answered in words of their own."""
    tree(tmp_path, "ds/manifest.json", "ds/zarr.json", "empty/.hidden", "own/forces.csv", "one/wrench.csv")
    tree(tmp_path, "logs/a/tcp.csv", "logs/a/wrench.csv", "logs/b/tcp.csv", "logs/b/wrench.csv", "logs/b/frames.csv")
    for path, said in (
        ("ds", "ds is a store"),
        ("ds/zarr.json", "is inside a store"),
        ("empty", "holds no recording and no file"),
        ("own", "4 levels of folders below it.*folder log"),
        ("one", "4 levels of folders below it.*folder log"),
        ("logs/b", "b holds 3 tables of a folder log and no log.yaml that can be read; expected a log.yaml beside"),
        ("logs", "a holds 2 tables of a folder log .* read, and so is it in 1 more of its folders"),
        ("own/forces.csv", "forces.csv is not a recording in a known format; expected.*folder log"),
    ):
        with pytest.raises((BrokenLog, UsageError), match=said):
            find_sources([tmp_path / path])


def test_files_that_belong_to_a_recording_are_not_unclaimed(tmp_path):
    """A file beside it that it names as its own."""
    tree(tmp_path, "a.log", "a.side", "b.side")
    assert found(tmp_path)[1] == ["b.side"]


def test_a_recording_that_is_named_twice_is_read_once(tmp_path):
    """A recording that is named in several ways is read once; several of one name are told apart by their folders."""
    tree(tmp_path, "a/run.log", "b/run.log", "c/run.log", "d/other.log")
    once = [(name, "log", "") for name in ("a/run.log", "b/run.log", "c/run.log", "other.log")]
    assert found(tmp_path)[0] == once
    assert found(tmp_path, tmp_path / "a" / ".." / "a" / "run.log")[0] == once
    assert found(tmp_path / "a" / "run.log", tmp_path / "d")[0] == [("run.log", "log", ""), once[3]]


def test_a_named_format_reads_what_it_is_given(tmp_path):
    """A named format reads what it is given, also what no format would claim."""
    tree(tmp_path, "a.txt")
    assert found(tmp_path / "a.txt", format_name="log")[0] == [("a.txt", "log", "")]


def test_pointers_are_no_recordings(tmp_path):
    """Beside recordings they are unclaimed; alone they are an error that counts them."""
    tree(tmp_path, "a.log", "b.log", "c.log")
    for name in ("b.log", "c.log"):
        (tmp_path / name).write_bytes(START + b"\n")
    assert found(tmp_path) == ([("a.log", "log", "")], ["b.log", "c.log"])
    (tmp_path / "a.log").unlink()
    with pytest.raises(NotFetched, match=r"b\.log.*and 1 more"):
        find_sources([tmp_path])
    (tmp_path / "c.log").unlink()
    with pytest.raises(NotFetched) as error:
        find_sources([tmp_path])
    assert "more)" not in str(error.value)


def test_pipes_are_never_opened(tmp_path):
    """One that is named is refused; one in a folder is unclaimed, and so is a link into nothing."""
    tree(tmp_path, "a.log")
    os.mkfifo(tmp_path / "p.log")
    (tmp_path / "l.log").symlink_to("nowhere")
    assert found(tmp_path) == ([("a.log", "log", "")], ["l.log", "p.log"])
    with pytest.raises(UsageError, match="is a pipe or a device"):
        find_sources([tmp_path / "p.log"])
    with pytest.raises(MissingFile, match="does not exist"):
        find_sources([tmp_path / "nobody"])
    with pytest.raises(BrokenLog, match="one of: log, bag"):
        find_sources([tree(tmp_path / "none", "x.txt")])


def test_links_that_lead_back_up_end_no_search(tmp_path):
    """What comes after them in the folder is found."""
    tree(tmp_path, "in/b.log")
    (tmp_path / "in" / "a").symlink_to("..")
    assert found(tmp_path / "in") == ([("b.log", "log", "")], ["a"])


def test_tables_without_their_description_are_said(tmp_path):
    """Two tables of a folder log that nothing claims are a log that lost its log.yaml; one may be anybody's."""
    for folder, names in {"log": ("wrench.csv", "frames.csv"), "other": ("wrench.csv", "notes.csv")}.items():
        (tmp_path / folder).mkdir()
        for name in names:
            (tmp_path / folder / name).write_text("t_ns\n")
    (found,) = undescribed_logs(sorted(tmp_path.rglob("*.csv")))
    assert (found.code, found.severity, found.count) == ("log-undescribed", "warning", 2)
    assert found.message.startswith(f"{tmp_path / 'log'} holds 2 tables of a folder log and no log.yaml")
