"""The content of a scenario file (``schemas/scenario.json``), as frozen records with defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactiledata.contract.schema import check_document, read_document
from tactiledata.errors import SchemaError, UsageError
from tactiledata.rig.hidden.effects import hidden_effect, is_null
from tactiledata.rig.motion.motion import TURNING_SPEED
from tactiledata.rig.motion.touch import Generate, Step, TouchPlan
from tactiledata.transforms import Transform

if TYPE_CHECKING:
    from tactiledata.rig.hidden.base import HiddenEffect


@dataclass(frozen=True)
class Material:
    """The gel's material: Young's modulus in Pa, Poisson's ratio, Coulomb friction. Known to the rig only."""

    youngs_modulus: float = 0.9e6
    poisson_ratio: float = 0.48
    friction: float = 0.8


@dataclass(frozen=True)
class Gel:
    """A flat pad bonded to a rigid base: its short and long side and its thickness, metres."""

    outline: tuple[float, float] = (0.0184, 0.0250)
    thickness: float = 0.0041


@dataclass(frozen=True)
class SensorSetup:
    """One sensor unit of a scenario.

    Parameters
    ----------
    serial : str
        Name of the unit.
    background : str
        Name of a bundled background, or path of a picture without contact.
    shore_00 : float, optional
        Shore 00 hardness that is printed on the pad.
    gel : Gel
        Its pad.
    optics : dict
        Optics that the scenario states; the rest is drawn.
    """

    serial: str
    background: str
    shore_00: float | None = None
    gel: Gel = Gel()
    optics: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Robot:
    """The mounting of sensor and force sensor on the arm, and the tool's mass (kg) and centre of gravity (tcp, m)."""

    tcp_from_gel: Transform = field(
        default_factory=lambda: Transform.from_parts(
            "tcp", "gel", (0.0021, -0.0013, 0.0004), (0.0043, -0.0026, 0.7071, 0.7071)
        )
    )
    tcp_from_ft: Transform = field(
        default_factory=lambda: Transform.from_parts("tcp", "ft", (0.0, 0.0, -0.118), (0.0, 0.0, 0.1305, 0.9914))
    )
    flange_from_tcp: Transform = field(
        default_factory=lambda: Transform.from_parts("flange", "tcp", (0.0, 0.0, 0.1565), (0.0, 0.0, 0.0, 1.0))
    )
    tool_mass: float = 0.45
    centre_of_gravity: tuple[float, float, float] = (0.002, -0.001, -0.052)


@dataclass(frozen=True)
class Imperfections:
    """The errors of a real rig: noise, bias, drift and losses; units and meaning in ``schemas/scenario.json``."""

    pose_repeatability: float = 3e-5
    remount: float = 0.0
    tcp_noise: float = 1e-6
    force_noise: float = 0.1
    torque_noise: float = 0.002
    coloured_share: float = 0.3
    correlation_time: float = 0.2
    force_quantum: float = 0.01
    torque_quantum: float = 0.001
    force_bias: float = 2.0
    force_drift: float = 0.02
    nan_wrench: float = 0.0
    dropped_frames: float = 0.0
    out_of_order: float = 0.0


@dataclass(frozen=True)
class Streams:
    """Rates of the streams in Hz; 0 leaves a stream out (``wrench_effective`` 0: every sample is new)."""

    joints: float = 500.0
    tcp: float = 125.0
    wrench: float = 100.0
    wrench_effective: float = 0.0
    arm_wrench: float = 125.0


@dataclass(frozen=True)
class Images:
    """The rules by which pictures are taken and encoded; meaning in ``schemas/scenario.json``."""

    capture: str = "step"
    rate: float = 30.0
    frames_per_step: int = 1
    free_air_frames: int = 1
    encoding: str = "jpeg"
    quality: int = 95
    channels: str = "bgr8"
    mislabelled: bool = False
    swapped_size: bool = False


@dataclass(frozen=True)
class ClockSetup:
    """The clock of a stream: host = stream + offset; jitter of the sampling moments and mean latency in seconds."""

    offset_ns: int = 0
    known: bool = False
    jitter: float = 0.0
    latency: float = 1e-3


@dataclass(frozen=True)
class Recordings:
    """The rules by which trajectories are grouped into logs, and what the logs state about themselves."""

    group: str = "sensor"
    trajectories_per_log: int = 1000
    pause: float = 0.6
    tare: str = "log"
    sign: str = "load_on_sensor"
    name_trajectories: bool = True
    describe: bool = True
    crcs: bool = True
    compression: str = "zstd"
    chunk_size: int = 768 * 1024
    powered: float = 1200.0


@dataclass(frozen=True)
class Scenario:
    """A world to record, checked against the schema; paths in it are relative to ``folder``."""

    sensors: Mapping[str, SensorSetup]
    indenters: Mapping[str, Mapping[str, Any]]
    title: str = ""
    seed: int = 0
    start_ns: int = 1_700_000_000_000_000_000
    material: Material = Material()
    contact: str = "analytic"
    contact_pitch: float = 4e-4
    robot: Robot = field(default_factory=Robot)
    imperfections: Imperfections = Imperfections()
    streams: Streams = Streams()
    images: Images = Images()
    clocks: Mapping[str, ClockSetup] = field(default_factory=dict)
    recordings: Recordings = Recordings()
    trajectories: tuple[TouchPlan, ...] = ()
    generate: Generate | None = None
    folder: Path = Path()
    hidden: tuple[HiddenEffect, ...] = ()

    def clock(self, stream: str) -> ClockSetup:
        """Return the clock of ``wrench``, ``tcp``, ``joints`` or ``frames``; the host's own where none is stated."""
        return self.clocks.get(stream, ClockSetup())


def load_scenario(source: Path | str | Mapping[str, Any], folder: Path | None = None) -> Scenario:
    """Return the scenario of a YAML or JSON file, or of its parsed document.

    Parameters
    ----------
    source : path or dict
        The file, or the document that was read from it.
    folder : Path, optional
        Folder to which paths in the scenario are relative; the file's own folder where it is not given.

    Raises
    ------
    SchemaError
        The document does not fit its schema, or names and ranges in it contradict one another.
    """
    if isinstance(source, Mapping):
        document, where, base = source, "the scenario", folder or Path()
        check_document(document, "scenario", where)
    else:
        path = Path(source)
        document, where, base = read_document(path, "scenario"), str(path), folder or path.parent
    scenario = replace(_scenario(document, base, where), hidden=_hidden(document, where))
    _check(scenario, document, where)
    return scenario


def _scenario(document: Mapping[str, Any], folder: Path, where: str) -> Scenario:
    """Return the scenario of a document that fits the schema, without its hidden effects."""
    plain = {key: document[key] for key in ("title", "seed", "start_ns", "contact", "contact_pitch") if key in document}
    sections = {
        name: _record(kind, document[name])
        for name, kind in (
            ("material", Material),
            ("imperfections", Imperfections),
            ("streams", Streams),
            ("images", Images),
            ("recordings", Recordings),
            ("generate", Generate),
        )
        if name in document
    }
    return Scenario(
        sensors={serial: _sensor(serial, entry) for serial, entry in document["sensors"].items()},
        indenters=dict(document["indenters"]),
        robot=_robot(document.get("robot", {}), where),
        clocks={name: _record(ClockSetup, entry) for name, entry in document.get("clocks", {}).items()},
        trajectories=tuple(_touch(entry) for entry in document.get("trajectories", [])),
        folder=folder,
        **plain,
        **sections,
    )


def _hidden(document: Mapping[str, Any], where: str) -> tuple[HiddenEffect, ...]:
    """Return the hidden effects of a document without those of no strength; refuse an effect that is given twice."""
    entries = document.get("hidden", [])
    names = [entry["effect"] for entry in entries]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise _fault(where, f"$.hidden[{index}].effect", f"the effect {name!r} is given twice", "each effect once")
    effects = [hidden_effect(entry, f"$.hidden[{index}]", where) for index, entry in enumerate(entries)]
    return tuple(effect for effect in effects if not is_null(effect))


def _record(kind: type, entry: Mapping[str, Any]) -> Any:
    """Return a record of a class from a checked section of the document; lists become tuples."""
    return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in entry.items()})


def _sensor(serial: str, entry: Mapping[str, Any]) -> SensorSetup:
    """Return the sensor unit of one entry of ``sensors``."""
    gel = _record(Gel, entry.get("gel", {}))
    return SensorSetup(serial, entry["background"], entry.get("shore_00"), gel, entry.get("optics", {}))


def _robot(entry: Mapping[str, Any], where: str) -> Robot:
    """Return the robot of the section ``robot``; poses that it does not state keep their defaults."""
    chosen: dict[str, Any] = {}
    for item in fields(Robot):
        if item.name not in entry:
            continue
        value = entry[item.name]
        to, _, source = item.name.partition("_from_")
        chosen[item.name] = _posed(to, source, value, f"$.robot.{item.name}", where) if source else value
    if "centre_of_gravity" in chosen:
        chosen["centre_of_gravity"] = tuple(chosen["centre_of_gravity"])
    return Robot(**chosen)


def _touch(entry: Mapping[str, Any]) -> TouchPlan:
    """Return the touch of one entry of ``trajectories``."""
    steps = []
    for item in entry["steps"]:
        ((kind, options),) = item.items()
        defaults = {"speed": TURNING_SPEED} if kind == "turn" else {}
        steps.append(_record(Step, {"kind": kind, **defaults, **options}))
    return _record(TouchPlan, {**entry, "steps": steps})


def _check(scenario: Scenario, document: Mapping[str, Any], where: str) -> None:
    """Refuse what a schema cannot exclude: unknown names, ranges upside down, nothing to play, streams at 0 Hz."""
    if not scenario.trajectories and scenario.generate is None:
        raise _fault(where, "$", "neither `trajectories` nor `generate` is given", "something to play")
    for name, entry in scenario.indenters.items():
        if "base_from_indenter" in entry:
            path = f"$.indenters.{name}.base_from_indenter"
            _posed("base", "indenter", entry["base_from_indenter"], path, where)
    # explicit touches: names, sensors, indenters and places
    names: set[str] = set()
    for index, touch in enumerate(scenario.trajectories):
        path = f"$.trajectories[{index}]"
        _known(touch.sensor, scenario.sensors, f"{path}.sensor", where)
        _known(touch.indenter, scenario.indenters, f"{path}.indenter", where)
        if touch.name in names:
            raise _fault(where, f"{path}.name", f"the name {touch.name!r} is given twice", "a name of its own")
        names.add(touch.name)
        _on_pad(touch.position, scenario.sensors[touch.sensor].gel, f"{path}.position", where)
    # generated touches: names, places and ranges
    if scenario.generate is not None:
        kinds: tuple[tuple[str, Mapping[str, Any]], ...] = (
            ("sensors", scenario.sensors),
            ("indenters", scenario.indenters),
        )
        for kind, table in kinds:
            for key in (kind, f"paired_{kind}"):
                for index, name in enumerate(getattr(scenario.generate, key)):
                    _known(name, table, f"$.generate.{key}[{index}]", where)
        for sensor in scenario.sensors.values():
            _on_pad(scenario.generate.position, sensor.gel, "$.generate.position", where)
        for key, value in document["generate"].items():
            if key in ("depth", "settle", "speed", "dwell", "tilt", "shear") and value[0] > value[1]:
                raise _fault(where, f"$.generate.{key}", f"the range {list(value)} is upside down", "[least, most]")
    # rates
    if scenario.images.capture != "step" and scenario.images.rate <= 0:
        raise _fault(where, "$.images.rate", "a video at 0 Hz", "a rate above 0")
    for name in ("tcp", "wrench"):
        if getattr(scenario.streams, name) <= 0:
            raise _fault(where, f"$.streams.{name}", f"stream {name} at 0 Hz", "a rate above 0")


def _on_pad(position: tuple[float, float], gel: Gel, path: str, where: str) -> None:
    """Refuse a position (2,), m, off the pad."""
    if any(abs(place) > side / 2 for place, side in zip(position, gel.outline, strict=True)):
        half = [side / 2 for side in gel.outline]
        raise _fault(
            where, path, f"the position {list(position)} m is off the pad", f"at most {half} m from its middle"
        )


def _known(name: str, table: Mapping[str, Any], path: str, where: str) -> None:
    """Refuse a name that a table of the scenario does not describe."""
    if name not in table:
        raise _fault(where, path, f"{name!r} is not described", f"one of: {', '.join(table)}")


def _posed(to: str, source: str, value: object, path: str, where: str) -> Transform:
    """Return the transform that stands at a path of a scenario file; a refusal names the file and the path."""
    try:
        return Transform.from_document(to, source, value)
    except (SchemaError, UsageError) as error:
        raise _fault(where, path, error.found, error.expected) from error


def _fault(where: str, path: str, found: str, expected: str) -> SchemaError:
    """Return the error for a fault at a path inside a scenario file."""
    return SchemaError(f"{where}, at {path}: {found}", expected, "Mend the scenario file.", path=path, file=where)
