"""Layout of the viewer: which panes a trajectory has, and how they are arranged on the screen."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from tactiledata.view.about import ABOUT
from tactiledata.view.curves import FORCE, OTHERS, POSE, RESIDUAL, TORQUE
from tactiledata.view.gel import INDENTER, SURFACE
from tactiledata.view.pictures import BACKGROUND, CONTACT, DIFFERENCE, PICTURES, camera_entity
from tactiledata.view.rerun_package import load_rerun
from tactiledata.view.touch_log import TRAJECTORY_TIME

EYE, LOOK_AT = (0.0, -0.030, 0.022), (0.0, 0.0, -0.002)
"""Where one looks at the gel from, and to, in metres of the gel frame: along its long side, from above."""


def panes(cameras: Collection[str], curves: Collection[str], with_gel: bool) -> Any:
    """The blueprint: pictures above, curves below, the gel and the words at the right.

    Parameters
    ----------
    cameras : collection of str
        Cameras of the trajectories that are shown.
    curves : collection of str
        Entities that have curves.
    with_gel : bool
        Whether any trajectory has a mesh.
    """
    import rerun.blueprint as rrb

    load_rerun()
    rows = [rrb.Horizontal(*_pictures(camera), name=camera) for camera in sorted(cameras)]
    above = [rrb.Tabs(*rows) if len(rows) > 1 else rows[0]] if rows else []
    plots = _plots(curves)
    left = [*above, *([rrb.Horizontal(*plots)] if plots else [])]
    words = rrb.TextDocumentView(origin=ABOUT, name="about")
    right = rrb.Vertical(_gel(), words, row_shares=[3, 2]) if with_gel else rrb.Vertical(words)
    sides = [rrb.Vertical(*left), right] if left else [right]
    return _blueprint(rrb.Horizontal(*sides, column_shares=[2, 1] if left else None))


def stacked_panes(cameras: Collection[str], curves: Collection[str], with_gel: bool) -> Any:
    """The blueprint for a narrow screen: tabs of pictures above, tabs of curves below them, then the gel and the words.

    Every pane is as wide as the screen.

    Parameters
    ----------
    cameras : collection of str
        Cameras of the trajectories that are shown.
    curves : collection of str
        Entities that have curves.
    with_gel : bool
        Whether any trajectory has a mesh.
    """
    import rerun.blueprint as rrb

    load_rerun()
    several = len(cameras) > 1
    pictures = [view for camera in sorted(cameras) for view in _picture_views(camera, camera if several else "")]
    last = [*([_gel()] if with_gel else []), rrb.TextDocumentView(origin=ABOUT, name="about")]
    rows = [views for views in (pictures, list(_plot_views(curves).values()), last) if views]
    return _blueprint(rrb.Vertical(*[rrb.Tabs(*views) if len(views) > 1 else views[0] for views in rows]))


def _blueprint(arranged: Any) -> Any:
    """The panes with the panels of the viewer beside them, which are folded away."""
    import rerun.blueprint as rrb

    return rrb.Blueprint(
        arranged,
        rrb.TimePanel(timeline=TRAJECTORY_TIME, state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
    )


def _pictures(camera: str) -> list[Any]:
    import rerun.blueprint as rrb

    picture, difference, mask, without = _picture_views(camera)
    return [rrb.Tabs(picture, without), difference, mask]


def _picture_views(camera: str, prefix: str = "") -> list[Any]:
    """Views of the picture, the difference, the contact mask and the sensor without contact."""
    import rerun.blueprint as rrb

    entity = camera_entity(camera)
    shown = {
        "picture": [PICTURES],
        "difference ×2, grey is none": [DIFFERENCE],
        "contact mask": [PICTURES, CONTACT],
        "without contact": [BACKGROUND],
    }
    return [
        rrb.Spatial2DView(
            origin=entity, contents=[f"{entity}/{part}" for part in parts], name=f"{prefix} {name}".strip()
        )
        for name, parts in shown.items()
    ]


def _plot_views(curves: Collection[str]) -> dict[str, Any]:
    """Views of the curves that there are, by entity."""
    import rerun.blueprint as rrb

    names = {
        FORCE: "force, N",
        TORQUE: "torque, N m",
        RESIDUAL: "residual, N",
        POSE: "moved, mm",
        OTHERS: "other signals",
    }
    legend = rrb.Corner2D.LeftTop
    return {
        name: rrb.TimeSeriesView(origin=name, name=title, plot_legend=legend)
        for name, title in names.items()
        if name in curves
    }


def _plots(curves: Collection[str]) -> list[Any]:
    import rerun.blueprint as rrb

    view = _plot_views(curves)
    forces = [view[name] for name in (FORCE, TORQUE) if name in view]
    poses = [view[name] for name in (POSE, OTHERS) if name in view]
    groups = [forces, [view[RESIDUAL]] if RESIDUAL in view else [], poses]
    return [rrb.Tabs(*group) if len(group) > 1 else group[0] for group in groups if group]


def _gel() -> Any:
    import rerun.blueprint as rrb

    return rrb.Spatial3DView(
        origin="gel",
        contents=[f"/{SURFACE}", "/gel/pressed", f"/{INDENTER}"],
        name="gel, simulated",
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=EYE, look_target=LOOK_AT, eye_up=(0.0, 0.0, 1.0)),
    )
