"""What is simulated says so on every page, in every table and every document, and nothing else ever does."""

from pathlib import Path

import pytest
import yaml
from copied_trees import copy_tree
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract.simulated import SimulatedCount, recording_kind
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.overview import page, touch_picture
from tactiledata.replay.overview import mesh_sections
from tactiledata.report.page import Panel, Picture
from tactiledata.store.change.merge import merge
from tactiledata.store.read.overview import overview
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_recordings, simulated_sensors, simulated_trajectories
from tactiledata.store.write.card import card

TERM = "simulated recordings"


def restated(folder, place, contact):
    """A copy of a folder log of which the description states another thing of its contacts, or nothing."""
    copy = copy_tree(folder, place)
    document = yaml.safe_load((copy / "log.yaml").read_text())
    if contact is None:
        del document["recorded_by"]
    else:
        document["recorded_by"]["contact"] = contact
    (copy / "log.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    return copy


@pytest.fixture(scope="module")
def mixed(tiny_folders, tmp_path_factory):
    """A store that was merged of one simulated recording and of one that does not state it."""
    place = tmp_path_factory.mktemp("mixed")
    first, second = tiny_folders
    ingest([first], place / "a.zarr")
    ingest([restated(second, place / second.name, None)], place / "b.zarr")
    merge([place / "a.zarr", place / "b.zarr"], place / "ds.zarr")
    return place / "ds.zarr"


def texts(location):
    """Card, report page with a picture, and sections of meshes of a store, in lower case."""
    store = Store.open(location)
    return {
        "card": card(Path(location), store.manifest).lower(),
        "README.md": (Path(location) / "README.md").read_text().lower(),
        "report": page(store, Picture(((Panel(b"png", 9),),), "Touches."), "default", mesh_sections(store)).lower(),
    }


def test_a_rigs_world_says_it_everywhere(tiny_store):
    """Card, page, its title and its caption; MCAP logs, all of which are simulated."""
    for name, text in texts(tiny_store).items():
        assert f"{TERM}: all 2 recordings." in text, name
    report = texts(tiny_store)["report"]
    assert f"<h1>what was recorded ({TERM})</h1>" in report
    assert report.split("<figcaption>")[1].split("</figcaption>")[0].endswith(f"{TERM}.")
    assert overview(Store.open(tiny_store))["simulated_recordings"] == {"simulated": 2, "real": 0, "not_stated": 0}


@pytest.mark.slow
def test_a_log_that_does_not_state_it_never_says_it(unstated):
    """Neither simulated nor real: the counts say that it is not stated, and no text has a word of it."""
    for name, text in texts(unstated).items():
        assert "simulated" not in text, name
        assert "real recording" not in text, name
    assert simulated_recordings(Store.open(unstated)) == SimulatedCount(0, 0, 2)


@pytest.mark.slow
def test_a_mixed_store_says_how_many(mixed, tiny_folders):
    """Merging keeps what each recording states; pictures of touches are told apart."""
    store = Store.open(mixed)
    for name, text in texts(mixed).items():
        assert f"{TERM}: 1 of 2 recordings; 1 does not state it." in text, name
    assert simulated_recordings(store).label == f"{TERM}: 1 of 2"
    uids, sources = (store.trajectories([name])[name].to_pylist() for name in ("uid", "source"))
    for uid, source in zip(uids, sources, strict=True):
        assert simulated_trajectories(store, [uid]).simulated == (source == 0)
    for row, source in enumerate(sources):
        assert ("simulated recording" in touch_picture(store, row).title) == (source == 0)
    sensors = store.trajectories(["sensor"])["sensor"].to_pylist()
    assert simulated_sensors(store) == sorted({s for s, source in zip(sensors, sources, strict=True) if source == 0})


@pytest.mark.slow
def test_an_ingest_says_it(tiny_folders, tmp_path):
    """Each recording and the counts of what came in; of what was there already nothing is counted."""
    real = restated(tiny_folders[1], tmp_path / "real", "Real")
    report = ingest([tiny_folders[0], real], tmp_path / "ds.zarr")
    assert sorted(source.kind for source in report.sources) == ["real", "simulated"]
    assert report.document()["simulated_recordings"] == {"simulated": 1, "real": 1, "not_stated": 0}
    again = ingest([tiny_folders[0]], tmp_path / "ds.zarr")
    assert again.simulated == SimulatedCount()


@given(st.integers(0, 9), st.integers(0, 9), st.integers(0, 9))
def test_words_say_it_where_anything_is_simulated_and_only_there(simulated, real, not_stated):
    """Title, caption and sentence change exactly where something is simulated, and no number is lost."""
    count = SimulatedCount(simulated, real, not_stated)
    said = [count.titled("T"), count.captioned("C."), count.sentence]
    assert [TERM in words.lower() for words in said] == [simulated > 0] * 3
    if not simulated:
        assert said == ["T", "C.", ""]
    elif real or not_stated:
        assert f"{simulated} of {count.total}" in count.titled("T")
        assert (f"{real} is real" in count.sentence or f"{real} are real" in count.sentence) == (real > 0)


@pytest.mark.parametrize(
    ("description", "kind"),
    [
        ({}, "not stated"),
        ({"recorded_by": "simulated"}, "not stated"),
        ({"recorded_by": {"contact": None}}, "not stated"),
        ({"recorded_by": {"contact": "not simulated"}}, "not stated"),
        ({"recorded_by": {"contact": " Simulated"}}, "simulated"),
        ({"recorded_by": {"contact": "REAL"}}, "real"),
    ],
)
def test_only_the_two_words_state_something(description, kind):
    """Any other text under contact, such as a person's address, states nothing."""
    assert recording_kind(description) == kind
