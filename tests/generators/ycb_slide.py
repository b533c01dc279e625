"""Tiny faithful fakes of YCB-Slide: the layout, keys and traps of the corpus, with pictures of a few pixels."""

import pickle
from datetime import datetime, timedelta
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

OBJECTS = ("004_sugar_box", "035_power_drill")
START = datetime(2022, 3, 20, 18, 40, 57, 408349)


def write(folder, rng, *, objects=OBJECTS, runs=2, frames=12, variant="synced", sim=True, lost=(), jump=None, **faults):
    """A small ``dataset/`` below ``folder``; returns its root.

    ``variant``: ``synced`` (synced_data.npy), ``digit`` (digit_data.npy only), ``old-keys`` (frame, timestamp,
    image_path). ``lost``: rows whose pose is empty. ``jump``: row at which the tracker jumps. Faults: ``no_frames``,
    ``drop_frame``, ``drop_alignment``, ``escape``, ``extra_frame``, ``optitrack``, ``bad_time``.
    """
    root = Path(folder) / "dataset"
    for thing in objects:
        home = root / "real" / thing
        home.mkdir(parents=True)
        alignment = np.eye(4)
        alignment[:3, :3] = Rotation.from_euler("z", 20, degrees=True).as_matrix()  # acts on nothing
        alignment[:3, 3] = [0.001, -0.002, 0.003]
        if not faults.get("drop_alignment"):
            np.save(home / "alignment.npy", alignment)
        for run in range(runs):
            _real_run(home / f"dataset_{run}", thing, rng, frames, variant, lost, jump, faults)
        if faults.get("optitrack"):
            write_optitrack(home / f"{thing}.csv", thing, rng)
        if sim:
            for run in range(runs):
                _sim_run(root / "sim" / thing / f"{run:02d}", rng, frames)
    return root


def poses(rng, count):
    """Poses (n, 7) of a slow slide, metres."""
    path = np.array([0.1, 0.2, 0.3]) + np.cumsum(rng.normal(scale=0.0005, size=(count, 3)), axis=0)
    turns = Rotation.from_rotvec(np.cumsum(rng.normal(scale=0.01, size=(count, 3)), axis=0))
    return np.concatenate([path, turns.as_quat()], axis=1)


def _real_run(home, thing, rng, frames, variant, lost, jump, faults):
    names = []
    for row in range(frames):
        names.append(f"frames/frame_{row:07d}.jpg")
        if not faults.get("no_frames"):
            _picture(home / names[-1], rng, (32, 24))
        _picture(home / f"webcam_frames/frame_{row:07d}.jpg", rng, (18, 32))
    if faults.get("drop_frame") is not None:
        (home / names[faults["drop_frame"]]).unlink()
    if faults.get("extra_frame"):
        _picture(home / f"frames/frame_{frames:07d}.jpg", rng, (32, 24))
    digit, still = poses(rng, frames), np.tile(poses(rng, 1), (frames, 1))
    if jump is not None:
        digit[jump, :3] += 0.2
    digit[list(lost)] = np.nan
    stamps = [round(0.0333 * row + 0.0001 * (row % 3), 6) for row in range(frames)]
    if faults.get("bad_time") is not None:
        stamps[faults["bad_time"]] = float("nan")
    if faults.get("escape"):
        names[1] = "../../../../../etc/passwd"
    webcam = [name.replace("frames/", "webcam_frames/") for name in names]
    content = {
        "start_time": START.strftime("%Y-%m-%d %I:%M:%S:%f %p"),
        "digit_frames": names,
        "webcam_frames": webcam,
        "timestamps": stamps,
    }
    if variant == "old-keys":
        longer = [f"data/20_03_2022/{thing}/{home.name}/{name}" for name in names]
        content = {"frame": list(range(frames)), "timestamp": stamps, "image_path": longer, "webcam_path": webcam,
                   "start_time": content["start_time"]}  # fmt: skip
    np.save(home / "digit_data.npy", content, allow_pickle=True)
    if variant == "synced":
        np.save(home / "synced_data.npy", {**content, "poses": {"DIGIT": digit, thing: still}}, allow_pickle=True)


def _sim_run(home, rng, frames):
    for row in range(frames):
        for part, size in (("tactile_images", (32, 24)), ("gt_heightmaps", (32, 24)), ("gt_contactmasks", (32, 24))):
            _picture(home / part / f"{row}.jpg", rng, size, grey=part != "tactile_images")
    truth = poses(rng, frames)
    content = {"gelposes": truth, "camposes": truth, "gelposes_meas": poses(rng, frames)}
    (home / "tactile_data.pkl").write_bytes(pickle.dumps(content))


def write_optitrack(path, thing, rng, *, rows=200, ahead=1.0, rate=120.0):
    """A Motive export with seven header rows, started ``ahead`` seconds before the camera, some cells empty."""
    start = (START - timedelta(seconds=ahead)).strftime("%Y-%m-%d %I.%M.%S.%f %p")
    bodies = ["DIGIT"] * 8 + [thing] * 8
    kinds = ["Rigid Body"] * 16
    parts = (["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"]) * 2
    axes = (["X", "Y", "Z", "W", "X", "Y", "Z", ""]) * 2
    lines = [
        f"Format Version,1.23,Take Name,take,Take Notes,,Capture Frame Rate,{rate},Export Frame Rate,{rate},"
        f"Capture Start Time,{start},Total Frames in Take,{rows}",
        "",
        ",,Type,".replace("Type,", "") + ",".join(kinds),
        ",," + ",".join(bodies),
        ",," + ",".join(["0"] * 16),
        ",," + ",".join(parts),
        "Frame,Time (Seconds)," + ",".join(axes),
    ]
    digit, still = poses(rng, rows), poses(rng, 1)[0]
    for row in range(rows):
        cells = [*digit[row, 3:], *digit[row, :3], 0.0002, *still[3:], *still[:3], 0.0001]
        texts = [f"{cell:.9f}" for cell in cells]
        if 60 <= row < 70:
            texts[:8] = [""] * 8  # the tracker lost the DIGIT
        lines.append(f"{row},{row / rate:.6f}," + ",".join(texts))
    path.write_text("\n".join(lines) + "\n")


def _picture(path, rng, size, grey=False):
    path.parent.mkdir(parents=True, exist_ok=True)
    shape = size if grey else (*size, 3)
    cv2.imwrite(str(path), rng.integers(0, 255, shape, dtype=np.uint8))
