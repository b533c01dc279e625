"""Levels of a mesh keep what graph convolutions rest on."""

import numpy as np
import pytest
from small_models import grid_topology, presses

from split_models.networks.decimation import decimate
from split_models.networks.mesh_graph import Hierarchy, Topology, build_hierarchy, cell_faces, scaled_laplacian


def block_topology(nx=5, ny=6, nz=4):
    """A volume of hexahedra."""
    number = np.arange(nx * ny * nz).reshape(nx, ny, nz)

    def corner(i, j, k):
        return number[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].ravel()

    ring = ((0, 0), (1, 0), (1, 1), (0, 1))
    cells = np.stack([corner(i, j, k) for k in (0, 1) for i, j in ring], axis=1)
    places = np.stack(np.meshgrid(np.arange(nx), np.arange(ny), np.arange(nz), indexing="ij"), -1).reshape(-1, 3)
    return Topology(places * 0.001, cell_faces(cells))


@pytest.mark.parametrize("topology", [grid_topology(), grid_topology(dome=20.0), block_topology()])
def test_each_level_has_half_the_vertices(topology):
    """Four poolings, each to one half rounded up; rows of a way up sum to 1, those of a way down are one vertex."""
    hierarchy = build_hierarchy(topology)
    for fine, coarse in zip(hierarchy.sizes[:-1], hierarchy.sizes[1:], strict=True):
        assert coarse == (fine + 1) // 2
    for down, up in zip(hierarchy.down, hierarchy.up, strict=True):
        assert np.allclose(up.sum(axis=1), 1.0, atol=1e-6)
        assert (np.diff(down.indptr) == 1).all()
        assert np.allclose((down @ up).toarray(), np.eye(down.shape[0]), atol=1e-6)


def test_the_laplacian_is_scaled():
    """It is symmetric with eigenvalues in [-1, 1], -1 among them for a connected mesh (the constant mode)."""
    for laplacian in build_hierarchy(grid_topology()).laplacians:
        dense = laplacian.toarray()
        values = np.linalg.eigvalsh(dense)
        assert np.allclose(dense, dense.T)
        assert values.min() == pytest.approx(-1.0, abs=1e-5)
        assert values.max() <= 1.0 + 1e-5


def test_a_vertex_without_neighbours_is_left_alone():
    """Its row is zero and nothing divides by zero."""
    assert not scaled_laplacian(np.array([[0, 1, 2]]), 4).toarray()[3].any()


def test_up_takes_back_what_is_linear():
    """On a flat mesh linear fields survive a pooling exactly but for vertices outside the coarser outline."""
    topology = grid_topology()
    hierarchy = build_hierarchy(topology)
    field = topology.places[:, :2] @ np.array([[1.0], [2.0]])
    back = hierarchy.up[0] @ (hierarchy.down[0] @ field)
    assert np.median(np.abs(back - field)) < 1e-6 * np.abs(field).max()


def test_pooling_spreads_evenly_on_a_flat_mesh():
    """No fine vertex is further from a kept one than some edges: nothing was eaten up from one corner."""
    topology = grid_topology()
    kept, faces = decimate(topology.places, topology.faces, topology.n_vertices // 2)
    gaps = np.linalg.norm(topology.places[:, None] - topology.places[kept][None], axis=-1).min(axis=1)
    assert gaps.max() < 0.0025
    assert faces.max() == len(kept) - 1


def test_smooth_dents_survive_pooling():
    """Pooled once and lifted again, a dent keeps 90 % of its energy."""
    topology = grid_topology()
    hierarchy = build_hierarchy(topology)
    dents = presses(topology, 5)
    for dent in dents:
        back = hierarchy.up[0] @ (hierarchy.down[0] @ dent)
        assert ((back - dent) ** 2).sum() < 0.1 * (dent**2).sum()


def test_cells_have_each_face_once():
    """Two hexahedra side by side have 11 faces, 22 triangles; a ten-node tetrahedron 16 triangles."""
    cells = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])
    assert len(cell_faces(cells)) == 22
    assert len(cell_faces(np.arange(10)[None])) == 16


def test_kept_levels_are_the_same(tmp_path, monkeypatch):
    """The second time they come from the disk; the digest tells topologies apart, not places."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path))
    topology = grid_topology(9, 8)
    first = build_hierarchy(topology)
    assert len(list((tmp_path / "mesh_graph").iterdir())) == 1
    second = build_hierarchy(topology)
    assert all(np.array_equal(one, second.arrays()[name]) for name, one in first.arrays().items())
    assert isinstance(second, Hierarchy)
    assert topology.digest == Topology(topology.places * 2, topology.faces).digest
    assert topology.digest != grid_topology(9, 9).digest
