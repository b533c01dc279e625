"""Projections that are learned together: what their loss is, and that it helps where plain ones do not close."""

import json

import numpy as np
import pytest
import torch
from small_models import grid_topology, presses
from touch_world import tiny_recipe

from split_models.methods.cycle import MESHES, PICTURES, CycleObjective, CyclePair
from split_models.tables.mesh_picture import MeshPictures
from tactiledata.optics.surface import GelSurface

pytestmark = pytest.mark.slow

SIZES = {"layers": [32], "dropout": []}


def pair(seed=0):
    torch.manual_seed(seed)
    return CyclePair({"inputs": 4, "outputs": 6, **SIZES}, {"inputs": 6, "outputs": 4, **SIZES})


def batch(seed=1, count=64):
    torch.manual_seed(seed)
    mesh = torch.randn(count, 4)
    deformation = torch.cat([mesh, mesh[:, :2] ** 2], dim=1)
    return {"mesh": mesh, "deformation": deformation, MESHES: 0.7 * mesh[:, None], PICTURES: 0.7 * deformation[:, None]}


def test_the_loss_is_its_parts():
    """Without weights the loss is the plain errors, and each weight adds its own part."""
    network, items = pair(), batch()
    plain = CycleObjective(network, 0.0, 0.0)(items, 0.0)
    both = CycleObjective(network, 2.0, 3.0)(items, 0.0)
    assert plain["loss"] == plain["error"]
    assert "own" not in plain
    assert torch.isclose(both["loss"], plain["error"] + 2.0 * both["cycle"] + 3.0 * both["own"])
    scaled = CycleObjective(network, 0.0, 0.0, (4.0, 0.5))(items, 0.0)["loss"]
    with torch.no_grad():
        errors = [
            torch.nn.functional.mse_loss(way(items[given]), items[wanted])
            for way, given, wanted in ((network.back, "deformation", "mesh"), (network.forth, "mesh", "deformation"))
        ]
    assert torch.isclose(scaled, errors[0] / 4.0 + errors[1] / 0.5)
    identity = {name: items[name] for name in ("mesh", "deformation")}
    for again, one in ((MESHES, "mesh"), (PICTURES, "deformation")):
        identity[again] = identity[one][:, None].repeat(1, 3, 1)
    assert torch.isclose(CycleObjective(network, 0.0, 1.0)(identity, 0.0)["own"], plain["error"])


def test_own_outputs_stop_the_fading():
    """Latent vectors shrink by 0.7 whenever they are encoded again: the plain pair fades, the other one holds."""
    faded = {}
    for own_weight in (0.0, 5.0):
        network = pair()
        objective = CycleObjective(network, 0.0, own_weight)
        learner = torch.optim.Adam(network.parameters(), 1e-2)
        for step in range(250):
            learner.zero_grad()
            objective(batch(step), 0.0)["loss"].backward()
            learner.step()
        with torch.no_grad():
            mesh = start = batch(999)["mesh"]
            for _ in range(10):
                mesh = network.back(0.7 * network.forth(0.7 * mesh))
            faded[own_weight] = float(mesh.norm() / start.norm())
    assert faded[0.0] < 0.2
    assert faded[5.0] > 3 * faded[0.0]


def test_meshes_are_drawn_by_their_depth():
    """An undeformed mesh is one plain colour; a press is brighter where it is deep, and nowhere else."""
    topology = grid_topology(41, 33, 0.0006)
    drawn = MeshPictures(GelSurface(topology.places, topology.faces), (80, 60), 1e-3)
    flat, pressed = (drawn.draw(one).astype(int) for one in (np.zeros_like(topology.places), presses(topology, 1)[0]))
    assert (flat == flat[0, 0]).all()
    changed = np.abs(pressed - flat).sum(axis=2)
    place = np.unravel_index(changed.argmax(), changed.shape)
    assert changed[place] > 150
    assert (changed == 0).mean() > 0.2


@pytest.mark.parametrize("method", ["split_cycle"])
def test_a_row_of_the_other_tables(method, touch_store, tmp_path, monkeypatch, capsys):
    """The pair serves the table of meshes as well, and is kept."""
    from tactiledata.cli.main import run

    path = tmp_path / "r.json"
    path.write_text(json.dumps(tiny_recipe(touch_store, "mesh", methods=[method], parts=["val"])))
    monkeypatch.setattr("sys.argv", ["tactiledata", "run", str(path), "--out", str(tmp_path / "out"), "--json"])
    with pytest.raises(SystemExit) as ended:
        run()
    assert ended.value.code == 0
    assert json.loads(capsys.readouterr().out)["rows"][0]["method"] == method
    assert len(list((tmp_path / "out" / "models").glob("cycle_pair_own-*"))) == 1
