"""A simulation that answers for touches that nobody has played: balls and flat punches in closed form."""

from __future__ import annotations

from collections.abc import Callable

from tactiledata.effects.ball_on_layer import BallOnLayer
from tactiledata.effects.punch_on_layer import PunchOnLayer
from tactiledata.effects.response import BaseResponse
from tactiledata.effects.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.material import GelMaterial

SHAPES: dict[str, Callable[[Touch], BaseResponse]] = {"sphere": BallOnLayer, "cylinder_flat": PunchOnLayer}


def closed_form(material: GelMaterial) -> Callable[[Touch], BaseResponse]:
    """A `BaseFamily`; forces are 5 to 20 % off at 1 mm depth, which hardly moves what separates two effects.

    Raises
    ------
    UsageError
        When it is asked for another shape.
    """
    return _respond


def _respond(touch: Touch) -> BaseResponse:
    shape = touch.indenter.shape
    if shape not in SHAPES:
        raise UsageError(
            f"indenter {shape!r} has no closed form here", f"one of: {', '.join(SHAPES)}", "Give a gel that plays it."
        )
    return SHAPES[shape](touch)
