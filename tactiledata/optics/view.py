"""Camera behind the gel: the map between pixels of a picture and points of the gel."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.sensors.base import Sensor


@dataclass(frozen=True)
class View:
    """A camera behind the gel, as the map from pixels to the plane of the undeformed outer surface.

    Parameters
    ----------
    shape : (rows, columns)
        Size of the picture.
    gel_from_pixel : (3, 3)
        ``[w x, w y, w] = gel_from_pixel @ [column, row, 1]``: metres, gel frame; pixel centres are whole numbers. An
        affine camera has ``[0, 0, 1]`` as its last row.

    Raises
    ------
    UsageError
        A matrix that is not invertible.
    """

    shape: tuple[int, int]
    gel_from_pixel: Array = field(compare=False)

    def __post_init__(self) -> None:
        matrix = np.asarray(self.gel_from_pixel, np.float64)
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 1e-30:
            raise UsageError(f"gel_from_pixel is {matrix.tolist()}", "an invertible 3 x 3 matrix", "")
        object.__setattr__(self, "gel_from_pixel", matrix / matrix[2, 2])

    @classmethod
    def nominal(cls, sensor: Sensor, shape: tuple[int, int] | None = None, mirrored: bool = True) -> View:
        """Return the view that a sensor model states: centred and upright.

        Parameters
        ----------
        sensor : Sensor
            A tactile sensor with a camera.
        shape : (rows, columns), optional
            Size of the picture; by default that of the sensor.
        mirrored : bool
            Columns run along gel x, as the camera behind the gel sees it; otherwise against gel x, as an observer in
            front sees it. Rows run along gel y in both.

        Raises
        ------
        UsageError
            The sensor takes no pictures.
        """
        if sensor.camera is None:
            raise UsageError(f"sensor {sensor.name!r} takes no pictures", "a tactile sensor", "")
        rows, columns = shape or sensor.camera.shape
        pitch_y, pitch_x = sensor.camera.field_of_view[0] / rows, sensor.camera.field_of_view[1] / columns
        sign = 1.0 if mirrored else -1.0
        return cls(
            (rows, columns),
            np.array(
                [
                    [sign * pitch_x, 0.0, -sign * pitch_x * (columns - 1) / 2],
                    [0.0, pitch_y, -pitch_y * (rows - 1) / 2],
                    [0.0, 0.0, 1.0],
                ]
            ),
        )

    @property
    def is_mirrored(self) -> bool:
        """Whether the picture is seen from behind the gel, so that columns and rows have the sense of gel x and y."""
        return bool(np.linalg.det(self.gel_from_pixel[:2, :2]) > 0)

    @property
    def pitches(self) -> tuple[float, float]:
        """Distances on the gel, m, from the picture's middle to the next column and to the next row."""
        middle = np.array([(self.shape[1] - 1) / 2, (self.shape[0] - 1) / 2])
        centre, across, down = self.points_at(middle + np.array([[0, 0], [1, 0], [0, 1]]))
        return float(np.linalg.norm(across - centre)), float(np.linalg.norm(down - centre))

    def points_at(self, pixels: NDArray[np.floating]) -> Array:
        """Return the gel points (..., 2), m, that pixels (..., 2) see; a pixel is (column, row)."""
        return _mapped(self.gel_from_pixel, pixels)

    def pixels_at(self, points: NDArray[np.floating]) -> Array:
        """Return the pixels (..., 2), (column, row), that see gel points (..., 2), m."""
        return _mapped(np.linalg.inv(self.gel_from_pixel), points)

    def points(self) -> Array:
        """Return the gel point (rows, columns, 2), m, of every pixel."""
        columns, rows = np.meshgrid(np.arange(self.shape[1]), np.arange(self.shape[0]))
        return self.points_at(np.stack([columns, rows], axis=-1).astype(np.float64))

    def scaled(self, shape: tuple[int, int]) -> View:
        """Return the same camera with pictures of another size; the picture's edges keep their places on the gel."""
        if tuple(shape) == self.shape:
            return self
        across, down = self.shape[1] / shape[1], self.shape[0] / shape[0]
        old_from_new = np.array([[across, 0, (across - 1) / 2], [0, down, (down - 1) / 2], [0, 0, 1]])
        return View((int(shape[0]), int(shape[1])), self.gel_from_pixel @ old_from_new)


def _mapped(matrix: NDArray[np.floating], places: NDArray[np.floating]) -> Array:
    """Places (..., 2) under a projective map (3, 3)."""
    mapped = np.asarray(places, np.float64) @ matrix[:, :2].T + matrix[:, 2]
    result: Array = mapped[..., :2] / mapped[..., 2:]
    return result
