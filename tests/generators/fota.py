"""Tiny faithful fakes of FoTa: WebDataset tars whose published split shuffles the frames of sequences."""

import io
import json
import tarfile
from pathlib import Path

import cv2
import numpy as np


def write(folder, rng, *, domain="yuan18", sequences=3, frames=8, shard=9, pose=False, **faults):
    """``<domain>/{train,val}/…`` below ``folder``; returns the folder.

    Faults: ``count`` (what train/count.txt says), ``escape`` (a member name), ``lone_json``, ``lone_image``,
    ``cut`` (share of the first tar that is left), ``link``, ``broken_json``, ``drop_count``.
    """
    home = Path(folder) / domain
    samples = [
        (key, _jpeg(rng), _label(sequence, frame, pose)) for key, sequence, frame in keys(domain, sequences, frames)
    ]
    order = rng.permutation(len(samples))
    edge = int(0.8 * len(samples))
    for part, rows in (("train", order[:edge]), ("val", order[edge:])):
        (home / part).mkdir(parents=True)
        for number, start in enumerate(range(0, len(rows), shard)):
            chosen = [samples[row] for row in rows[start : start + shard]]
            is_first = part == "train" and number == 0
            _tar(home / part / f"data-{number:06d}.tar", chosen, faults if is_first else {})
        count = faults.get("count", len(rows)) if part == "train" else len(rows)
        if not faults.get("drop_count"):
            (home / part / "count.txt").write_text(str(count))
    return Path(folder)


def keys(domain, sequences, frames):
    """Keys as the corpus' scripts make them, with their sequence and frame."""
    for sequence in range(sequences):
        for frame in range(frames):
            if domain == "tvl":
                yield f"data{sequence + 1}_{frame}-0-{frame * 17:04d}", sequence, frame
            elif domain == "calandra17":
                when = "during" if frame % 2 else "before"
                yield f"calandra_corl_{frame // 4}_{sequence}_gelsight{'AB'[frame // 2 % 2]}_{when}", sequence, frame
            elif domain == "objectfolder_real":
                yield f"Wooden Spoon_{sequence}_{frame}", sequence, frame
            else:
                yield f"{sequence}_2_frame{frame + 1:06d}", sequence, frame


def _label(sequence, frame, pose):
    label = {"fuzziness": sequence, "wool": True, "obj_name": f"cloth {sequence}"}
    if pose:
        label |= {"x_mm": 1.5 * frame, "y_mm": 2.0, "z_mm": -3.0}
        if pose != "position":
            label |= {"quat_x": 0.0, "quat_y": 0.0, "quat_z": 0.0, "quat_w": 1.0}
    return label


def _tar(path, samples, faults):
    with tarfile.open(path, "w") as archive:
        for number, (key, image, label) in enumerate(samples):
            text = b"{not json" if faults.get("broken_json") and number == 0 else json.dumps(label).encode()
            if not (faults.get("lone_json") and number == 1):
                _add(archive, f"{key}.jpg", image)
            if not (faults.get("lone_image") and number == 1):
                _add(archive, f"{key}.json", text)
        if faults.get("escape"):
            _add(archive, faults["escape"], samples[0][1])
        if faults.get("link"):
            member = tarfile.TarInfo("9_9_frame000001.jpg")
            member.type, member.linkname = tarfile.SYMTYPE, "/etc/passwd"
            archive.addfile(member)
    if faults.get("cut"):
        content = path.read_bytes()
        path.write_bytes(content[: int(len(content) * faults["cut"])])


def _add(archive, name, content):
    member = tarfile.TarInfo(name)
    member.size = len(content)
    archive.addfile(member, io.BytesIO(content))


def _jpeg(rng):
    return cv2.imencode(".jpg", rng.integers(0, 255, (24, 32, 3), dtype=np.uint8))[1].tobytes()
