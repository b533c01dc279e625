"""`replay`: a mesh for every frame of a store."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.documents import (
    calibration_document,
    effects_document,
    made_of_another_store,
    refuse_result_of_another_store,
)
from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import INDENTERS, need_folder, need_writable_folder, refuse_given
from tactiledata.cli.output import JSON_OPTION, emit, err, plain, progress, say
from tactiledata.cli.task_options import SCHEDULER, SIMULATION_WORKERS, workers_of
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.extras import GEL, PAGE, need_packages
from tactiledata.contract.paths import need_file_name
from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import UnknownName, UsageError

SOFTEST, STIFFEST = 1e3, 1e9
"""Pa, Young's moduli that are taken from the command line: beyond these it was stated in another unit."""


def register(app: typer.Typer) -> None:
    """Add the command `replay` to the application."""
    app.command("replay")(replay)


def replay(
    context: typer.Context,
    store: str = STORE_ARGUMENT,
    resolution: str = typer.Option(
        "low", "--resolution", help="Resolution of the mesh: low (6,105 vertices) or high (80,190)."
    ),
    fidelity: str = typer.Option(
        "finite-strain", "--fidelity", help="Strain model: finite-strain, or linear for a quick preview."
    ),
    calibration: Path = typer.Option(
        None, "--calibration", help="File calibration.json of `tactiledata calibrate`: the gel's material."
    ),
    effects: Path = typer.Option(
        None, "--effects", help="File effects.json of `tactiledata diagnose`: missing physics and material."
    ),
    youngs_modulus: float = typer.Option(
        None, "--youngs-modulus", help="Young's modulus of the gel in Pa, instead of that in a file."
    ),
    poisson_ratio: float = typer.Option(
        None, "--poisson-ratio", help="Poisson's ratio of the gel, instead of that in a file."
    ),
    friction: float = typer.Option(None, "--friction", help="Coulomb's coefficient, instead of that in a file."),
    keep: str = typer.Option("all", "--keep", help="Nodes whose displacements are stored: all or surface."),
    name: str = typer.Option(None, "--name", help="Name in the store [default: low, low-linear, high, high-linear]."),
    replace: bool = typer.Option(
        False,
        "--replace",
        help="Replace a mesh of this name that was made with other options or is damaged, and a page of another store.",
    ),
    indenters: Path = typer.Option(None, "--indenters", help="Folder of the mesh files that recordings name."),
    pad: Path = typer.Option(None, "--pad", help="Pad mesh of your own (.mesh, .msh, .vtk), for all sensors."),
    pad_unit: str = typer.Option("mm", "--pad-unit", help="Length unit of the pad mesh."),
    gap_limit: float = typer.Option(
        0.1, "--gap-limit", help="Longest gap in seconds across which a pose is interpolated."
    ),
    out: Path = typer.Option(Path("replay"), "--out", help="Folder for the page with pictures."),
    workers: int = SIMULATION_WORKERS,
    scheduler: str = SCHEDULER,
    as_json: bool = JSON_OPTION,
) -> None:
    """Attach a soft-gel mesh to every frame of a store.

    The simulation follows the recorded poses. A run that was killed continues where it stopped.

    Example: tactiledata replay ds.zarr --calibration calibration.json
    """
    need_packages("a replay", *GEL, *PAGE)
    # refuse wrong usage before any work, and before the imports that take seconds
    for given, option, choices in (
        (resolution, "resolution", ("low", "high")),
        (fidelity, "fidelity", ("finite-strain", "linear")),
        (keep, "choice of --keep", ("all", "surface")),
    ):
        if given not in choices:
            raise UnknownName(option, given, choices)
    if youngs_modulus is not None and not SOFTEST <= youngs_modulus <= STIFFEST:
        raise UsageError(
            f"--youngs-modulus is {youngs_modulus:g} Pa",
            f"{SOFTEST:g} to {STIFFEST:g} Pa: a soft gel has 1e5 to 1e6",
            "State it in pascals: 0.9 MPa is 0.9e6, 900 kPa is 900e3.",
        )
    if pad is None:
        refuse_given(context, ["pad_unit"], "without --pad", "with --pad")
    else:
        refuse_given(context, ["resolution"], "with --pad", "without --pad")
    need_folder(indenters, "--indenters", INDENTERS)
    if not 0 < gap_limit < 1e6:
        raise UsageError(f"--gap-limit {gap_limit}", "a number of seconds above 0")
    # material and effects: stated values win over the files
    stated = {"youngs_modulus": youngs_modulus, "poisson_ratio": poisson_ratio, "friction": friction}
    calibrated = {} if calibration is None else calibration_document(calibration)
    diagnosed = {} if effects is None else effects_document(effects)
    material, origins = _material(stated, diagnosed.get("material", {}), calibrated)
    from tactiledata.effects.simulate.setting import settings_of
    from tactiledata.gel.elasticity.material import GelMaterial
    from tactiledata.replay.attach import replay as attach
    from tactiledata.replay.options import ReplayOptions
    from tactiledata.replay.overview import write_replay_page
    from tactiledata.store.read.flags import flagged_trajectories
    from tactiledata.store.read.reader import Store

    if name is not None:
        need_file_name(name, "mesh", "stiffer")
    options = ReplayOptions(
        material=GelMaterial(**material),
        resolution=resolution,  # type: ignore[arg-type]
        fidelity=fidelity,  # type: ignore[arg-type]
        keep=keep,  # type: ignore[arg-type]
        offsets=diagnosed.get("offsets") or calibrated.get("offsets", {}),
        effects=settings_of(diagnosed, str(effects)) if diagnosed else (),
        gap_limit_ns=round(gap_limit * 1e9),
        indenter_folder=indenters,
        name=name,
        make_pad=_own_pad(pad, pad_unit),
    )
    need_writable_folder(out, f"replay-{options.mesh_name}.html")
    # replay
    location = working_store(store)
    elsewhere: list[str] = []
    flagged: set[str] = set()
    if Path(location).is_dir():
        with damage_explains(location):
            opened = Store.open(location)
            flagged = set(flagged_trajectories(opened))
        refuse_result_of_another_store(out / f"replay-{options.mesh_name}.html", opened, replace)
        files = ((calibration, calibrated), (effects, diagnosed))
        made = ((path, made_of_another_store(document, opened)) for path, document in files)
        elsewhere = [f"{path}: {words}" for path, words in made if words]
    if not as_json:
        for words in elsewhere:
            err().print(plain(f"note: {words}"))
    with damage_explains(location), progress("replaying", quiet=as_json) as report_progress:
        report = attach(location, options, workers_of(workers, scheduler), scheduler, report_progress, replace)
    page = write_replay_page(Store.open(location), report.mesh, out) if report.with_mesh else None
    played = sorted(flagged.difference(*report.refused.values())) if report.with_mesh else []
    # print
    if as_json:
        told = {
            "material_from": origins,
            "of_other_stores": elsewhere,
            "flagged": played,
            "page": None if page is None else str(page),
        }
        emit({**report.document(), **told})
    else:
        for line in report.lines():
            say(line)
        say(f"  {', '.join(f'{_SHORT[key].format(value)} ({origins[key]})' for key, value in material.items())}")
        if diagnosed and not options.acting:
            say("  every effect in the file has no strength, so the effects change nothing")
        if calibrated and (calibrated["engine"], calibrated["fidelity"]) != ("fem", fidelity):
            fitted_with = f"{calibrated['engine']}, {calibrated['fidelity']}"
            say(f"  the calibration was made with {fitted_with}: its stiffness compensates for the errors of that")
        if (known := diagnosed.get("provenance", {}).get("settings", {}).get("fidelity", fidelity)) != fidelity:
            say(
                f"  the effects were found with {known}: the stiffness in their file compensates for the errors of that"
            )
        if played:
            bad, were = counted(len(played), "trajectory"), agreeing(len(played), "was", "were")
            them = agreeing(len(played), "it", "them")
            say(f"  {bad} flagged as bad {were} played as well: splits leave {them} out")
        if page is not None:
            say(f"look: {page}")
            say(f"load: TactileDataset({location!r}, split=…, streams=['digit', 'mesh/{report.mesh}'])")
    if report.fell_short:
        raise typer.Exit(1)


_SHORT = {"youngs_modulus": "E {:.4g} Pa", "poisson_ratio": "nu {:.4g}", "friction": "mu {:.4g}"}
"""Short forms of the material's parameters, for a line of output."""


def _material(
    stated: Mapping[str, float | None], refitted: Mapping[str, Any], calibrated: Mapping[str, Any]
) -> tuple[dict[str, float], dict[str, str]]:
    """Return the material's parameters and their origins: stated, else from the effects, else from the calibration.

    Refuses a material of which a parameter is in none of the three.
    """
    sources = {"stated": stated, "from the effects": refitted, "from the calibration": calibrated}
    material, origins = {}, {}
    for name in stated:
        for origin, values in sources.items():
            if name not in material and (value := values.get(name)) is not None:
                material[name], origins[name] = float(value), origin
    missing = [name for name in stated if name not in material]
    if missing:
        raise UsageError(
            f"nothing states the gel's {_in_words(missing)}",
            "the gel's material: Young's modulus, Poisson's ratio and friction",
            "Give --calibration calibration.json (of `tactiledata calibrate`), --effects effects.json (of `tactiledata"
            f" diagnose`), or {' '.join('--' + name.replace('_', '-') + ' …' for name in missing)}.",
        )
    return material, origins


def _in_words(parameters: list[str]) -> str:
    words = {"youngs_modulus": "Young's modulus", "poisson_ratio": "Poisson's ratio", "friction": "friction"}
    *first, last = [words[name] for name in parameters]
    return f"{', '.join(first)} and {last}" if first else last


def _own_pad(path: Path | None, unit: str) -> Any:
    """Return a function that gives the user's pad mesh for every sensor; None where no file is named."""
    from tactiledata.gel.mesh.mesh_file import pad_from_file

    if path is None:
        return None
    mesh = pad_from_file(path, unit)
    return lambda sensor, geometry: mesh
