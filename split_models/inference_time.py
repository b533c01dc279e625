"""How long a frame takes: simulating the mesh, and making the picture of it, each method at the resolution it needs."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from split_models.methods import MESH_TO_IMAGE, for_sensor
from split_models.prepare import replay_options
from split_models.workshop import Workshop
from tactiledata.errors import UsageError
from tactiledata.gel.embedded import EmbeddedEngine
from tactiledata.gel.fem import FemEngine
from tactiledata.gel.material import GelMaterial
from tactiledata.replay.options import ReplayOptions
from tactiledata.replay.plan import plan_replay
from tactiledata.rig.scenario import load_scenario
from tactiledata.rig.worlds import find_scenario
from tactiledata.store.reader import Store

WARM_UP = 3
"""Calls before the clock starts: first ones allocate and choose kernels."""


def prepare_time(workshop: Workshop) -> dict[str, Any]:
    """The methods, trained."""
    return {name: MESH_TO_IMAGE[name](workshop) for name in workshop.recipe.rows["methods"] or ["split"]}


def time_rows(workshop: Workshop) -> list[dict[str, Any]]:
    """Median seconds a frame: a row for each resolution that is simulated and for each method's pictures."""
    rows = [
        _row(f"simulation, {resolution} resolution", simulation_seconds(workshop, resolution))
        for resolution in ("low", "high")
    ]
    frames = workshop.frames(workshop.recipe.rows["parts"][0])
    numbers = np.linspace(0, len(frames) - 1, min(workshop.recipe.rows["frames"], len(frames))).astype(np.int64)
    for name, method in prepare_time(workshop).items():
        sensors = [frames.sensors[number] for number in numbers]
        calls = [
            _call(for_sensor(method, sensor), frames.displacements([int(number)]), frames.background(sensor))
            for sensor, number in zip(sensors, numbers, strict=True)
        ]
        rows.append(_row(f"mesh to image, {name}", seconds_of(calls, workshop.device)))
    return rows


def _call(method: Any, displacements: Any, background: Any) -> Callable[[], Any]:
    return lambda: method.predict(displacements, background)


def seconds_of(calls: list[Callable[[], Any]], device: torch.device) -> list[float]:
    """Seconds of each call, on a quiet device, after some that do not count."""
    for call in calls[:WARM_UP]:
        call()
    found = []
    for call in calls:
        if device.type == "cuda":
            torch.cuda.synchronize(device)
        started = time.perf_counter()
        call()
        if device.type == "cuda":
            torch.cuda.synchronize(device)
        found.append(time.perf_counter() - started)
    return found


def simulation_seconds(workshop: Workshop, resolution: str) -> list[float]:
    """Seconds a frame of touches of the store through the gel, trajectory by trajectory, factorisation left out."""
    store = Store.open(workshop.store)
    options = _options(workshop)
    plan = plan_replay(store, options.pads, None)
    playable = [touch for touch in plan.touches if touch.obstacle is None]
    if not playable:
        raise UsageError(f"no trajectory of {store.location} can be replayed", "poses and described indenters", "")
    pad = plan.pads[playable[0].pad]
    nu, fidelity = options.material.poisson_ratio, options.fidelity
    engine = (
        EmbeddedEngine(pad.sensor, pad.geometry, nu, fidelity)
        if resolution == "high"
        else FemEngine(pad.mesh, nu, fidelity)
    )
    limit, counted = workshop.recipe.rows["frames"], 0
    found: list[float] = []
    for touch in playable:
        pressed = touch.gel_touch(store, 0.0)
        started = time.perf_counter()
        for _ in engine.play([pressed], options.material):
            pass
        found.append((time.perf_counter() - started) / len(pressed.poses))
        counted += len(pressed.poses)
        if counted >= limit:
            break
    return found


def _options(workshop: Workshop) -> ReplayOptions:
    data = workshop.recipe.data
    if data["world"]:
        return replay_options({**data["replay"], "resolution": "low"}, load_scenario(find_scenario(data["world"])))
    frames = workshop.frames("train")
    known = frames.arrays.store.mesh(frames.mesh_name).settings
    return ReplayOptions(GelMaterial(**known["material"]), resolution="low", fidelity=known["fidelity"])


def _row(what: str, seconds: list[float]) -> dict[str, Any]:
    low, high = (float(value) for value in np.quantile(seconds, [0.1, 0.9]))
    score = {
        "value": float(np.median(seconds)),
        "low": low,
        "high": high,
        "frames": len(seconds),
        "unit": "s",
        "better": "lower",
    }
    return {"part": "all", "method": what, "scores": {"seconds": score}}
