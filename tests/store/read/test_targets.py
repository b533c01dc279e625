"""Names of target sensors: the store's own, an imported YCB-Slide, bundled pictures, and near names for the rest."""

import cv2
import numpy as np
import pytest
from copied_trees import copy_tree
from generators import ycb_slide

from tactiledata.errors import UnknownName
from tactiledata.ingest.pipeline import ingest
from tactiledata.sensors.backgrounds import load_background
from tactiledata.store.change.add_sensor import add_sensor
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import find_target


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """A store of a small fake of YCB-Slide with the unit of the sugar box (0), not that of the mug (4)."""
    folder = tmp_path_factory.mktemp("corpus")
    root = ycb_slide.write(folder, np.random.default_rng(0), runs=1, sim=False, objects=("004_sugar_box",))
    ingest([root], folder / "ycb.zarr")
    return folder / "ycb.zarr"


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_sensor_of_the_store_is_itself(tiny_store, elsewhere):
    """A serial of the store stands for its own picture, and the words say where that is from."""
    store = Store.open(tiny_store)
    serial, reference = next(iter(store.references().items()))
    target = find_target(serial, store)
    np.testing.assert_array_equal(target.background, reference.image)
    assert serial in target.resolved
    assert reference.origin in target.resolved


def test_without_the_corpus_bundled_pictures_stand_in(tiny_store, elsewhere):
    """The aliases are bundled pictures with licence and attribution, and the words say so."""
    for alias in ("ycb-sensorA", "ycb-sensorB"):
        target = find_target(alias, Store.open(tiny_store))
        np.testing.assert_array_equal(target.background, load_background(alias))
        assert "comes with the toolkit" in target.resolved
        assert target.licence == "MIT"
        assert "Sudharshan Suresh" in target.attribution


@pytest.mark.slow
def test_an_imported_corpus_beside_the_store_is_taken(tiny_store, corpus, elsewhere):
    """With YCB-Slide in the working folder, A is its unit 0; its unit 4 was not imported, so B stays bundled."""
    copy_tree(corpus, elsewhere / "ycb.zarr")
    (elsewhere / "broken.zarr").mkdir()
    store = Store.open(tiny_store)
    target = find_target("ycb-sensorA", store)
    assert target.name == "ycb-slide-bg0"
    assert "ycb-slide-bg0" in target.resolved
    assert "ycb.zarr" in target.resolved
    assert "median of 12" in target.resolved
    taken = Store.open(corpus)
    rows = [row for row, name in enumerate(taken.frames(["camera"])["camera"].to_pylist()) if name == "digit"]
    expected = np.rint(np.median([np.asarray(image) for image in taken.images(rows)], axis=0))
    np.testing.assert_array_equal(target.background, expected)
    assert "comes with the toolkit" in find_target("ycb-sensorB", store).resolved


def test_an_imported_unit_with_a_picture_of_its_own(corpus, elsewhere):
    """A picture that was added to the corpus's unit goes before the median of its frames."""
    own = elsewhere / "own.zarr"
    copy_tree(corpus, own)
    cv2.imwrite(str(elsewhere / "empty.png"), np.full((32, 24, 3), 90, np.uint8))
    add_sensor(own, "ycb-slide-bg0", elsewhere / "empty.png", licence="CC0", source="my desk")
    target = find_target("ycb-sensorA", Store.open(own))
    assert (target.background == 90).all()
    assert "from my desk" in target.resolved
    assert target.licence == "CC0"


def test_unknown_sensor_lists_near_names(tiny_store, elsewhere):
    """A slip of the pen is answered with the near names, and how to add a sensor."""
    with pytest.raises(UnknownName, match=r"Did you mean .*ycb-sensorA.*sensors add"):
        find_target("ycb-sensora", Store.open(tiny_store))
