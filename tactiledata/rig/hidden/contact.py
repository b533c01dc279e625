"""One touch with hidden effects: the plain contact where the arm really goes, and its forces changed by the effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.analytic import touch_analytic
from tactiledata.rig.contact.closed_form import contact_law
from tactiledata.rig.contact.contact import PlayTouch, RigContact, TouchSetup, contact_times
from tactiledata.rig.hidden.base import EarlierTouch, HiddenEffect, RealTouch, TouchFacts
from tactiledata.rig.hidden.history import elastic_work
from tactiledata.rig.hidden.pull import SolvedPull
from tactiledata.rig.hidden.slider import Loaded, SlidingLaws, areas_of
from tactiledata.rig.motion.motion import Path

ANALYTIC_ROUNDS, OTHER_ROUNDS = 8, 3
"""Rounds in which force and compliance are made to agree: by closed forms, then by the scenario's form of contact."""


@dataclass(frozen=True)
class HiddenContact:
    """A `RigContact` whose forces are changed by hidden effects.

    Parameters
    ----------
    inner : RigContact
        The contact along the real path, before effects change its forces.
    wrench : (n, 6), N, N m
        The changed wrench on the indenter, gel frame.
    slipping : (n,) bool
        Whether all that touches slides.
    unbalanced : m
        Largest difference between the arm's deflection and that which its compliance gives for the forces.
    """

    inner: RigContact
    wrench: RealArray
    slipping: NDArray[np.bool_]
    unbalanced: float

    @property
    def path(self) -> Path:
        """Commanded path of the indenter over the gel."""
        return self.inner.path

    @property
    def deviation(self) -> RealArray | None:
        """Error of the arm that adds to path and offset, (n, 3), m, at ``CONTACT_RATE``: x, y, depth."""
        return self.inner.deviation

    @property
    def unsettled(self) -> int:
        """Number of the solver's steps that did not converge."""
        return self.inner.unsettled

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Return the height (n_y, n_x), m, of the gel's surface at seconds from the start."""
        return self.inner.surface(seconds)


def touch_hidden(
    setup: TouchSetup, facts: TouchFacts, effects: Sequence[HiddenEffect], play: PlayTouch
) -> tuple[TouchSetup, HiddenContact, EarlierTouch]:
    """Play a touch with hidden effects: return its real setup, its contact, and the record of it for later touches.

    Parameters
    ----------
    setup : TouchSetup
        The touch as the scenario states it.
    facts : TouchFacts
        Time, mounting and earlier touches.
    effects : sequence of HiddenEffect
        Effects, in the order in which they act.
    play : callable
        Plays a touch without effects: the scenario's form of contact.
    """
    for effect in effects:
        setup = effect.prepared(setup, facts)
    touch = _EffectsOnTouch(setup, facts, effects, play)
    contact = touch.balanced()
    real_touch = touch.real_touch(contact.inner)
    earlier = EarlierTouch(facts.touch.position, facts.seconds, float(elastic_work(real_touch).max()))
    return setup, contact, earlier


class _EffectsOnTouch:
    """The hidden effects on one touch, along the path of the contact without them."""

    def __init__(self, setup: TouchSetup, facts: TouchFacts, effects: Sequence[HiddenEffect], play: PlayTouch) -> None:
        self._setup, self._facts, self._effects, self._play = setup, facts, effects, play
        self._plain = play(setup, None, None)
        self._path = self._plain.path
        self._law = contact_law(setup.indenter, setup.footprint, setup.thickness, setup.material)

    @cached_property
    def _solved_pull(self) -> SolvedPull:
        """The pull along the gel without effects, at several frictions, along the path as commanded."""
        setup, positions = self._setup, self._path.at(contact_times(self._path))

        def solve(friction: float) -> RealArray:
            material = replace(setup.material, friction=friction)
            return self._play(replace(setup, material=material, offset=np.zeros(3)), self._path, None).wrench

        stiffness = self._law.columns_at(positions[:, 2])[1]
        return SolvedPull(positions, stiffness, setup.material.friction, solve)

    def real_touch(self, contact: RigContact) -> RealTouch:
        """Return the touch at the real positions of a contact."""
        positions = self._path.at(contact_times(self._path)) + self._setup.offset
        if contact.deviation is not None:
            positions = positions + contact.deviation
        return RealTouch(self._facts, self._setup, self._law, self._path, positions)

    def balanced(self) -> HiddenContact:
        """Return the contact whose forces agree with the deflections by compliance that they cause."""
        # deviations that do not depend on forces, and compliances
        args = (self._path, self._setup, self._facts)
        shifts = [shift for effect in self._effects if (shift := effect.shift(*args)) is not None]
        compliances = [matrix for effect in self._effects if (matrix := effect.compliance(*args)) is not None]
        if not shifts and not compliances:
            return self._changed(self._plain)
        fixed: RealArray = sum(shifts, np.zeros((len(contact_times(self._path)), 3)))
        if not compliances:
            return self._changed(self._play(self._setup, self._path, fixed))
        # closed forms come near the balance in little time, the scenario's form of contact ends it
        compliance, deflection = np.sum(compliances, axis=0), np.zeros_like(fixed)
        rounds = [_analytic] * ANALYTIC_ROUNDS + [self._play] * (OTHER_ROUNDS if self._play is not _analytic else 0)
        for play in rounds:
            contact = self._changed(play(self._setup, self._path, fixed + deflection))
            missing = _as_deviation(contact.wrench[:, :3] @ compliance.T) - deflection
            deflection = deflection + self._damped(missing, compliance, contact)
        return HiddenContact(contact.inner, contact.wrench, contact.slipping, float(np.abs(missing).max()))

    def _damped(self, missing: RealArray, compliance: RealArray, contact: HiddenContact) -> RealArray:
        """Return Newton's step (n, 3), m, for a missing deflection, with the stiffness of the closed forms."""
        real_touch = self.real_touch(contact.inner)
        normal = np.interp(real_touch.depth, self._law.depth, np.gradient(self._law.force, self._law.depth))
        sideways = np.interp(real_touch.depth, self._law.depth, self._law.stiffness) * ~contact.slipping
        touching = real_touch.positions[:, 2] > 0
        stiffness = np.stack([sideways, sideways, normal], axis=1) * touching[:, None]
        return missing / (1 + stiffness * np.diag(compliance))

    def _changed(self, contact: RigContact) -> HiddenContact:
        """Return a contact whose forces every effect has changed in turn."""
        real_touch = self.real_touch(contact)
        before, pull_before = contact.wrench[:, 2], -contact.wrench[:, :2]
        normal = before
        plain: RealArray = np.interp(real_touch.depth, self._law.depth, self._law.stiffness)
        stiff = plain
        for effect in self._effects:
            force = effect.normal(normal, real_touch)
            if effect.STIFFENS:
                stiff = stiff * np.divide(force, normal, out=np.ones_like(force), where=normal > 0)
            normal = force
            stiff = effect.tangential_stiffness(stiff, real_touch)
        loads = Loaded(before, plain), Loaded(normal, stiff)
        pull, slipping = self._pull(real_touch, pull_before, contact.slipping, *loads)
        if normal is before and pull is pull_before:
            return HiddenContact(contact, contact.wrench, contact.slipping, 0.0)
        return HiddenContact(contact, self._wrench(real_touch, contact.wrench, normal, pull), slipping, 0.0)

    def _pull(
        self, real_touch: RealTouch, pull: RealArray, slipping: NDArray[np.bool_], before: Loaded, after: Loaded
    ) -> tuple[RealArray, NDArray[np.bool_]]:
        """Return pull (n, 2), N, and sliding (n,) with the effects, from those of the contact itself."""
        factors = [factor for effect in self._effects if (factor := effect.friction(real_touch)) is not None]
        spread = max((effect.spread() for effect in self._effects), default=0.0)
        memories = [memory for effect in self._effects if (memory := effect.memory(real_touch)) is not None]
        same = all(new is old for new, old in zip(after, before, strict=True))
        if same and not factors and not spread and not memories:
            return pull, slipping
        laws = SlidingLaws(factors, [spread], np.prod(memories, axis=0) if memories else None)
        path, areas = real_touch.positions[:, :2], areas_of(real_touch.radius)
        return self._solved_pull.changed(path, areas, pull, before, after, laws)

    def _wrench(self, real_touch: RealTouch, wrench: RealArray, normal: RealArray, pull: RealArray) -> RealArray:
        """Return the wrench (n, 6) with changed forces; each change acts at the closed forms' centre of pressure."""
        share = np.divide(normal, wrench[:, 2], out=np.zeros_like(normal), where=wrench[:, 2] > 0)[:, None]
        scaled = wrench * share
        force = np.concatenate([-pull, normal[:, None]], axis=1)
        point = self._law.columns_at(real_touch.positions[:, 2])[2]
        point[:, :2] += real_touch.positions[:, :2]
        return np.concatenate([force, scaled[:, 3:] + np.cross(point, force - scaled[:, :3])], axis=1)


def _as_deviation(move: RealArray) -> RealArray:
    """Return moves (n, 3), m, along gel x, y, z as moves along x, y, depth."""
    return move * np.array([1.0, 1.0, -1.0])


def _analytic(setup: TouchSetup, path: Path | None, deviation: RealArray | None) -> RigContact:
    """Play a touch by closed forms; one function object, by which the balance knows this form of contact."""
    return touch_analytic(setup, path, deviation)


analytic: PlayTouch = _analytic
"""The closed forms as a form of contact."""


def hidden_entries(effects: Sequence[HiddenEffect]) -> list[dict[str, Any]]:
    """Return the entries of hidden effects in a log's truth: name, number, place of action and parameters."""
    from dataclasses import asdict

    from tactiledata.rig.hidden.effects import name_of

    return [
        {
            "effect": name_of(effect),
            "number": effect.NUMBER,
            "acts": effect.ACTS,
            "parameters": asdict(effect),  # type: ignore[call-overload]
        }
        for effect in effects
    ]
