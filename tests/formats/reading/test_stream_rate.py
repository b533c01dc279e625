"""Rates are those of times: pictures that carry none have no rate, in any format."""

import json

import pytest
from generators.mcap_files import START, Tape, encoded, picture
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.cli.main import run
from tactiledata.formats.reading.stream_rate import has_times, rate_of


@pytest.fixture
def inspected(capsys, monkeypatch):
    """What `inspect` prints about a path."""

    def look(path, *options):
        monkeypatch.setattr("sys.argv", ["tactiledata", "inspect", str(path), *options])
        with pytest.raises(SystemExit):
            run()
        return capsys.readouterr().out

    return look


@pytest.mark.parametrize("count", [1, 2, 5])
def test_pictures_without_times_have_no_rate(tmp_path, inspected, count):
    """A folder of pictures has stamps 0, 1, 2 ns: "no times" is said instead of 1000000000 Hz."""
    for index in range(count):
        (tmp_path / f"{index}.png").write_bytes(encoded(picture(index)))
    printed = inspected(tmp_path)
    assert "000000" not in printed
    assert ("no times" in printed.split("no-clock")[0].split("images without times")[0]) == (count > 1)
    [topic] = json.loads(inspected(tmp_path, "--json"))["sources"][0]["topics"]
    assert (topic["rate"], topic["has_times"], topic["messages"]) == (None, count == 1, count)


def test_messages_with_one_log_time_have_no_rate(tmp_path, inspected):
    """A recording whose recorder stamped all messages alike, or 1 ns apart, says so; true times keep their rate."""
    with Tape(tmp_path / "run.mcap") as tape:
        for index in range(11):
            for topic, step in (("/alike", 0), ("/counted", 1), ("/timed", 10_000_000)):
                tape.raw(topic, START + index * step, b'{"v": 1}', "X", "jsonschema", "json", b"{}")
    lines = {line.split()[0]: line for line in inspected(tmp_path / "run.mcap").splitlines() if line.startswith("/")}
    assert "no times" in lines["/alike"]
    assert "no times" in lines["/counted"]
    assert " 100.0 " in lines["/timed"]


@given(count=st.integers(2, 10**6), step=st.integers(0, 10**9), first=st.integers(0, 2**60))
def test_a_rate_is_that_of_evenly_spaced_stamps(count, step, first):
    """Law: stamps a step apart give 1/step where a step is at least 1 us, and none below."""
    last = first + (count - 1) * step
    rate = rate_of(count, first, last)
    assert has_times(count, first, last) == (step >= 1_000)
    assert rate is None if step < 1_000 else rate == pytest.approx(1e9 / step)


def test_facts_of_a_recording_are_said_in_words(tmp_path, inspected):
    """Lists have no brackets, what is empty is not said, and how long it lasts has its unit; --json keeps them all."""
    (tmp_path / "empty.png").write_bytes(encoded(picture(0)))
    printed = inspected(tmp_path)
    assert "trajectories stated: 1" in printed
    for absent in ("[]", "licence", "duration"):
        assert absent not in printed
    [source] = json.loads(inspected(tmp_path, "--json"))["sources"]
    assert source["facts"]["sensors"] == []
    with Tape(tmp_path / "run.mcap") as tape:
        for index in (0, 1250):
            tape.raw("/any", START + index * 1_000_000, b"{}", "X", "jsonschema", "json", b"{}")
    assert "files: run.mcap\n" in (printed := inspected(tmp_path / "run.mcap"))
    assert "duration: 1.2 s\n" in printed
