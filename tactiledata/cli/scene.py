"""`scene`: arm, sensor and indenter at one frame, as a picture or as MJCF."""

from __future__ import annotations

from pathlib import Path

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, say
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.errors import UsageError


def register(app: typer.Typer) -> None:
    """Add this module's command."""
    app.command("scene")(scene)


def scene(
    store: str = STORE_ARGUMENT,
    trajectory: str = typer.Option(..., "--trajectory", help="Name or uid."),
    frame: int = typer.Option(0, "--frame", help="Counted from 0 within the trajectory."),
    out: Path = typer.Option(Path("scene.png"), "--out", help="A picture (.png), or the scene for MuJoCo (.xml)."),
    indenters: Path = typer.Option(None, "--indenters", help="Folder of the mesh files that recordings name."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Arm, sensor and indenter at one frame. Joints and poses are held against each other; exit 1 where they disagree.

    Example: tactiledata scene ds.zarr --trajectory t00000 --frame 8 --out touch.png
    """
    from tactiledata.replay.frame_scene import frame_scene
    from tactiledata.store.read.reader import Store

    kind = out.suffix.lower()
    if kind not in (".png", ".xml"):
        raise UsageError(f"--out {out}", "a name that ends in .png or .xml", "")
    location = working_store(store)
    with damage_explains(location):
        found = frame_scene(Store.open(location), trajectory, frame, indenters)
    out.parent.mkdir(parents=True, exist_ok=True)
    if kind == ".xml":
        out.write_text(found.scene.mjcf, encoding="utf-8")
    else:
        _write_picture(out, found.scene.picture())
    facts = found.facts()
    if as_json:
        emit({"out": str(out), **facts})
    else:
        say(f"pose of the sensor from: {found.pose_from}")
        x, y, z = (1e3 * value for value in facts["indenter_tip_in_gel_m"])
        say(f"indenter's tip in the gel frame: {x:.2f} {y:.2f} {z:.2f} mm")
        say(f"least distance of gel and indenter, convex hulls: {1e3 * facts['distance_m']:.2f} mm")
        if found.check is not None:
            word = "agree" if found.agrees else "DISAGREE"
            say(
                f"joints and poses {word}: {1e3 * found.check.position_off:.2f} mm, "
                f"{1e3 * found.check.rotation_off:.2f} mrad rms over {found.check.samples} frames"
            )
        say(str(out))
    if not found.agrees:
        raise typer.Exit(1)


def _write_picture(path: Path, picture: object) -> None:
    import cv2
    import numpy as np

    written, content = cv2.imencode(".png", np.asarray(picture)[:, :, ::-1])
    if not written:
        raise UsageError(f"{path} cannot be written as PNG")
    path.write_bytes(content.tobytes())
