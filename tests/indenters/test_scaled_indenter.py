"""A scaled indenter is the same solid, seen larger."""

import numpy as np
import pytest
import trimesh

from tactiledata.errors import UsageError
from tactiledata.indenters import INDENTERS
from tactiledata.indenters.mesh_indenter import MeshIndenter
from tactiledata.indenters.scaled import scaled


@pytest.mark.parametrize("name", sorted(INDENTERS))
def test_distances_and_heights_scale_with_it(name):
    """Distances and heights of every solid scale with its size, and scaling back gives the first sizes."""
    solid = INDENTERS[name]()
    larger = scaled(solid, 1.1)
    points = np.random.default_rng(1).uniform(-6e-3, 6e-3, (200, 3))
    assert larger.signed_distance(1.1 * points) == pytest.approx(1.1 * solid.signed_distance(points), abs=1e-9)
    x, y = points[:, :2].T
    assert larger.height(1.1 * x, 1.1 * y) == pytest.approx(1.1 * solid.height(x, y), abs=1e-9)
    assert scaled(larger, 1 / 1.1).sizes == pytest.approx(solid.sizes)


def test_a_mesh_scales_too():
    """A solid from a mesh file is scaled in all its extents, and its document stays that of the file."""
    solid = MeshIndenter(trimesh.creation.icosphere(radius=4e-3).apply_translation([0, 0, 4e-3]), "ball.stl", "mm")
    larger = scaled(solid, 0.97)
    assert larger.mesh().extents == pytest.approx(0.97 * solid.mesh().extents)
    assert larger.document == solid.document


def test_nothing_is_scaled_out_of_what_is_made():
    """A size outside the range of real indenters is refused."""
    with pytest.raises(UsageError, match="metres"):
        scaled(INDENTERS["sphere"](), 1000.0)
