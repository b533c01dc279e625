"""From touch to picture: what the steps give is what the method gives, and both resolutions see the same frames."""

import json
from operator import mul

import cv2
import numpy as np
import pytest
import yaml
from small_models import grid_topology, image_vae, mesh_vae, pictures, presses
from touch_world import PLAN, tiny_recipe

from split_models.methods.optical_method import OpticalMethod
from split_models.methods.taxim import taxim_published
from split_models.networks.latent import LatentMeshToImage, NoContact
from split_models.networks.projection import Projection
from split_models.tables.inference_time import cost_rows
from split_models.tables.peak_memory import peak_memory
from split_models.tables.simulated_frames import SimulatedFrames
from split_models.tables.step_race import TimedMethod, steps_of, time_methods
from tactiledata.cli.main import run
from tactiledata.gel.mesh.structured_pad import PLANS, GridPlan
from tactiledata.optics.surface import GelSurface

TOPOLOGY = grid_topology()
SURFACE = GelSurface(TOPOLOGY.places, TOPOLOGY.faces)
BACKGROUND = pictures(1, seed=9)[0]
FINER = GridPlan(8, 9, 0.8e-3, (4.8e-3, 5.6e-3), (0.0, 0.4, 0.8, 1.0))


@pytest.mark.parametrize(
    "method",
    [
        NoContact(),
        taxim_published(SURFACE),
        LatentMeshToImage("split", mesh_vae(), image_vae(), Projection(8, 16, (16,))),
        LatentMeshToImage("nosplit", mesh_vae(), image_vae(), Projection(8, 16, (16,)), is_split=False),
    ],
    ids=lambda method: method.name,
)
def test_steps_together_are_the_method(method):
    """The steps one after the other draw what `predict` draws."""
    moved = presses(TOPOLOGY, 1)
    found = moved
    for _, step in steps_of(method, BACKGROUND):
        found = step(found)
    assert np.array_equal(found, method.predict(moved, BACKGROUND))


@pytest.mark.slow
def test_memory_is_that_of_the_work():
    """A process that fills 200 MB more has a peak 200 MB higher, whatever this one holds."""
    little, much = peak_memory(mul, b"x", 1), peak_memory(mul, b"x", 200_000_000)
    assert 190 < much - little < 260


def test_a_race_is_over_the_same_frames():
    """Every contender draws all frames, each on its own mesh; the ratio is that of the overall medians."""
    moved = list(presses(TOPOLOGY, 4))
    finer = grid_topology(33, 23, 0.0005)
    simulated = {
        "low": SimulatedFrames(SURFACE, 800, [0.03, 0.01, 0.02], moved, [(0, n) for n in range(4)], 1.0),
        "high": SimulatedFrames(
            GelSurface(finer.places, finer.faces), 3000, [0.2], list(presses(finer, 4)), [(0, n) for n in range(4)], 2.0
        ),
    }
    timed = [
        TimedMethod("taxim_published", taxim_published(SURFACE), "low"),
        TimedMethod("taxim_published", taxim_published(SURFACE), "high"),
        TimedMethod("no_contact", NoContact(), "low"),
    ]
    time_methods(timed, simulated, [(number, "D1") for number in (0, 2, 3)], {"D1": BACKGROUND})
    assert [list(one.seconds) for one in timed] == [["height map", "optics"]] * 2 + [["picture"]]
    assert all(len(one.pictures) == 3 for one in timed)
    assert np.array_equal(timed[0].pictures[1], taxim_published(SURFACE).predict(moved[2:3], BACKGROUND)[0])
    on_finer = OpticalMethod(**{**vars(taxim_published(SURFACE)), "surface": simulated["high"].surface})
    assert np.array_equal(
        timed[1].pictures[2], on_finer.predict(simulated["high"].displacements[3][None], BACKGROUND)[0]
    )
    low, high, network = cost_rows(timed, simulated)
    assert (low["simulation"]["value"], high["simulation"]["value"]) == (0.02, 0.2)
    assert high["memory to simulate"]["value"] == 2.0
    for row, resolution in ((low, "low"), (high, "high")):
        ratio = network[f"times faster than the fastest baseline, {resolution} resolution"]["value"]
        assert ratio == pytest.approx(row["overall"]["value"] / network["overall"]["value"])
    assert list(low) == list(network)  # so that columns stand in one order
    assert all(score["value"] is None for name, score in low.items() if name.startswith("times"))
    assert network["height map"]["value"] is None


@pytest.mark.slow
def test_the_table_from_a_store(touch_store, tmp_path, monkeypatch, capsys):
    """Taxim at both resolutions, SPLIT at the low one, all steps, and the picture of them; another pad is refused."""
    monkeypatch.setattr("split_models.tables.step_race.peak_memory", lambda *_: 5.0)
    monkeypatch.setattr("split_models.tables.simulated_frames.peak_memory", lambda *_: 7.0)
    path = tmp_path / "times.yaml"
    rows = {"methods": ["taxim_published", "split"], "parts": ["test"], "frames": 6}
    path.write_text(yaml.safe_dump(tiny_recipe(touch_store, "inference_time", **rows)))

    def command():
        monkeypatch.setattr("sys.argv", ["tactiledata", "run", str(path), "--out", str(tmp_path / "out"), "--json"])
        with pytest.raises(SystemExit) as ended:
            run()
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    code, printed, _ = command()
    assert code == 2
    assert "which is not the low-resolution pad" in printed
    monkeypatch.setitem(PLANS, "low", PLAN)
    monkeypatch.setitem(PLANS, "high", FINER)
    code, printed, err = command()
    assert code == 0, err
    found = {row["method"]: row["scores"] for row in json.loads(printed)["rows"]}
    names = [f"Taxim, published calibration, {one} resolution" for one in ("low", "high")]
    assert list(found) == [*names, "SPLIT, low resolution"]
    steps = ["simulation", "height map", "optics", "mesh encoder", "projection", "decoder", "overall"]
    assert list(found["SPLIT, low resolution"])[:7] == steps
    assert [found[names[1]][f"memory to {what}"]["value"] for what in ("simulate", "draw")] == [7.0, 5.0]
    grid = cv2.imread(str(tmp_path / "out" / "times" / "small" / "resolutions-test.png"))
    assert grid.shape[1] == 4 * 150 + 3 * 4
