"""The sensor whose style is wanted, by name: its picture without contact, and whose picture that is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.take import UNUSABLE
from tactiledata.errors import StoreError, TactileDataError, UnknownName
from tactiledata.sensors.backgrounds import ALIASES, bundled_backgrounds, load_background, resolve_background
from tactiledata.store.read.reader import Store

YCB_FORMAT = "ycb_slide"
"""Sources of this format make a store an imported YCB-Slide."""
YCB_SERIALS = {"ycb-sensorA": "ycb-slide-bg0", "ycb-sensorB": "ycb-slide-bg4"}
"""Units of the corpus that the two names stand for: those whose numbers the bundled pictures of the same names bear."""
MEDIAN_FRAMES = 64
"""Frames of which the median is taken where a sensor has no picture without contact."""


@dataclass(frozen=True)
class Target:
    """A sensor to transfer to.

    Parameters
    ----------
    name : str
        The serial under which transferred frames are filed: of a store's unit its own, so that holding that unit out
        holds them out too; else the name that was asked for.
    background : (H, W, 3) uint8 RGB
    resolved : str
        In words, whose picture that is.
    licence, attribution, model : str
    """

    name: str
    background: NDArray[np.uint8]
    resolved: str
    licence: str = ""
    attribution: str = ""
    model: str = "digit"


def find_target(name: str, store: Store) -> Target:
    """The sensor that a name stands for.

    The store's own sensors come first, then `ycb-sensorA` and `ycb-sensorB`, then the bundled pictures. The two aliases
    are units of an imported YCB-Slide where the store, or another in the working folder, is one that holds them; else
    bundled pictures by that corpus's authors.

    Raises
    ------
    UnknownName
        Nothing goes by that name; lists near ones.
    StoreError
        A YCB-Slide unit without any whole frame.
    """
    if name in store.manifest["references"]:
        return _of_store(name, store)
    if name in YCB_SERIALS and (place := ycb_store(name, store)) is not None:
        return _of_store(YCB_SERIALS[name], place)
    bundled = bundled_backgrounds()
    if name not in bundled and name not in ALIASES:
        known = {*store.manifest["references"], *ALIASES, *bundled}
        raise UnknownName(
            "sensor", name, known, "`tactiledata sensors add NAME --background FILE...` adds one to the store."
        )
    info = resolve_background(name)
    stands_for = "" if info.name == name else f"{info.name}, "
    words = f"{stands_for}a real picture that comes with the toolkit ({info.source})"
    return Target(name, load_background(name), words, info.licence, info.attribution)


def ycb_store(alias: str, store: Store) -> Store | None:
    """The imported YCB-Slide, among a store and those in the working folder, that holds an alias's unit."""
    return next((place for place in _with_neighbours(store) if _holds_unit(place, YCB_SERIALS[alias])), None)


def _with_neighbours(store: Store) -> Iterator[Store]:
    yield store
    for path in sorted(Path.cwd().glob("*.zarr")):
        if path.resolve() == Path(store.location).resolve():
            continue
        try:
            yield Store.open(path)
        except TactileDataError:
            continue  # what is broken, or no store, is not the corpus


def _holds_unit(store: Store, serial: str) -> bool:
    is_ycb_slide = YCB_FORMAT in store.sources(["format"])["format"].to_pylist()
    return is_ycb_slide and serial in store.trajectories(["sensor"])["sensor"].to_pylist()


def _of_store(serial: str, store: Store) -> Target:
    model = store.sensors().get(serial, {}).get("model", "") or "digit"
    where = f"sensor {serial} of {store.location}"
    if serial in store.manifest["references"]:
        reference = store.reference(serial)
        return Target(serial, reference.image, f"{where} ({reference.origin})", reference.licence, model=model)
    image, count = _median_frame(store, serial)
    words = f"{where} (it has no picture without contact: median of {count} of its frames, touches among them)"
    return Target(serial, image, words, model=model)


def _median_frame(store: Store, serial: str) -> tuple[NDArray[np.uint8], int]:
    frames = store.frames(["sensor", "flags"])
    whole = (np.asarray(frames["flags"]) & UNUSABLE) == 0
    rows = np.flatnonzero(whole & np.asarray(pc.equal(frames["sensor"].cast("string"), serial)))
    if not len(rows):
        raise StoreError(
            f"sensor {serial} of {store.location} has no whole image",
            "frames to take a median of",
            f"Add its picture: `tactiledata sensors add {serial} --background FILE... --store {store.location}`.",
        )
    chosen = rows[np.unique(np.linspace(0, len(rows) - 1, MEDIAN_FRAMES).astype(int))]
    pictures = _of_one_size([np.asarray(image) for image in store.images(chosen)])
    return np.rint(np.median(pictures, axis=0)).astype(np.uint8), len(pictures)


def _of_one_size(pictures: Sequence[NDArray[np.uint8]]) -> list[NDArray[np.uint8]]:
    return [picture for picture in pictures if picture.shape == pictures[0].shape]
