"""Frames that are hard to solve: deep, nearly incompressible, sheared under high friction; what follows a failure."""

import numpy as np
import pytest
from pressing import poses, pressed, slab

from tactiledata.gel.contact.contact_path import ContactPath, ContactState
from tactiledata.gel.contact.gap import APART
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.contact.recorder import FrameRecorder
from tactiledata.gel.contact.relief import indenter_relief
from tactiledata.gel.contact.trajectory_solve import MOST_HALVINGS, TrajectorySolve
from tactiledata.gel.engines import finite_strain
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.engines.tangent_step import TangentStep
from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.indenters.sphere import Sphere

NU = 0.495
BALL = Sphere(4e-3)
DEEP = poses(
    *[(0.1, 0.2, -0.22 * step) for step in range(1, 6)],
    *[(0.4, 0.2, -1.1), (0.7, 0.3, -1.1), (0.4, 0.3, -1.0), (0.1, 0.6, -1.1), (0, 0, 2)],
)
"""Down to 1.1 mm, then out by 0.6 mm, back and across, and up."""
HARDEST = ("edge", "cone")
SHEARED = poses(
    (0, 0, 1),
    (0, 0, -0.2),
    (0, 0, -0.4),
    *[(0.1 * step, 0, -0.4) for step in (1, 2, 3, 4, 5)],
    (0.5, 0, 1),
    (0.5, 0, -0.2),
)
BARRIER = 5e-5
"""m along x: the touch cannot be followed across it, where ``_obstruct`` says so."""


@pytest.fixture(scope="module")
def soft():
    return FemEngine(slab(), NU)


def _all_solved(engine, names):
    for name in names:
        history = pressed(engine, make_indenter({"shape": name}, None, name), DEEP, 0.9, keep="none")
        assert not (history.status == FrameStatus.NOT_CONVERGED).any(), (name, history.status)
        assert not history.resumed.any()
        assert history.status[-1] == FrameStatus.NO_CONTACT
        forces = history.wrench[4:-1, :3]
        assert (np.linalg.norm(forces[:, :2], axis=1) <= 0.9 * forces[:, 2] / np.cos(np.arctan(0.9)) + 1e-6).all()


@pytest.mark.parametrize("name", [HARDEST[0], pytest.param(HARDEST[1], marks=pytest.mark.slow)])
def test_sharp_indenters_are_followed(soft, name):
    """An edge and a cone, at nu 0.495 and mu 0.9, are followed to 1.1 mm, out by 0.6 mm, back and up into the air."""
    _all_solved(soft, [name])


@pytest.mark.nightly
def test_every_indenter_is_followed(soft):
    """So are the other eleven, some far beyond the forces of recordings."""
    _all_solved(soft, sorted(set(INDENTERS) - set(HARDEST)))


def _solve_of(engine, at):
    """The load steps of one touch of a ball, to be led by hand."""
    surface, mesh = engine.surface, engine.mesh
    count = len(surface.corners)
    nowhere = np.full((4, 4), np.nan)
    state = ContactState(nowhere, np.zeros((count, 3)), np.zeros((len(mesh.vertices), 3)), np.full(count, APART))
    rest = mesh.vertices[surface.nodes]
    path = ContactPath(surface, engine._compliance, rest, surface.nodes, indenter_relief(BALL), 0.5, state)
    recorder = FrameRecorder(len(at), mesh, surface, 1.0, "none")
    return TrajectorySolve(0, GelTouch(BALL, at), path, recorder, mesh.thickness)


def _take(solve):
    """Take the present load step as solved, with some force below the surface; return its depth, m."""
    path = solve.path
    forces = np.zeros_like(path.state.forces)
    forces[0, 2] = -1e-9 if path._pose[2, 3] < 0 else 0.0
    path.accept_step(path.state.displacement, forces, path.state.gaps)
    solve.step_done(0.0)
    return -path.state.pose[2, 3]


def test_a_failed_step_is_halved_where_it_failed(soft):
    """Solved steps of the frame are kept, the failed one is halved until it goes, and then steps are as long again."""
    solve = _solve_of(soft, poses((0, 0, -0.1), (0, 0, -0.4), (0, 0, -0.55)))
    assert solve.next_step()
    assert _take(solve) == pytest.approx(0.1e-3)
    # 0.3 mm are two steps of 0.15 mm; the second one fails twice
    assert solve.next_step()
    assert _take(solve) == pytest.approx(0.25e-3)
    depths = []
    for fails in (True, True, False, False, False, False):
        assert solve.next_step()
        if fails:
            solve.step_failed()
        else:
            depths.append(_take(solve))
    np.testing.assert_allclose(depths, [0.2875e-3, 0.325e-3, 0.4e-3, 0.55e-3])
    assert (solve.recorder.status == FrameStatus.SOLVED).all()


def test_the_air_ends_an_interruption_and_a_second_failure_gives_up(soft):
    """A frame is pressed anew once, then given up; the next starts from rest and counts as resumed, up to the air."""
    solve = _solve_of(soft, poses((0, 0, -0.1), (0, 0, -0.2), (0, 0, -0.1), (0, 0, 1), (0, 0, -0.1)))
    assert solve.next_step()
    _take(solve)
    for attempt in range(2):
        assert solve.next_step()
        assert [solve.step_failed() for _ in range(MOST_HALVINGS + 1)] == [False] * MOST_HALVINGS + [True]
        assert not solve.path.state.is_touching, attempt
    while solve.next_step():
        _take(solve)
    assert solve.recorder.status.tolist() == [0, FrameStatus.NOT_CONVERGED, 0, FrameStatus.NO_CONTACT, 0]
    assert solve.recorder.resumed.tolist() == [False, False, True, False, False]


def _obstruct(monkeypatch):
    """Let no load step across ``BARRIER`` find an equilibrium, however short; all others are solved as ever."""

    def is_blocked(path):
        return path.state.is_touching and path.state.pose[0, 3] < BARRIER <= path._pose[0, 3]

    take, iterate = finite_strain.LoadStepSolve.take_iteration, TangentStep.iterate

    def take_or_fail(self, displacement, forces, gaps, residual):
        astray = np.full_like(displacement, np.inf) if is_blocked(self.trajectory.path) else displacement
        with np.errstate(invalid="ignore"):
            take(self, astray, forces, gaps, residual)

    def iterate_or_fail(self, path):
        if not is_blocked(path):
            return iterate(self, path)
        self._iterations = 10**6
        return None

    monkeypatch.setattr(finite_strain.LoadStepSolve, "take_iteration", take_or_fail)
    monkeypatch.setattr(TangentStep, "iterate", iterate_or_fail)


@pytest.mark.slow
def test_a_touch_goes_on_after_a_failure(soft, monkeypatch):
    """No frame is lost where a path is interrupted; frames say so up to the next air, and forces are soon the same.

    Against the path in finer steps: the normal force within 1 %. The force along begins at nothing, because what was
    sheared before the interruption is not known, and is within 3 % of friction's limit after 0.3 mm more.
    """
    finer = np.repeat(SHEARED, 2, axis=0)
    finer[1::2] = SHEARED
    finer[2::2, :3, 3] = (SHEARED[:-1, :3, 3] + SHEARED[1:, :3, 3]) / 2
    whole = pressed(soft, BALL, finer, 0.3, keep="none").wrench[1::2]
    _obstruct(monkeypatch)
    history = pressed(soft, BALL, SHEARED, 0.3, keep="none")
    assert (history.status == [1, 0, 0, 0, 0, 0, 0, 0, 1, 0]).all()
    assert history.resumed.tolist() == [False] * 3 + [True] * 5 + [False] * 2
    np.testing.assert_allclose(history.wrench[1:8, 2], whole[1:8, 2], rtol=1e-2)
    along = np.abs(history.wrench[:, 0] - whole[:, 0])[3:8] / (0.3 * whole[3:8, 2])
    assert abs(history.wrench[3, 0]) < 0.02 * history.wrench[3, 2]
    assert along[3:].max() < 0.03
