"""Touches that are solved before a proof draws its worlds are those that its worlds need."""

import pytest

from tactiledata.prove.answers.tasks import SolveTask, solve
from tactiledata.prove.worlds.generators import make_generator
from tactiledata.prove.worlds.logs import play_logs, unfelt
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.rig.scenario.scenario import load_scenario

OFFSETS_OF_A_TOUCH = 4
"""Depth offsets between which a bank interpolates."""


@pytest.mark.slow
def test_a_world_finds_its_touch_solved(tmp_path):
    """A task keeps the touch at four depths; a world, whose depth is another one, needs at most one more."""
    plan = named_plan("coarse-0")
    name = str(plan.touches[-1]["name"])
    kept = []
    for _ in range(2):
        solve(SolveTask("layer", "coarse-0", name, tmp_path))
        kept.append({file.name for file in tmp_path.rglob("*.npz")})
    assert len(kept[0]) == OFFSETS_OF_A_TOUCH
    assert kept[1] == kept[0]
    generator = make_generator("layer", WorldMaker.of(plan, tmp_path).bank)

    def only_this(gel, setup, path=None, deviation=None):
        return (generator if setup.touch.name == name else unfelt)(gel, setup, path, deviation)

    play_logs(load_scenario(plan.scenario(5, plan.truth, [])), only_this)
    after = {file.name for file in tmp_path.rglob("*.npz")}
    assert kept[0] <= after
    assert len(after) <= OFFSETS_OF_A_TOUCH + 1
