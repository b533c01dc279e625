"""What a recording says of itself (``schemas/log.json``), with its transforms as named poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tactiledata.contract.schema import check_document
from tactiledata.errors import SchemaError, UnknownName, UsageError
from tactiledata.transforms import Transform

LOG_FORMAT = "tactiledata-log/1"

PLACEHOLDER = "REPLACE"
"""What names begin with that a draft leaves for a person to fill in."""


@dataclass(frozen=True)
class LogDescription:
    """The content of a log.yaml, checked.

    Parameters
    ----------
    document : dict
        As in ``schemas/log.json``; empty where a recording says nothing of itself.
    where : str
        The file or record that it came from, for messages.
    """

    document: Mapping[str, Any] = field(default_factory=dict)
    where: str = ""

    @classmethod
    def checked(cls, document: Mapping[str, Any], where: str) -> LogDescription:
        """A description that fits the schema and whose transforms are rigid.

        Raises
        ------
        SchemaError
            With the path inside the document.
        """
        check_document(document, "log", where)
        description = cls(document, where)
        for name in ("gel", "ft"):
            description.transform(f"tcp_from_{name}")
        for name in description.indenters:
            description.base_from_indenter(name)
        return description

    @property
    def is_empty(self) -> bool:
        """Whether the recording says nothing of itself."""
        return not self.document

    @property
    def sensors(self) -> Mapping[str, Any]:
        """Sensors by serial."""
        return self.document.get("sensors", {})

    @property
    def indenters(self) -> Mapping[str, Any]:
        """Indenters by name."""
        return self.document.get("indenters", {})

    @property
    def robot(self) -> Mapping[str, Any]:
        """Robot model, ``tcp_from_gel``, ``tcp_from_ft``, tool."""
        return self.document.get("robot", {})

    @property
    def wrench(self) -> Mapping[str, Any]:
        """What the wrench stream means: sign, gravity, tare events."""
        return self.document.get("wrench", {})

    @property
    def units(self) -> Mapping[str, Any]:
        """Units of the columns of a folder log's tables, by stream; a stream that is not named is in SI units."""
        return self.document.get("units", {})

    def without_units(self) -> LogDescription:
        """The description of the same recording after its numbers were brought to SI units."""
        return LogDescription({key: value for key, value in self.document.items() if key != "units"}, self.where)

    def clock_offset(self, stream: str) -> int:
        """Nanoseconds to add to a stream's stamps to reach the host clock; 0 where that is not known."""
        return self.stated_clock_offset(stream) or 0

    def stated_clock_offset(self, stream: str) -> int | None:
        """Nanoseconds to add to a stream's stamps to reach the host clock; ``None`` where that is not stated."""
        clock = self.document.get("clocks", {}).get(stream, {})
        return int(clock["offset_ns"]) if "offset_ns" in clock and clock.get("known", True) else None

    def switched_on(self, sensor: str, before_ns: int) -> int | None:
        """Return the moment (ns, host clock) at which a sensor was last switched on before another; ``None`` where not
        stated.
        """
        stated = self.sensors.get(sensor, {}).get("power_on_ns", [])
        return max((int(moment) for moment in stated if moment <= before_ns), default=None)

    def transform(self, name: str) -> Transform | None:
        """``tcp_from_gel`` or ``tcp_from_ft``; ``None`` where not stated."""
        value = self.robot.get(name)
        to, _, source = name.partition("_from_")
        return None if value is None else self._posed(to, source, value, f"$.robot.{name}")

    def base_from_indenter(self, indenter: str) -> Transform | None:
        """Return the stated pose of an indenter in the base frame; ``None`` where it is not stated."""
        if indenter not in self.indenters:
            raise UnknownName("indenter", indenter, self.indenters)
        value = self.indenters[indenter].get("base_from_indenter")
        path = f"$.indenters.{indenter}.base_from_indenter"
        return None if value is None else self._posed("base", indenter, value, path)

    def _posed(self, to: str, source: str, value: object, path: str) -> Transform:
        """The transform that stands at a path of the document; a refusal names the file and the path."""
        try:
            return Transform.from_document(to, source, value)
        except (SchemaError, UsageError) as error:
            found = f"{self.where or 'the description'} at {path}: {error.found}"
            raise SchemaError(found, error.expected, error.remedy, path=path, file=self.where) from error

    def merged(self, addition: Mapping[str, Any], where: str) -> LogDescription:
        """The description with another laid over it, key by key; what is added wins."""
        return LogDescription.checked(_merge({"format": LOG_FORMAT, **self.document}, addition), where)


def _merge(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    both = dict(below)
    for key, value in above.items():
        if isinstance(value, Mapping) and isinstance(both.get(key), Mapping):
            both[key] = _merge(both[key], value)
        else:
            both[key] = value
    return both
