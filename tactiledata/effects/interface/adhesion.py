"""The gel pulls at an indenter that leaves."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.response import ContactResponse
from tactiledata.effects.touch.state import TouchState, wrench_at
from tactiledata.indenters.base import Indenter

AFTER_SHEAR = 0.12
"""Share of the work of adhesion that is left once the contact has slid."""
NEWTON_STEPS = 60
"""Iterations for the contact radius: enough for double precision from any start above the root."""


def jkr_force(depth: Array, radius: float, modulus: float, work: Array) -> Array:
    """Force (n,), N, on a ball by Johnson, Kendall and Roberts; 0 where the contact has parted.

    F = 4 E* a^3 / (3 R) - sqrt(8 pi W E* a^3) at the larger a of depth = a^2 / R - sqrt(2 pi W a / E*).

    Parameters
    ----------
    depth : (n,) m
        Depths of the tip below the undeformed surface; negative above it.
    radius : float
        Radius R of the ball, m.
    modulus : float
        E* = E / (1 - nu^2), Pa.
    work : (n,) J/m^2
        Work of adhesion W.
    """
    pull = np.sqrt(2.0 * np.pi * work / modulus)
    # in x = sqrt(a) the depth is a convex quartic: from above its least value, Newton's steps fall onto the larger root
    least = np.cbrt(radius * pull / 4.0)
    holds = least**4 / radius - pull * least <= depth
    x = 2.0 * np.sqrt(np.sqrt(radius * np.maximum(depth, 0.0))) + 4.0 * least
    for _ in range(NEWTON_STEPS):
        slope = 4.0 * x**3 / radius - pull
        miss = x**4 / radius - pull * x - depth
        x = np.where(slope > 0, x - np.divide(miss, slope, out=np.zeros_like(x), where=slope > 0), x)
        x = np.maximum(x, least)
    cube = x**6
    force = 4.0 * modulus * cube / (3.0 * radius) - np.sqrt(8.0 * np.pi * work * modulus * cube)
    return np.where(holds, force, 0.0)


def punch_force(depth: Array, radius: float, modulus: float, work: Array) -> Array:
    """Force (n,), N, of adhesion on a flat punch, at most 0; 0 where it has parted, and where it presses.

    F = 2 E* a depth, down to Kendall's -sqrt(8 pi E* W a^3).

    Parameters
    ----------
    depth : (n,) m
        Depths of the punch below the undeformed surface; it pulls where they are negative.
    radius : float
        Radius a of the punch, m.
    modulus : float
        E* = E / (1 - nu^2), Pa.
    work : (n,) J/m^2
        Work of adhesion W.
    """
    force = 2.0 * modulus * radius * np.minimum(depth, 0.0)
    return np.where(force >= -np.sqrt(8.0 * np.pi * modulus * work * radius**3), force, 0.0)


def tip_radius(indenter: Indenter, reach: float) -> float:
    """Radius of curvature, m, of a tip over a circle of radius ``reach``, m; infinite where it is flat."""
    angle = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    height = indenter.height(reach * np.cos(angle), reach * np.sin(angle))
    height = height[np.isfinite(height)]
    mean = float(height.mean()) if len(height) else 0.0
    return reach**2 / (2.0 * mean) if mean > 1e-9 * reach else np.inf


class Adhesion(Effect):
    """A pull on an indenter that leaves: from the deepest frame on, ``work`` is spent on new surface.

    From there on the contact keeps its area, and the force falls along the line of a flat punch until it meets the
    curve of Johnson, Kendall and Roberts (`jkr_force`), which ends near -1.5 pi W R. A flat tip follows `punch_force`
    down to -sqrt(8 pi E* W a^3). Once the contact has slid, 12 % of the work is left. After parting there is no pull
    until the touch ends.

    Source: Johnson, Kendall and Roberts, Proc. R. Soc. A 324, 1971; Kendall, J. Phys. D 4, 1971; loss by shear, arXiv
    2310.13708.
    """

    name = "adhesion"
    title = "adhesion on leaving (JKR)"
    slot = "interface"
    parameters = (
        strength(
            "work", "J/m^2", "work of adhesion while the contact shrinks",
            bounds=(0.0, 10.0), plausible=(0.0, 2.0), deviation=0.4, source="PDMS on glass, receding: 0.1 to 1 J/m^2",
        ),
    )  # fmt: skip
    look_alikes = ("mullins", "relaxation", "lag")
    distinguishing_trial = (
        "Leave slowly from a flat punch, without shear and after it: only adhesion pulls, and shear ends it."
    )
    detectability = (
        "A clean ball pulls 1 to 20 mN, which 0.1 N hides; a flat punch of 3 mm radius 0.3 to 0.6 N or more."
    )
    reference = "Johnson, Kendall and Roberts, Proc. R. Soc. A 324, 1971"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        contact = state.contact
        depth = np.where(np.isfinite(contact.depth), contact.depth, -np.inf)
        if not contact.touching.any():
            return state
        # frames after the deepest one, and the work of adhesion that is left in them
        deepest = np.maximum.accumulate(np.where(contact.touching, depth, -np.inf))
        leaves = np.isfinite(deepest) & np.isfinite(depth) & (depth < deepest)
        slid = np.maximum.accumulate(contact.sliding & contact.touching)
        work = values["work"] * np.where(slid, AFTER_SHEAR, 1.0)
        pull = np.zeros(len(depth))
        pull[leaves] = self._pull(state, contact, depth[leaves], deepest[leaves], work[leaves])
        # a contact that has parted does not pull again
        parted = np.maximum.accumulate(leaves & (depth < 0) & (pull == 0.0))
        force = np.zeros((len(depth), 3))
        force[:, 2] = np.where(parted, 0.0, pull)
        return state.with_interface(wrench_at(force, np.nan_to_num(contact.centre)))

    @staticmethod
    def _pull(state: TouchState, contact: ContactResponse, depth: Array, deepest: Array, work: Array) -> Array:
        """Normal force (m,), N, at most 0, that adhesion adds in frames in which the indenter leaves."""
        material = state.touch.material
        modulus = material.youngs_modulus / (1.0 - material.poisson_ratio**2)
        widest = float(contact.radius.max())
        radius = tip_radius(state.touch.indenter, 0.1 * widest)
        if np.isinf(radius):
            return punch_force(depth, widest, modulus, work)

        def hertz(at: Array) -> Array:
            """Force, N, of the ball without adhesion at depths, m."""
            return 4.0 / 3.0 * modulus * np.sqrt(radius) * np.maximum(at, 0.0) ** 1.5

        kept = hertz(deepest) - 2.0 * modulus * np.sqrt(radius * deepest) * (deepest - depth)
        return np.minimum(np.maximum(kept, jkr_force(depth, radius, modulus, work)) - hertz(depth), 0.0)
