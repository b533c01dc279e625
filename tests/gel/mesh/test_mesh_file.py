"""Pads from mesh files: as they are, in the gel frame, or refused with the reason."""

from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from skfem import MeshTet

from tactiledata.errors import MissingFile, SchemaError, UnknownName, UsageError
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.mesh_file import pad_from_file
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

PUBLISHED = Path(__file__).parents[2] / "data" / "digit_gel" / "digit_gel.mesh"
MATERIAL = GelMaterial(0.9e6, 0.47, 0.6)


def slab():
    """Points (v, 3), m, and tetrahedra of a slab 16 x 24 x 4 mm, base at z = 0, whose end at +y is narrower on top."""
    mesh = MeshTet.init_tensor(np.linspace(-8e-3, 8e-3, 7), np.linspace(-12e-3, 12e-3, 9), np.linspace(0, 4e-3, 3))
    points = mesh.p.T.copy()
    points[:, 0] *= 1 - 0.3 * np.clip(points[:, 1] / 12e-3, 0, 1)
    points[:, 2] *= 1 - 0.2 * (points[:, 0] / 8e-3) ** 2
    return points, mesh.t.T.copy()


def written(folder, points, cells, name="pad.vtk", kind="tetra"):
    path = folder / name
    meshio.vtk.write(path, meshio.Mesh(points, [(kind, cells)]), binary=True)
    return path


def test_published_mesh_lies_in_the_gel_frame():
    """The base is found, -y of the file is out, the round end is at +y, and the sizes are those of the sensor."""
    pad = pad_from_file(PUBLISHED, "m")
    stated = pad_from_file(PUBLISHED, "m", out="-y", along="-x")
    np.testing.assert_allclose(pad.vertices, stated.vertices, atol=1e-6)
    assert pad.thickness == pytest.approx(DIGIT.gel.thickness, abs=2e-5)
    np.testing.assert_allclose(np.ptp(pad.vertices, axis=0)[:2], DIGIT.gel.outline, atol=2e-5)
    assert pad.vertices[pad.surface, 2].max() == 0
    far, near = pad.vertices[:, 1] > 11.5e-3, pad.vertices[:, 1] < -11.5e-3
    assert np.ptp(pad.vertices[far, 0]) < 0.5 * np.ptp(pad.vertices[near, 0])
    assert (len(pad.vertices), len(pad.cells)) == (11783, 6969)


def test_cells_keep_the_volume_and_the_surface_closes():
    """Ten-node cells fill what the four-node ones filled; outer surface and base together have no net area."""
    pad = pad_from_file(PUBLISHED, "m")
    assert cell_quadrature(pad).weights.sum() == pytest.approx(1.2965679e-6, rel=1e-6)
    corners = pad.vertices[pad.faces[:, :3]]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0) / 2
    base = np.ptp(pad.vertices[pad.base], axis=0)
    assert base[2] < 2e-5
    np.testing.assert_allclose(area[:2], 0, atol=1e-8)
    assert 0.8 < area[2] / (base[0] * base[1]) < 1.0
    ends = pad.vertices[pad.faces[:, [0, 1, 2]]] + pad.vertices[pad.faces[:, [1, 2, 0]]]
    np.testing.assert_allclose(pad.vertices[pad.faces[:, 3:]], ends / 2, atol=1e-9)


def test_any_attitude_and_unit_is_the_same_pad(tmp_path):
    """A slab turned and written in millimetres, its cells the other way round, comes out as the slab upright."""
    points, cells = slab()
    upright = pad_from_file(written(tmp_path, points, cells), "m", out="+z", along="+y")
    turn = Rotation.from_euler("xyz", [0.7, -0.4, 2.1]).as_matrix()
    path = written(tmp_path, (points @ turn.T + 0.3) * 1e3, cells[:, [1, 0, 2, 3]], "turned.vtk")
    pad = pad_from_file(path, "mm")
    order, wanted = (np.lexsort(np.round(part.vertices * 1e7).T) for part in (pad, upright))
    np.testing.assert_allclose(pad.vertices[order], upright.vertices[wanted], atol=1e-9)
    assert (len(pad.base), len(pad.faces)) == (len(upright.base), len(upright.faces))
    assert contact_surface(pad).patch_areas.sum() == pytest.approx(contact_surface(upright).patch_areas.sum())


@pytest.mark.slow
def test_slab_is_pressed(tmp_path):
    """A pad from a file is pressed as any other, and holds a fixed order of its vertices."""
    path = written(tmp_path, *slab())
    pad = pad_from_file(path, "m")
    assert pad.digest == pad_from_file(path, "m").digest
    forces = [_pressed(pad, fidelity, [1.2e-3])[0] for fidelity in ("linear", "finite-strain")]
    assert forces[0] == pytest.approx(forces[1], rel=0.3)
    assert forces[0] > 0.3


def _pressed(pad, fidelity, depths):
    poses = np.tile(np.eye(4), (len(depths), 1, 1))
    poses[:, 2, 3] = -np.asarray(depths)
    _, history = next(FemEngine(pad, 0.47, fidelity).play([GelTouch(Sphere(0.004), poses)], MATERIAL))
    assert (history.status == FrameStatus.SOLVED).all()
    return history.wrench[:, 2]


@pytest.mark.nightly
def test_published_mesh_is_pressed():
    """The published mesh runs at both fidelities; its cells of 1 mm are stiff or soft by up to a sixth at 0.3 mm."""
    pad, graded = pad_from_file(PUBLISHED, "m"), pad_mesh("digit", DIGIT.gel)
    for fidelity in ("linear", "finite-strain"):
        assert _pressed(pad, fidelity, [3e-4])[0] == pytest.approx(_pressed(graded, fidelity, [3e-4])[0], rel=0.17)


def _inverted(points, cells):
    inner = np.flatnonzero((np.abs(points - [0, 0, 2e-3]) < [1e-4, 1e-4, 1e-3]).all(axis=1))[0]
    points[inner, 0] += 5e-3
    return points, cells


def _flat(points, cells):
    inner = np.flatnonzero((np.abs(points - [0, 0, 2e-3]) < [1e-4, 1e-4, 1e-3]).all(axis=1))[0]
    around = cells[(cells == inner).any(axis=1)][0]
    points[inner] = points[around[around != inner]].mean(axis=0)
    return points, cells


def _cracked(points, cells):
    low = points[cells].mean(axis=1)[:, 1] < 0
    cells[low] += len(points)
    return np.concatenate([points, points]), cells


def _not_a_number(points, cells):
    points[3, 1] = np.nan
    return points, cells


@pytest.mark.parametrize(
    ("spoil", "unit", "reason"),
    [
        (_inverted, "m", r"turned inside out: \d+ faces"),
        (_flat, "m", r"2 of 576 cells are flat"),
        (_cracked, "m", r"not watertight: \d+ nodes lie on others"),
        (_not_a_number, "m", "no finite numbers"),
        (lambda points, cells: (points, cells), "mm", r"2\.4e-05 m long when its numbers are read as mm.*unit m"),
        (lambda points, cells: (points * 1e3, cells), "m", r"24 m long.*fit the unit mm"),
    ],
)
def test_spoilt_meshes_are_refused(tmp_path, spoil, unit, reason):
    """Every fault has a name, and the sound slab none."""
    points, cells = slab()
    pad_from_file(written(tmp_path, points, cells), "m")
    with pytest.raises(SchemaError, match=reason):
        pad_from_file(written(tmp_path, *spoil(points.copy(), cells.copy())), unit)


def test_no_flat_base_is_said(tmp_path):
    """A lens has no base: the axes must be stated."""
    points, cells = slab()
    points[:, 2] += 0.02 * ((points[:, 0] / 8e-3) ** 2 + (points[:, 1] / 12e-3) ** 2) * (points[:, 2] - 3e-3)
    points[:, 0] += 1e-3 * np.sin(points[:, 1] * 400)
    points[:, 1] *= 1 + 0.1 * np.sin(points[:, 0] * 300)
    points[:, 2] += 1e-3 * np.sin(points[:, 0] * 500) * np.cos(points[:, 1] * 500)
    with pytest.raises(SchemaError, match="flat base of at least"):
        pad_from_file(written(tmp_path, points, cells), "m")


def test_files_that_are_no_volume_meshes(tmp_path):
    """Surfaces, broken files, foreign files, unknown units and axes have messages of their own."""
    points, cells = slab()
    surface = written(tmp_path, points, cells[:, :3], "surface.vtk", "triangle")
    with pytest.raises(SchemaError, match=r"no tetrahedra, only triangle.*Fill the surface"):
        pad_from_file(surface, "m")
    sound = written(tmp_path, points, cells)
    (tmp_path / "torn.vtk").write_bytes(sound.read_bytes()[:2000])
    (tmp_path / "torn.mesh").write_text(PUBLISHED.read_text()[:20000])
    for name in ("torn.vtk", "torn.mesh"):
        with pytest.raises(SchemaError, match="torn"):
            pad_from_file(tmp_path / name, "m")
    (tmp_path / "pad.step").write_text("x")
    with pytest.raises(SchemaError, match=r"\.step file"):
        pad_from_file(tmp_path / "pad.step", "m")
    with pytest.raises(MissingFile):
        pad_from_file(tmp_path / "none.mesh", "m")
    with pytest.raises(UnknownName, match="length unit"):
        pad_from_file(sound, "parsec")
    with pytest.raises(UsageError, match="right angles"):
        pad_from_file(sound, "m", out="+z", along="-z")
    with pytest.raises(UsageError, match="axis 'up'"):
        pad_from_file(sound, "m", out="up")
