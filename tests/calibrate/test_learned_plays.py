"""Plays of touches that are learned from a few: laws that hold exactly, and what notices that they do not hold."""

import numpy as np
import pytest

from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.plays import player
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.calibrate.plays.learned_plays import (
    FEWEST_EXAMPLES,
    TOO_FAR,
    LearnedChange,
    example_touches,
    learned_laws,
    learned_nodes,
)
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere

PLAN = ResponsePlan((0.45, 0.47, 0.49), (0.4, 0.6, 0.85))
MIDDLE = Node(0.47, 0.6, 0.0)


def gel_touch(number, depth=5e-4, radius=3e-3):
    """Two frames of a press; its place on the gel grows with its number."""
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, 0, 3] = 1e-4 * number
    poses[1, 2, 3] = -depth
    return GelTouch(Sphere(radius), poses)


def a_play(rows):
    """A play of rows (n, 7): wrench and area."""
    return Play(rows[:, :6], np.full(len(rows), FrameStatus.SOLVED, dtype=np.int8), rows[:, 6])


def some_rows(rng, frames=6):
    """Forces that press, with shear, torques and an area."""
    rows = rng.normal(size=(frames, 7))
    rows[:, 2] = 3.0 + rng.random(frames)
    rows[:, 6] = 1.0 + rng.random(frames)
    return rows


def of_nodes(rng, count, change):
    """Middle, linear middle and linear plays of touches, and plays whose change is a function of these."""
    middle, slow = ([some_rows(rng) for _ in range(count)] for _ in range(2))
    other = [rows + 0.2 * rng.normal(size=rows.shape) for rows in slow]
    node = [one + change(one, two, three) for one, two, three in zip(middle, slow, other, strict=True)]
    return ([a_play(rows) for rows in each] for each in (middle, slow, other, node))


def test_a_change_that_is_a_sum_of_the_terms_is_predicted_exactly():
    """0.3 of the linear change, 0.1 of the force, -0.05 of the linear one: to the ridge's small share."""
    middle, slow, other, node = of_nodes(
        np.random.default_rng(1), 20, lambda one, two, three: 0.3 * (three - two) + 0.1 * one - 0.05 * two
    )
    found = learned_nodes({place: node[place] for place in range(8)}, middle, slow, other)
    for place in range(8, 20):
        np.testing.assert_allclose(found.plays[place].wrench, node[place].wrench, atol=3e-3)
        np.testing.assert_allclose(found.plays[place].area, node[place].area, atol=3e-3)
    assert found.error < 1e-3
    assert found.are_close


def test_examples_keep_their_own_plays():
    """What was played is not replaced by what is predicted."""
    middle, slow, other, node = of_nodes(np.random.default_rng(2), 12, lambda one, *_: 0.4 * np.sin(5 * one))
    found = learned_nodes({place: node[place] for place in (1, 4, 5)}, middle, slow, other)
    assert [found.plays[place] is node[place] for place in range(12)] == [place in (1, 4, 5) for place in range(12)]


def test_the_error_is_that_of_an_example_predicted_from_the_others():
    """The error is that of examples which are left out of the fit and predicted, over their largest force."""
    rng = np.random.default_rng(3)
    middle, slow, other, node = of_nodes(rng, 6, lambda one, *_: 0.3 * np.sin(3 * one))
    places = range(6)
    found = learned_nodes(dict(enumerate(node)), middle, slow, other)
    squares, frames = 0.0, 0
    for left_out in places:
        rest = {place: node[place] for place in places if place != left_out}
        off = learned_nodes(rest, middle, slow, other).plays[left_out].wrench - node[left_out].wrench
        largest = np.linalg.norm(middle[left_out].wrench[:, :3], axis=1).max()
        squares += float(((off[:, :3] / largest) ** 2).sum())
        frames += len(off)
    assert found.error == pytest.approx(np.sqrt(squares / frames), rel=1e-6)
    assert found.error > TOO_FAR
    assert not found.are_close


def test_without_a_hint_the_change_is_that_of_the_linear_engine_times_the_ratio():
    """Examples that do not change say nothing of the weights, which stay at the scheme of `estimated_change`."""
    weights = LearnedChange.of(
        terms={0: np.zeros((4, 2, 7))},
        changes={0: np.zeros((4, 7))},
        sizes={0: np.ones(7)},
        prior=np.array([1.0, 0.0]),
    ).weights
    np.testing.assert_array_equal(weights, np.tile([1.0, 0.0], (5, 1)))


def test_another_law_is_learned_from_forces_and_depths():
    """A force that grows by 0.2 of itself for each mm of depth: what the linear engine does not know."""
    rng = np.random.default_rng(4)
    depths = [1e-3 * rng.random(6) for _ in range(16)]
    middle, slow, stiff, _ = of_nodes(rng, 16, lambda *_: 0.0)
    node = [
        a_play(np.column_stack([one.wrench, one.area]) * (1 + 200 * depth[:, None]))
        for one, depth in zip(middle, depths, strict=True)
    ]
    found = learned_laws({place: node[place] for place in range(8)}, middle, slow, stiff, depths)
    for place in range(8, 16):
        np.testing.assert_allclose(found.plays[place].wrench, node[place].wrench, atol=3e-3)


def test_frames_that_a_source_lacks_are_missing():
    """A frame that the linear engine has not solved is not predicted, and not counted among the examples."""
    middle, slow, other, node = of_nodes(np.random.default_rng(5), 10, lambda one, *_: 0.1 * one)

    def lacking(play):
        wrench, status = play.wrench.copy(), play.status.copy()
        wrench[2], status[2] = np.nan, FrameStatus.NOT_CONVERGED
        return Play(wrench, status, play.area)

    other[0], other[9] = lacking(other[0]), lacking(other[9])
    found = learned_nodes({place: node[place] for place in range(8)}, middle, slow, other)
    assert found.plays[9].status[2] == FrameStatus.NOT_CONVERGED
    assert np.isnan(found.plays[9].wrench[2]).all()
    assert found.plays[9].status[3] == FrameStatus.SOLVED
    assert np.isfinite(found.error)


def test_few_touches_are_all_examples():
    """All touches are examples where fewer than eight others would be left to be predicted."""
    most = 2 * FEWEST_EXAMPLES - 1
    assert example_touches([gel_touch(k) for k in range(most)]) == list(range(most))
    assert len(example_touches([gel_touch(k) for k in range(most + 1)])) == FEWEST_EXAMPLES


def test_examples_hold_the_deepest_touch_of_every_indenter_and_far_places():
    """Nine radii of which one is pressed once; the ends of a row of touches; a twelfth of many touches."""
    touches = [gel_touch(k, depth=3e-4 + 1e-6 * k, radius=3e-3 + 1e-4 * (k % 9)) for k in range(36)]
    touches.append(GelTouch(CylinderFlat(2e-3, 1e-2), gel_touch(0, depth=1e-4).poses))
    chosen = example_touches(touches)
    assert 36 in chosen
    assert {k % 9 for k in chosen if k < 36} == set(range(9))
    assert set(range(27, 36)) <= set(chosen)
    row = [gel_touch(k) for k in range(120)]
    assert len(example_touches(row)) == 10
    assert {0, 119} <= set(example_touches(row))
    assert example_touches(row) == example_touches(row)


@pytest.fixture
def counted(monkeypatch):
    """A gel whose force is 1 plus what a node adds, by touch; how many touches were played at each node."""
    plays = {}
    wild = set()

    def play(mesh, requests, beside, runner, report):
        found = [{node: played(request, node) for node in request.nodes} for request in requests]
        count = sum(len(request.touches) * len(request.nodes) for request in requests)
        report(count, count, "")
        return found, []

    def played(request, node):
        key = request.mechanics, node
        plays[key] = plays.get(key, 0) + len(request.touches)
        nu, mu, z = node.poisson_ratio - 0.47, node.friction - 0.6, node.offset / 5e-5
        found = []
        for touch in request.touches:
            place = float(touch.uid)
            load = (1.3 if request.mechanics == "finite-strain" else 1.0) * (2.0 + np.arange(3.0) + 0.1 * place)
            load = load * (1 + 3 * nu + 0.4 * mu + 0.2 * z)
            if request.mechanics == "finite-strain" and node in wild:
                load = load + np.sin(7 * place)
            rows = np.zeros((3, 7))
            rows[:, 2] = rows[:, 6] = load
            found.append(a_play(rows))
        return found

    monkeypatch.setattr(player, "play_requests", play)
    return plays, wild


def touches_of(count):
    return [
        MeasuredTouch(str(k), str(k), "s", "i", gel_touch(k), np.zeros((2, 6)), np.arange(2.0), 40.0)
        for k in range(count)
    ]


@pytest.mark.slow
def test_offsets_and_nu_are_played_for_the_examples_and_friction_for_all(counted):
    """With nu or the offset changed, 8 of 40 touches are played, and the others are predicted as they would play."""
    plays, _ = counted
    told = []
    found = player.play_plan(None, "finite-strain", touches_of(40), PLAN, None, lambda *one: told.append(one))
    at = {node: count for (mechanics, node), count in plays.items() if mechanics == "finite-strain"}
    assert at[MIDDLE] == at[Node(0.47, 0.4, 0.0)] == at[Node(0.47, 0.85, 0.0)] == 40
    assert at[Node(0.45, 0.6, 0.0)] == at[Node(0.49, 0.6, 0.0)] == at[Node(0.47, 0.6, 5e-5)] == 8
    assert len(at) == 7
    loads = [play.wrench[1, 2] for play in found.by_node()[Node(0.49, 0.6, 0.0)]]
    np.testing.assert_allclose(loads, 1.3 * (3.0 + 0.1 * np.arange(40)) * 1.06, rtol=1e-4)
    # what is told as finished ends at what there is to do
    assert told[-1][0] == told[-1][1] == 3 * 40 + 4 * 8 + 19 * 40


def test_a_node_that_cannot_be_told_from_examples_is_played_for_all(counted):
    """Forces at one offset that follow no law: all of its touches are played, and no others more."""
    plays, wild = counted
    node = Node(0.47, 0.6, 5e-5)
    wild.add(node)
    told = []
    found = player.play_plan(None, "finite-strain", touches_of(40), PLAN, None, lambda *one: told.append(one))
    assert plays["finite-strain", node] == 8 + 40
    # what is told as finished goes on from the first run
    assert [done for done, *_ in told] == [912, 952]
    assert plays["finite-strain", Node(0.47, 0.6, -5e-5)] == 8
    loads = np.array([play.wrench[1, 2] for play in found.played[node]])
    np.testing.assert_allclose(loads, 1.3 * (3.0 + 0.1 * np.arange(40)) * 1.2 + np.sin(7 * np.arange(40)))


def test_few_touches_are_played_at_every_node_where_one_thing_differs(counted):
    """Fifteen touches leave nothing to learn."""
    plays, _ = counted
    player.play_plan(None, "finite-strain", touches_of(15), PLAN, None)
    assert {count for (mechanics, _), count in plays.items() if mechanics == "finite-strain"} == {15}
