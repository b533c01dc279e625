"""Hidden adhesion: the edge of the contact advances at one energy and recedes at another (JKR), pinned in between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.closed_form import punch_stiffness
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, RealTouch

FINE = 6001
"""Number of discrete states of the contact's edge: every half micrometre of depth."""


@dataclass(frozen=True)
class HiddenPinnedEdge(HiddenEffect):
    """The contact's edge is pinned by adhesion: a contact of radius a persists at depths d below its balance d(a).

    It acts like a punch of radius a that is pulled back, F = F(a) - S(a) [d(a) - d], and releases the energy
    G = [d(a) - d]² S'(a) / (4 pi a) per area at its edge. The contact grows while G < ``advancing`` and shrinks while
    G > ``receding``; F(a) and S(a) are those of the rig's closed forms. A ball on a thick layer pulls off at about
    1.5 pi W R, a flat punch at sqrt(8 pi E* W a³). Once the contact was sheared, both energies fall to 15 %.

    Parameters
    ----------
    advancing, receding : J/m²
        Energies per area at which the edge advances and recedes.
    """

    NUMBER: ClassVar[str] = "6"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = (
        "K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. A 324 (1971), by D. Maugis' balance"
    )
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"advancing": 0.02, "receding": 0.1},
        "medium": {"advancing": 0.05, "receding": 0.3},
        "strong": {"advancing": 0.1, "receding": 1.0},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"advancing": (0.0, 10.0), "receding": (0.0, 10.0)}
    advancing: float = 0.0
    receding: float = 0.0

    LEFT_AFTER_SHEAR: ClassVar[float] = 0.15
    """Share of both energies that is left after shear."""
    SHEARED: ClassVar[float] = 5e-5
    """Travel along the gel, m, from which on a contact counts as sheared."""

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, with the pull of adhesion."""
        # for each state of the edge: radius, stiffness S and the factor of the energy release
        depth = np.linspace(0.0, real_touch.law.depth[-1], FINE)
        radius = np.maximum(np.interp(depth, real_touch.law.depth, real_touch.law.radius), 1e-6)
        thickness, material = real_touch.setup.thickness, real_touch.setup.material
        stiffness = punch_stiffness(radius, thickness, material)
        slope = (
            punch_stiffness(radius * 1.001, thickness, material) - punch_stiffness(radius * 0.999, thickness, material)
        ) / (0.002 * radius)
        release = slope / (4 * np.pi * radius)
        # the state of the edge at each moment
        border = _border(real_touch.positions[:, 2], depth, release, self._energies(real_touch))
        held = border >= 0
        out = force.copy()
        at = border[held]
        sunk = real_touch.positions[held, 2]
        # only what adhesion adds: the force itself may be the layer solver's
        plain = np.interp(np.maximum(sunk, 0.0), real_touch.law.depth, real_touch.law.force)
        sticky = np.interp(depth[at], real_touch.law.depth, real_touch.law.force) - stiffness[at] * (depth[at] - sunk)
        out[held] += sticky - plain
        return out

    def _energies(self, real_touch: RealTouch) -> RealArray:
        """Return the advancing and the receding energy (n, 2), J/m², at each moment."""
        sideways = np.linalg.norm(
            np.diff(real_touch.positions[:, :2], axis=0, prepend=real_touch.positions[:1, :2]), axis=1
        )
        sheared = np.cumsum(np.where(real_touch.positions[:, 2] > 0, sideways, 0.0)) > self.SHEARED
        factor = np.where(sheared, self.LEFT_AFTER_SHEAR, 1.0)
        return factor[:, None] * np.array([self.advancing, self.receding])


def _border(sunk: RealArray, depth: RealArray, release: RealArray, energies: RealArray) -> RealArray:
    """Return the index (n,) of the edge's state at each moment; -1 without contact.

    Parameters
    ----------
    sunk : (n,), m
        Depth of the indenter, below 0 above the gel.
    depth, release : (k,), m and N/m³
        For each state: the depth at which it is in balance, and the factor of (d(a) - d)² in the energy release.
    energies : (n, 2), J/m²
        Advancing and receding energy at each moment.
    """
    out = np.full(len(sunk), -1)
    state, last = -1, len(depth) - 1
    for moment, here in enumerate(sunk.tolist()):
        advancing, receding = energies[moment]
        if state < 0 and here < 0:
            continue
        state = max(state, int(np.searchsorted(depth, here)), 0)
        while state < last and (depth[state + 1] - here) ** 2 * release[state + 1] < advancing:
            state += 1
        while state >= 0 and depth[state] > here and (depth[state] - here) ** 2 * release[state] > receding:
            state -= 1
        # a point contact that does not pull is no contact
        if state < 0 or (here < 0 and state == 0 and depth[state] - here > 0 and receding == 0):
            state = -1
        out[moment] = min(state, last)
    return out
