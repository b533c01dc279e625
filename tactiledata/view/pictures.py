"""Pictures of a trajectory, how they differ from the sensor without contact, and where they show a contact."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from tactiledata.arrays import Indices, PictureArray
from tactiledata.contract.take import UNUSABLE
from tactiledata.contract.wording import counted
from tactiledata.errors import StoreError
from tactiledata.report.plots import difference_picture
from tactiledata.sensors.image_checks import shows_contact
from tactiledata.store.read.reader import Store
from tactiledata.view.chosen import thinned
from tactiledata.view.options import ViewOptions
from tactiledata.view.rerun_package import load_rerun
from tactiledata.view.touch_log import TouchLog

PICTURES, DIFFERENCE, CONTACT, BACKGROUND = "picture", "difference", "contact", "background"
"""Entities below that of a camera."""
BLOCK = 16
"""Frames in memory at once."""
JPEG_QUALITY = 95
"""Quality of the differences, which are kept as JPEG; pictures stay as they came."""
CONTACT_CLASS, CONTACT_COLOUR = 1, (255, 120, 0, 120)
MEDIA = {"jpeg": "image/jpeg", "png": "image/png"}


def camera_entity(camera: str) -> str:
    """The entity of a camera, above those of its pictures."""
    return f"cameras/{load_rerun().escape_entity_path_part(camera)}"


def put_pictures(log: TouchLog, store: Store, options: ViewOptions) -> tuple[list[str], list[str], int]:
    """Put the pictures of a trajectory; return its cameras, what is missing in words, and how many pictures there are.

    Parameters
    ----------
    log : TouchLog
    store : Store
    options : ViewOptions
    """
    facts = log.touch.facts
    rows = np.arange(facts["frame_start"], facts["frame_stop"])
    table = store.frames(["camera", "sensor", "t_ns", "flags"]).slice(facts["frame_start"], len(rows))
    cameras = np.array(table["camera"].to_pylist(), object)
    missing, shown = [], 0
    names = sorted(set(cameras.tolist()))
    for camera in names:
        own = np.flatnonzero(cameras == camera)
        own = own[thinned(len(own), options.stride, options.pictures)]
        sensor = table["sensor"][int(own[0])].as_py()
        count, words = _put_camera(
            log,
            store,
            camera_entity(camera),
            rows[own],
            table["t_ns"].to_numpy()[own],
            (table["flags"].to_numpy()[own] & UNUSABLE) == 0,
            _background(store, sensor),
        )
        shown += count
        missing += words
    if not names:
        missing.append("No picture: the trajectory has no frames.")
    return names, missing, shown


def _background(store: Store, sensor: str) -> PictureArray | None:
    return store.reference(sensor).image if sensor in store.manifest["references"] else None


def _put_camera(
    log: TouchLog,
    store: Store,
    entity: str,
    rows: Indices,
    t_ns: Any,
    usable: Any,
    background: PictureArray | None,
) -> tuple[int, list[str]]:
    """Put the frames of one camera; return how many pictures were put, and what is missing in words."""
    rr = load_rerun()
    shown = unlike = broken = 0
    if background is not None:
        log.put_static(f"{entity}/{BACKGROUND}", rr.EncodedImage(contents=_png(background), media_type="image/png"))
        classes = [(0, "no contact", (0, 0, 0, 0)), (CONTACT_CLASS, "contact", CONTACT_COLOUR)]
        log.put_static(f"{entity}/{CONTACT}", rr.AnnotationContext(classes))
    encodings = store.frames(["encoding"])["encoding"]
    for first in range(0, len(rows), BLOCK):
        for place in range(first, min(first + BLOCK, len(rows))):
            row = int(rows[place])
            log.at(int(t_ns[place]))
            picture = _picture(store, row) if usable[place] else None
            if picture is None:
                broken += 1
                for part in (PICTURES, DIFFERENCE, CONTACT):
                    log.clear(f"{entity}/{part}")
                continue
            shown += 1
            log.put(f"{entity}/{PICTURES}", _as_it_came(store, row, encodings[row].as_py(), picture))
            if background is None:
                continue
            if background.shape != picture.shape:
                unlike += 1
                continue
            difference = difference_picture(picture, background)
            log.put(f"{entity}/{DIFFERENCE}", rr.EncodedImage(contents=_jpeg(difference), media_type="image/jpeg"))
            seen = shows_contact(picture, background)
            mask = np.where(seen.is_contact & seen.mask, CONTACT_CLASS, 0).astype(np.uint8)
            log.put(f"{entity}/{CONTACT}", rr.SegmentationImage(mask))
        # what is written leaves the memory before more is read
        log.flush()
    missing = []
    if background is None:
        missing.append(
            "No difference and no contact mask: the store has no picture of the sensor without contact "
            "(`tactiledata sensors add` adds one)."
        )
    if unlike:
        missing.append(f"No difference in {counted(unlike, 'frame')}: the picture without contact has another size.")
    if broken:
        missing.append(f"No picture in {counted(broken, 'frame')}: not recorded, broken, of another size, or blank.")
    return shown, missing


def _picture(store: Store, row: int) -> PictureArray | None:
    """A frame's picture (H, W, 3) RGB; ``None`` where it cannot be read."""
    try:
        return np.asarray(store.images([row], threads=1)[0])
    except StoreError:
        return None


def _as_it_came(store: Store, row: int, encoding: str, picture: PictureArray) -> Any:
    """The picture of a frame for rerun: JPEG and PNG bytes as the store has them, raw frames as they are."""
    rr = load_rerun()
    if encoding not in MEDIA:
        return rr.Image(picture, color_model="RGB")
    return rr.EncodedImage(contents=store.encoded([row])[0], media_type=MEDIA[encoding])


def _jpeg(picture: PictureArray) -> bytes:
    return cv2.imencode(".jpg", picture[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


def _png(picture: PictureArray) -> bytes:
    return cv2.imencode(".png", picture[:, :, ::-1])[1].tobytes()
