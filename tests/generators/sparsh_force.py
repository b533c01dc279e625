"""Tiny faithful fakes of Sparsh's force sets: pickled lists of JPEG bytes, forces in one dict per batch."""

import pickle
from pathlib import Path

import cv2
import numpy as np

PROBES = ("sphere", "flat", "sharp")


def write(folder, rng, *, probes=PROBES, images=40, per_file=25, protocol=4, **faults):
    """Batches below ``folder``; returns it.

    Faults: ``longer_indexes`` (5 more indexes than forces), ``flags`` (number of contact flags), ``outside`` (an index
    behind the last image), ``cut`` (bytes cut from this file's end), ``evil`` (an object that runs code), ``arrays``
    (images as arrays), ``overlap`` (two trajectories share images), ``no_labels``.
    """
    for probe in probes:
        home = Path(folder) / probe / "batch_1"
        home.mkdir(parents=True)
        pictures = [_jpeg(rng) for _ in range(images)]
        if faults.get("arrays"):
            pictures = [rng.integers(0, 255, (32, 24, 3), dtype=np.uint8) for _ in range(images)]
        for number, start in enumerate(range(0, images, per_file)):
            path = home / f"dataset_digit_{number:02d}.pkl"
            path.write_bytes(pickle.dumps(pictures[start : start + per_file], protocol))
            if faults.get("cut") == number:
                path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
        if not faults.get("no_labels"):
            content = faults.get("evil") or _labels(rng, images, faults)
            (home / "dataset_slip_forces.pkl").write_bytes(pickle.dumps(content, protocol))
        (home / "org_dataset_digit_00.pkl").write_bytes(b"the originals, which nobody needs")
    return Path(folder)


def spans(images, overlap=False):
    """First and last image of each trajectory."""
    third = images // 4
    second = third if overlap else 2 * third
    return [(2, third), (second, 3 * third)]


def _labels(rng, images, faults):
    in_contact = np.zeros(faults.get("flags") or images, dtype=np.int64)
    trajectories = {}
    for number, (start, stop) in enumerate(spans(images, faults.get("overlap"))):
        start -= 3 if faults.get("overlap") and number else 0
        indexes = np.arange(start, stop)
        forces = np.column_stack(
            [rng.normal(size=len(indexes)), rng.normal(size=len(indexes)), -np.arange(len(indexes))]
        )
        if faults.get("longer_indexes"):
            forces = forces[:-2]
        if faults.get("outside") and number:
            indexes[-1] = images + 100
        in_contact[indexes[indexes < len(in_contact)]] = 1
        trajectories[number] = {
            "indexes": indexes,
            "forces": forces,
            "slip_label": (np.arange(len(forces)) % 2).astype(np.int64),
            "coef_friction": 0.5,
        }
    return {"in_contact": in_contact, "trajectories": trajectories}


def _jpeg(rng):
    return cv2.imencode(".jpg", rng.integers(0, 255, (32, 24, 3), dtype=np.uint8))[1].tobytes()
