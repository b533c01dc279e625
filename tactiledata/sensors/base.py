"""What a sensor model is: one frozen description, every number with its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tactiledata.errors import UsageError

Kind = Literal["tactile", "force"]


@dataclass(frozen=True)
class GelGeometry:
    """The soft pad. What a log states under ``gel:`` wins over these.

    Parameters
    ----------
    outline : (short, long), metres; along x and y of the gel frame
    thickness : metres, in the middle
    edge_thickness : metres, at the rim; the pad is flat where it equals ``thickness``
    round_end : metres, length of the half-elliptic end at +y of the gel frame; 0 where the outline is a rectangle
    corner_radius : metres, of the corners at -y
    shore_00 : durometer on the Shore 00 scale, where known
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
    """The picture that a tactile sensor gives.

    Parameters
    ----------
    shape : (rows, columns), of the canonical RGB uint8 image
    field_of_view : (along rows, along columns), metres on the gel surface that ``shape`` covers
    frame_rate : Hz, nominal
    """

    shape: tuple[int, int]
    field_of_view: tuple[float, float]
    frame_rate: float

    @property
    def pixel_pitch(self) -> tuple[float, float]:
        """Metres on the gel per pixel, (down a column, along a row)."""
        return self.field_of_view[0] / self.shape[0], self.field_of_view[1] / self.shape[1]


@dataclass(frozen=True)
class ForceSpecification:
    """What a force-torque sensor can say; forces N, torques N m, rates Hz.

    ``force_noise`` and ``torque_noise`` are standard deviations of one reading, ``*_quantum`` the step of the digits
    that are sent, ``seen_rates`` rates at which recordings really come.
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
    """A sensor model.

    Parameters
    ----------
    name : str
        Name in the table and in ``log.yaml``.
    title, maker : str
        For people.
    kind : "tactile" or "force"
        Tactile sensors have ``gel`` and ``camera``, force sensors have ``force``.
    sources : mapping
        Where each number comes from, by field (``"gel.outline"``); estimates of our own say so.

    Raises
    ------
    UsageError
        A description that does not go with its kind, or a number without a source.
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
        is_complete = {"tactile": self.gel and self.camera, "force": self.force}[self.kind] is not None
        missing = [entry for entry in self._numbers() if entry not in self.sources]
        if not is_complete or missing:
            raise UsageError(
                f"sensor {self.name!r} of kind {self.kind!r} lacks "
                + (f"sources of {', '.join(missing)}" if missing else "its gel, camera or force specification"),
                "a complete description, every number with its source",
            )

    def _numbers(self) -> list[str]:
        parts = {"gel": self.gel, "camera": self.camera, "force": self.force}
        return [
            f"{part}.{name}"
            for part, block in parts.items()
            if block is not None
            for name, value in vars(block).items()
            if value not in (None, (), 0.0)
        ]
