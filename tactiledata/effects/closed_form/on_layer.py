"""What closed forms of a contact on a bonded layer have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.touch.response import ContactResponse, GelVariant
from tactiledata.effects.touch.touch import Touch


@dataclass(frozen=True)
class OnLayer(ABC):
    """A `BaseResponse` in closed form, at any variant of the gel.

    Parameters
    ----------
    touch : Touch
        Its indenter has a ``radius``.
    """

    touch: Touch

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """As `BaseResponse.respond`."""
        return self._respond(offset, shift, friction, GelVariant())

    def difference(self, variant: GelVariant) -> Array:
        """As `BaseResponse.difference`."""
        n = len(self.touch)
        asked = np.zeros(n), np.zeros((n, 2)), np.ones(n)
        return self._respond(*asked, variant).wrench - self._respond(*asked, GelVariant()).wrench

    @abstractmethod
    def _respond(self, offset: Array, shift: Array, friction: Array, gel: GelVariant) -> ContactResponse:
        """The touch, elsewhere and with another friction, on a variant of the gel."""
