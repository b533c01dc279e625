"""`scene`: draw arm, sensor and indenter at one frame, as a picture or as MJCF."""

from __future__ import annotations

from pathlib import Path

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import INDENTERS, need_folder, need_writable_folder
from tactiledata.cli.output import JSON_OPTION, emit, say
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.own_files import marked_png
from tactiledata.errors import UsageError


def register(app: typer.Typer) -> None:
    """Add the command `scene` to the application."""
    app.command("scene")(scene)


def scene(
    store: str = STORE_ARGUMENT,
    trajectory: str = typer.Option(..., "--trajectory", help="Name or uid of the trajectory."),
    frame: int = typer.Option(0, "--frame", help="Number of the frame within the trajectory, from 0."),
    out: Path = typer.Option(
        Path("scene.png"), "--out", help="File to write: a picture (.png), or the scene for MuJoCo (.xml)."
    ),
    indenters: Path = typer.Option(None, "--indenters", help="Folder of the mesh files that recordings name."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Draw arm, sensor and indenter at one frame.

    Recorded joints and poses are compared; the exit code is 1 where they disagree.

    Example: tactiledata scene ds.zarr --trajectory t00000 --frame 8 --out touch.png
    """
    from tactiledata.replay.frame_scene import frame_scene
    from tactiledata.store.read.reader import Store

    kind = out.suffix.lower()
    if kind not in (".png", ".xml"):
        raise UsageError(f"--out {out}", "a file name that ends in .png or .xml", "")
    need_writable_folder(out.parent, out.name)
    location = working_store(store)
    with damage_explains(location):
        shown = frame_scene(Store.open(location), trajectory, frame, need_folder(indenters, "--indenters", INDENTERS))
    write_atomic(out, shown.scene.mjcf.encode() if kind == ".xml" else _png(shown.scene.picture()))
    facts = shown.facts()
    if as_json:
        emit({"out": str(out), **facts})
    else:
        say(f"pose of the sensor from: {shown.pose_from}")
        x, y, z = (1e3 * value for value in facts["indenter_tip_in_gel_m"])
        say(f"indenter's tip in the gel frame: {x:.2f} {y:.2f} {z:.2f} mm")
        say(f"least distance of gel and indenter, convex hulls: {1e3 * facts['distance_m']:.2f} mm")
        if shown.check is not None:
            word = "agree" if shown.agrees else "DISAGREE"
            say(
                f"joints and poses {word}: {1e3 * shown.check.position_off:.2f} mm, "
                f"{1e3 * shown.check.rotation_off:.2f} mrad rms over {shown.check.samples} frames"
            )
        say(str(out))
    if not shown.agrees:
        raise typer.Exit(1)


def _png(picture: object) -> bytes:
    """Return a picture (h, w, 3), RGB, as a PNG."""
    import cv2
    import numpy as np

    return marked_png(cv2.imencode(".png", np.asarray(picture)[:, :, ::-1])[1].tobytes())
