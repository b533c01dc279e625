"""The bundled pictures of untouched sensors."""

import numpy as np
import pytest

from tactiledata.errors import UnknownName
from tactiledata.sensors.backgrounds import ALIASES, bundled_backgrounds, load_background, resolve_background


def test_there_are_eighteen_different_ones():
    """There are eighteen pictures of eighteen units, none within 5 grey levels of another on average."""
    images = [load_background(name) for name in bundled_backgrounds()]
    assert len(images) == 18
    assert {image.shape for image in images} == {(320, 240, 3)}
    small = np.array([image[::8, ::8].astype(float) for image in images])
    gaps = np.abs(small[:, None] - small[None]).mean(axis=(2, 3, 4)) + 255 * np.eye(18)
    assert gaps.min() > 5


def test_pictures_are_rgb():
    """Red is the channel that leads on the left, as LEDs of a DIGIT lie."""
    left = np.mean([load_background(name)[80:200, :60].mean(axis=(0, 1)) for name in bundled_backgrounds()], axis=0)
    assert left[0] == left.max()
    assert left[0] > left[2] + 20


def test_licence_and_notice_travel_along():
    """The folder of the pictures holds their licence and says where they come from."""
    for info in bundled_backgrounds().values():
        assert info.path.is_file()
        assert "suddhu/tacto" in info.source
    folder = resolve_background("digit-bg-0").path.parent
    assert "MIT License" in (folder / "LICENSE").read_text()
    assert "suddhu/tacto" in (folder / "NOTICE.md").read_text()


def test_aliases_say_which_picture_they_are():
    """The two target sensors of the paper stand for two different bundled pictures."""
    assert {resolve_background(alias).name for alias in ALIASES} == {"digit-bg-0", "digit-bg-1"}
    np.testing.assert_array_equal(load_background("ycb-sensorA"), load_background("digit-bg-0"))


def test_unknown_background_lists_near_names():
    """A misspelt name is told the nearest ones."""
    with pytest.raises(UnknownName, match="ycb-sensorA"):
        resolve_background("ycb-sensora")


def test_loaded_picture_is_the_callers():
    """Changing a loaded picture changes nobody else's."""
    first = load_background("digit-bg-3")
    first[:] = 0
    assert load_background("digit-bg-3").any()
