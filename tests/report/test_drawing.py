"""Figures with texts in any script and forces of any size are drawn without a word of matplotlib or NumPy."""

import warnings

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager

from tactiledata.report.drawing import drawing
from tactiledata.report.panels import panels_of
from tactiledata.report.plots import TouchPicture, draw_touches, png_bytes

SECONDS = np.linspace(0.0, 1.0, 6)
PICTURE = np.full((8, 6, 3), 90, np.uint8)
SCRIPTS = "\u4f20\u611f\u5668, \u7403"


def touches(title="t", scale=1.0):
    force = np.stack([SECONDS, -SECONDS, SECONDS], axis=1) * scale
    return draw_touches([TouchPicture(title, PICTURE, PICTURE, SECONDS, force, "gel", SECONDS, 0.4)])


@pytest.mark.parametrize("draw", [lambda figure: panels_of(figure, "c"), png_bytes], ids=["panels", "file"])
@pytest.mark.parametrize(
    "given", [{"title": SCRIPTS}, {"title": "a$b_{c$"}, {"scale": 1e308}], ids=["scripts", "dollars", "large"]
)
def test_what_recordings_hold_is_drawn_without_warnings(given, draw):
    """A name in Chinese, one with dollar signs, and forces near the largest float: no warning reaches the user."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert draw(touches(**given))


def test_other_warnings_still_come():
    """Only that of missing signs is taken: everything else in a drawing is heard."""
    with pytest.warns(UserWarning, match="of another kind"), drawing(Figure()):
        warnings.warn("of another kind", UserWarning, stacklevel=1)


def test_fonts_of_the_machine_are_asked_for_other_scripts(monkeypatch):
    """Those that are there follow a text's own font once; where there are none, texts stay as they are."""
    figure = Figure()
    text = figure.text(0, 0, SCRIPTS)
    own = text.get_fontfamily()
    for names, more in (
        (["Some Font"], []),
        (["SimHei", "Some Font", "Noto Sans CJK SC"], ["Noto Sans CJK SC", "SimHei"]),
    ):
        monkeypatch.setattr(type(fontManager), "get_font_names", lambda _, known=names: known)
        for _ in range(2):
            with drawing(figure):
                pass
            assert text.get_fontfamily() == [*own, *more]


@pytest.mark.parametrize("scale", [1.0, np.nan], ids=["forces", "no forces"])
def test_long_names_stay_in_the_picture(scale):
    """A name of any length is broken into lines; nothing is cut off at the right, and the mark at its end is there."""
    figure = touches("D20001, sphere, " + "session_03_robot_left/" * 6 + ", simulated recording", scale)
    figure.draw_without_rendering()
    named = [
        text for axes in figure.axes for text in (axes.xaxis.label, axes._left_title) if "D20001" in text.get_text()
    ]
    (text,) = named
    assert text.get_text().endswith("simulated recording")
    assert text.get_window_extent().x1 <= figure.bbox.x1
