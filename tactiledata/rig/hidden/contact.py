"""One touch with hidden effects: the plain contact, led where the arm really goes, and what becomes of its forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.analytic import touch_analytic
from tactiledata.rig.contact.closed_form import contact_law, stick_slip
from tactiledata.rig.contact.contact import CONTACT_RATE, PlayTouch, RigContact, TouchSetup, contact_times
from tactiledata.rig.hidden.base import EarlierTouch, HiddenEffect, RealTouch, TouchFacts
from tactiledata.rig.hidden.coulomb_limit import beyond_coulomb
from tactiledata.rig.hidden.history import elastic_work
from tactiledata.rig.hidden.slider import areas_of, slide
from tactiledata.rig.motion.motion import Path

ANALYTIC_ROUNDS, OTHER_ROUNDS = 8, 3
"""How often force and yielding are brought together: in closed form, then in the contact that is asked for."""


@dataclass(frozen=True)
class HiddenContact:
    """See `RigContact`; ``inner`` is the contact without what became of its forces.

    Parameters
    ----------
    unbalanced : m
        Greatest difference between what the arm yields and what its forces ask for.
    """

    inner: RigContact
    wrench: RealArray
    slipping: NDArray[np.bool_]
    unbalanced: float

    @property
    def path(self) -> Path:
        """See `RigContact.path`."""
        return self.inner.path

    @property
    def deviation(self) -> RealArray | None:
        """See `RigContact.missed`."""
        return self.inner.deviation

    @property
    def unsettled(self) -> int:
        """See `RigContact.unsettled`."""
        return self.inner.unsettled

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """See `RigContact.surface`."""
        return self.inner.surface(seconds)


def touch_hidden(
    setup: TouchSetup, facts: TouchFacts, effects: Sequence[HiddenEffect], play: PlayTouch
) -> tuple[TouchSetup, HiddenContact, EarlierTouch]:
    """The touch as it really is, what the gel does, and what is left of it for later touches."""
    for effect in effects:
        setup = effect.prepared(setup, facts)
    plain = play(setup, None, None)
    touch = _EffectsOnTouch(setup, facts, effects, plain.path)
    found = touch.yielding(plain, play)
    real_touch = touch.real_touch(found.inner)
    earlier = EarlierTouch(facts.touch.position, facts.seconds, float(elastic_work(real_touch).max()))
    return setup, found, earlier


class _EffectsOnTouch:
    def __init__(self, setup: TouchSetup, facts: TouchFacts, effects: Sequence[HiddenEffect], path: Path) -> None:
        self._setup, self._facts, self._effects, self._path = setup, facts, effects, path
        self._law = contact_law(setup.indenter, setup.footprint, setup.thickness, setup.material)

    def real_touch(self, contact: RigContact) -> RealTouch:
        positions = self._path.at(contact_times(self._path)) + self._setup.offset
        if contact.deviation is not None:
            positions = positions + contact.deviation
        return RealTouch(self._facts, self._setup, self._law, self._path, positions)

    def yielding(self, plain: RigContact, play: PlayTouch) -> HiddenContact:
        """The contact where forces and what yields to them agree."""
        args = (self._path, self._setup, self._facts)
        shifts = [shift for effect in self._effects if (shift := effect.shift(*args)) is not None]
        gives = [give for effect in self._effects if (give := effect.compliance(*args)) is not None]
        if not shifts and not gives:
            return self._changed(plain)
        fixed: RealArray = sum(shifts, np.zeros((len(contact_times(self._path)), 3)))
        if not gives:
            return self._changed(play(self._setup, self._path, fixed))
        give, given = np.sum(gives, axis=0), np.zeros_like(fixed)
        rounds = [_analytic] * ANALYTIC_ROUNDS + [play] * (OTHER_ROUNDS if play is not _analytic else 0)
        for one in rounds:
            found = self._changed(one(self._setup, self._path, fixed + given))
            missing = _as_miss(found.wrench[:, :3] @ give.T) - given
            given = given + self._damped(missing, give, found)
        return HiddenContact(found.inner, found.wrench, found.slipping, float(np.abs(missing).max()))

    def _damped(self, missing: RealArray, give: RealArray, found: HiddenContact) -> RealArray:
        """Newton's step (n, 3) with the stiffness of the closed forms."""
        real_touch = self.real_touch(found.inner)
        normal = np.interp(real_touch.depth, self._law.depth, np.gradient(self._law.force, self._law.depth))
        sideways = np.interp(real_touch.depth, self._law.depth, self._law.stiffness) * ~found.slipping
        touching = real_touch.positions[:, 2] > 0
        stiffness = np.stack([sideways, sideways, normal], axis=1) * touching[:, None]
        return missing / (1 + stiffness * np.diag(give))

    def _changed(self, contact: RigContact) -> HiddenContact:
        """The contact's forces, changed by every effect in turn."""
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
        pull, slipping = self._pull(real_touch, pull_before, contact.slipping, (before, plain), (normal, stiff))
        if normal is before and pull is pull_before:
            return HiddenContact(contact, contact.wrench, contact.slipping, 0.0)
        return HiddenContact(contact, self._wrench(real_touch, contact.wrench, normal, pull), slipping, 0.0)

    def _pull(
        self,
        real_touch: RealTouch,
        pull: RealArray,
        slipping: NDArray[np.bool_],
        before: tuple[RealArray, RealArray],
        after: tuple[RealArray, RealArray],
    ) -> tuple[RealArray, NDArray[np.bool_]]:
        """Pull (n, 2) and slipping (n,): the contact's own, plus what sliders on springs say that effects change."""
        factors = [factor for effect in self._effects if (factor := effect.friction(real_touch)) is not None]
        spread = max((effect.spread() for effect in self._effects), default=0.0)
        memories = [memory for effect in self._effects if (memory := effect.memory(real_touch)) is not None]
        same = all(new is old for new, old in zip(after, before, strict=True))
        if same and not factors and not spread and not memories:
            return pull, slipping
        coefficient = self._setup.material.friction
        path, areas = real_touch.positions[:, :2], areas_of(real_touch.radius)
        plain = stick_slip(path, before[0], before[1], coefficient)[0]
        memory = np.prod(memories, axis=0) if memories else None
        changed, limit, slipping = slide(path, *after, areas, coefficient, CONTACT_RATE, factors, spread, memory)
        out: RealArray = pull + (changed - plain)
        limit = limit * beyond_coulomb(pull, coefficient * before[0])
        size = np.linalg.norm(out, axis=1)
        over = size > limit
        out[over] *= (limit[over] / size[over])[:, None]
        return out, slipping

    def _wrench(self, real_touch: RealTouch, wrench: RealArray, normal: RealArray, pull: RealArray) -> RealArray:
        """Forces changed; torques so that each change acts at the centre of pressure of the closed forms."""
        share = np.divide(normal, wrench[:, 2], out=np.zeros_like(normal), where=wrench[:, 2] > 0)[:, None]
        scaled = wrench * share
        force = np.concatenate([-pull, normal[:, None]], axis=1)
        point = self._law.columns_at(real_touch.positions[:, 2])[2]
        point[:, :2] += real_touch.positions[:, :2]
        return np.concatenate([force, scaled[:, 3:] + np.cross(point, force - scaled[:, :3])], axis=1)


def _as_miss(move: RealArray) -> RealArray:
    """Moves (n, 3) along gel x, y, z as x, y, depth."""
    return move * np.array([1.0, 1.0, -1.0])


def _analytic(setup: TouchSetup, path: Path | None, deviation: RealArray | None) -> RigContact:
    return touch_analytic(setup, path, deviation)


analytic: PlayTouch = _analytic


def hidden_entries(effects: Sequence[HiddenEffect]) -> list[dict[str, Any]]:
    """What the truth says of hidden effects."""
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
