"""Equilibria of a pad under a rigid body that moves: Newton's method, and smaller moves where it fails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.prove.element_world.pad import Array, BrickPad
from tactiledata.prove.element_world.slices import Factor, Slices
from tactiledata.prove.element_world.surface import Held, Pose, Pressed, SpringSurface

ROUNDS = 14
"""Largest number of corrections in a step."""
TOLERANCE = 2e-3
"""Greatest imbalance of a step, as a share of the contact's force."""
LEAST_FORCE = 2e-3
"""Force over Young's modulus, mm², of which that share is taken at least."""
HALVINGS = 4
"""How often a step is halved before its best answer is taken."""
SMALLEST_VOLUME = 0.15
"""Ratio of a point's volume to that at rest below which a correction is taken in part."""
LONGEST = 0.5
"""Greatest correction of a node, mm."""
PARTS = (1.0, 0.5, 0.25)
"""Parts of a correction that are tried until one is good enough; else the best is taken."""
BETTER = 0.9
"""Fall of the imbalance with which a correction is good enough."""
FAST = 0.25
"""Fall of the imbalance in a correction with which the factors serve once more."""


@dataclass(frozen=True)
class State:
    """An equilibrium of pad and body.

    Parameters
    ----------
    displacements : (n, 3), mm
        Of the nodes.
    held : Held
        What the surface remembers.
    wrench : (6,), mm² and mm³
        Of the gel on the body, about the gel's origin.
    is_slipping : bool
        Whether all that touches slips.
    unsettled : int
        How many steps on the way ended without balance.
    """

    displacements: Array
    held: Held
    wrench: Array
    is_slipping: bool = False
    unsettled: int = 0


class Stepper:
    """Moves a body over a pad, step by step.

    Parameters
    ----------
    pad : BrickPad
        The bricks.
    surface : SpringSurface
        Contact and friction.
    """

    def __init__(self, pad: BrickPad, surface: SpringSurface) -> None:
        self._pad, self._surface, self._slices = pad, surface, Slices(pad)
        self._free = ~pad.is_bonded
        self._last: tuple[Factor, Pressed] | None = None
        self.factored = 0

    def rest(self, pose: Pose) -> State:
        """Return the pad that nothing touches, with a body somewhere above it."""
        self._last = None
        return State(np.zeros_like(self._pad.places), self._surface.at_rest(pose), np.zeros(6))

    def move(self, state: State, pose: Pose, halvings: int = HALVINGS) -> State:
        """Return the equilibrium after a straight move of the body to a pose.

        Parameters
        ----------
        state : State
            Before the move.
        pose : Pose
            After it.
        halvings : int
            How often the move may be halved.
        """
        found, is_settled = self._newton(state, pose)
        if is_settled:
            return found
        if halvings == 0:
            return State(found.displacements, found.held, found.wrench, found.is_slipping, state.unsettled + 1)
        self._last = None
        middle = Pose(pose.body, pose.rotation, 0.5 * (state.held.tip + pose.tip))
        return self.move(self.move(state, middle, halvings - 1), pose, halvings - 1)

    def _newton(self, state: State, pose: Pose) -> tuple[State, bool]:
        """Return the best state that corrections find, and whether it is in balance."""
        u = self._predicted(state, pose)
        factor = None
        pressed, right, size = self._balance(u, pose, state)
        off = float(np.linalg.norm(right)) / size
        for _ in range(ROUNDS):
            if off < TOLERANCE:
                break
            if factor is None:
                factor = self._factor(u, pressed)
            correction, before, tries = factor.solve(right), off, []
            for part in PARTS:
                tried = self._corrected(u, part * correction)
                pressed, right, size = self._balance(tried, pose, state)
                tries.append((float(np.linalg.norm(right)) / size, tried, pressed, right))
                if tries[-1][0] < BETTER * before:
                    break
            off, u, pressed, right = min(tries, key=lambda each: each[0])
            if off > FAST * before and off > TOLERANCE:
                factor = None
            else:
                self._last = (factor, pressed)
        touching = pressed.touching
        slipping = bool(touching.any() and (pressed.slipping | ~touching).all())
        held = Held(pressed.points, pressed.gap, pressed.stretch, pose.tip)
        found = State(u, held, self._surface.wrench(pressed), slipping, state.unsettled)
        return found, off < TOLERANCE

    def _predicted(self, state: State, pose: Pose) -> Array:
        """Return displacements after a move, as the last factors and the last contact tell them."""
        if self._last is None:
            return state.displacements
        factor, pressed = self._last
        move = pose.tip - state.held.tip
        force, _, rows = self._surface.on_bricks(pressed.yields @ move, pressed.yields, with_stiffness=False)
        bricks = np.zeros((len(self._pad.bricks), 8, 3))
        self._add(bricks, force, rows)
        return self._corrected(state.displacements, factor.solve(self._slices.gathered(bricks, self._pad)))

    def _balance(self, u: Array, pose: Pose, state: State) -> tuple[Pressed, Array, float]:
        """Return the contact, what is missing to balance (n,), and the size of the contact's force."""
        pressed = self._surface.press(u, pose, state.held)
        force, _, rows = self._surface.on_bricks(pressed.traction, pressed.yields, with_stiffness=False)
        missing = -self._pad.respond(u, with_stiffness=False).force
        self._add(missing, force, rows)
        return pressed, self._slices.gathered(missing, self._pad), max(float(np.linalg.norm(force)), LEAST_FORCE)

    def _factor(self, u: Array, pressed: Pressed) -> Factor:
        """Return the factors of the stiffness of bricks and contact."""
        stiffness = self._pad.respond(u).stiffness
        _, yields, rows = self._surface.on_bricks(pressed.traction, pressed.yields)
        bricks, corners = self._pad.brick_of_facet[rows], self._pad.corners[rows]
        # a facet has a brick of its own
        stiffness[bricks[:, None, None], corners[:, :, None], :, corners[:, None, :]] += yields.transpose(0, 1, 3, 2, 4)
        self.factored += 1
        return self._slices.factor(stiffness)

    def _add(self, bricks: Array, force: Array, rows: Array) -> None:
        """Add forces (f, 4, 3) on the corners of facets to those of their bricks."""
        at = self._pad.brick_of_facet[rows]
        bricks[at[:, None], self._pad.corners[rows]] += force

    def _corrected(self, u: Array, correction: Array) -> Array:
        """Return displacements after a correction (n,), or after a part of it where it would turn a brick over."""
        move = np.zeros_like(u)
        move[self._free] = correction.reshape(-1, 3)
        largest = float(np.abs(move).max())
        if not np.isfinite(largest):
            return u
        move *= min(1.0, LONGEST / max(largest, 1e-12))
        for _ in range(6):
            if self._pad.smallest_volume(u + move) > SMALLEST_VOLUME:
                break
            move *= 0.5
        return u + move
