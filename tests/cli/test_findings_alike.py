"""Findings that say the same of many recordings are told once, and all of them stay within reach."""

import json

import pytest
import yaml
from command import run_command
from copied_trees import copy_tree

from tactiledata.cli.output import findings
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import bare_wording


def printed(capsys, found, **options):
    """The lines that are printed of pairs of places and findings."""
    findings(found, **options)
    return [line.strip() for line in capsys.readouterr().out.splitlines()]


def gaps(count):
    """Findings of as many recordings, which differ in their numbers and names."""
    return [(f"day{n}", Finding("gap", "warning", f"wrench: {n} gaps of '{n}'", "wrench")) for n in range(count)]


def test_findings_alike_are_printed_once_with_their_places(capsys):
    """Five findings with the same words are printed once, with three places and how to list all of them."""
    assert printed(capsys, gaps(5)) == [
        "warning day0: wrench: 0 gaps of '0' [gap]",
        "and 4 more like it, in day1, day2, day3 …",
        "all of them: --json",
    ]
    assert len(printed(capsys, gaps(2))) == 2


def test_other_words_and_other_codes_stay_apart(capsys):
    """A finding with other words, another code or another severity is never hidden behind one like it."""
    others = [
        ("x", Finding("gap", "warning", "wrench: stands still", "wrench")),
        ("y", Finding("gap-long", "warning", "wrench: 9 gaps of '9'", "wrench")),
        ("z", Finding("csv-value", "damage", "wrench: 9 gaps of '9'", "wrench")),
    ]
    lines = printed(capsys, [*gaps(9), *others])
    assert [line.split("[")[1] for line in lines if "[" in line] == ["csv-value]", "gap]", "gap]", "gap-long]"]
    assert sum("more like it" in line for line in lines) == 1


def test_what_is_past_the_last_line_is_counted(capsys):
    """Beyond the most lines that are printed, findings are counted one by one, also those that are alike."""
    many = [(f"run{n}", Finding(f"kind-{n % 3}", "info", f"{n} rows")) for n in range(30)]
    lines = printed(capsys, many, most=2, all_of_them="ask again")
    assert lines[-2:] == ["… and 20 more", "all of them: ask again"]


def test_findings_without_a_place_are_counted(capsys):
    """Findings that name no recording are taken together by their stream, or are only counted."""
    chunks = [("", Finding("store-part", "damage", f"part-{n} cannot be read", f"table{n}")) for n in range(5)]
    assert "in table1, table2, table3 …" in printed(capsys, chunks)[1]
    bare = [("", Finding("store-part", "damage", f"part-{n} cannot be read")) for n in range(5)]
    assert printed(capsys, bare)[1] == "and 4 more like it"


@pytest.mark.parametrize(
    ("one", "other", "is_alike"),
    [
        ("run1: 3 of 9 rows", "run2: 14 of 90 rows", True),
        ("left: no serial", "right: no serial", True),
        ("also in monday (2), tuesday (1)", "also in wednesday (3)", True),
        ("the sensor's picture isn't there", "the sensor's gel isn't there", False),
        ("too many rows", "too few rows", False),
    ],
)
def test_wording_leaves_out_numbers_and_names(one, other, is_alike):
    """Messages are alike where they differ in numbers, in names that are given, and in what stands before a colon."""
    days = ("monday", "tuesday", "wednesday")
    assert (bare_wording(one, days) == bare_wording(other, days)) is is_alike


def spoilt(log, folder, number):
    """A copy of a folder log with a number that cannot be read, in another line of each copy."""
    copy = copy_tree(log, folder / f"run{number}")
    document = yaml.safe_load((copy / "log.yaml").read_text(encoding="utf-8"))
    (copy / "log.yaml").write_text(yaml.safe_dump({**document, "title": f"run {number}"}), encoding="utf-8")
    rows = (copy / "wrench.csv").read_text(encoding="utf-8").splitlines()
    rows[5 + number] = rows[5 + number].rpartition(",")[0] + ",nan"
    (copy / "wrench.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")


@pytest.mark.slow
def test_a_folder_of_bad_recordings_is_told_in_few_lines(tiny_folders, tmp_path, capsys):
    """Inspect and ingest print the fault of four recordings once; JSON documents and the store hold all four."""
    for number in range(4):
        spoilt(tiny_folders[0], tmp_path / "logs", number)
    for call in (("inspect", tmp_path / "logs"), ("ingest", tmp_path / "logs", "--store", tmp_path / "ds.zarr")):
        code, out, _ = run_command(capsys, *call)
        assert code == 1
        assert (out.count("[csv-value]"), out.count("and 3 more like it, in run1, run2, run3\n")) == (1, 2), out
    assert f"tactiledata info {tmp_path / 'ds.zarr'} --json" in out
    looked = json.loads(run_command(capsys, "inspect", tmp_path / "logs", "--json")[1])["sources"]
    assert all("csv-value" in {finding["code"] for finding in source["findings"]} for source in looked)
    kept = json.loads(run_command(capsys, "info", tmp_path / "ds.zarr", "--json")[1])["all_findings"]
    assert [row["source"] for row in kept if row["code"] == "csv-value"] == ["run0", "run1", "run2", "run3"]
