"""The demo's world conceals a relaxation, and the demo's diagnosis names it."""

from dataclasses import replace
from functools import partial

import pytest

from tactiledata.cli.demo_steps.diagnosis import diagnose_touches
from tactiledata.cli.demo_steps.gel import balls_of
from tactiledata.diagnose import options
from tactiledata.effects import EFFECTS
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario.generate import touches
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import find_scenario

pytestmark = pytest.mark.slow

OTHERS = ("rate_friction", "frame_rotation")
MOST = 10
"""Touches that are recorded: two more than a diagnosis needs."""
COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))


def coarse_pad(name, gel):
    return structured_pad(name, gel, COARSE)


def test_it_names_what_its_world_conceals(tmp_path, monkeypatch):
    """The demo's diagnosis names relaxation, which its world conceals, and then says that this is the truth.

    To be quicker, the rig's grid is twice as coarse as the demo's, and so is about the mesh of the simulated gel: both
    err more than the demo's do. Relaxation competes with all that look like it, and with some others, in place of the
    whole catalogue.
    """
    known = ("relaxation", *EFFECTS["relaxation"]().look_alikes, *OTHERS)
    small = partial(options.DiagnosisOptions, make_pad=coarse_pad, effects=known)
    monkeypatch.setattr(options, "DiagnosisOptions", small)
    scenario = load_scenario(find_scenario("demo"))
    hidden = [type(one).__name__ for one in scenario.hidden]
    assert hidden == ["HiddenSpringpot"]
    # what the diagnosis does not use need not be recorded
    balls = balls_of(scenario)
    used = tuple(one for one in touches(scenario) if one.indenter in balls)[:MOST]
    scenario = replace(scenario, trajectories=used, generate=None, contact_pitch=2 * scenario.contact_pitch)
    store = tmp_path / "demo.zarr"
    ingest(record(scenario, tmp_path / "recordings", "mcap"), store)
    told = []
    diagnosis, page = diagnose_touches(store, tmp_path, scenario, 1, told.append, quiet=True)
    assert diagnosis["naming"]["verdict"] in ("explained", "partly explained")
    assert diagnosis["naming"]["ties"] == []
    assert diagnosis["naming"]["names"] == ["relaxation"]
    assert any("The simulation lacks viscoelastic relaxation" in one for one in told)
    assert any("were made with viscoelastic relaxation" in one for one in told)
    assert page.is_file()
