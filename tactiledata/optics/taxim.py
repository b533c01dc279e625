"""Taxim's table: change of colour at a pixel, as a quadratic of its place for each slope of the gel there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.errors import MissingFile, SchemaError, UsageError

TERMS = 6
"""Number of terms of a quadratic: u², v², u v, u, v, 1."""


@dataclass(frozen=True)
class TaximTable:
    """Change of colour by slope and place (Si and Yuan, Taxim, 2022, section III-B).

    The slope's angle against the flat gel, 0 to pi/2, and its direction, -pi to pi, are divided into equal bins. Each
    bin has, for each channel, a quadratic of the pixel's place: ``a u² + b v² + c u v + d u + e v + f``, in grey
    levels. Here u and v run from -1 to 1 over the picture, along columns and rows, so that one table serves pictures
    of any size. Flat gel, the first bin of the angle, never changes the colour, whatever its coefficients.

    Parameters
    ----------
    coefficients : (angles, directions, 3, 6)
        Coefficients a to f of each bin, for R, G and B.
    origin : str
        Source of the table, for tables and reports.

    Raises
    ------
    UsageError
        Another shape, or coefficients that are not finite.
    """

    coefficients: Array
    origin: str

    def __post_init__(self) -> None:
        shape = np.shape(self.coefficients)
        if len(shape) != 4 or shape[2:] != (3, TERMS) or min(shape[:2]) < 2 or not np.isfinite(self.coefficients).all():
            raise UsageError(
                f"a table of shape {shape}", f"finite coefficients (angles, directions, 3, {TERMS})", "Calibrate again."
            )

    @property
    def bins(self) -> tuple[int, int]:
        """Number of bins of the angle and of the direction."""
        return self.coefficients.shape[0], self.coefficients.shape[1]

    def change(self, slopes: Any) -> NDArray[np.float32]:
        """Return the change of colour (rows, columns, 3), grey levels, that slopes (rows, columns, 2) cause.

        ``slopes`` are those of the indentation to the next column and row, m/m, as ``height_map.slopes`` returns.
        """
        angle, direction = slope_bins(slopes, self.bins)
        change = np.zeros((*angle.shape, 3), np.float32)
        steep = angle > 0
        terms = place_terms((angle.shape[0], angle.shape[1]))[steep]
        change[steep] = np.einsum("nkt,nt->nk", self._single[angle[steep], direction[steep]], terms)
        return change

    @cached_property
    def _single(self) -> NDArray[np.float32]:
        """Coefficients in single precision."""
        return self.coefficients.astype(np.float32)

    def save(self, path: Path) -> None:
        """Write the table to an .npz file."""
        np.savez_compressed(path, coefficients=self.coefficients.astype(np.float32), origin=np.array(self.origin))

    @classmethod
    def load(cls, path: Path) -> TaximTable:
        """Read a table that ``save`` wrote.

        Raises
        ------
        MissingFile
            The file does not exist.
        SchemaError
            The file holds no table.
        """
        arrays = _arrays(Path(path), ("coefficients", "origin"))
        return cls(arrays["coefficients"].astype(np.float64), str(arrays["origin"]))


def slope_bins(slopes: Any, bins: tuple[int, int]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the bins (...) of the angle and of the direction of slopes (..., 2), m/m.

    As in the published tables the last bin holds only the end of its range: n bins have the width range / (n - 1).
    """
    along, down = np.moveaxis(np.asarray(slopes, np.float32), -1, 0)
    angle = np.arctan(np.hypot(along, down)) / (np.pi / 2) * (bins[0] - 1)
    direction = (np.arctan2(down, along) + np.pi) / (2 * np.pi) * (bins[1] - 1)
    # float32 may round pi up to beyond the last bin
    return angle.astype(np.intp), np.minimum(direction.astype(np.intp), bins[1] - 1)


def place_terms(shape: tuple[int, int]) -> NDArray[np.float32]:
    """Return the six terms u², v², u v, u, v, 1 (rows, columns, 6) of every pixel's place."""
    v, u = np.meshgrid(*((np.arange(size) + 0.5) / size * 2 - 1 for size in shape), indexing="ij")
    return np.stack([u * u, v * v, u * v, u, v, np.ones_like(u)], axis=-1).astype(np.float32)


PUBLISHED_SHAPE = (480, 640)
"""Rows and columns of the pictures, turned on their side, from which the published DIGIT table was made."""


def published_digit_table(path: Path | None = None) -> TaximTable:
    """Return the DIGIT table published with Taxim, turned to upright pictures.

    The package holds the file (``taxim_digit/NOTICE.md``).

    The file counts places and directions in pictures that lie on their side (480 x 640: an upright picture turned
    clockwise). Turning back is exact: a quadratic stays one under a change of coordinates, and a quarter turn is a
    whole number of bins. Its ``grad_r`` is the first channel of a BGR picture: only then are balls orange above and
    blue below, as in real DIGIT contacts. Its coefficients of a flat gel, up to 116 grey levels in the corners, are
    subtracted, so that a picture without contact is the background.

    Raises
    ------
    MissingFile
        The file does not exist.
    SchemaError
        The file holds no such table.
    """
    path = Path(__file__).parent / "taxim_digit" / "polycalib.npz" if path is None else Path(path)
    arrays = _arrays(path, ("bins", "grad_r", "grad_g", "grad_b"))
    bins = int(arrays["bins"])
    lying = np.stack([arrays[name] for name in ("grad_b", "grad_g", "grad_r")], axis=2).astype(np.float64)
    if lying.shape != (bins, bins, 3, TERMS) or (bins - 1) % 4:
        raise SchemaError(
            f"{path} holds tables of shape {arrays['grad_r'].shape} with {bins} bins",
            f"(n, n, {TERMS}) with n - 1 divisible by 4",
            "Is this polycalib.npz of a DIGIT?",
        )
    # upright (u, v) lies at column (1 - v) / 2 of the width and row (1 + u) / 2 of the height
    rows, columns = PUBLISHED_SHAPE
    flat = tuple(int(index) for index in slope_bins(np.zeros(2), (bins, bins)))
    upright = _substituted(
        lying - lying[flat], x=(0.0, -columns / 2, columns / 2 - 0.5), y=(rows / 2, 0.0, rows / 2 - 0.5)
    )
    # a slope (along, down) of the upright picture is (-down, along) of the lying one: a quarter turn on
    quarter = (bins - 1) // 4
    source = (np.arange(bins) + quarter) % (bins - 1)
    upright = upright[:, source]
    upright[0] = 0.0
    return TaximTable(upright, "published DIGIT table (Taxim)")


def _substituted(coefficients: Array, x: tuple[float, float, float], y: tuple[float, float, float]) -> Array:
    """Coefficients of quadratics of (x, y), rewritten as quadratics of (u, v).

    x = x0 u + x1 v + x2, and y likewise.
    """
    terms = np.zeros((TERMS, TERMS))  # old terms as sums of new ones

    # squares and product of x and y, without the constant's row above
    def product(first: tuple[float, float, float], second: tuple[float, float, float]) -> list[float]:
        (a, b, c), (d, e, f) = first, second
        return [a * d, b * e, a * e + b * d, a * f + c * d, b * f + c * e, c * f]

    terms[0], terms[1], terms[2] = product(x, x), product(y, y), product(x, y)
    terms[3], terms[4], terms[5] = (0, 0, 0, *x), (0, 0, 0, *y), (0, 0, 0, 0, 0, 1)
    return coefficients @ terms


def _arrays(path: Path, names: tuple[str, ...]) -> dict[str, NDArray[Any]]:
    """Read arrays from an .npz file; refuse a file that is missing or lacks one of them."""
    if not path.is_file():
        raise MissingFile(f"no table at {path}", "an .npz with a Taxim table", "", path=str(path))
    try:
        with np.load(path, allow_pickle=False) as archive:
            return {name: archive[name] for name in names}
    except (KeyError, ValueError, OSError, EOFError) as error:
        raise SchemaError(f"{path} is no Taxim table: {error}", f"an .npz with {', '.join(names)}", "") from error
