"""Layouts of the viewer: what each shows, and how wide a pane is."""

import pytest

pytest.importorskip("rerun")

import rerun.blueprint as rrb
from command import run_command
from viewed_store import read_view

from tactiledata.view.curves import FORCE, OTHERS, POSE, RESIDUAL, TORQUE
from tactiledata.view.panes import panes, stacked_panes

CURVES = (FORCE, TORQUE, RESIDUAL, POSE, OTHERS)
CASES = [((), (), False), (("digit",), CURVES, True), (("left", "right"), (FORCE,), False), ((), (POSE,), True)]


def views(container):
    """The views below a container with what each shows, by kind, place and content."""
    for part in container.contents:
        if isinstance(part, rrb.Container):
            yield from views(part)
        else:
            yield part.class_identifier, part.origin, tuple(part.contents)


def containers(container):
    """A container and all below it."""
    yield container
    for part in container.contents:
        if isinstance(part, rrb.Container):
            yield from containers(part)


@pytest.mark.parametrize(("cameras", "curves", "with_gel"), CASES)
def test_the_narrow_layout_shows_the_same_panes(cameras, curves, with_gel):
    """No pane is lost or shown twice where panes are stacked."""
    wide, narrow = (make(cameras, curves, with_gel).root_container for make in (panes, stacked_panes))
    assert sorted(views(narrow)) == sorted(views(wide))


@pytest.mark.parametrize(("cameras", "curves", "with_gel"), CASES)
def test_no_pane_of_the_narrow_layout_stands_beside_another(cameras, curves, with_gel):
    """Every pane is as wide as the screen: there are tabs in at most three rows, and no columns."""
    rows, *tabs = containers(stacked_panes(cameras, curves, with_gel).root_container)
    assert isinstance(rows, rrb.Vertical)
    assert all(isinstance(part, rrb.Tabs) for part in tabs)
    assert 1 <= len(rows.contents) <= 3


def test_the_wide_layout_has_columns():
    """The other layout puts panes beside one another, so that the law of the narrow one can fail."""
    assert any(isinstance(part, rrb.Horizontal) for part in containers(panes(("digit",), CURVES, True).root_container))


def test_tabs_of_several_cameras_are_told_apart():
    """With several cameras the name of each tab begins with that of its camera."""
    first = stacked_panes(("left", "right"), (), False).root_container.contents[0]
    names = [view.name for view in first.contents]
    assert len(set(names)) == len(names) == 8
    assert {name.split()[0] for name in names} == {"left", "right"}


@pytest.mark.slow
def test_the_command_writes_the_narrow_layout(tiny_store, tmp_path, capsys):
    """`view --narrow` writes another layout and the same recordings."""
    for name, options in (("wide", ()), ("narrow", ("--narrow",))):
        code, _, _ = run_command(
            capsys, "view", tiny_store, "--most", "1", "--no-open", "--out", tmp_path / f"{name}.rrd", *options
        )
        assert code == 0
    (wide, layouts), (narrow, others) = (read_view(tmp_path / f"{name}.rrd") for name in ("wide", "narrow"))
    assert layouts == others == 1
    assert wide.keys() == narrow.keys()
