"""One legend in all pictures: measured values are dots, simulated values are lines, and nothing else is a dot."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

import cv2

from tactiledata.report import calibration_plots, diagnosis_plots, naming_plots, replay_plots
from tactiledata.report.page import LegendEntry, Panel, Picture, Section, render_page
from tactiledata.report.panels import GREY, legend_of, panels_of
from tactiledata.report.plots import TouchPicture, draw_touches

SECONDS = np.linspace(0.0, 1.0, 6)
FORCE = np.stack([SECONDS, -SECONDS, 2 * SECONDS], axis=1)
PICTURE = np.full((8, 6, 3), 90, np.uint8)
EVENT = diagnosis_plots.EventPicture("onset", np.arange(6), FORCE, FORCE / 10, ("Fx", "Fy", "Fz"), "times the noise")
MAP = diagnosis_plots.MapPicture("E", "x, mm", "y, mm", "%", SECONDS, SECONDS, np.ones((6, 6)), np.eye(6, dtype=bool))
VERTICES = np.array([[0.0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0]])
FIGURES = {
    "recorded": lambda: draw_touches(
        [TouchPicture("t", PICTURE, PICTURE, SECONDS, FORCE, "gel", SECONDS, 0.4)] * 2
    ),
    "calibrated": lambda: calibration_plots.draw_overlays(
        [calibration_plots.Overlay("t", SECONDS, FORCE, FORCE)] * 5
    ),
    "residuals": lambda: calibration_plots.draw_residuals(FORCE[:, 2], FORCE / 9, ("Fx", "Fy", "Fz")),
    "losses": lambda: calibration_plots.draw_surfaces(
        [calibration_plots.LossSurface("t", "E", "nu", "N", SECONDS, SECONDS, np.outer(SECONDS, SECONDS), (0, 0), 0.5)]
    ),
    "replayed": lambda: replay_plots.draw_replayed(
        [replay_plots.ReplayedTouch("t", SECONDS, FORCE, SECONDS, FORCE, 0.4, VERTICES, VERTICES / 10,
                                    np.array([[0, 1, 2]]))]
    ),
    "trajectories": lambda: naming_plots.draw_overlays(
        [naming_plots.OverlayPicture("t", SECONDS, FORCE, {"plain": FORCE, "with the effect": FORCE})]
    ),
    "dependences": lambda: diagnosis_plots.draw_dependences(
        [diagnosis_plots.Dependence("E", "speed", False, SECONDS, SECONDS, SECONDS, SECONDS, SECONDS)]
    ),
    "events": lambda: naming_plots.draw_event_pairs([(EVENT, None)]),
    "map": lambda: naming_plots.draw_map_pair([MAP, MAP]),
    "evidence": lambda: naming_plots.draw_ladder(["a", "b"], [3.0, 9.0], [5.0, 5.0]),
    "moved": lambda: naming_plots.draw_movement([naming_plots.Moved("E", (1.0, 2.0, 3.0), (2.0, 3.0, 4.0))]),
    "held out": lambda: naming_plots.draw_held_out(
        [naming_plots.ErrorPanel("force, N", ["trajectories"], {"plain": [1.0], "black box": [2.0]}, [0.5])]
    ),
    "shares": lambda: diagnosis_plots.draw_shares(["a"], [0.5], [0.2]),
    "errors": lambda: diagnosis_plots.draw_errors(["a", "b"], [0.5, 0.1], "N"),
}  # fmt: skip
BOTH, MEASURED = ("calibrated", "replayed", "trajectories"), ("recorded",)


@pytest.mark.parametrize("name", FIGURES)
def test_measured_values_are_dots_and_simulated_values_are_lines(name):
    """What is called measured is dots that are not joined; what is called simulated is a line; no other is round."""
    called = {"measured": 0, "simulated": 0}
    for axis in FIGURES[name]().axes:
        for line in axis.get_lines():
            is_joined, mark = line.get_linestyle() not in ("None", "none", ""), line.get_marker()
            words = str(line.get_label())
            if "measured" in words:
                assert (mark, is_joined) == ("o", False), words
            elif "simulated" in words:
                assert (mark in ("", "None"), is_joined) == (True, True), words
            else:
                assert mark not in ("o", ".", ","), words
            for kind in called:
                called[kind] += kind in words
    assert [kind for kind, count in called.items() if count] == [
        *(["measured"] if name in (*BOTH, *MEASURED) else []), *(["simulated"] if name in BOTH else []),
    ]  # fmt: skip


@pytest.mark.slow
def test_panels_hold_all_that_is_drawn():
    """Five trajectories, four in a row: five panels as in the grid, each with words, and every drawn pixel in one."""
    figure = FIGURES["calibrated"]()
    before = [axis.patch.get_alpha() for axis in figure.axes]
    picture = panels_of(figure, "caption")
    assert [len(row) for row in picture.rows] == [4, 1]
    assert {panel.words for row in picture.rows for panel in row} == {"t: force, N over time, s"}
    assert [entry.mark for entry in picture.legend] == ["dot"] * 3 + ["line"] * 3
    assert picture.legend[0] == LegendEntry("Fx measured", "#c0392b", "dot")
    drawn = [cv2.imdecode(np.frombuffer(panel.png, np.uint8), cv2.IMREAD_UNCHANGED)[..., 3]
             for row in picture.rows for panel in row]  # fmt: skip
    whole = np.asarray(figure.canvas.buffer_rgba())[..., 3]
    assert sum((alpha > 0).sum() for alpha in drawn) == (whole > 0).sum() > 1000
    # the figure is as it was, and no panel is cut through what is drawn
    assert [axis.patch.get_alpha() for axis in figure.axes] == before
    for alpha in drawn[:3]:
        assert not alpha[:, -1].any()


@pytest.mark.slow
def test_photographs_keep_their_colours_on_a_dark_page():
    """The photographs of a touch are one opaque panel each, their words grey; nothing has a background."""
    figure = FIGURES["recorded"]()
    photographs, plot = panels_of(figure, "caption").rows[0]
    assert (photographs.is_photograph, plot.is_photograph) == (True, False)
    assert "difference" in photographs.words
    shown, drawn = (
        cv2.imdecode(np.frombuffer(panel.png, np.uint8), cv2.IMREAD_UNCHANGED) for panel in (photographs, plot)
    )
    assert (drawn[..., 3] == 0).mean() > 0.5
    assert (shown[..., 3] == 0).any()
    boxes = [axis.get_window_extent() for axis in figure.axes[:3]]
    area = sum(box.width * box.height for box in boxes)
    assert (shown[..., 3] == 255).sum() > 0.95 * area
    # whatever is drawn and not grey is part of a photograph
    coloured = (shown[..., 3] > 0) & (shown[..., :3] != GREY).any(axis=2)
    assert 0.5 * area < coloured.sum() < 1.05 * area
    beside = shown[(shown[..., 3] > 0) & ~coloured]
    assert len(beside) > 100


@pytest.mark.slow
def test_a_legend_says_how_a_mark_is_drawn():
    """Squares that are joined, dashes, boxes and ticks are told apart."""
    marks = {entry.words: entry.mark for name in FIGURES for entry in legend_of(FIGURES[name]().axes)}
    assert marks["simulated, plain"] == "dashes"
    assert marks["simulated, with the effect"] == "line"
    assert marks["scale and offset refitted"] == "joined squares"
    assert marks["share of all values"] == marks["image taken"] == "tick"
    assert marks["evidence"] == "box"
    assert marks["optimum"] == "cross"


def test_commands_in_sentences_are_set_as_code():
    """What stands between backticks is code; a lone backtick stays, and tags are escaped within and without."""
    page = render_page("title", ["`tactiledata diagnose` looks", "a ` and <b>", "`<script>`"], [], "footer")
    assert "<p><code>tactiledata diagnose</code> looks</p>" in page
    assert "<p>a ` and &lt;b&gt;</p>" in page
    assert "<p><code>&lt;script&gt;</code></p>" in page


@pytest.mark.parametrize(("width", "is_scrolled"), [(480, False), (571, False), (573, True), (900, True)])
def test_a_wide_drawing_is_scrolled_on_a_phone(width, is_scrolled):
    """Words are never drawn at less than 0.6 of their size: what is too wide for a phone is scrolled there."""
    panel = Panel(b"", round(width / 0.69), "shares")
    assert panel.width == width
    page = render_page("t", [], [Section("s", pictures=[Picture([[panel]], "c")])], "f")
    assert ('role="group" tabindex="0" aria-label="Picture: shares"' in page) == is_scrolled
    assert f"min-width: {round(0.6 * width)}px" * is_scrolled in page
    assert Panel(b"", 2000, "pictures", is_photograph=True).fits_phones


def test_counts_of_a_table_have_separators_as_on_the_terminal():
    """Thousands are parted, and other numbers stand as they are."""
    page = render_page("t", [], [Section("s", columns=("a", "b"), rows=[(10857, 0.25), (True, "1000")])], "f")
    assert '<td class="number">10,857</td><td class="number">0.25</td>' in page
    assert "<td>1000</td>" in page
