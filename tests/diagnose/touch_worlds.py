"""Touches of a rig that is none of the simulations: other contact law, other friction, finer time, other formulas."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.diagnose.touches.touch_case import TouchCase, TouchSet
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.sensors.digit import DIGIT

TRUTH = GelMaterial(0.88e6, 0.48, 0.8)
START = GelMaterial(0.9e6, 0.475, 0.75)
FORCE_NOISE, TORQUE_NOISE = 0.1, 0.003
CORRELATION = 0.4
FINE = 0.02
FRAMES = np.array([0, 0.5, 0.9, 1.4, 1.7, 2, 2.5, 3, 3.33, 3.67, 4, 4.5, 5, 5.4, 5.7, 7])
"""Places between the corners of a path; corners of a slide are among them, as what turns unseen cannot be replayed."""


@dataclass(frozen=True)
class World:
    """What a rig has that its simulation does not; 0 where nothing.

    ``growth`` is by which share of itself relaxing is stronger in the last touch than in the middle of the session.
    """

    compliance: float = 0.0
    relaxing: float = 0.0
    growth: float = 0.0
    rate: float = 0.0
    turn: tuple = (0.0, 0.0, 0.0)
    matrix: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    mass: float = 0.0
    lag: float = 0.0
    thinner: float = 0.0
    ripple: float = 0.0
    jitter: float = 3e-5
    mismatch: float = 1.0


def base(material):
    """The simulation that is fitted."""
    return BallOnLayer


def world_cases(world, seed=0, trajectories=40):
    """Trajectories of a world: press, dwell, slide, turn back, leave, at other speeds, depths, places each time."""
    rng = np.random.default_rng(seed)
    law = Law(world, rng)
    late = np.linspace(-1.0, 1.0, trajectories)
    worlds = [replace(world, relaxing=world.relaxing * (1.0 + world.growth * share)) for share in late]
    return TouchSet([_case(one, law, rng, number) for number, one in enumerate(worlds)], base)


class Law:
    """Contact of this rig: exponent, layer and shear spring differ by some per cent, differently for each draw."""

    def __init__(self, world, rng):
        size = world.mismatch
        self.exponent = 1.5 + size * rng.uniform(-0.03, 0.03)
        self.layer = 1.0 + size * rng.uniform(-0.04, 0.04)
        self.spring = 1.0 + size * rng.uniform(-0.08, 0.08)
        self.shape = dict(enumerate(1.0 + size * rng.normal(0, 0.02, 4)))
        self.thickness = DIGIT.gel.thickness * (1.0 - world.thinner)

    def normal(self, depth, radius, kind):
        d = np.maximum(depth, 0.0)
        chi = np.sqrt(radius * d) / self.thickness
        modulus = TRUTH.youngs_modulus / (1 - TRUTH.poisson_ratio**2)
        reference = 6e-4
        hertz = 4 / 3 * modulus * np.sqrt(radius) * reference**1.5 * (d / reference) ** self.exponent
        # another expansion of the layer's stiffening, within some per cent over the range that is pressed
        return self.shape[kind] * hertz * (1.0 + self.layer * (1.10 * chi + 1.45 * chi**2 + 0.60 * chi**3))


def _case(world, law, rng, number):
    kind = number % 4
    radius = (0.002, 0.003, 0.004, 0.006)[kind]
    frames = len(FRAMES)
    deepest = rng.uniform(0.4, 1.1) * 1e-3 * (1.0 if radius < 0.005 else 0.8)
    speed = 10 ** rng.uniform(-4.0, -2.3)
    pressing, dwell = 10 ** rng.uniform(-0.5, 0.7), 10 ** rng.uniform(-0.3, 1.3)
    slide = rng.uniform(1.0, 3.0) * 1e-3
    marks = np.cumsum([0.0, 0.5, pressing, dwell, slide / speed, slide / speed / 2, pressing, 0.3])
    depths = deepest * np.array([-0.2, -0.2, 1.0, 1.0, 1.0, 1.0, -0.2, -0.2])
    ways = slide * np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.5, 0.5])
    dealt = np.interp(FRAMES, np.arange(8), marks)
    fine = np.union1d(np.arange(0.0, marks[-1], min(FINE * marks[-1] / 4, 0.1)), dealt)
    angle, place = rng.uniform(0, 2 * np.pi), rng.uniform(-4e-3, 4e-3, 2)
    jitter = rng.normal(0, world.jitter)
    wrench = _wrench(world, law, fine, np.interp(fine, marks, depths) + jitter, np.interp(fine, marks, ways),
                     speed, radius, kind, angle, place)  # fmt: skip
    gravity = Rotation.from_euler("xyz", rng.uniform(-0.9, 0.9, 3)).apply([0.0, 0.0, -9.81])
    swing = Rotation.from_rotvec([0.4 * np.cos(angle), 0.4 * np.sin(angle), 0.0])
    turned = np.array([(swing ** float(share)).apply(gravity) for share in dealt / marks[-1]])
    picked = wrench[np.searchsorted(fine, dealt)]
    free = np.interp(dealt, marks, depths) < -0.1 * deepest
    tare = free & (dealt < marks[2])
    measured = _sensor(world, picked, turned, rng)
    measured = measured - measured[tare].mean(axis=0)
    poses = np.tile(np.eye(4), (frames, 1, 1))
    poses[:, :2, 3] = place + np.outer(np.interp(dealt, marks, ways), [np.cos(angle), np.sin(angle)])
    poses[:, 2, 3] = -np.interp(dealt, marks, depths)
    powered = 120.0 + 60.0 * number
    touch = Touch(
        seconds=dealt + 1e-6 * np.arange(frames), poses=poses, indenter=Sphere(radius), material=START,
        geometry=DIGIT.gel, sensor="one", indenter_name=f"ball {kind}", mount=f"ball {kind}", gravity=turned,
        powered=powered + dealt, earlier_depth=np.full(frames, 1e-3), earlier_contacts=np.full(frames, float(number)),
        tare=tare,
    )  # fmt: skip
    covariance = np.diag([FORCE_NOISE**2] * 3 + [TORQUE_NOISE**2] * 3)
    inflation = (1 + CORRELATION) / (1 - CORRELATION)
    noise = WrenchNoise(covariance, inflation, "planted")
    return TouchCase(touch, measured, noise, free, free_samples=float(tare.sum()), name=f"D-{number}")


def _wrench(world, law, t, depth, way, speed, radius, kind, angle, place):
    along = np.array([np.cos(angle), np.sin(angle)])
    normal = law.normal(depth, radius, kind)
    if world.compliance:
        # an arm that is stiffer the harder it is pushed
        for _ in range(60):
            given = world.compliance * normal / (1.0 + 0.01 * normal)
            normal = 0.5 * normal + 0.5 * law.normal(depth - given, radius, kind)
    if world.ripple:
        normal = normal * (1.0 + world.ripple * np.sin(2 * np.pi * (place[0] + along[0] * way) / 1.5e-3))
    memory = _power_law(t, world.relaxing) if world.relaxing else np.tri(len(t))
    touching = normal > 0
    normal = np.where(touching, memory @ np.diff(normal, prepend=normal[:1]), 0.0)
    shear = _bristles(world, law, normal, memory, depth, way, speed, radius)
    force = np.column_stack([np.outer(shear, along), normal])
    at = np.column_stack([place + np.outer(way, along), -np.maximum(depth, 0.0)])
    wrench = np.column_stack([force, np.cross(at, force)])
    return _late(t, wrench, world.lag) if world.lag else wrench


def _bristles(world, law, normal, memory, depth, way, speed, radius):
    """Dahl's friction: a knee without a corner; its level may follow speed by a power law. Bristles remember (n, n)."""
    level = TRUTH.friction * (speed / 1e-3) ** (world.rate / np.log(10)) * normal
    a = np.sqrt(radius * np.maximum(depth, 0.0))
    shear_modulus = TRUTH.youngs_modulus / (2 * (1 + TRUTH.poisson_ratio))
    spring = law.spring * 8 * shear_modulus * a / (2 - TRUTH.poisson_ratio)
    steps, found, given = (np.zeros_like(way) for _ in range(3))
    steps[1:] = np.diff(way)
    for k in range(1, len(way)):
        if level[k] <= 0:
            given[:k] = 0.0
            continue
        held, gain = memory[k, :k] @ given[:k], memory[k, k]
        target = -np.sign(steps[k]) * level[k] if steps[k] else held
        ahead = np.clip(held - gain * spring[k] * steps[k], -level[k], level[k])
        # a corner rounded over the last tenth
        is_near = abs(ahead) >= 0.9 * level[k] and ahead * target > 0
        found[k] = 0.97 * ahead + 0.03 * target if is_near else ahead
        given[k] = (found[k] - held) / gain
    return found


def _power_law(t, size):
    """What is left (n, n) at each moment of a change at each moment before."""
    since = t[:, None] - t
    return np.where(since >= 0, 1.0 + size * (1.0 + np.maximum(since, 0.0) / 0.3) ** -0.5, 0.0)


def _late(t, wrench, lag):
    """Two low-passes one after the other."""
    out = wrench.copy()
    for _ in range(2):
        before = out.copy()
        for k in range(1, len(t)):
            fade = np.exp(-(t[k] - t[k - 1]) / (lag / 2))
            out[k] = before[k] + fade * (out[k - 1] - before[k])
    return out


def _sensor(world, wrench, gravity, rng):
    turn = Rotation.from_euler("zyx", world.turn[::-1]).as_matrix()
    force, torque = wrench[:, :3] @ turn.T, wrench[:, 3:] @ turn.T
    force = force @ (np.eye(3) + world.matrix).T + world.mass * gravity
    noise = rng.normal(size=(len(wrench), 6))
    for k in range(1, len(noise)):
        noise[k] = CORRELATION * noise[k - 1] + np.sqrt(1 - CORRELATION**2) * noise[k]
    scale = np.array([FORCE_NOISE] * 3 + [TORQUE_NOISE] * 3)
    return np.column_stack([force, torque]) + noise * scale


PLANTS = {
    "arm_compliance": World(compliance=1.5e-5),
    "relaxation": World(relaxing=0.15),
    "rate_friction": World(rate=0.2),
    "frame_rotation": World(turn=(0.021, -0.012, 0.043)),
    "gain_crosstalk": World(matrix=np.array([[0.0, 0.02, 0.03], [0.02, 0.0, -0.02], [0.03, -0.02, 0.02]])),
    "tool_weight": World(mass=0.04),
    "lag": World(lag=0.08),
    "thickness": World(thinner=0.15),
}


def null(seed, trajectories=40):
    """A world with nothing in it, whose contact is another one."""
    return world_cases(World(), seed, trajectories)
