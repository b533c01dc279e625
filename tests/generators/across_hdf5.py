"""Tiny faithful fakes of ACROSS' simulation results: trials, steps and environments in HDF5, natural order matters."""

from pathlib import Path

import h5py
import numpy as np


def write(folder, rng, *, sensors=("digit",), trials=2, steps=11, environments=3, vertices=20, **faults):
    """``results_<sensor>_<job>.hdf5`` files in ``folder``; returns it.

    Faults: ``cut`` (share of the file that is left), ``drop_env``, ``other_mesh``, ``external`` (a link to this file),
    ``huge``, ``other_name``.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for sensor in sensors:
        path = folder / (faults.get("other_name") or f"results_{sensor}_job_7.hdf5")
        with h5py.File(path, "w") as file:
            for trial in range(trials):
                for step in range(steps):
                    home = file.create_group(f"trial_{trial}/step_{step}")
                    for environment in range(environments):
                        _environment(home, sensor, environment, trial, step, vertices, rng, faults)
            if faults.get("external"):
                file["trial_9"] = h5py.ExternalLink(str(faults["external"]), "/trial_0")
        if faults.get("cut") is not None:
            content = path.read_bytes()
            path.write_bytes(content[: int(len(content) * faults["cut"])])
    return folder


def mesh(trial, step, environment, vertices):
    """The planted vertices (V, 3), metres."""
    start = np.arange(3 * vertices, dtype=np.float64).reshape(-1, 3) * 1e-4
    return start + 1e-3 * trial + 1e-5 * step + 1e-6 * environment


def _environment(home, sensor, environment, trial, step, vertices, rng, faults):
    if faults.get("drop_env") == (trial, step, environment):
        return
    count = vertices + 1 if faults.get("other_mesh") == (trial, step, environment) else vertices
    nodes = mesh(trial, step, environment, count).astype(np.float32)
    if faults.get("huge") and step == 1:
        home.create_dataset(f"nodal_coords_{sensor}/env_{environment}", shape=(10**9, 3), dtype="f4", chunks=(1000, 3))
    else:
        home[f"nodal_coords_{sensor}/env_{environment}"] = nodes
    home[f"net_force_vecs_{sensor}/env_{environment}"] = np.array([0.0, 0.1 * step, -0.5 * step], dtype=np.float32)
