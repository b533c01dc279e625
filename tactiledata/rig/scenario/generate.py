"""Touches drawn at random from a scenario's ``generate`` block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactiledata.rig.motion.touch import Generate, Step, TouchPlan
from tactiledata.rig.scenario.scenario import Scenario

STREAM = 1
"""Number of the random stream of generated touches: each part of the rig has its own, so that none disturbs another."""


def touches(scenario: Scenario) -> tuple[TouchPlan, ...]:
    """Return all touches of a scenario: the explicit ones, then the generated ones in order of their names.

    Touch *k* is drawn from (seed, k) alone, so that a larger ``count`` does not change the first touches.
    """
    plan = scenario.generate
    if plan is None:
        return scenario.trajectories
    sensors = plan.sensors or tuple(scenario.sensors)
    indenters = plan.indenters or tuple(scenario.indenters)
    paired = (plan.count if plan.paired else 0) if isinstance(plan.paired, bool) else plan.paired
    drawn: list[TouchPlan] = []
    for index in range(plan.count):
        rng = np.random.default_rng([scenario.seed, STREAM, index])
        # sensors change fastest; the shift by rounds lets every sensor meet every indenter, also when counts share
        # a factor
        sensor = sensors[index % len(sensors)]
        rounds = index if index < paired else index // len(sensors) + index % len(sensors)
        choice = (plan.paired_indenters or indenters) if index < paired else indenters
        touch = _draw(plan, rng, f"t{index:05d}", sensor, choice[rounds % len(choice)])
        if index < paired:
            shared = plan.paired_sensors or sensors
            drawn.extend(replace(touch, name=f"{touch.name}-{serial}", sensor=serial) for serial in shared)
        else:
            drawn.append(touch)
    return scenario.trajectories + tuple(drawn)


def _draw(plan: Generate, rng: np.random.Generator, name: str, sensor: str, indenter: str) -> TouchPlan:
    """Return one touch, drawn from the ranges of a plan."""
    # the press, and the rest after it
    speed = float(rng.choice(plan.speeds)) if plan.speeds else _log_uniform(rng, plan.speed)
    settle = _log_uniform(rng, plan.settle)
    depth = round(_log_uniform(rng, plan.depth) / plan.step) * plan.step
    steps = [Step("press", depth=max(depth, plan.step), step=plan.step, speed=speed, settle=settle)]
    if plan.dwell[1] > 0:
        steps.append(Step("dwell", time=_log_uniform(rng, plan.dwell)))
    # a share of the touches is sheared, and a share of those is sheared back
    if rng.random() < plan.shear_share:
        length = _log_uniform(rng, plan.shear) * rng.choice([-1.0, 1.0])
        by = (length, 0.0) if rng.random() < 0.5 else (0.0, length)
        steps.append(Step("shear", by=by, step=plan.shear_step, speed=speed, settle=settle))
        if rng.random() < plan.reverse_share:
            steps.append(Step("reverse", step=plan.shear_step, speed=speed, settle=settle))
    steps.append(Step("retreat", speed=2 * speed))
    # angle and place
    tilt = rng.uniform(*plan.tilt)
    direction = rng.uniform(0.0, 2 * np.pi)
    return TouchPlan(
        name=name,
        sensor=sensor,
        indenter=indenter,
        steps=tuple(steps),
        position=(
            float(rng.uniform(-plan.position[0], plan.position[0])),
            float(rng.uniform(-plan.position[1], plan.position[1])),
        ),
        tilt=(float(tilt * np.cos(direction)), float(tilt * np.sin(direction))),
        yaw=float(rng.uniform(-1.2, 1.2)),
        force_limit=plan.force_limit,
        group=name,
    )


def _log_uniform(rng: np.random.Generator, bounds: tuple[float, float]) -> float:
    """Return a value within bounds whose logarithm is uniform; a uniform value where the range begins at 0."""
    least, most = bounds
    if least <= 0:
        return float(rng.uniform(least, most))
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))
