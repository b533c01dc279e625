"""What every indenter of the table, and every mesh, obeys."""

import numpy as np
import pytest
import trimesh
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tactiledata.errors import UsageError
from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.indenters.mesh_indenter import MeshIndenter

MESHES = ["sphere", "cross"]
"""Solids whose meshes are also taken as meshes from elsewhere."""
KINDS = [*INDENTERS, *(f"mesh of {name}" for name in MESHES)]
HOLLOW = {"ring", "torus"}
"""Solids with nothing on their axis."""


def build(kind):
    if kind.startswith("mesh of "):
        return MeshIndenter(INDENTERS[kind.removeprefix("mesh of ")]().mesh())
    return INDENTERS[kind]()


@pytest.fixture(scope="module", params=KINDS)
def solid(request):
    return build(request.param)


@pytest.fixture(scope="module")
def surface(solid):
    return solid.mesh()


@pytest.fixture
def rng():
    return np.random.default_rng(20)


def around(surface, rng, n, margin=0.003):
    """Points (n, 3) in and around a body."""
    low, high = surface.bounds
    return rng.uniform(low - margin, high + margin, (n, 3))


def chord(surface):
    """Largest distance between a curved surface and its mesh."""
    return 1.5e-3 * float(surface.extents.max())


def slow_distance(surface, points):
    """The obvious twin: distance to every triangle, sign from the sum of the solid angles of all triangles."""
    scale = 1e5  # trimesh compares products of four lengths with an absolute tolerance
    triangles, points = scale * np.asarray(surface.triangles), scale * points
    distances = np.empty(len(points))
    for index, point in enumerate(points):
        nearest = trimesh.triangles.closest_point(triangles, np.broadcast_to(point, (len(triangles), 3)))
        a, b, c = np.moveaxis(triangles - point, 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        turns = np.arctan2((a * np.cross(b, c)).sum(1), below).sum() / (2 * np.pi)
        distances[index] = np.linalg.norm(nearest - point, axis=1).min() * (-1 if turns > 0.5 else 1)
    return distances / scale


def test_there_are_thirteen():
    """The table holds the thirteen solids, each under its own name."""
    assert len(INDENTERS) == 13
    assert all(INDENTERS[name].shape == name for name in INDENTERS)


def test_mesh_is_a_closed_body(surface):
    """The mesh is watertight, faces outward and encloses a volume."""
    assert surface.is_watertight
    assert surface.is_winding_consistent
    assert surface.volume > 0


def test_distance_vanishes_on_the_surface(solid, surface):
    """The signed distance is zero on the mesh, up to the chord error."""
    points, _ = trimesh.sample.sample_surface(surface, 1000, seed=1)
    assert np.abs(solid.signed_distance(points)).max() < chord(surface)
    assert np.abs(solid.signed_distance(np.asarray(surface.vertices))).max() < 1e-9


def test_distance_agrees_with_its_slow_twin(solid, surface, rng):
    """The signed distance is the distance to the nearest triangle, signed by containment."""
    points = around(surface, rng, 8)
    fast, slow = solid.signed_distance(points), slow_distance(surface, points)
    clear = np.abs(slow) > chord(surface)
    assert (np.sign(fast) == np.sign(slow))[clear].all()
    off = np.abs(fast - slow)
    if not solid.is_exact_inside:
        assert (np.abs(fast) <= np.abs(slow) + chord(surface)).all()
        off = off[slow > 0]
    assert off.max() < chord(surface)


def test_gradient_has_norm_one(solid, surface, rng):
    """The distance grows by the step almost everywhere."""
    points = around(surface, rng, 500)
    step = 1e-7
    gradient = [
        (solid.signed_distance(points + step * axis) - solid.signed_distance(points - step * axis)) / (2 * step)
        for axis in np.eye(3)
    ]
    assert (np.abs(np.linalg.norm(gradient, axis=0) - 1) < 1e-3).mean() > 0.98


def test_tip_is_at_the_origin(solid, surface):
    """The body lies in z >= 0 and touches z = 0, on the axis unless it is hollow there."""
    assert surface.bounds[0, 2] == pytest.approx(0, abs=1e-12)
    axis = np.linspace(surface.bounds[0, 0], surface.bounds[1, 0], 2001)
    assert solid.height(axis, np.zeros_like(axis)).min() == pytest.approx(0, abs=1e-8)
    on_axis = solid.height(np.zeros(1), np.zeros(1))[0]
    assert on_axis == np.inf if solid.shape in HOLLOW else on_axis == pytest.approx(0, abs=1e-8)


def test_height_agrees_with_the_distance(solid, surface, rng):
    """Just below the height is outside, just above inside; where there is none, the whole column is outside."""
    x, y, z = around(surface, rng, 800).T
    height = solid.height(x, y)
    has_body = np.isfinite(height)
    assert 0.1 < has_body.mean() < 0.95
    columns = np.column_stack([x, y, z])
    assert (solid.signed_distance(columns[~has_body]) > 0).all()
    columns[:, 2] = np.where(has_body, height, 0.0)
    hair = np.array([0.0, 0.0, 1e-6])
    assert (solid.signed_distance(columns[has_body] - hair) > 0).all()
    assert (solid.signed_distance(columns[has_body] + hair) < 0).all()
    assert (solid.signed_distance(columns[has_body] * [1, 1, 0] - hair) > 0).all()


def test_height_takes_any_shape(solid):
    """A grid of places gives a grid of heights."""
    x, y = np.meshgrid(np.linspace(-0.002, 0.002, 4), np.linspace(-0.002, 0.002, 3))
    heights = solid.height(x, y)
    assert heights.shape == (3, 4)
    assert heights[2, 1] == pytest.approx(solid.height(x[2, 1:2], y[2, 1:2])[0])


def test_no_points_give_no_distances(solid):
    """An empty query has an empty answer."""
    assert solid.signed_distance(np.zeros((0, 3))).shape == (0,)
    assert solid.height(np.zeros(0), np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("name", INDENTERS)
def test_document_round_trip(name):
    """An indenter made from its own document is the same."""
    solid = INDENTERS[name]()
    assert make_indenter(solid.document, None, "test") == solid


SIZE_FACTORS = st.lists(st.floats(0.5, 1.6), min_size=6, max_size=6)
SPREAD = st.tuples(*[st.floats(-1.5, 1.5)] * 3)


def resized(name, factors):
    """The solid with each size changed by its own factor; drawn again where sizes contradict one another."""
    defaults = INDENTERS[name]().sizes
    try:
        return INDENTERS[name](**{k: v * f for (k, v), f in zip(defaults.items(), factors, strict=False)})
    except UsageError:
        assume(False)


@pytest.mark.parametrize("name", INDENTERS)
@settings(max_examples=8)
@given(factors=SIZE_FACTORS, pairs=st.lists(st.tuples(SPREAD, SPREAD), min_size=1, max_size=6))
def test_distance_is_one_lipschitz(name, factors, pairs):
    """Between two points the distance changes by no more than they are apart, whatever the sizes."""
    solid = resized(name, factors)
    first, second = 0.01 * np.array(pairs).transpose(1, 0, 2)
    change = np.abs(solid.signed_distance(first) - solid.signed_distance(second))
    assert (change <= np.linalg.norm(first - second, axis=1) + 1e-12).all()


@pytest.mark.parametrize("name", INDENTERS)
@settings(max_examples=8)
@given(factors=SIZE_FACTORS, scale=st.floats(0.3, 3.0), places=st.lists(SPREAD, min_size=1, max_size=6))
def test_distance_scales_with_the_sizes(name, factors, scale, places):
    """All lengths times s give distances and heights times s."""
    solid = resized(name, factors)
    scaled = {k: v if k.endswith("angle") else v * scale for k, v in solid.sizes.items()}
    points = 0.01 * np.array(places)
    larger = INDENTERS[name](**scaled)
    np.testing.assert_allclose(
        larger.signed_distance(scale * points), scale * solid.signed_distance(points), rtol=1e-9, atol=1e-14
    )
    x, y = (points + 1.1e-7)[:, :2].T  # off the rims, where a rounding decides between a height and none
    np.testing.assert_allclose(larger.height(scale * x, scale * y), scale * solid.height(x, y), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("name", INDENTERS)
@settings(max_examples=3)
@given(factors=SIZE_FACTORS)
def test_mesh_follows_the_sizes(name, factors):
    """With any sizes the mesh is closed, its corners lie on the surface, and it stands on z = 0."""
    solid = resized(name, factors)
    surface = solid.mesh()
    assert surface.is_watertight
    assert surface.volume > 0
    assert np.abs(solid.signed_distance(np.asarray(surface.vertices))).max() < 1e-9
    assert surface.bounds[0, 2] == pytest.approx(0, abs=1e-12)
