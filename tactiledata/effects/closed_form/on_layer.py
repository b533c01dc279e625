"""Base of the closed forms of a contact on a bonded layer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.touch.response import ContactResponse, GelVariant
from tactiledata.effects.touch.touch import Touch


@dataclass(frozen=True)
class OnLayer(ABC):
    """A `BaseResponse` in closed form, which needs no design points: it answers for any variant of the gel.

    Parameters
    ----------
    touch : Touch
        The touch; its indenter has a ``radius``.
    """

    touch: Touch

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """Return the answer of the nominal gel where the indenter is elsewhere than recorded, or friction is another.

        Parameters
        ----------
        offset, shift, friction : arrays
            As in `BaseResponse.respond`.
        """
        return self._respond(offset, shift, friction, GelVariant())

    def difference(self, variant: GelVariant) -> Array:
        """Wrench (n, 6), N and N m, of the recorded touch with a variant of the gel, less that with the nominal gel."""
        return self._recorded(variant) - self._nominal

    @cached_property
    def _nominal(self) -> Array:
        """Wrench (n, 6), N and N m, of the recorded touch with the nominal gel."""
        return self._recorded(GelVariant())

    def _recorded(self, variant: GelVariant) -> Array:
        """Return the wrench (n, 6), N and N m, of the recorded touch with a variant of the gel."""
        n = len(self.touch)
        return self._respond(np.zeros(n), np.zeros((n, 2)), np.ones(n), variant).wrench

    @abstractmethod
    def _respond(self, offset: Array, shift: Array, friction: Array, gel: GelVariant) -> ContactResponse:
        """Return the answer of a variant of the gel to the touch with an offset, a shift and another friction."""
