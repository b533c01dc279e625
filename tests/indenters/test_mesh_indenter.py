"""Mesh files from strangers: taken as they are, or refused with the reason."""

import math
import pickle

import numpy as np
import pytest
import trimesh
from few_examples import few
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.errors import MissingFile, SchemaError, UnsafeContent
from tactiledata.indenters import make_indenter
from tactiledata.indenters.box import Box
from tactiledata.indenters.mesh_indenter import MeshIndenter
from tactiledata.indenters.sphere import Sphere


def cube_in_millimetres():
    cube = trimesh.creation.box([8.0, 8.0, 8.0])
    cube.apply_translation([0, 0, 4.0])
    return cube


@pytest.fixture
def folder(tmp_path):
    for kind in ("stl", "obj", "ply"):
        cube_in_millimetres().export(tmp_path / f"cube.{kind}")
    return tmp_path


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
def test_file_becomes_the_solid_that_it_shows(folder, kind):
    """A cube drawn in mm is the cube in metres, from every kind of file."""
    cube = make_indenter({"mesh": f"cube.{kind}", "unit": "mm"}, folder, "test")
    points = np.random.default_rng(3).uniform(-0.01, 0.015, (200, 3))
    np.testing.assert_allclose(cube.signed_distance(points), Box().signed_distance(points), atol=1e-9)
    assert make_indenter(cube.document, folder, "test").document == cube.document


def test_mesh_wins_over_shape(folder):
    """Where both are given, the mesh is what touched."""
    entry = {"shape": "sphere", "radius": 0.004, "mesh": "cube.stl", "unit": "mm"}
    assert make_indenter(entry, folder, "test").shape == "mesh"


def test_inward_faces_are_turned(folder):
    """A file whose triangles all face inward means the same body."""
    cube = cube_in_millimetres()
    cube.invert()
    cube.export(folder / "inward.stl")
    solid = make_indenter({"mesh": "inward.stl", "unit": "mm"}, folder, "test")
    assert solid.signed_distance(np.array([[0.0, 0.0, 0.004]]))[0] == pytest.approx(-0.004)
    assert solid.mesh().volume > 0


def test_overlapping_bodies_are_one(folder):
    """Two closed bodies that overlap are their union: exact outside, inside a bound with the right sign."""
    both = trimesh.util.concatenate([cube_in_millimetres(), cube_in_millimetres().apply_translation([4.0, 0, 0])])
    both.export(folder / "both.stl")
    solid = make_indenter({"mesh": "both.stl", "unit": "mm"}, folder, "test")
    found = solid.signed_distance(np.array([[0.002, 0.0, 0.004], [0.010, 0.0, 0.004], [0.0, 0.006, 0.004]]))
    assert -0.004 <= found[0] < 0
    np.testing.assert_allclose(found[1:], 0.002, atol=1e-9)


def test_height_of_a_grid_has_no_holes():
    """Rays through corners and along edges of triangles find the surface all the same."""
    ball = Sphere()
    solid = MeshIndenter(ball.mesh())
    x, y = np.meshgrid(*[np.linspace(-0.0036, 0.0036, 73)] * 2)
    inside = np.hypot(x, y) < 0.0036
    x, y = x[inside], y[inside]
    assert np.abs(solid.height(x, y) - ball.height(x, y)).max() < 2e-5


def test_travels_between_processes(folder):
    """A mesh indenter can be sent to a worker."""
    solid = make_indenter({"mesh": "cube.stl", "unit": "mm"}, folder, "test")
    points = np.array([[0.0, 0.0, -0.001]])
    solid.signed_distance(points)
    again = pickle.loads(pickle.dumps(solid))
    assert again.signed_distance(points) == solid.signed_distance(points)


def test_open_surface_is_refused_with_its_open_edges(folder):
    """A hole is an error that counts the open edges and names the remedy."""
    cube = cube_in_millimetres()
    cube.update_faces(np.arange(len(cube.faces)) > 0)
    cube.export(folder / "open.stl")
    with pytest.raises(SchemaError, match=r"3 open edges.*make manifold") as caught:
        make_indenter({"mesh": "open.stl", "unit": "mm"}, folder, "test")
    assert caught.value.facts["open_edges"] == 3


def test_mixed_faces_are_refused(folder):
    """Triangles that face both ways leave no inside."""
    cube = cube_in_millimetres()
    cube.faces[0] = cube.faces[0][::-1]
    cube.export(folder / "mixed.ply")
    with pytest.raises(SchemaError, match="face both ways"):
        make_indenter({"mesh": "mixed.ply", "unit": "mm"}, folder, "test")


@pytest.mark.parametrize(("factor", "unit", "right"), [(1.0, "m", "mm"), (1e-3, "mm", "m")])
def test_wrong_unit_is_named(folder, factor, unit, right):
    """Metres for millimetres, or the other way round, is an error that says which unit fits."""
    cube = cube_in_millimetres()
    cube.apply_scale(factor)
    cube.export(folder / "scaled.stl")
    with pytest.raises(SchemaError, match=rf"fit the unit {right}:"):
        make_indenter({"mesh": "scaled.stl", "unit": unit}, folder, "test")


def test_size_that_no_unit_explains_is_refused(folder):
    """A part that fits in no unit asks for the file's scale."""
    cube = cube_in_millimetres()
    cube.apply_scale(1e5)
    cube.export(folder / "huge.stl")
    with pytest.raises(SchemaError, match="Check the file's scale"):
        make_indenter({"mesh": "huge.stl", "unit": "mm"}, folder, "test")


def test_not_a_number_is_refused(folder):
    """Vertices that are no numbers are an error, not a distance of nan."""
    text = (folder / "cube.obj").read_text()
    first = next(line for line in text.splitlines() if line.startswith("v "))
    (folder / "nan.obj").write_text(text.replace(first, "v nan 0 0"))
    with pytest.raises(SchemaError, match=r"not finite|not watertight|cannot be read"):
        make_indenter({"mesh": "nan.obj", "unit": "mm"}, folder, "test")


def test_vertices_in_a_plane_are_refused(folder):
    """Vertices of two coordinates, which the loader accepts, are no surface."""
    text = (folder / "cube.obj").read_text()
    flat = [" ".join(line.split()[:3]) if line.startswith("v ") else line for line in text.splitlines()]
    (folder / "flat.obj").write_text("\n".join(line for line in flat if not line.startswith("vn")) + "\n")
    with pytest.raises(SchemaError, match="vertices with 2 coordinates"):
        make_indenter({"mesh": "flat.obj", "unit": "mm"}, folder, "test")


def test_degenerate_triangle_does_not_spoil_signs(folder):
    """A triangle without area, as CAD programs write them, leaves inside and outside alone."""
    cube = cube_in_millimetres()
    a, b, c = cube.faces[0]
    middle = (cube.vertices[a] + cube.vertices[b]) / 2
    new = len(cube.vertices)
    faces = np.concatenate([cube.faces[1:], [[a, new, c], [new, b, c], [a, b, new]]])
    split = trimesh.Trimesh(np.concatenate([cube.vertices, [middle]]), faces, process=False)
    split.export(folder / "sliver.ply")
    solid = make_indenter({"mesh": "sliver.ply", "unit": "mm"}, folder, "test")
    points = np.random.default_rng(4).uniform(-0.006, 0.012, (300, 3))
    np.testing.assert_allclose(solid.signed_distance(points), Box().signed_distance(points), atol=1e-9)


@pytest.mark.parametrize("name", ["../cube.stl", "/etc/cube.stl", "a/../../cube.stl", "C:\\cube.stl"])
def test_path_out_of_the_folder_is_refused(folder, name):
    """A mesh lies inside its log."""
    with pytest.raises(UnsafeContent):
        make_indenter({"mesh": name, "unit": "mm"}, folder, "test")


def test_link_out_of_the_folder_is_refused(folder, tmp_path_factory):
    """A link does not lead out of the log either."""
    outside = tmp_path_factory.mktemp("outside") / "cube.stl"
    cube_in_millimetres().export(outside)
    (folder / "link.stl").symlink_to(outside)
    with pytest.raises(UnsafeContent):
        make_indenter({"mesh": "link.stl", "unit": "mm"}, folder, "test")


def test_further_files_are_not_followed(folder):
    """Materials that an OBJ names are not opened, wherever they point."""
    text = (folder / "cube.obj").read_text()
    (folder / "named.obj").write_text("mtllib ../../secret.mtl\nusemtl x\n" + text)
    assert make_indenter({"mesh": "named.obj", "unit": "mm"}, folder, "test").mesh().is_watertight


def test_missing_or_foreign_file_is_refused(folder):
    """No file, a folder, another kind of file: each is said."""
    (folder / "part.step").write_text("ISO-10303-21;")
    (folder / "dir.stl").mkdir()
    with pytest.raises(SchemaError, match="a file of kind stl, obj, ply"):
        make_indenter({"mesh": "part.step", "unit": "mm"}, folder, "test")
    for name in ("none.stl", "dir.stl"):
        with pytest.raises(MissingFile):
            make_indenter({"mesh": name, "unit": "mm"}, folder, "test")


@pytest.mark.parametrize("unit", ["inch", 1, ["mm"], "MM"])
def test_unknown_unit_is_refused(folder, unit):
    """Only the units of the schema are read."""
    with pytest.raises(SchemaError, match="unit"):
        make_indenter({"mesh": "cube.stl", "unit": unit}, folder, "test")


def test_oversized_file_is_refused(folder, monkeypatch):
    """A file over the limit is not read."""
    monkeypatch.setattr("tactiledata.indenters.mesh_indenter.MAX_MESH_BYTES", 100)
    with pytest.raises(SchemaError, match="at most 100"):
        make_indenter({"mesh": "cube.stl", "unit": "mm"}, folder, "test")


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
@few(30)
@given(cut=st.floats(0, 1), noise=st.binary(max_size=40), place=st.floats(0, 1))
def test_broken_file_is_refused_or_read(tmp_path_factory, kind, cut, noise, place):
    """Cut and overwritten files give a mesh or one of our errors, never another."""
    folder = tmp_path_factory.mktemp("broken")
    whole = cube_in_millimetres().export(file_type=kind)
    content = bytearray(whole.encode() if isinstance(whole, str) else whole)
    start = math.floor(place * len(content))
    content[start : start + len(noise)] = noise
    (folder / f"part.{kind}").write_bytes(bytes(content[: math.ceil(cut * len(content))]))
    try:
        solid = make_indenter({"mesh": f"part.{kind}", "unit": "mm"}, folder, "test")
    except SchemaError:
        return
    assert np.isfinite(solid.signed_distance(np.zeros((1, 3)))).all()
