"""JPEG, PNG and raw pictures decoded straight into an array, at their own size or at a smaller one."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral

import simplejpeg

from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError


def decode_jpeg_into(content: bytes, target: PictureArray) -> bool:
    """Whether a JPEG file was decoded straight into ``target`` (H, W, 3); if not, another decoder may still know it.

    OpenCV has no way to decode into an array that is there, and copying a picture takes a tenth of decoding it.
    """
    try:
        return simplejpeg.decode_jpeg(content, "RGB", buffer=target).shape == target.shape
    except ValueError:
        return False


def decode_smaller_jpeg(content: bytes, shape: tuple[int, ...], target: PictureArray) -> bool:
    """Whether a JPEG file was decoded into a smaller ``target`` (h, w, 3); if not, another decoder may still know it.

    Of the sizes n/8 at which libjpeg-turbo can leave the transform, the smallest that covers the target is taken: the
    rest of the picture is never computed. What is still larger than the target is averaged by area.

    Parameters
    ----------
    content : bytes
        A JPEG file.
    shape : (H, W, 3)
        Of the picture that the file must hold.
    target : (h, w, 3) uint8
        Where the picture goes.
    """
    rows, columns = target.shape[:2]
    try:
        if simplejpeg.decode_jpeg_header(content)[:2] != shape[:2]:
            return False
        picture = simplejpeg.decode_jpeg(content, "RGB", min_height=rows, min_width=columns)
    except ValueError:
        return False
    average_into(picture, target)
    return True


def average_into(picture: PictureArray, target: PictureArray) -> None:
    """Fill ``target`` (h, w, 3) with the means over areas of a picture (H, W, 3) that is no smaller."""
    if picture.shape == target.shape:
        target[...] = picture
        return
    import cv2

    target[...] = cv2.resize(picture, (target.shape[1], target.shape[0]), interpolation=cv2.INTER_AREA)


def need_smaller(size: Sequence[int], shape: tuple[int, int]) -> tuple[int, int]:
    """Return a size that pictures are to have, checked: whole rows and columns, none more than they have.

    Parameters
    ----------
    size : (rows, columns)
        Size that is asked for.
    shape : (rows, columns)
        Size that the pictures have.

    Raises
    ------
    UsageError
        Something else, or a size that is larger.
    """
    asked = tuple(size) if isinstance(size, Sequence) and not isinstance(size, str) else ()
    if (
        len(asked) != 2
        or not all(isinstance(side, Integral) and not isinstance(side, bool) for side in asked)
        or not all(1 <= side <= most for side, most in zip(asked, shape, strict=True))
    ):
        raise UsageError(
            f"a size of {size!r}",
            f"(rows, columns) of whole numbers, at least 1 and at most the {shape[0]} x {shape[1]} of the pictures",
            "Pictures are only made smaller; enlarge them in your model.",
        )
    return int(asked[0]), int(asked[1])
