"""Images of messages as they go into a store: encoded bytes as they came, raw pixels as RGB."""

from __future__ import annotations

import base64
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import cv2
import numpy as np

from tactiledata.contract.image_bytes import MAX_SIDE, read_header, size_fault
from tactiledata.contract.lfs_pointer import fault_words
from tactiledata.contract.picture_kinds import ALPHA_LEFT_OUT, Remark, remarks_on
from tactiledata.contract.records import Finding, Image, ImageSink
from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.cdr import COMPRESSED_LAYOUT, IMAGE_LAYOUT, Take, compressed_at, image_at
from tactiledata.formats.mcap.collect import FaultCount
from tactiledata.formats.mcap.decode import FAULTS, Decoder
from tactiledata.formats.mcap.message_fields import frame_of, path_of, stamp_of, value_at
from tactiledata.formats.mcap.roles import COMPRESSED_KINDS, ImageRole
from tactiledata.formats.mcap.undecoded import reason_of

RAW_CHANNELS = {"rgb8": (3, "rgb"), "bgr8": (3, "bgr"), "rgba8": (4, "rgb"), "bgra8": (4, "bgr"), "8UC3": (3, "bgr")}
"""Bytes a pixel and channel order of the raw encodings that are colour pictures; 8UC3 is OpenCV's, blue first."""
_TO_RGB = {
    ("rgb", 3): None,
    ("bgr", 3): cv2.COLOR_BGR2RGB,
    ("rgb", 4): cv2.COLOR_RGBA2RGB,
    ("bgr", 4): cv2.COLOR_BGRA2RGB,
}
DATA_URI = re.compile(r"data:[^,]{0,200};base64,")
"""What stands before base64 where a picture was written for a browser."""
SERIAL = re.compile(r"(?<![A-Za-z0-9])([A-Z]\d{5})(?![A-Za-z0-9])", re.IGNORECASE)
"""A DIGIT's serial in a topic or frame_id."""


def stated_serials(role: ImageRole, sensors: tuple[str, ...], is_only_camera: bool, frame: str) -> dict[str, str]:
    """Who calls the sensor of a camera by which serial, whoever is to be believed first.

    Parameters
    ----------
    role : ImageRole
    sensors : tuple of str
        Serials that the recording's description states.
    is_only_camera : bool
    frame : str
        ``frame_id`` of an image.
    """
    claims = {
        "the mapping": role.sensor,
        "the description": sensors[0] if len(sensors) == 1 and is_only_camera else "",
        "frame_id": _serial_in(frame, sensors),
        "the topic": _serial_in(role.topic, sensors),
    }
    return {origin: serial for origin, serial in claims.items() if serial}


def _serial_in(text: str, sensors: tuple[str, ...]) -> str:
    parts = set(re.split(r"[/\s]+", text))
    stated = [sensor for sensor in sensors if sensor in parts]
    if len(stated) == 1:
        return stated[0]
    match = SERIAL.search(text.replace("_", "/"))
    return match[1].upper() if match else ""


@dataclass
class CameraBuffer:
    """What is noted while a camera's images pass into the sink.

    Parameters
    ----------
    role : ImageRole
    sink : ImageSink
    sensors : tuple of str
        Serials that the recording's description states.
    is_only_camera : bool
    """

    role: ImageRole
    sink: ImageSink
    sensors: tuple[str, ...]
    is_only_camera: bool
    images: int = 0
    faults: FaultCount = field(default_factory=FaultCount)
    broken: FaultCount = field(default_factory=FaultCount)
    truncated: FaultCount = field(default_factory=FaultCount)
    remarks: dict[str, tuple[Remark, FaultCount]] = field(default_factory=dict)
    claims: dict[str, set[str]] = field(default_factory=dict)
    serials: dict[str, str] = field(default_factory=dict)
    serials_used: Counter[str] = field(default_factory=Counter)

    def serial(self, frame: str) -> str:
        """The serial of the sensor that took an image with this frame_id."""
        if frame not in self.serials:
            stated = stated_serials(self.role, self.sensors, self.is_only_camera, frame)
            for origin, serial in stated.items():
                self.claims.setdefault(serial, set()).add(origin)
            self.serials[frame] = next(iter(stated.values()), "")
        return self.serials[frame]

    def push(
        self, image: tuple[bytes, str, int, int] | None, frame: str, log_ns: int, publish_ns: int, header_ns: int | None
    ) -> None:
        """One image into the sink; ``None`` keeps the moment where the picture is lost.

        Parameters
        ----------
        image : (payload, encoding, height, width), optional
            Bytes, their encoding, and pixels; ``None`` where the picture is lost.
        frame : str
            The frame_id of the message.
        log_ns, publish_ns : int
            Stamps of the recorder and of the publisher, ns.
        header_ns : int, optional
            Stamp in the message, ns; ``None`` where the message has no header.
        """
        payload, encoding, height, width = image or (b"", "missing", 0, 0)
        serial = self.serial(frame)
        self.images += 1
        self.serials_used[serial] += 1
        self.sink.add(
            Image(
                self.role.camera,
                payload,
                encoding,  # type: ignore[arg-type]
                height,
                width,
                log_ns,
                publish_ns,
                -1 if header_ns is None else header_ns,
                sensor=serial,
                name=self.role.topic,
            )
        )

    def remark(self, log_ns: int, remark: Remark) -> None:
        """Count one more image of which this is said."""
        self.remarks.setdefault(remark.code, (remark, FaultCount()))[1].add(log_ns, remark.words)

    def findings(self) -> list[Finding]:
        """What was wrong with the images, and with who took them."""
        camera, topic = self.role.camera, self.role.topic
        found = self.faults.finding(
            "undecodable-message", f"{{messages}} of {topic} cannot be decoded: {{reason}}", camera
        )
        found += self.broken.finding("image-unreadable", f"{{images}} of {topic} {{are}} lost: {{reason}}", camera)
        found += self.truncated.finding("image-truncated", f"{{images}} of {topic} without an end mark", camera)
        for remark, faults in self.remarks.values():
            text = f"{{images}} of {topic}: the first {{reason}}"
            found += faults.finding(remark.code, text, camera, remark.severity)
        if len(self.claims) > 1:
            said = "; ".join(
                f"{serial} by {' and '.join(sorted(origins))}" for serial, origins in sorted(self.claims.items())
            )
            used = ", ".join(sorted(filter(None, self.serials_used))) or "none"
            text = f"{topic}: the sensor is called {said}; {used} is used"
            # a mapping is a person's decision; without one, nobody decided
            found.append(
                Finding("serial-overruled", "warning", text, camera)
                if self.role.sensor
                else Finding("serial-conflict", "damage", text, camera)
            )
        return found


def image_taker(decoder: Decoder, camera: CameraBuffer) -> Take:
    """What reads the messages of an image topic into the sink."""
    if camera.role.data:
        return _general(partial(_picture_at, camera.role.data), decoder, camera, True)
    is_compressed = decoder.kind in COMPRESSED_KINDS
    general = _general(_compressed_fields if is_compressed else _raw_fields, decoder, camera, is_compressed)
    if decoder.layout == COMPRESSED_LAYOUT:
        return _fast_compressed(camera, general)
    return _fast_raw(camera, general) if decoder.layout == IMAGE_LAYOUT else general


def _fast_compressed(camera: CameraBuffer, general: Take) -> Take:
    def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        try:
            stamp, frame, style, payload = compressed_at(buffer, start, stop)
        except ValueError:
            general(buffer, start, stop, log_ns, publish_ns)
            return
        camera.push(_encoded(payload, style, camera, log_ns), frame, log_ns, publish_ns, stamp)

    return take


def _fast_raw(camera: CameraBuffer, general: Take) -> Take:
    def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        try:
            stamp, frame, style, height, width, step, payload = image_at(buffer, start, stop)
        except ValueError:
            general(buffer, start, stop, log_ns, publish_ns)
            return
        pixels = _raw(style, height, width, step, payload, camera, log_ns)
        camera.push(pixels, frame, log_ns, publish_ns, stamp)

    return take


def _general(
    fields: Callable[[Any], tuple[Any, ...]], decoder: Decoder, camera: CameraBuffer, is_compressed: bool
) -> Take:
    store: Callable[..., Any] = _encoded if is_compressed else _raw

    def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        try:
            message = decoder.decode(buffer[start:stop])
            found, stamp, frame = fields(message), stamp_of(message), frame_of(message)
        except FAULTS as error:
            camera.faults.add(log_ns, reason_of(error))
            return
        camera.push(store(*found, camera, log_ns), frame, log_ns, publish_ns, stamp)

    return take


def _compressed_fields(message: Any) -> tuple[bytes, str]:
    return _bytes_of(value_at(message, ("data",))), str(value_at(message, ("format",)))


def _picture_at(steps: tuple[str | int, ...], message: Any) -> tuple[bytes, str]:
    value = value_at(message, steps)
    # base64 may come in lines
    return _bytes_of("".join(value.split()) if isinstance(value, str) else value), path_of(steps)


def _raw_fields(message: Any) -> tuple[str, int, int, int, bytes]:
    height, width, step = (int(value_at(message, (name,))) for name in ("height", "width", "step"))
    return str(value_at(message, ("encoding",))), height, width, step, _bytes_of(value_at(message, ("data",)))


def _bytes_of(value: Any) -> bytes:
    if isinstance(value, str):
        start = DATA_URI.match(value)
        return base64.b64decode(value[start.end() if start else 0 :], validate=True)
    if isinstance(value, Mapping):
        raise TypeError("pixels that are a dictionary")
    if isinstance(value, int | float | np.number):  # of which bytes() would make that many zeros
        raise TypeError("what should hold a picture is a number, and no picture")
    return bytes(value)


def _encoded(payload: bytes, style: str, camera: CameraBuffer, log_ns: int) -> tuple[bytes, str, int, int] | None:
    """JPEG or PNG bytes as they came, with what their header says."""
    try:
        header = read_header(payload)
    except BrokenLog as error:
        camera.broken.add(log_ns, f"{fault_words(error)} (format {style!r})")
        return None
    remarks = remarks_on(header, payload)
    for remark in remarks:
        camera.remark(log_ns, remark)
    if any(remark.is_lost for remark in remarks):
        return None
    if not header.is_complete:
        camera.truncated.add(log_ns, "cut")
    return payload, header.encoding, header.height, header.width


def _raw(
    style: str, height: int, width: int, step: int, payload: bytes, camera: CameraBuffer, log_ns: int
) -> tuple[bytes, str, int, int] | None:
    """Raw pixels as RGB, row-major, without padding."""
    if style not in RAW_CHANNELS:
        words = f"has the encoding {style!r}, no colour picture ({', '.join(RAW_CHANNELS)} are read)"
        camera.remark(log_ns, Remark("image-encoding", "damage", words))
        return None
    channels, order = RAW_CHANNELS[style]
    order = camera.role.channel_order or order
    if (
        not (0 < height <= MAX_SIDE and 0 < width <= MAX_SIDE)
        or step < width * channels
        or len(payload) != step * height
    ):
        camera.broken.add(
            log_ns,
            f"{height} rows x {width} columns {style} with {step} bytes a row, and {len(payload)} bytes of pixels",
        )
        return None
    if fault := size_fault(height, width):
        camera.remark(log_ns, Remark("image-too-large", "damage", f"is not taken: its {fault}"))
        return None
    if channels == 4:
        camera.remark(log_ns, Remark("image-alpha", "warning", ALPHA_LEFT_OUT))
    if order == "rgb" and channels == 3 and step == width * 3:
        return payload, "raw", height, width
    rows = np.frombuffer(payload, np.uint8).reshape(height, step)[:, : width * channels]
    pixels = np.ascontiguousarray(rows).reshape(height, width, channels)
    code = _TO_RGB[order, channels]
    return (pixels if code is None else cv2.cvtColor(pixels, code)).tobytes(), "raw", height, width
