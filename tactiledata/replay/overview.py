"""Page of a store's replayed meshes: counts, errors against measured forces, pictures of firm touches."""

from __future__ import annotations

import json
from pathlib import Path, PurePosixPath

import numpy as np

from tactiledata import __version__
from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.wording import LINEAR_IS_LOW, counted
from tactiledata.replay.effect_words import effects_in_words
from tactiledata.report.page import Section, render_page
from tactiledata.report.panels import panels_of
from tactiledata.report.replay_plots import ReplayedTouch, draw_replayed
from tactiledata.store.layout.places import folder_name
from tactiledata.store.read.meshes import HAS_MESH, StoredMesh
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_recordings, touch_mark

MOST_TOUCHES = 5
"""Most touches of a mesh that are drawn."""
IN_CONTACT = HAS_MESH[0]
"""Status of a frame with contact."""


def write_replay_page(store: Store, name: str, out: Path) -> Path:
    """Write the page ``replay-<name>.html`` of a mesh, and return its path.

    Parameters
    ----------
    store : Store
        A store with meshes.
    name : str
        Name of the mesh.
    out : Path
        Folder of the page; it is made if needed.
    """
    path = out / f"replay-{folder_name(name)}.html"
    footer = f"tactiledata {__version__}; store digest {store.digest}; mesh digest {store.mesh(name).facts['digest']}"
    sections = [mesh_section(store, name)]
    named = f"The store is {PurePosixPath(store.location).name}."
    html = render_page("What was replayed", [named], sections, footer, simulated_recordings(store))
    write_atomic(path, html.encode())
    return path


def mesh_sections(store: Store) -> list[Section]:
    """Return one page section for each mesh of a store."""
    return [mesh_section(store, name) for name in store.mesh_names]


def mesh_section(store: Store, name: str) -> Section:
    """Return the page section of a mesh: settings, error against the measured force, counts, pictures."""
    mesh = store.mesh(name)
    sentences = [*_settings_sentences(mesh), *_compared(store, mesh)]
    touches = [replayed_touch(store, mesh, row) for row in _chosen(store, mesh)]
    caption = (
        "Firm touches, one per sensor and indenter. Left: the gel's outer surface at the largest simulated force, "
        "coloured by how far it moved (height doubled). Right: measured (dots) and simulated (lines) contact force; "
        "dotted: the moment that is shown."
    )
    pictures = [panels_of(draw_replayed(touches), caption)] if touches else []
    counts = sorted((int(code), count) for code, count in mesh.facts["counts"].items())
    rows = [(mesh.statuses[code], count) for code, count in counts]
    return Section(f"Mesh {name}", sentences, ("frames", "how many"), rows, pictures)


def _settings_sentences(mesh: StoredMesh) -> list[tuple[str, str]]:
    """Sentences on size, material, fidelity and effects of a mesh, each with its severity."""
    sizes, material = mesh.facts["sizes"], mesh.settings["material"]
    sentences = [
        (
            "",
            f"{sizes['vertices']} vertices, of which {sizes['kept']} are kept. The replay was given "
            f"E {material['youngs_modulus'] / 1e3:.4g} kPa (stiffness), nu {material['poisson_ratio']:.4g} (Poisson's "
            f"ratio) and mu {material['friction']:.4g} (friction); {mesh.settings['fidelity']}.",
        )
    ]
    if effects := effects_in_words(mesh.settings):
        sentences.append(("", f"With {effects}. The simulated force is what the force sensor would read."))
    if mesh.settings["fidelity"] == "linear":
        sentences.append(("warning", f"Linear is a preview: {LINEAR_IS_LOW}."))
    return sentences


def _compared(store: Store, mesh: StoredMesh) -> list[tuple[str, str]]:
    """Sentence on the error of the simulated force in all frames with contact, with its severity."""
    if "contact_wrench" not in store.aligned_names or store.meaning("aligned", "contact_wrench").frame != "gel":
        return [("", "The store has no measured contact force in the gel frame to compare with.")]
    in_contact = np.flatnonzero(mesh.status() == IN_CONTACT)
    measured = store.aligned("contact_wrench", in_contact)[0][:, :3]
    error = np.linalg.norm(mesh.wrench(in_contact)[:, :3] - measured, axis=1)
    is_known = np.isfinite(error)
    if not is_known.any():
        return [("", "No frame in contact has a measured force to compare with.")]
    strength = np.linalg.norm(measured[is_known], axis=1)
    text = (
        f"Over {counted(int(is_known.sum()), 'frame')} in contact the simulated force differs from the measured one by "
        f"{np.median(error[is_known]):.2f} N in the median, and by at most {np.percentile(error[is_known], 90):.2f} N "
        f"in nine of ten (the median measured force is {np.median(strength):.2f} N)."
    )
    return [("", text)]


def _chosen(store: Store, mesh: StoredMesh) -> list[int]:
    """Rows of the trajectories to show: for each pair of sensor and indenter the one with the largest force."""
    table = store.trajectories(["sensor", "indenter", "frame_start", "frame_stop"]).to_pylist()
    force = np.nan_to_num(np.linalg.norm(mesh.wrench()[:, :3], axis=1))
    best: dict[tuple[str, str], tuple[float, int]] = {}
    for row, facts in enumerate(table):
        peak = float(force[facts["frame_start"] : facts["frame_stop"]].max(initial=0.0))
        key = (facts["sensor"], facts["indenter"])
        if peak > best.get(key, (0.0, -1))[0]:
            best[key] = peak, row
    # each indenter is shown once before any is shown a second time
    shown: list[tuple[str, str]] = []
    remaining = sorted(best)
    while remaining and len(shown) < MOST_TOUCHES:
        shown_indenters = {indenter for _, indenter in shown}
        shown.append(min(remaining, key=lambda key: (key[1] in shown_indenters, -best[key][0])))
        remaining.remove(shown[-1])
    return [best[key][1] for key in shown]


def replayed_touch(store: Store, mesh: StoredMesh, row: int) -> ReplayedTouch:
    """Return what is drawn of one trajectory: forces over time, and the deformed pad.

    Parameters
    ----------
    store : Store
        Gives times and measured forces.
    mesh : StoredMesh
        Gives simulated forces and displacements.
    row : int
        Row of the trajectory in the store's table.
    """
    facts = store.trajectories().slice(row, 1).to_pylist()[0]
    frames = np.arange(facts["frame_start"], facts["frame_stop"])
    seconds = (store.frames(["t_ns"])["t_ns"].to_numpy()[frames] - facts["start_ns"]) / 1e9
    simulated = mesh.wrench(frames)[:, :3]
    shown = int(np.argmax(np.nan_to_num(np.linalg.norm(simulated, axis=1))))
    # the deformed pad at the frame of the largest simulated force
    pad, number = mesh.pad(), int(mesh.pad_numbers(frames[shown : shown + 1])[0])
    displacement = np.zeros_like(pad.vertices[number])
    displacement[pad.kept] = mesh.displacement(frames[shown : shown + 1])[0]
    native, measured = _measured(store, facts["signal_rows"], facts["start_ns"])
    names = [facts["sensor"], facts["indenter"], full_names(store)[row]]
    title = "  ".join([*names, *filter(None, [touch_mark(store, row)])])
    return ReplayedTouch(
        title, native, measured, seconds, simulated, seconds[shown], pad.vertices[number], displacement, pad.triangles
    )


def _measured(store: Store, signal_rows: str, start_ns: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,), s, and measured contact forces (n, 3), N, at the native rate; empty where there are none."""
    first, stop = json.loads(signal_rows).get("contact_wrench", [0, 0])
    if first == stop or store.signal("contact_wrench").frame != "gel":
        return np.zeros(0), np.zeros((0, 3))
    signal = store.signal("contact_wrench")
    return (signal.t_ns(first, stop) - start_ns) / 1e9, signal.values(first, stop)[:, :3]
