"""Residuals with known truth: presses, dwells and shears, noise as rigs have it, and planted effects."""

import numpy as np

from tactiledata.diagnose.residuals.residuals import Covariate, ResidualParameter, Residuals

COMPONENTS = ("fx", "fy", "fz")
PHASES = ("free air", "press", "dwell", "shear", "leave")
MODULUS = 900.0


def planted(
    seed=0,
    trajectories=40,
    frames=15,
    plant=None,
    own=True,
    correlation=0.5,
    heavy=True,
    random_effects=True,
):
    """Residuals of trajectories that press, dwell, shear and leave.

    The noise is correlated inside trajectories, its size differs threefold between them, and each trajectory has a
    modulus and zeros of its own; none of this goes with any covariate. ``plant(world) -> (n, k)`` is added.
    """
    rng = np.random.default_rng(seed)
    n = trajectories * frames
    groups = np.repeat(np.arange(trajectories), frames)
    place = np.tile(np.linspace(0, 1, frames), trajectories)
    deepest = np.repeat(rng.uniform(0.3, 1.2, trajectories), frames)
    shape = np.interp(place, [0, 0.15, 0.4, 0.85, 1], [0, 0, 1, 1, 0])
    depth = deepest * shape
    phase = np.array(PHASES)[np.searchsorted([0.16, 0.42, 0.6, 0.86], place)]
    speed = np.repeat(10 ** rng.uniform(-1, 1, trajectories), frames)
    covariates = {
        "depth": Covariate(depth, "mm"),
        "speed": Covariate(speed, "mm/s"),
        "minutes": Covariate(np.repeat(rng.permutation(trajectories) * 1.5, frames), "min"),
        "index": Covariate(groups.astype(float), "1"),
        "x": Covariate(np.repeat(rng.uniform(-6, 6, trajectories), frames), "mm"),
        "y": Covariate(np.repeat(rng.uniform(-8, 8, trajectories), frames), "mm"),
    }
    is_slip = (phase == "shear") & (place > 0.7)
    labels = {
        "phase": phase,
        "contact": np.where(is_slip, "slip", "stick"),
        "indenter": np.repeat(np.array(["ball", "cone", "box"])[rng.integers(0, 3, trajectories)], frames),
    }
    force = 40.0 * depth**1.5
    angle = np.repeat(rng.uniform(0, 2 * np.pi, trajectories), frames)
    pushed = np.column_stack([np.cos(angle), np.sin(angle)])
    shear = np.interp(place, [0, 0.6, 0.7, 0.86, 1], [0, 0, 1, 1, 0])
    of_modulus = np.column_stack([0.3 * force[:, None] * (shear * ~is_slip)[:, None] * pushed, force]) / MODULUS
    of_friction = np.column_stack([force[:, None] * is_slip[:, None] * pushed, np.zeros(n)])
    of_offset = np.column_stack([np.zeros((n, 2)), 60.0 * np.sqrt(np.maximum(depth, 0))])
    parameters = [ResidualParameter("E", "kPa", MODULUS), ResidualParameter("mu", "1", 0.8)]
    slopes = [of_modulus, of_friction]
    if own:
        parameters.append(ResidualParameter("offset", "mm", own_deviation=0.04))
        slopes.append(of_offset)
    values = noise(rng, trajectories, frames, correlation, heavy)
    if random_effects:
        values += np.repeat(rng.normal(0, 0.5, (trajectories, 3)), frames, axis=0)
        values += of_modulus * np.repeat(rng.normal(0, 20.0, trajectories), frames)[:, None]
        values += of_offset * np.repeat(rng.normal(0, 0.04, trajectories), frames)[:, None]
    world = Residuals(
        values, COMPONENTS, groups, covariates, labels, tuple(parameters), np.stack(slopes, axis=2),
        units=("N",) * 3, deviations=np.full(3, 0.1),
    )  # fmt: skip
    return world if plant is None else world.with_values(values + plant(world))


def noise(rng, trajectories, frames, correlation, heavy):
    """Noise (n, 3): autoregressive inside trajectories, of sizes that differ between them."""
    white = rng.normal(size=(trajectories, frames, 3))
    values = white.copy()
    for frame in range(1, frames):
        values[:, frame] = correlation * values[:, frame - 1] + np.sqrt(1 - correlation**2) * white[:, frame]
    if heavy:
        values *= np.exp(rng.uniform(-0.55, 0.55, trajectories))[:, None, None]
    return values.reshape(-1, 3)


def modulus_over(name, share, low, high, logarithmic=False):
    """A plant: E changes by a share of itself as a covariate goes from low to high."""

    def plant(world):
        scale = np.log if logarithmic else np.asarray
        z = scale(world.covariates[name].values)
        along = (z - scale(low)) / (scale(high) - scale(low))
        return world.slopes[:, :, 0] * (MODULUS * share * along)[:, None]

    return plant
