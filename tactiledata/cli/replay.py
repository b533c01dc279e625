"""`replay`: a mesh for every frame of a store."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.documents import calibration_document, effects_document
from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.errors import UnknownName, UsageError


def register(app: typer.Typer) -> None:
    """Add this module's command."""
    app.command("replay")(replay)


def replay(
    store: str = STORE_ARGUMENT,
    resolution: str = typer.Option("low", "--resolution", help="Mesh: low (6,105 vertices) or high (80,190)."),
    fidelity: str = typer.Option("finite-strain", "--fidelity", help="finite-strain, or linear: a quick preview."),
    calibration: Path = typer.Option(None, "--calibration", help="calibration.json of `tactiledata calibrate`."),
    effects: Path = typer.Option(None, "--effects", help="effects.json of `tactiledata diagnose`: missing physics."),
    youngs_modulus: float = typer.Option(None, "--youngs-modulus", help="Pa; wins over both files."),
    poisson_ratio: float = typer.Option(None, "--poisson-ratio", help="Wins over both files."),
    friction: float = typer.Option(None, "--friction", help="Coulomb's coefficient; wins over both files."),
    keep: str = typer.Option("all", "--keep", help="Nodes whose displacement is kept: all, or those of the surface."),
    name: str = typer.Option(None, "--name", help="Name in the store [default: low, low-linear, high, high-linear]."),
    replace: bool = typer.Option(False, "--replace", help="Make a mesh of this name anew where it was made otherwise."),
    indenters: Path = typer.Option(None, "--indenters", help="Folder of the mesh files that recordings name."),
    pad: Path = typer.Option(None, "--pad", help="A pad mesh of your own (.mesh, .msh, .vtk), for all sensors."),
    pad_unit: str = typer.Option("mm", "--pad-unit", help="Unit of the pad mesh."),
    gap_limit: float = typer.Option(0.1, "--gap-limit", help="Seconds; across a longer gap a pose is missing."),
    out: Path = typer.Option(Path("replay"), "--out", help="Folder for the page with pictures."),
    workers: int = typer.Option(1, "--workers", help="Local processes."),
    scheduler: str = typer.Option(None, "--scheduler", help="Address of a Dask scheduler, instead of local processes."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Attach a soft-gel mesh to every frame of a store. Touches are played as recorded; goes on where it was killed.

    Example: tactiledata replay ds.zarr --calibration calibration.json --workers 2
    """
    from tactiledata.effects.simulate.setting import settings_of
    from tactiledata.gel.elasticity.material import GelMaterial
    from tactiledata.replay.attach import replay as attach
    from tactiledata.replay.options import ReplayOptions
    from tactiledata.replay.overview import write_replay_page
    from tactiledata.store.read.reader import Store

    for given, option, choices in (
        (resolution, "resolution", ("low", "high")),
        (fidelity, "fidelity", ("finite-strain", "linear")),
        (keep, "choice of --keep", ("all", "surface")),
    ):
        if given not in choices:
            raise UnknownName(option, given, choices)
    if not 0 < gap_limit < 1e6:
        raise UsageError(f"--gap-limit {gap_limit}", "seconds above 0")
    stated = {"youngs_modulus": youngs_modulus, "poisson_ratio": poisson_ratio, "friction": friction}
    calibrated = {} if calibration is None else calibration_document(calibration)
    found = {} if effects is None else effects_document(effects)
    material, origins = _material(stated, found.get("material", {}), calibrated)
    options = ReplayOptions(
        material=GelMaterial(**material),
        resolution=resolution,  # type: ignore[arg-type]
        fidelity=fidelity,  # type: ignore[arg-type]
        keep=keep,  # type: ignore[arg-type]
        offsets=found.get("offsets") or calibrated.get("offsets", {}),
        effects=settings_of(found, str(effects)) if found else (),
        gap_limit_ns=round(gap_limit * 1e9),
        indenter_folder=indenters,
        name=name,
        make_pad=_own_pad(pad, pad_unit),
    )
    location = working_store(store)
    with damage_explains(location), progress("replaying", quiet=as_json) as tell:
        report = attach(location, options, workers, scheduler, tell, replace)
    page = write_replay_page(Store.open(location), report.mesh, out) if report.with_mesh else None
    if as_json:
        emit({**report.document(), "material_from": origins, "page": None if page is None else str(page)})
    else:
        for line in report.lines():
            say(line)
        say(f"  {', '.join(f'{_SHORT[key].format(value)} ({origins[key]})' for key, value in material.items())}")
        if found and not options.acting:
            say("  every effect of the file is null: it changes nothing")
        if calibrated and (calibrated["engine"], calibrated["fidelity"]) != ("fem", fidelity):
            found_with = f"{calibrated['engine']}, {calibrated['fidelity']}"
            say(f"  the calibration was found with {found_with}: its stiffness makes up for that")
        if (known := found.get("provenance", {}).get("settings", {}).get("fidelity", fidelity)) != fidelity:
            say(f"  the effects were found with {known}: the stiffness beside them makes up for that")
        if page is not None:
            say(f"look: {page}")
            say(f"load: TactileDataset({location!r}, split=…, streams=['digit', 'mesh/{report.mesh}'])")
    if report.fell_short:
        raise typer.Exit(1)


_SHORT = {"youngs_modulus": "E {:.4g} Pa", "poisson_ratio": "nu {:.4g}", "friction": "mu {:.4g}"}


def _material(
    stated: Mapping[str, float | None], refitted: Mapping[str, Any], calibrated: Mapping[str, Any]
) -> tuple[dict[str, float], dict[str, str]]:
    """The material's parameters, and where each comes from: stated, else of the effects, else of the calibration."""
    sources = {"stated": stated, "from the effects": refitted, "from the calibration": calibrated}
    material, origins = {}, {}
    for name in stated:
        for origin, values in sources.items():
            if name not in material and (value := values.get(name)) is not None:
                material[name], origins[name] = float(value), origin
    missing = [f"--{name.replace('_', '-')}" for name in stated if name not in material]
    if missing:
        raise UsageError(
            f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not known",
            "the gel's material",
            "Name --calibration calibration.json (of `tactiledata calibrate`), --effects effects.json (of `tactiledata"
            " diagnose`), or all three values.",
        )
    return material, origins


def _own_pad(path: Path | None, unit: str) -> Any:
    from tactiledata.gel.mesh.mesh_file import pad_from_file

    if path is None:
        return None
    mesh = pad_from_file(path, unit)
    return lambda sensor, geometry: mesh
