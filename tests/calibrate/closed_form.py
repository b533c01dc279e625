"""A gel in closed form: Hertz on a bonded layer, Mindlin's partial slip. A world whose truth is known exactly."""

import numpy as np

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.experiment import Experiment
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.response import Response
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise

TRUTH = np.array([900e3, 0.478, 0.78])
NOISE = WrenchNoise(np.diag([0.1**2] * 3 + [0.002**2] * 3), 1.0, "planted")
FRAMES = 14
THICKNESS = 4e-3
FREE_SAMPLES = 40.0


class ClosedFormWorld:
    """Touches of spheres of several radii at several places; pressed first, sheared then."""

    def __init__(self, count=20, seed=0, shear=8e-4):
        chance = np.random.default_rng(seed)
        self.count = count
        self.radius = chance.choice([2e-3, 4e-3, 8e-3], count)
        self.place = chance.uniform(-3e-3, 3e-3, (count, 2))
        half = FRAMES // 2
        depth = chance.uniform(0.5e-3, 1.1e-3, count)
        self.depth = depth[:, None] * np.concatenate([np.linspace(-0.1, 1, half), np.ones(FRAMES - half)])
        far = chance.uniform(0.5, 1.0, count) * chance.choice([-1, 1], count) * shear
        self.shear = far[:, None] * np.concatenate([np.zeros(half), np.linspace(0.2, 1, FRAMES - half)])
        self.starts = np.arange(count) * FRAMES

    def wrench(self, nu, mu, offsets):
        """(count * FRAMES, 6), Young's modulus 1."""
        depth = np.maximum(self.depth + np.broadcast_to(offsets, self.count)[:, None], 0.0)
        contact = np.sqrt(self.radius[:, None] * depth)
        alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1 - nu)
        share = 2 * alpha / np.pi * contact / THICKNESS
        normal = 4 / 3 / (1 - nu**2) * contact * depth * (1 - share + share**2)
        stick = 3 * (2 - nu) * mu * normal * 2 * (1 + nu) / (16 * np.maximum(contact, 1e-9))
        slid = np.clip(np.abs(self.shear) / np.maximum(stick, 1e-12), 0, 1)
        tangential = -np.sign(self.shear) * mu * normal * (1 - (1 - slid) ** 1.5)
        x, y = self.place.T[:, :, None]
        wrench = np.stack([tangential, 0 * normal, normal, y * normal, -x * normal, -y * tangential], axis=-1)
        return wrench.reshape(-1, 6)

    def measured(self, truth=TRUTH, offsets=0.0, noise=NOISE, seed=0, tare=True):
        """(n, 6) N, N m: with noise, and zeros that are as uncertain as their free air."""
        chance = np.random.default_rng(seed)
        clean = truth[0] * self.wrench(truth[1], truth[2], offsets)
        if noise is None:
            return clean
        zeros = np.sqrt(np.pi / 2 / FREE_SAMPLES) * chance.standard_normal((self.count, 6)) * noise.deviations * tare
        return clean + chance.standard_normal(clean.shape) * noise.deviations + np.repeat(zeros, FRAMES, axis=0)

    def response(self, bounds="paper"):
        plan = ResponsePlan.of(find_bounds(bounds))
        plays = {node: self.wrench(node.poisson_ratio, node.friction, node.offset) for node in plan.nodes()}
        return Response.of(plan, plays, self.starts)

    def experiment(self, measured, bounds="paper"):
        poses = np.tile(np.eye(4), (FRAMES, 1, 1))
        touches = tuple(
            MeasuredTouch(
                f"uid{k}", f"t{k}", "D1", "ball", GelTouch(Sphere(radius=float(self.radius[k])), poses),
                measured[k * FRAMES : (k + 1) * FRAMES], np.arange(FRAMES) / 10, FREE_SAMPLES,
            )
            for k in range(self.count)
        )  # fmt: skip
        frames = tuple(np.arange(FRAMES) for _ in touches)
        return Experiment(touches, frames, self.response(bounds), measured, {})
