"""Annotated contact radii held against the body that made the contact: a rigid ball leaves no circle wider than itself.

Shared by all formats, as `base` is: members of the family may import it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactiledata.contract.records import Finding

CODE = "impossible-contact-radius"


def impossible_radii(radii: ArrayLike, indenter_radius: float, pixel_pitch: float) -> NDArray[np.bool_]:
    """Return a mask (n,) of contact radii, in pixels, that exceed the indenter's own radius, or are negative or not
    finite.

    Parameters
    ----------
    radii : (n,), pixels
    indenter_radius : metres; of a ball, or of the circle that bounds another body seen head-on
    pixel_pitch : metres on the gel per pixel

    Examples
    --------
    >>> impossible_radii([10, 20, 21, -1], indenter_radius=0.002, pixel_pitch=0.0001).tolist()
    [False, False, True, True]
    """
    values = np.asarray(radii, dtype=float)
    with np.errstate(invalid="ignore"):
        return ~((values >= 0) & (values <= indenter_radius / pixel_pitch))


def radius_findings(
    radii: ArrayLike, indenter_radius: float, pixel_pitch: float, what: str, stream: str = ""
) -> list[Finding]:
    """One warning where annotated contact radii are impossible; an empty list where all are possible.

    The annotations are kept as they are: the images beside them may be sound. Whoever calibrates with these radii
    learns a slope that the ball does not have.

    Parameters
    ----------
    radii : (n,), pixels
        Radii of contacts as annotated.
    indenter_radius : float
        Radius of the ball, m.
    pixel_pitch : float
        Width of a pixel on the gel, m.
    what : str
        The annotation's name in the recording, for the message.
    stream : str
        The stream that the finding is about.
    """
    values = np.asarray(radii, dtype=float)
    is_impossible = impossible_radii(values, indenter_radius, pixel_pitch)
    count = int(is_impossible.sum())
    if not count:
        return []
    kinds, numbers = np.unique(values[is_impossible], return_counts=True)
    repeated = int(numbers.argmax())
    message = (
        f"{count} of {len(values)} {what} are impossible: the indenter's own radius is "
        f"{indenter_radius / pixel_pitch:.2f} px ({indenter_radius * 1e3:g} mm at {pixel_pitch * 1e3:.4g} mm/px), the "
        f"largest annotated is {np.nanmax(values[is_impossible], initial=0):g} px"
    )
    if numbers[repeated] > 1:
        message += f"; {numbers[repeated]} of them are exactly {kinds[repeated]:g}, as a value typed once would be"
    return [Finding(CODE, "warning", message, stream, count=count)]
