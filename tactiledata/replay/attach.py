"""Replay of a store: workers simulate trajectories, which are committed in order; it may be killed at any moment."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.compute import make_scheduler
from tactiledata.contract.progress import Progress
from tactiledata.errors import UsageError
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.replay.effect_touches import EffectTouch, ReplayEffects
from tactiledata.replay.effect_words import effects_in_words
from tactiledata.replay.options import ReplayOptions
from tactiledata.replay.plan import PlannedTouch, ReplayPlan, plan_replay
from tactiledata.replay.report import ReplayReport
from tactiledata.replay.solve import Run, solve_run
from tactiledata.replay.status import STATUSES
from tactiledata.store.check.meshes import mesh_fault
from tactiledata.store.check.values import need_sound_values
from tactiledata.store.layout.lock import writing_lock
from tactiledata.store.layout.manifest import read_manifest
from tactiledata.store.layout.places import INTAKE_LOCK, STAGING, folder_name
from tactiledata.store.read.meshes import PadArrays
from tactiledata.store.read.reader import Store
from tactiledata.store.write.card import write_card
from tactiledata.store.write.commit import recover, store_errors
from tactiledata.store.write.documents import need_whole_documents
from tactiledata.store.write.mesh_writer import append_mesh, drop_mesh

RUN_TOUCHES = 16
"""Most trajectories of a run, which are solved together.

It does not depend on the number of workers, because results depend on the grouping in the last digit."""
RUN_BYTES = 256 * 2**20
"""Largest size of a run's rows, bytes; a single trajectory is never cut."""


def replay(
    store_path: Path | str,
    options: ReplayOptions,
    workers: int = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
    replace: bool = False,
) -> ReplayReport:
    """Simulate every frame of a store and attach the meshes to it; frames that have a mesh already are kept.

    A process can be killed at any moment: the same call then continues where it stopped, and ends with the same bytes.

    Parameters
    ----------
    store_path : path
        A local store.
    options : ReplayOptions
        Material, resolution, fidelity and effects.
    workers : int
        Local processes.
    scheduler : str, optional
        Address of a Dask scheduler, instead of local processes.
    progress : callable, optional
        Called with the number of finished trajectories, their total and a label.
    replace : bool
        Delete a mesh of this name that was made with other options or is damaged, and make it again.

    Raises
    ------
    UsageError
        The store has a mesh of this name that was made with other options, an effect does not fit, or no trajectory can
        be replayed at all.
    StoreBusy
        Another process writes to the store.
    StoreError
        The store is damaged.
    TactileDataError
        Numbers that the store was given are damaged.
    """
    folder = Path(store_path)
    runner = make_scheduler(workers, scheduler)
    read_manifest(folder)
    with writing_lock(folder, INTAKE_LOCK):
        # finish or undo what an interrupted process left
        recover(folder)
        store = Store.open(folder)
        need_whole_documents(store)
        need_sound_values(store, store.signal_names)
        plan = plan_replay(store, options.pads, options.indenter_folder)
        effects = _effects(store, plan, options)
        plan = plan if effects is None else effects.plan
        # a mesh of the same options is continued; one of other options, or a damaged one, is refused or deleted
        name = options.mesh_name
        if name in store.mesh_names:
            differences = _differences(store, plan, options)
            if differences and not replace:
                raise _made_otherwise(store, name, differences)
            if replace and (differences or mesh_fault(store, name)):
                drop_mesh(folder, name)
                store = Store.open(folder)
        rows_before = store.manifest.get("meshes", {}).get(name, {"rows": 0})["rows"]
        if plan.pads:
            _attach(folder, store, plan, effects, options, rows_before, runner, progress)
    return ReplayReport.of(Store.open(folder), name, plan, rows_before)


def _effects(store: Store, plan: ReplayPlan, options: ReplayOptions) -> ReplayEffects | None:
    """Return the effects on a store's trajectories, or ``None`` where no effect acts.

    Raises
    ------
    UsageError
        An effect that the chosen engine cannot simulate, or that the store does not fit.
    """
    if not options.acting:
        return None
    effects = ReplayEffects(store, plan, options.acting)
    if options.is_interpolated and effects.varies_gel:
        raise UsageError(
            "effects of another gel at --resolution high",
            "--resolution low: the high one is interpolated from the nominal gel",
            "Replay at low resolution, or leave the effects of gel and geometry out.",
        )
    if options.fidelity == "linear" and effects.stiffens:
        raise UsageError(
            "effect 'strain_stiffening' at --fidelity linear",
            "--fidelity finite-strain: a linear gel has no such law",
            "Replay at finite strain, or leave it out.",
        )
    return effects


def _differences(store: Store, plan: ReplayPlan, options: ReplayOptions) -> list[str]:
    """Return in words what differs between the stored mesh and one of these options, with the pads of the plan."""
    facts = store.mesh(options.mesh_name).facts
    there, here = _in_words(facts["settings"]), _in_words(options.document())
    found = [
        f"{name} {there.get(name, 'unknown')} there, {here.get(name, 'unknown')} here"
        for name in dict.fromkeys([*there, *here])
        if there.get(name) != here.get(name)
    ]
    if not found and facts["settings"] != options.document():
        found = ["other values"]
    stored_pads, planned_pads = ([pad["sha256"] for pad in pads] for pads in (facts["pads"], _described(plan)))
    return found if stored_pads == planned_pads[: len(stored_pads)] else [*found, "another pad"]


def _in_words(settings: Mapping[str, Any]) -> dict[str, str]:
    """Return a mesh's settings as words by their names; contact offsets by number and the start of their digest."""
    shown = {"material", "effects", "offsets", "offsets_sha256"}
    return {
        **{name.replace("_", " "): f"{value:.6g}" for name, value in settings["material"].items()},
        **{name.replace("_", " "): str(value) for name, value in settings.items() if name not in shown},
        "offsets": f"{settings['offsets']} ({settings['offsets_sha256'][:8]})",
        "effects": effects_in_words(settings) or "none",
    }


def _made_otherwise(store: Store, name: str, differences: list[str]) -> UsageError:
    """Error for a stored mesh that was made with other options."""
    return UsageError(
        f"the mesh {name!r} of {store.location} was made with other options ({'; '.join(differences)})",
        "the same options, to continue it",
        "Add --replace to make it again, or --name NAME to keep it and make another.",
        mesh=name,
    )


def _described(plan: ReplayPlan) -> list[Mapping[str, Any]]:
    """Descriptions of the plan's pads as JSON values."""
    return [pad.described for pad in plan.pads]


def _attach(
    folder: Path,
    store: Store,
    plan: ReplayPlan,
    effects: ReplayEffects | None,
    options: ReplayOptions,
    rows_before: int,
    scheduler: Any,
    progress: Progress | None,
) -> None:
    """Solve all frames after the first ``rows_before`` in runs, and commit the runs in order."""
    pad = _pad_arrays(plan, options)
    runs = list(_runs(folder, store, plan, effects, options, rows_before, pad))
    total, done = sum(len(run.touches) for run in runs), 0
    facts = {
        "kind": plan.pads[0].mesh.kind,
        "settings": options.document(),
        "statuses": {str(status): words for status, words in sorted(STATUSES.items())},
    }
    # outcomes come in the order of the runs
    for outcome in scheduler.outcomes(solve_run, runs):
        run = outcome.task
        arrays = {array: np.load(path, mmap_mode="r") for array, path in outcome.value.items()}
        append_mesh(folder, options.mesh_name, facts, _described(plan), pad, run.frames, arrays)
        shutil.rmtree(run.folder, ignore_errors=True)
        done += len(run.touches)
        if progress is not None:
            progress(done, total, str(run))
    # the card states what the store holds
    if runs:
        with store_errors(folder), writing_lock(folder):
            write_card(folder, read_manifest(folder))


def _pad_arrays(plan: ReplayPlan, options: ReplayOptions) -> PadArrays:
    """Arrays of the plan's pads as the store keeps them; all pads share cells and surface."""
    mesh = plan.pads[0].mesh
    surface = contact_surface(mesh)
    return PadArrays(
        vertices=np.stack([pad.mesh.vertices for pad in plan.pads]),
        cells=mesh.cells,
        triangles=mesh.triangles,
        kept=np.arange(len(mesh.vertices)) if options.keep == "all" else surface.nodes,
        surface=surface.nodes,
        corners=surface.nodes[surface.corners],
        base=mesh.base,
    )


def _runs(
    folder: Path,
    store: Store,
    plan: ReplayPlan,
    effects: ReplayEffects | None,
    options: ReplayOptions,
    rows_before: int,
    pad: PadArrays,
) -> Iterator[Run]:
    """Yield the runs that cover all frames from ``rows_before`` to the last; the last one ends with the store."""
    sizes = {name: len(getattr(pad, name)) for name in ("kept", "surface", "corners")}
    frame_bytes = 12 * (sizes["kept"] + sizes["surface"]) + sizes["corners"]
    waiting = [touch for touch in plan.touches if touch.frames[0] >= rows_before]
    first = rows_before
    for group in _groups(waiting, frame_bytes):
        is_last = not group or group[-1] is waiting[-1]
        stop = store.n_frames if is_last else group[-1].frames[1]
        if stop > first:
            yield Run(
                store=str(folder.resolve()),
                folder=str(folder.resolve() / STAGING / f"mesh-{folder_name(options.mesh_name)}-{first}"),
                frames=(first, stop),
                touches=tuple(group),
                offsets=tuple(_offset(touch, options) for touch in group),
                effects=tuple(_effect_touch(store, touch, effects, options) for touch in group),
                pads=plan.pads,
                is_interpolated=options.is_interpolated,
                sizes=sizes,
                material=options.material,
                fidelity=options.fidelity,
                keep=options.keep,
                gap_limit_ns=options.gap_limit_ns,
            )
        first = stop


def _offset(touch: PlannedTouch, options: ReplayOptions) -> float:
    """Contact offset of a trajectory, m: how much deeper its indenter is than recorded."""
    return float(options.offsets.get(touch.uid, 0.0))


def _effect_touch(
    store: Store, touch: PlannedTouch, effects: ReplayEffects | None, options: ReplayOptions
) -> EffectTouch | None:
    """Inputs of the effects on a trajectory, or ``None`` where none acts or it cannot be replayed."""
    if effects is None or touch.obstacle is not None:
        return None
    return effects.touch(touch, touch.gel_touch(store, _offset(touch, options), options.gap_limit_ns), options.material)


def _groups(touches: list[PlannedTouch], frame_bytes: int) -> Iterator[list[PlannedTouch]]:
    """Yield touches in groups of limited number and size; without touches, one empty group for the remaining frames."""
    group: list[PlannedTouch] = []
    size = 0
    for touch in touches:
        added = (touch.frames[1] - touch.frames[0]) * frame_bytes
        if group and (len(group) == RUN_TOUCHES or size + added > RUN_BYTES):
            yield group
            group, size = [], 0
        group.append(touch)
        size += added
    yield group
