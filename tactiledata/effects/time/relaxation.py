"""The gel relaxes: linear viscoelasticity."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.relaxing_shear import relaxing_shear
from tactiledata.effects.touch.state import TouchState, wrench_at
from tactiledata.effects.touch.time_operators import fading_memory


class Relaxation(Effect):
    """One term of a Prony series: F(t) = F_e(t) + share * integral of exp(-(t - s) / time) dF_e(s).

    F_e is the answer of the fully relaxed gel, whose modulus is that of the simulation; ``share`` is E_i over it. Set
    the effect several times for a spectrum. Where the sum would pull, a gel without adhesion has parted: the wrench is
    0. Coulomb's law holds at each moment: while the contact slides, its shear is in proportion to the normal force of
    that moment; when it stops sliding, it relaxes from there (`relaxing_shear`).

    Source: Lakes, Viscoelastic Materials, ch. 2; contact at one depth history, Lee and Radok, J. Appl. Mech. 27, 1960.
    """

    name = "relaxation"
    title = "viscoelastic relaxation"
    slot = "time"
    parameters = (
        strength(
            "share", "1", "modulus that relaxes, over the relaxed modulus",
            bounds=(0.0, 1.0), plausible=(0.0, 0.3), deviation=0.06,
            source="0.02 to 0.15 a term, PDMS and Ecoflex; one term may stand for two",
        ),
        shape(
            "time", "s", "time constant",
            default=3.0, bounds=(0.02, 300.0), grid=(0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0), source="0.1 to 60 s",
        ),
    )  # fmt: skip
    look_alikes = ("lag", "mullins", "heating", "clock_skew")
    distinguishing_trial = (
        "A dwell of 60 s at one depth: force falls at zero motion; a lag does not, and ends within a second."
    )
    unlisted_look_alike = (
        "water that drains out of the gel, or a relaxation that is faster in a warm gel. Dwells of half a minute under"
        " a small and under a large contact, without a slide, on a cold and on a warm sensor, tell them apart"
    )
    detectability = "share 0.1: 0.5 N at 5 N in the first dwell second; E and mu hide 50 to 84 % of its variance."
    reference = "Lakes, Viscoelastic Materials"

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"E": "the gel once relaxed"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        wrench = state.wrench
        slow = wrench + values["share"] * fading_memory(state.touch.seconds, wrench, values["time"])
        slow = slow + _shear_as_it_slides(wrench, slow, state, values["share"], values["time"])
        parted = ~state.contact.touching | ((slow[:, 2] <= 0) & (state.contact.wrench[:, 2] > 0))
        return state.with_reading(np.where(parted[:, None] & np.isfinite(slow), _at_rest(wrench, state), slow))


def _shear_as_it_slides(wrench: Array, slow: Array, state: TouchState, share: float, time: float) -> Array:
    """Wrench (n, 6) to add so that the shear of a sliding contact follows its normal force, and relaxes at rest.

    Parameters
    ----------
    wrench : (n, 6) N, N m
        Answer of the fully relaxed gel.
    slow : (n, 6) N, N m
        The same after relaxation, component by component.
    state : TouchState
        State before the effect.
    share, time : float
        Parameters of the effect.
    """
    # shear of friction and its limit, both by the normal force after relaxation
    known = np.isfinite(slow).all(axis=1)
    grown = np.divide(slow[:, 2], wrench[:, 2], out=np.ones(len(slow)), where=wrench[:, 2] > 0)
    sliding = wrench[:, :2] * np.maximum(grown, 0.0)[:, None]
    friction = state.touch.material.friction * state.friction * slow[:, 2]
    limit = np.where(slow[:, 2] > 0, np.maximum(friction, np.hypot(*sliding.T)), 0.0)
    # the shear of a contact that sticks, slides and relaxes, in frames that were solved
    elastic, slides = wrench[known, :2], state.contact.sliding[known]
    shear = relaxing_shear(state.touch.seconds[known], elastic, slides, sliding[known], limit[known], share, time)
    more = np.zeros((len(slow), 3))
    more[known, :2] = shear - slow[known, :2]
    return wrench_at(more, np.nan_to_num(state.contact.centre))


def _at_rest(wrench: Array, state: TouchState) -> Array:
    """Wrench (n, 6) of a gel that has parted: that of free air, which is 0 except for an adhesive pull."""
    return np.where(state.contact.touching[:, None], 0.0, wrench)
