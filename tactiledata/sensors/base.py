"""Descriptions of sensor models, frozen, every number with its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tactiledata.errors import UsageError

Kind = Literal["tactile", "force"]
"""What a sensor measures: pictures of a gel, or wrenches."""


@dataclass(frozen=True)
class GelGeometry:
    """Shape of the soft pad; what a log states under ``gel:`` takes precedence.

    Parameters
    ----------
    outline : (short, long)
        Sides, m, along x and y of the gel frame.
    thickness : float
        Height in the middle, m.
    edge_thickness : float
        Height at the rim, m; the pad is flat where it equals ``thickness``.
    round_end : float
        Length, m, of the half-elliptic end at +y of the gel frame; 0 where the outline is a rectangle.
    corner_radius : float
        Radius, m, of the corners at -y.
    shore_00 : float, optional
        Hardness on the Shore 00 scale, where known.
    """

    outline: tuple[float, float]
    thickness: float
    edge_thickness: float
    round_end: float = 0.0
    corner_radius: float = 0.0
    shore_00: float | None = None

    @property
    def is_flat(self) -> bool:
        """Whether the outer surface is a plane."""
        return self.edge_thickness == self.thickness


@dataclass(frozen=True)
class TactileCamera:
    """The camera of a tactile sensor.

    Parameters
    ----------
    shape : (rows, columns)
        Size of the picture, RGB uint8, upright.
    field_of_view : (along rows, along columns)
        Lengths, m, on the surface of the gel that the picture covers.
    frame_rate : float
        Nominal rate, Hz.
    """

    shape: tuple[int, int]
    field_of_view: tuple[float, float]
    frame_rate: float

    @property
    def pixel_pitch(self) -> tuple[float, float]:
        """Length, m, on the gel of a pixel: (down a column, along a row)."""
        return self.field_of_view[0] / self.shape[0], self.field_of_view[1] / self.shape[1]


@dataclass(frozen=True)
class ForceSpecification:
    """Range, noise and rate of a force-torque sensor.

    Parameters
    ----------
    force_range, torque_range : float
        Largest component of force, N, and torque, N m, on each axis.
    force_noise, torque_noise : float
        Standard deviation of one reading, N and N m.
    force_quantum, torque_quantum : float
        Step of the digits that are sent, N and N m.
    rate : float
        Nominal rate, Hz.
    seen_rates : tuple of float
        Rates, Hz, that recordings really have.
    """

    force_range: float
    torque_range: float
    force_noise: float
    torque_noise: float
    force_quantum: float
    torque_quantum: float
    rate: float
    seen_rates: tuple[float, ...] = ()


@dataclass(frozen=True)
class Sensor:
    """Description of a sensor model.

    Parameters
    ----------
    name : str
        Name in the table and in ``log.yaml``.
    title : str
        Name of the model, for people.
    maker : str
        Maker, for people.
    kind : "tactile" or "force"
        Tactile sensors have ``gel`` and ``camera``, force sensors have ``force``.
    gel : GelGeometry, optional
        Shape of the soft pad.
    camera : TactileCamera, optional
        Camera behind the pad.
    force : ForceSpecification, optional
        Range, noise and rate.
    sources : mapping, field -> str
        Where each number comes from, by field (``"gel.outline"``); estimates of our own say so.

    Raises
    ------
    UsageError
        A description without the parts of its kind, or a number without a source.
    """

    name: str
    title: str
    maker: str
    kind: Kind
    gel: GelGeometry | None = None
    camera: TactileCamera | None = None
    force: ForceSpecification | None = None
    sources: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse a description without the parts of its kind, or a number without a source."""
        is_complete = {"tactile": self.gel and self.camera, "force": self.force}[self.kind] is not None
        missing = [entry for entry in self._numbers() if entry not in self.sources]
        if not is_complete or missing:
            raise UsageError(
                f"sensor {self.name!r} of kind {self.kind!r} lacks "
                + (f"sources of {', '.join(missing)}" if missing else "its gel, camera or force specification"),
                "a complete description, every number with its source",
            )

    def _numbers(self) -> list[str]:
        """Fields that need a source, as ``part.name``: those that are neither empty nor 0."""
        parts = {"gel": self.gel, "camera": self.camera, "force": self.force}
        return [
            f"{part}.{name}"
            for part, block in parts.items()
            if block is not None
            for name, value in vars(block).items()
            if value not in (None, (), 0.0)
        ]
