"""Images of one colour throughout, such as a black one among good ones: they show no gel, and are marked.

Not every image is decoded for it, which would take longer than reading the recording: an image of one colour is far
smaller as a file (and as compressed pixels) than a picture of a gel, so that only small ones are looked at.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted
from tactiledata.ingest.checks.spooled import SpooledImages
from tactiledata.sensors.image_checks import is_one_colour

SMALL = 0.8
"""Images whose bytes are below this share of their camera's median are decoded: few, as a touch changes little of a
file. A black image whose noise fills as many bytes as a picture is not seen, unless it is the first, middle or last
one."""
SMALL_BLANK = 2.0
"""Where the first, middle or last image is of one colour, images of up to this many times its bytes are decoded."""
MOST_NAMED = 3
"""Images that a sentence names."""


def blank_images(images: SpooledImages) -> tuple[NDArray[np.int64], list[Finding]]:
    """Rows (in the order of the sink) of images of one colour throughout, and a finding a camera."""
    cameras = np.array(images.columns["camera"].to_pylist(), dtype=object)
    encodings = np.array(images.columns["encoding"].to_pylist(), dtype=object)
    length = images.columns["length"].to_numpy()
    marked: list[int] = []
    findings: list[Finding] = []
    for camera in sorted(set(cameras)):
        of_camera = np.flatnonzero((cameras == camera) & (encodings != "missing"))
        # the kinds of file differ in size: each is judged beside its own kind
        blank = [
            row
            for kind in sorted(set(encodings[of_camera]))
            for row in _blank(images, of_camera[encodings[of_camera] == kind], length)
        ]
        if not blank:
            continue
        marked += blank
        places = {row: number for number, row in enumerate(of_camera.tolist())}
        named = ", ".join(str(places[row]) for row in sorted(blank)[:MOST_NAMED])
        text = (
            f"{counted(len(blank), 'image')} of {len(of_camera)} of camera {camera!r}, of one colour throughout: "
            f"number {named}{' …' if len(blank) > MOST_NAMED else ''} in the order of the recording. No picture of a "
            "gel is; marked, and left out of splits and datasets. Check the light and the cable of the camera"
        )
        findings.append(Finding("image-blank", "warning", text, camera, count=len(blank)))
    return np.array(sorted(marked), np.int64), findings


def _blank(images: SpooledImages, rows: NDArray[np.int64], length: NDArray[np.int64]) -> list[int]:
    """Rows, of those of one camera and kind, of images of one colour."""
    known: dict[int, bool] = {}

    def is_blank(row: int) -> bool:
        if row not in known:
            (picture,) = images.decode(np.array([row]))
            known[row] = picture is not None and is_one_colour(picture)
        return known[row]

    limit = SMALL * float(np.median(length[rows]))
    for probe in rows[[0, len(rows) // 2, -1]].tolist():
        if is_blank(probe):
            limit = max(limit, SMALL_BLANK * float(length[probe]))
    return [row for row in rows[length[rows] <= limit].tolist() if is_blank(row)]
