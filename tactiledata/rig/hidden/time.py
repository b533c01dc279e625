"""Hidden relaxation: a power law without a time constant, and the drainage of a poroelastic gel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import fftconvolve

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.contact import CONTACT_RATE
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, RealTouch
from tactiledata.rig.hidden.history import warmth

Kernel = Callable[[RealArray], RealArray]
"""Function that gives the relaxation modulus (n,), relative to the instantaneous one, at seconds (n,)."""


def relaxed(force: RealArray, kernel: Kernel) -> RealArray:
    """Return relaxed forces (n, ...), by Boltzmann's superposition of instantaneous ones at ``CONTACT_RATE``."""
    weights = kernel(np.arange(len(force)) / CONTACT_RATE)
    steps = np.diff(force, axis=0, prepend=np.zeros_like(force[:1]))
    shape = (len(weights),) + (1,) * (force.ndim - 1)
    answer: RealArray = fftconvolve(steps, weights.reshape(shape), axes=0)[: len(force)]
    return answer


@dataclass(frozen=True)
class HiddenSpringpot(HiddenEffect):
    """The gel relaxes by a power law: every change of force decays as (1 + t / onset)^-alpha.

    The surface does not pull an indenter that leaves it: the force stays at or above 0.

    Parameters
    ----------
    alpha : float
        Exponent.
    onset : s
        Time at which the decay begins.
    """

    NUMBER: ClassVar[str] = "1"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "springpot, regularised at short times: e.g. F. Mainardi, Fractional Calculus (2010), ch. 3"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"alpha": 0.02},
        "medium": {"alpha": 0.045},
        "strong": {"alpha": 0.08},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"alpha": (0.0, 0.5), "onset": (1e-4, 10.0)}
    alpha: float = 0.0
    onset: float = 0.02

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the relaxed normal force (n,), N."""
        return _pressing(relaxed(force, self._kernel(real_touch)), force)

    def memory(self, real_touch: RealTouch) -> RealArray:
        """Return the share (n,) of a tangential pull that is left k samples later."""
        return self._kernel(real_touch)(np.arange(len(real_touch.positions)) / CONTACT_RATE)

    def _kernel(self, real_touch: RealTouch) -> Kernel:
        """Return the relaxation function of a touch."""
        exponent = self._exponent(real_touch)
        return lambda seconds: (1 + seconds / self.onset) ** -exponent

    def _exponent(self, real_touch: RealTouch) -> float:
        """Return the exponent of a touch."""
        return self.alpha


@dataclass(frozen=True)
class HiddenWarmSpringpot(HiddenSpringpot):
    """The gel relaxes by a power law, faster when warm: its exponent is alpha (1 + per_kelvin T).

    The warming T since power-on is 12 K in the end.

    Parameters
    ----------
    per_kelvin : 1/K
        Relative rise of the exponent per kelvin.
    """

    NUMBER: ClassVar[str] = "outside"
    SOURCE: ClassVar[str] = "springpot with a linear temperature coefficient, assumed"
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {**HiddenSpringpot.RANGES, "per_kelvin": (-0.05, 1.0)}
    per_kelvin: float = 0.1

    def _exponent(self, real_touch: RealTouch) -> float:
        return self.alpha * (1 + self.per_kelvin * warmth(real_touch.facts.seconds_on, 12.0))


@dataclass(frozen=True)
class HiddenDrainage(HiddenEffect):
    """Fluid drains from under the contact, so that a share p of each change of force decays.

    It decays as 0.491 exp(-0.908 sqrt x) + 0.509 exp(-1.679 x), x = D t / a², with a the largest radius of the contact
    in the touch: larger contacts drain slower.

    Parameters
    ----------
    share : float
        The share p.
    diffusivity : m²/s
        The diffusivity D of the fluid.
    """

    NUMBER: ClassVar[str] = "outside"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "Y. Hu, X. Zhao, J. J. Vlassak, Z. Suo, Appl. Phys. Lett. 96 (2010), sphere"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"share": 0.05},
        "medium": {"share": 0.10},
        "strong": {"share": 0.20},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"share": (0.0, 0.9), "diffusivity": (1e-9, 1e-3)}
    share: float = 0.0
    diffusivity: float = 2e-6

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, of the draining gel."""
        widest = float(real_touch.radius.max())
        if widest == 0:
            return force

        def kernel(seconds: RealArray) -> RealArray:
            x = self.diffusivity * seconds / widest**2
            left = 0.491 * np.exp(-0.908 * np.sqrt(x)) + 0.509 * np.exp(-1.679 * x)
            return 1 - self.share * (1 - left)

        return _pressing(relaxed(force, kernel), force)


def _pressing(force: RealArray, instant: RealArray) -> RealArray:
    """Return forces (n,), N, at least 0, and 0 where the instantaneous force is not positive."""
    return np.where(instant > 0, np.maximum(force, 0.0), 0.0)
