"""Two steps of each network and two transfers, on a processor and with small networks."""

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.nightly
def test_the_quick_form_prints_twelve_networks_that_agree_with_themselves(tmp_path):
    """Each network takes two steps; on the CPU what it gives, and what a transfer draws, differ by nothing."""
    done = subprocess.run(
        [sys.executable, ROOT / "benchmarks" / "paper_networks.py", "--quick", "--json", "figures.json"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=900,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert len(figures["networks"]) == 12
    for name, facts in figures["networks"].items():
        assert f"| {name} | {facts['batch']} |" in done.stdout
        assert len(facts["step_seconds"]) == 2, name
        assert all(one["largest"] == 0.0 < one["spread"] for one in facts["differs"].values()), name
    assert set(figures["transfer"]) == {"latent", "latent-on-background"}
    assert all(one["largest difference"] == 0 < one["pictures"] for one in figures["transfer"].values())


@pytest.mark.slow
def test_a_device_that_gives_something_else_is_told():
    """Networks that add 0.25 at their second call, which is the CPU's, differ by 0.25."""
    import torch
    from paper_networks import differences

    calls = []

    class Drifting(torch.nn.Module):
        def forward(self, values):
            calls.append(len(values))
            return values + 0.25 * (len(calls) - 1)

    run = SimpleNamespace(device=torch.device("cpu"), frames=lambda part: Meshes())
    apart = differences(run, "mesh_vae", Drifting())
    assert calls == [4, 4]
    assert apart["output"]["largest"] == 0.25
    assert apart["output"]["spread"] > 1.0


class Meshes:
    """Four meshes of two vertices."""

    def __len__(self):
        return 4

    def displacements(self, numbers):
        return np.arange(24, dtype=np.float32).reshape(4, 2, 3)[numbers]
