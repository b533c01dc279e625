"""Plays estimated from a few and from another engine: laws that hold exactly, and frames that are missing."""

import numpy as np
import pytest

from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.plays.estimated_plays import estimated_change, estimated_node, is_learned, is_played
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.calibrate.plays.player import PlanPlays
from tactiledata.gel.contact.history import FrameStatus

PLAN = ResponsePlan((0.45, 0.47, 0.49), (0.4, 0.6, 0.85))
MIDDLE = Node(0.47, 0.6, 0.0)
LOADS = np.array([0.0, 1.0, 2.0, 4.0])


def play(node, factor=1.0, product=0.0, own=0.0):
    """A play whose load is bilinear in the departures of a node, but for what one engine alone has.

    Parameters
    ----------
    factor : float
        On all forces.
    product : float
        Of what two departures together add, in both engines.
    own : float
        Of a single departure of mu, in this engine alone.
    """
    nu, mu, z = node.poisson_ratio - 0.47, node.friction - 0.6, node.offset / 5e-5
    change = 3.0 * nu + 0.4 * mu + 0.2 * z + product * (nu * mu + nu * z + mu * z) + own * mu**2
    load = factor * LOADS * (1.0 + change)
    wrench = np.column_stack([-node.friction * load, 0.1 * load, load, 0.01 * load, 0.02 * load, 0.0 * load])
    status = np.where(load > 0, FrameStatus.SOLVED, FrameStatus.NO_CONTACT).astype(np.int8)
    return Play(wrench, status, 1e-6 * load)


def test_a_plan_is_played_where_one_thing_differs():
    """Seven of nineteen nodes are played: the middle, two other nu, two other mu, two offsets."""
    played = [node for node in PLAN.nodes() if is_played(PLAN, node)]
    assert len(played) == 7
    assert MIDDLE in played
    expected = [Node(0.45, 0.6, 0.0), Node(0.49, 0.6, 0.0), Node(0.47, 0.4, 0.0), Node(0.47, 0.85, 0.0)]
    assert set(played) - {MIDDLE} == {*expected, Node(0.47, 0.6, 5e-5), Node(0.47, 0.6, -5e-5)}


def test_estimates_are_exact_where_both_engines_agree_on_what_two_things_add():
    """What a single departure adds in one engine alone, and a factor between the engines, cancel in each component."""
    nodes = list(PLAN.nodes())
    played = {node: [play(node, 1.3, 2.0, own=0.7)] for node in nodes if is_played(PLAN, node)}
    linear = {node: [play(node, 1.0, 2.0)] for node in nodes}
    found = PlanPlays(PLAN, played, linear).by_node()
    assert list(found) == nodes
    for node in nodes:
        expected = play(node, 1.3, 2.0, own=0.7)
        # the shear is the product of mu and the load: its own terms of third order are no part of the scheme
        np.testing.assert_allclose(found[node][0].wrench[:, 2], expected.wrench[:, 2], rtol=1e-12)
        np.testing.assert_allclose(found[node][0].area, expected.area, rtol=1e-12)
        assert np.array_equal(found[node][0].status, expected.status)


def test_a_change_that_was_not_played_is_the_linear_engines():
    """Rough estimates need the middle and other frictions at finite strain; they are exact up to a common factor."""
    nodes = list(PLAN.nodes())
    rubs = [node for node in nodes if is_played(PLAN, node) and not is_learned(PLAN, node)]
    assert set(rubs) == {MIDDLE, Node(0.47, 0.4, 0.0), Node(0.47, 0.85, 0.0)}
    linear = {node: [play(node, 1.0, 2.0)] for node in nodes}
    found = PlanPlays(PLAN, {node: [play(node, 1.3, 2.0, own=0.7)] for node in rubs}, linear).by_node()
    for node in nodes:
        expected = play(node, 1.3, 2.0, own=0.7)
        np.testing.assert_allclose(found[node][0].wrench[:, 2], expected.wrench[:, 2], rtol=1e-12)


def test_without_the_linear_engine_what_two_things_add_is_lost():
    """The other engine is what tells how two departures act together."""
    played = {node: [play(node, 1.3, 2.0)] for node in PLAN.nodes() if is_played(PLAN, node)}
    flat = {node: [play(MIDDLE)] for node in PLAN.nodes()}
    corner = Node(0.45, 0.85, 0.0)
    lost = play(corner, 1.3, 2.0).wrench[:, 2] - estimated_node(PLAN, corner, played, flat)[0].wrench[:, 2]
    np.testing.assert_allclose(lost, 1.3 * LOADS * 2.0 * (-0.02 * 0.25), atol=1e-12)


def test_a_change_is_scaled_by_the_ratio_of_the_two_engines():
    """Forces are 1.3 times those of the linear engine, and so is the change."""
    other = Node(0.47, 0.6, 5e-5)
    found = estimated_change(play(MIDDLE, 1.3), play(MIDDLE), play(other))
    np.testing.assert_allclose(found.wrench, play(other, 1.3).wrench, rtol=1e-12)


def lacking(given, frame, status=FrameStatus.NOT_CONVERGED):
    wrench, states = given.wrench.copy(), given.status.copy()
    wrench[frame], states[frame] = np.nan, status
    return Play(wrench, states, given.area)


def test_frames_that_a_play_at_finite_strain_lacks_are_missing_with_its_reason():
    """One of the three plays is enough; other frames are untouched."""
    first = Node(0.45, 0.6, 0.0)
    played = {node: [play(node)] for node in PLAN.nodes() if is_played(PLAN, node)}
    linear = {node: [play(node)] for node in PLAN.nodes()}
    whole = estimated_node(PLAN, Node(0.45, 0.85, 0.0), played, linear)[0]
    played[first] = [lacking(play(first), 2, FrameStatus.TOO_DEEP)]
    found = estimated_node(PLAN, Node(0.45, 0.85, 0.0), played, linear)[0]
    assert found.status[2] == FrameStatus.TOO_DEEP
    assert np.isnan(found.wrench[2]).all()
    np.testing.assert_array_equal(found.wrench[[0, 1, 3]], whole.wrench[[0, 1, 3]])


def test_frames_that_the_linear_engine_lacks_go_without_it():
    """The sum of the single changes is left."""
    node = Node(0.45, 0.85, 0.0)
    played = {one: [play(one, product=2.0)] for one in PLAN.nodes() if is_played(PLAN, one)}
    linear = {one: [play(one, product=2.0)] for one in PLAN.nodes()}
    linear[node] = [lacking(play(node, product=2.0), 3)]
    found = estimated_node(PLAN, node, played, linear)[0]
    assert found.wrench[3, 2] == pytest.approx(4.0 * (1.0 + 3.0 * -0.02 + 0.4 * 0.25))


def test_an_estimate_that_pulls_is_no_contact():
    """Two changes that each take 60 % of the load off leave no load less than none: nothing touches."""
    node, alone = Node(0.45, 0.85, 0.0), (Node(0.45, 0.6, 0.0), Node(0.47, 0.85, 0.0))
    middle = play(MIDDLE)
    weak = Play(0.4 * middle.wrench, middle.status, 0.4 * middle.area)
    played = {MIDDLE: [middle], **{one: [weak] for one in alone}}
    linear = {one: [middle] for one in (node, MIDDLE, *alone)}
    found = estimated_node(PLAN, node, played, linear)[0]
    np.testing.assert_array_equal(found.wrench, 0.0)
    np.testing.assert_array_equal(found.area, 0.0)
    assert set(found.status) == {FrameStatus.NO_CONTACT}
