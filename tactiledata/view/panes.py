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
    return rrb.Blueprint(
        rrb.Horizontal(*sides, column_shares=[2, 1] if left else None),
        rrb.TimePanel(timeline=TRAJECTORY_TIME, state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
    )


def _pictures(camera: str) -> list[Any]:
    import rerun.blueprint as rrb

    entity = camera_entity(camera)
    views = [
        rrb.Spatial2DView(origin=entity, contents=[f"{entity}/{PICTURES}"], name="picture"),
        rrb.Spatial2DView(origin=entity, contents=[f"{entity}/{DIFFERENCE}"], name="difference ×2, grey is none"),
        rrb.Spatial2DView(origin=entity, contents=[f"{entity}/{PICTURES}", f"{entity}/{CONTACT}"], name="contact mask"),
    ]
    without = rrb.Spatial2DView(origin=entity, contents=[f"{entity}/{BACKGROUND}"], name="without contact")
    return [rrb.Tabs(views[0], without), *views[1:]]


def _plots(curves: Collection[str]) -> list[Any]:
    import rerun.blueprint as rrb

    names = {
        FORCE: "force, N",
        TORQUE: "torque, N m",
        RESIDUAL: "residual, N",
        POSE: "moved, mm",
        OTHERS: "other signals",
    }
    legend = rrb.Corner2D.LeftTop
    view = {
        name: rrb.TimeSeriesView(origin=name, name=title, plot_legend=legend)
        for name, title in names.items()
        if name in curves
    }
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
