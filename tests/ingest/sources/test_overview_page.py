"""The page about a store, part by part, over stores that are only their tables."""

import json
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pytest

from tactiledata.contract.records import Finding
from tactiledata.contract.simulated import SimulatedCount
from tactiledata.contract.take import TRAJECTORY_SCHEMA, FrameFlag, Reference, findings_table
from tactiledata.errors import MissingFile
from tactiledata.ingest.sources import first_program as program_module
from tactiledata.ingest.sources import overview as module
from tactiledata.ingest.sources.first_program import first_program
from tactiledata.ingest.sources.overview import choose_touches, draw, page, touch_picture, write_report
from tactiledata.report.page import Panel, Picture, Section
from tactiledata.report.plots import TouchPicture
from tactiledata.splits.options import PARTITIONS
from tactiledata.splits.suggest import Suggestion
from tactiledata.units import SIGNAL_COLUMNS
from tests.ingest.made_takes import frames, touch

PNG = Picture(((Panel(b"png", 9),),), "caption")


class Samples:
    """A signal of a store: fz counts its rows, a second apart."""

    frame = "gel"
    columns = SIGNAL_COLUMNS["contact_wrench"]

    def t_ns(self, first, last):
        return np.arange(first, last) * 10**9

    def values(self, first, last):
        return np.tile(np.arange(first, last, dtype=float)[:, None], (1, 6)) + np.arange(6) / 10


class Tables:
    """A store that is its tables."""

    location = "my.zarr"
    digest = "d1gest"
    n_frames = 57

    def __init__(self, table=None, touches=(), signals=("contact_wrench",), **parts):
        self.table = frames(0) if table is None else table
        self.touches = list(touches)
        self.signal_names = signals
        self.parts = parts
        self.aligned_names = list(parts.get("aligned", {}))
        self.frame_value_names = parts.get("frame_values", ())

    def read_file(self, path):
        raise MissingFile(path, "a file", "Look elsewhere.")

    def trajectories(self, columns=None):
        found = pa.Table.from_pylist(self.touches) if self.touches else TRAJECTORY_SCHEMA.empty_table()
        return found if columns is None else found.select(columns)

    def frames(self, columns):
        return self.table.select(columns)

    def sensors(self):
        return {"D1": {"model": "digit"}}

    def references(self):
        return self.parts.get("references", {})

    def signal(self, name):
        return Samples()

    def images(self, rows):
        return [f"image {row}" for row in rows]

    def sources(self, columns):
        rows = self.parts.get("sources", [{"key": "one", "description": "{}"}, {"key": "two", "description": "{}"}])
        return pa.Table.from_pylist(rows).select(columns)

    def findings(self):
        rows = self.parts.get("findings", [])
        table = findings_table([finding for _, finding in rows])
        return table.set_column(0, "source", pa.array([source for source, _ in rows], pa.int32()))

    def split_names(self):
        return self.parts.get("splits", ())

    def aligned(self, name):
        return self.parts["aligned"][name], None


def row(name, peak=1.0, sensor="D1", indenter="ball", frames=(0, 1), **columns):
    columns = {"peak_force": peak, "sensor": sensor, "indenter": indenter, "end_ns": 10**9, **columns}
    return touch(name, frame_start=frames[0], frame_stop=frames[1], **columns)


def chosen(rows, monkeypatch):
    """Names of the touches that are shown, in order; a touch called none has no picture."""
    monkeypatch.setattr(
        module, "touch_picture", lambda store, place: None if rows[place]["trajectory"] == "none" else place
    )
    return [rows[place]["trajectory"] for place in choose_touches(Tables(touches=rows))]


def test_of_each_sensor_and_indenter_the_firmest_touch_is_shown(monkeypatch):
    """A touch without images is none, one without a force comes last."""
    rows = [row("a", 1), row("b", 3), row("c", 2), row("d", 9, frames=(4, 4)), row("e", np.nan, "D2")]
    rows.append(row("f", 0, "D2"))
    assert chosen(rows, monkeypatch) == ["b", "f"]
    assert chosen([row("e", np.nan), row("f", 0.0)], monkeypatch) == ["f"]
    assert chosen([row("a", 1, frames=(3, 4)), row("b", 1, frames=(4, 5))], monkeypatch) == ["a"]
    assert chosen([row("a", 1, frames=(5, 4))], monkeypatch) == []
    assert chosen([row("none", 5), row("b", 1, "D2")], monkeypatch) == ["b"]


def test_new_sensors_and_indenters_are_shown_before_known_ones(monkeypatch):
    """The touch with most that was not shown comes next, and among equals the first."""
    rows = [
        row("a", 1, "D1", "ball"), row("b", 9, "D1", "edge"), row("c", 5, "D2", "ball"), row("d", 2, "D2", "edge"),
        row("e", 1, "D3", "ball"),
    ]  # fmt: skip
    assert chosen(rows, monkeypatch) == ["a", "d", "e", "b", "c"]


def test_six_touches_are_shown(monkeypatch):
    """The first six of eight sensors are shown."""
    assert chosen([row(f"t{n}", n, f"D{n}") for n in range(8)], monkeypatch) == ["t0", "t1", "t2", "t3", "t4", "t5"]


def pictured(flags, force, place=1, **options):
    table = frames(8, t_ns=np.arange(8) * 10**8, flags=flags, contact_force=force)
    ranges = json.dumps({"contact_wrench": [2, 5]})
    rows = [row("other"), row("t", frames=(2, 7), start_ns=10**8, signal_rows=ranges, **options)]
    return table, rows


def test_a_touch_is_shown_at_its_largest_force():
    """A touch is shown by its usable image at the largest force, with its own samples and seconds from its start."""
    table, rows = pictured([0, 0, 0, 0, 0, FrameFlag.BROKEN, 0, 0], [99, 99, 1, 2, 3, 50, np.nan, 99])
    reference = Reference(np.zeros((8, 6, 3), np.uint8), "a file")
    shown = touch_picture(Tables(table, rows, references={"D1": reference}), 1)
    assert shown.title == "D1, ball, one/t"
    assert shown.image == "image 4"
    assert shown.background is reference.image
    assert shown.force_frame == "gel"
    np.testing.assert_allclose(shown.seconds, [1.9, 2.9, 3.9], rtol=1e-12)
    np.testing.assert_allclose(shown.force, [[2, 2.1, 2.2], [3, 3.1, 3.2], [4, 4.1, 4.2]], rtol=1e-12)
    np.testing.assert_allclose(shown.frame_seconds, [0.1, 0.2, 0.3, 0.4, 0.5], rtol=1e-12)
    assert shown.shown_second == pytest.approx(0.3, rel=1e-12)


def test_without_forces_the_middle_image_is_shown():
    """Without forces the middle usable image is shown; without samples or a reference none of these is."""
    table, rows = pictured([0, 0, FrameFlag.MISSING, 0, 0, 0, 0, 0], np.nan)
    shown = touch_picture(Tables(table, rows, signals=()), 1)
    assert shown.image == "image 5"
    assert (shown.background, shown.seconds.shape, shown.force.shape, shown.force_frame) == (None, (0,), (0, 3), "")
    table, rows = pictured(0, np.nan)
    assert touch_picture(Tables(table, rows, signals=()), 1).image == "image 4"
    rows[1]["signal_rows"] = "{}"
    assert touch_picture(Tables(table, rows), 1).force.shape == (0, 3)


def test_a_touch_without_usable_images_has_no_picture():
    """Nor is it an error; an indenter that is not named is called so, and kinds of recordings are told apart."""
    table, rows = pictured(FrameFlag.STRAY_SIZE, 1.0)
    assert touch_picture(Tables(table, rows), 1) is None
    table, rows = pictured(FrameFlag.OUTSIDE, 1.0, indenter="")
    assert touch_picture(Tables(table, rows), 1).title == "D1, (not named), one/t"
    sources = [
        {"key": key, "description": json.dumps({"recorded_by": {"contact": "simulated"}} if key == "one" else {})}
        for key in ("one", "two")
    ]
    kinds = Tables(table, rows, sources=sources)
    kinds.touches[0]["source"] = 1
    assert touch_picture(kinds, 1).title == "D1, (not named), one/t, simulated recording"


def some_touch(force):
    picture = np.full((8, 6, 3), 9, np.uint8)
    seconds = np.arange(len(force), dtype=float)
    return TouchPicture("t", picture, picture, seconds, np.array(force, float).reshape(-1, 3), "gel", seconds, 0.0)


@pytest.mark.slow
def test_the_caption_names_only_what_is_there():
    """One touch with a force is enough to name it."""
    assert draw([some_touch([]), some_touch([[0, 0, 1]])])[1].startswith("The firmest touches")
    assert draw([some_touch([])])[1].startswith("Touches, one per sensor")


FACTS = {
    "findings": {},
    "by_camera": {"digit": {"frames": 3, "recordings": ["one", "two"]}},
    "sources": 1, "trajectories": 2, "frames": 3, "status": {"unverified": 2, "ok": 1, "damaged": 3},
    "by_sensor": {"D1": {"model": "digit", "trajectories": 2, "frames": 3}},
    "by_indenter": {"": {"trajectories": 1, "frames": 2}, "ball": {"trajectories": 1, "frames": 1}},
    "signals": {
        "tcp": {"columns": ["x", "y"], "frame": "", "samples": 7, "rate_hz": 100.0, "effective_rate_hz": 0},
        "wrench": {"columns": ["fx"], "frame": "ft", "samples": 8, "rate_hz": 50.0, "effective_rate_hz": 24.97},
    },
}  # fmt: skip


def test_the_page_holds_its_parts_in_order(monkeypatch):
    """Counts in words, and a section that is empty is left out."""
    kept = {}

    def rendered(title, sentences, sections, footer, simulated):
        kept.update(sentences=sentences, sections=sections, footer=footer)
        return title

    monkeypatch.setattr(module, "overview", lambda store: FACTS)
    monkeypatch.setattr(module, "render_page", rendered)
    monkeypatch.setattr(module, "first_program", lambda store, split: f"program of {split}")
    monkeypatch.setattr(module, "suggest_split", lambda store: Suggestion("split it"))
    assert page(Tables(), PNG, "mine", [Section("More")]) == "What was recorded"
    assert kept["sentences"] == [
        "The store my.zarr holds 1 recording with 2 trajectories and 3 images of 1 sensor and 1 indenter.",
        "3 recordings lost data to damage, and what is whole was kept; 1 recording is whole; 2 recordings have no "
        "checksums and could not be verified.",
    ]
    titles = [
        "Touches",
        "Cameras",
        "Sensors and indenters",
        "Signals",
        "What the checks found",
        "Split",
        "More",
        "Use it",
    ]
    assert [section.title for section in kept["sections"]] == titles
    assert list(kept["sections"][0].pictures) == [PNG]
    assert kept["sections"][-1].code == ["program of mine"]
    assert kept["sections"][1].rows == [("digit", 3, "one, two")]
    assert kept["sections"][2].rows == [
        ("sensor", "D1", 2, 3), ("indenter", "(not named)", 1, 2), ("indenter", "ball", 1, 1),
    ]  # fmt: skip
    assert kept["sections"][3].rows == [
        ("tcp", "x y", "not stated", 7, 100.0, "-"), ("wrench", "fx", "ft", 8, 50.0, 25.0),
    ]  # fmt: skip
    assert kept["footer"].endswith("store digest d1gest")
    monkeypatch.setattr(module, "overview", lambda store: FACTS | {"signals": {}, "by_camera": {}})
    page(Tables(), None, "mine")
    assert [section.title for section in kept["sections"]] == [titles[2], *titles[4:6], titles[7]]


def test_findings_are_ranked_and_sixty_are_shown():
    """Damage comes before warnings and infos, then the order is by code and by recording."""
    rows = [
        (1, Finding("b", "info", "five")), (1, Finding("a", "warning", "four")), (0, Finding("z", "damage", "one")),
        (0, Finding("a", "warning", "three")), (1, Finding("c", "info", "six")), (0, Finding("a", "damage", "zero")),
    ]  # fmt: skip
    sentences = findings_section(Tables(findings=rows)).sentences
    words = [text.split(": ")[2].split(" ")[0] for _, text in sentences]
    assert words == [
        "zero",
        "one",
        "three",
        "four",
        "five",
        "six",
    ]
    assert sentences[0] == ("damage", "damage: one: zero [a]")
    assert sentences[3] == ("warning", "warning: two: four [a]")
    many = [(0, Finding("a", "info", "x"))] * 60
    assert len(findings_section(Tables(findings=many)).sentences) == 60
    more = findings_section(Tables(findings=[*many, *many[:2]])).sentences
    assert (len(more), more[60]) == (61, ("", "… and 2 more: tactiledata info --json"))
    assert findings_section(Tables()).sentences == [("", "The checks found nothing.")]


def test_without_a_split_the_one_that_can_be_drawn_is_named(monkeypatch):
    """The page names the split that can be drawn, or why none can be."""
    monkeypatch.setattr(module, "suggest_split", lambda store: Suggestion("split it"))
    found = module._split(Tables(), "default")
    assert (list(found.code), len(found.sentences)) == (["split it"], 1)
    monkeypatch.setattr(module, "suggest_split", lambda store: Suggestion(reason="too few"))
    found = module._split(Tables(), "default")
    assert list(found.code) == []
    assert [text for _, text in found.sentences] == [
        "There is no split yet. Draw one before you train on this store.", "No split can be drawn yet: too few",
    ]  # fmt: skip


def findings_section(store):
    return module._findings(store, module.all_findings(store))


def counts(**given):
    return {
        part: {"trajectories": given.get(part, 0), "frames": 10 * given.get(part, 0)}
        for part in (*PARTITIONS, "excluded")
    }


def described(monkeypatch, held_out, problem="", force=(1.0, 13.0)):
    document = {"counts": counts(train=3), "held_out": held_out, "options": {"a": 1}}
    monkeypatch.setattr(module, "read_split_document", lambda store, name: document)
    monkeypatch.setattr(module, "read_split", lambda store, name: SimpleNamespace(force=force))
    monkeypatch.setattr(
        module, "parts_without", lambda store, split: [Finding("split-empty-part", "warning", "no val")]
    )
    monkeypatch.setattr(module, "coverage_problem", lambda split, uids: problem)
    monkeypatch.setattr(module, "flagged_in_parts", lambda store, split: [])
    monkeypatch.setattr(module, "command", lambda location, name, options: f"draw {location} {name} {options}")
    return module._split(Tables(splits=("mine",), touches=[touch()]), "mine")


def test_a_split_is_described(monkeypatch):
    """A split is described by its parts and what is held out, and nothing more where it knows all trajectories."""
    found = described(monkeypatch, {"sensor": ["D1", "D2"], "indenter": []})
    assert found.rows[0] == ("train", 3, 30)
    assert [part for part, _, _ in found.rows] == [*PARTITIONS, "excluded"]
    assert [text for _, text in found.sentences] == [
        "The split 'mine' divides whole trajectories. Held out for test_unseen: sensor D1, D2.",
        "It takes whole images with a contact force of 1 to 13 N: its parts hold 30 of 57.",
        "no val.",
    ]
    assert found.code == []
    nothing = described(monkeypatch, {"sensor": []})
    assert nothing.sentences[0][1].endswith("for test_unseen: nothing.")
    unfiltered = described(monkeypatch, {}, force=None)
    assert unfiltered.sentences[1] == ("info", "It takes whole images: its parts hold 30 of 57.")


def test_a_split_that_is_out_of_date_is_drawn_again(monkeypatch):
    """The page names the command that draws a split anew which is out of date."""
    found = described(monkeypatch, {}, "1 new")
    assert found.sentences[3] == (
        "warning",
        "The split is out of date: 1 new. Draw it again; until then it cannot be loaded.",
    )
    assert found.code == ["draw my.zarr mine {'a': 1}"]


def test_the_page_is_written_with_its_picture(monkeypatch, tmp_path):
    """The page is written with its picture if there is a touch to be shown, and alone if there is none."""
    monkeypatch.setattr(module, "page", lambda store, picture, split, further: f"{picture} {split}")
    monkeypatch.setattr(module, "draw", lambda touches: ("figure", "caption"))
    monkeypatch.setattr(module, "panels_of", lambda figure, caption: f"{figure} with {caption}")
    monkeypatch.setattr(module, "png_bytes", lambda figure, heading, has_legend: b"png" * has_legend)
    monkeypatch.setattr(module, "simulated_recordings", lambda store: SimulatedCount())
    monkeypatch.setattr(module, "choose_touches", lambda store: [1])
    found = write_report(Tables(), tmp_path)
    assert found == {"page": tmp_path / "report.html", "picture": tmp_path / "recorded.png"}
    assert found["page"].read_text() == "figure with caption default"
    assert found["picture"].read_bytes() == b"png"
    monkeypatch.setattr(module, "choose_touches", lambda store: [])
    assert write_report(Tables(), tmp_path, "mine") == {"page": tmp_path / "report.html"}
    assert (tmp_path / "report.html").read_text() == "None mine"


FINITE, UNKNOWN = np.ones((2, 1)), np.full((2, 1), np.nan)


def streams(monkeypatch, cameras, aligned, frame_values=()):
    """The streams that a first program loads."""
    monkeypatch.setattr(program_module, "read_split_document", lambda store, name: {"counts": counts(val=1)})
    table = frames(len(cameras), camera=list(cameras))
    text = first_program(Tables(table, aligned=aligned, frame_values=frame_values, splits=("s",)), "s")
    assert text.splitlines()[3].startswith('val = TactileDataset("my.zarr", split="s/val", streams=')
    return json.loads(text.partition("streams=")[2].partition(")")[0])


def test_the_first_program_takes_the_most_filmed_camera_and_the_most_wanted_values(monkeypatch):
    """The program takes the most filmed camera and the most wanted values that are known, else values of images."""
    both = {"tcp": FINITE, "contact_wrench": FINITE}
    assert streams(monkeypatch, ["a", "b", "b"], both) == ["b", "contact_wrench"]
    assert streams(monkeypatch, ["a", "a", "b"], {"other": FINITE, "joints": FINITE}) == ["a", "joints"]
    assert streams(monkeypatch, ["a"], {"tcp": FINITE, "contact_wrench": UNKNOWN}) == ["a", "tcp"]
    assert streams(monkeypatch, ["a"], {"other": np.array([[np.nan, 1.0]])}) == ["a", "other"]
    assert streams(monkeypatch, ["a"], {"tcp": UNKNOWN}, ("truth", "more")) == ["a", "truth"]
    assert streams(monkeypatch, ["a"], {}) == ["a"]


def test_without_a_split_the_first_program_draws_on_what_would_be_drawn(monkeypatch):
    """The first part that has frames; where none can be drawn, a table is shown."""
    table = frames(1, camera=["a"])
    totals = {part: type("Counts", (), {"frames": int(part == "test")}) for part in PARTITIONS}
    report = type("Report", (), {"counts": totals})
    monkeypatch.setattr(program_module, "suggest_split", lambda store: Suggestion("split", report))
    assert 'split="s/test"' in first_program(Tables(table), "s")
    monkeypatch.setattr(program_module, "suggest_split", lambda store: Suggestion(reason="too few"))
    assert first_program(Tables(table), "s").splitlines()[-1] == "print(store.trajectories().to_pandas())"
    empty = {"counts": counts()}
    monkeypatch.setattr(program_module, "read_split_document", lambda store, name: empty)
    assert "TactileDataset" not in first_program(Tables(table, splits=("s",)), "s")


def test_names_outside_of_ascii_stay_as_they_are(monkeypatch):
    """Names outside of ASCII stay as they are in the text of a program."""
    assert streams(monkeypatch, ["fühler"], {}) == ["fühler"]
    text = first_program(Tables(frames(1, camera=["fühler"]), aligned={}, splits=("s",)), "s")
    assert "fühler" in text
