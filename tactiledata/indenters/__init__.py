"""Indenters: which rigid solid touches the gel?

There are thirteen parametric solids, one file and one line in the table below each, and any solid from a mesh file.
Read in this order:

- ``base``: what every indenter offers, a signed distance, a mesh and a height; ``base.planar`` and ``base.surface``
  are the geometry that several solids share.
- ``sphere``, ``dome``, ``torus``, ...: the parametric solids.
- ``mesh_indenter``: a solid from an STL, OBJ or PLY file.
- ``scaled``: a solid of another size. ``gallery``: a picture of all solids.

Solids know nothing of gel, poses or logs. One solid imports ``base``, never another one.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactiledata.errors import SchemaError, UnknownName, UsageError
from tactiledata.registry import Registry

if TYPE_CHECKING:
    from tactiledata.indenters.base import Indenter

INDENTERS = Registry(
    "indenter",
    {
        "sphere": "tactiledata.indenters.sphere:Sphere",
        "dome": "tactiledata.indenters.dome:Dome",
        "torus": "tactiledata.indenters.torus:Torus",
        "cone": "tactiledata.indenters.cone:Cone",
        "pyramid": "tactiledata.indenters.pyramid:Pyramid",
        "edge": "tactiledata.indenters.edge:Edge",
        "cylinder_side": "tactiledata.indenters.cylinder_side:CylinderSide",
        "cylinder_flat": "tactiledata.indenters.cylinder_flat:CylinderFlat",
        "ring": "tactiledata.indenters.ring:Ring",
        "box": "tactiledata.indenters.box:Box",
        "hexagon": "tactiledata.indenters.hexagon:Hexagon",
        "cross": "tactiledata.indenters.cross:Cross",
        "dots": "tactiledata.indenters.dots:Dots",
    },
    group="tactiledata.indenters",
)
"""Parametric solids by name, smooth ones first; each class takes its sizes as keyword arguments, all optional."""

NOT_SIZES = frozenset({"shape", "mesh", "unit", "base_from_indenter"})
"""Keys of an entry that are not sizes of the shape."""


def make_indenter(entry: Mapping[str, Any], folder: Path | None, where: str) -> Indenter:
    """Return the solid that an entry of a log or a scenario describes.

    Parameters
    ----------
    entry : mapping
        ``{shape, <sizes>}`` or ``{mesh, unit}``, as under ``indenters:`` in ``schemas/log.json``; where both are given
        the mesh wins. Sizes that are not given have the shape's defaults.
    folder : Path, optional
        Folder to which the path of a mesh is relative; ``None`` where a mesh is not allowed.
    where : str
        Document and place in it, for messages.

    Raises
    ------
    SchemaError
        An unknown shape, a size that the shape does not have or cannot have, or a mesh without a unit.
    LostFile, UnsafeContent
        A mesh file that does not exist, or lies outside ``folder``.

    Examples
    --------
    >>> make_indenter({"shape": "sphere", "radius": 0.003}, None, "example").sizes
    {'radius': 0.003}
    """
    if entry.get("mesh") is not None:
        from tactiledata.indenters.mesh_indenter import load_mesh_indenter  # trimesh only where a mesh is named

        return load_mesh_indenter(entry, folder, where)
    shape = entry.get("shape")
    if not isinstance(shape, str):
        raise SchemaError(
            f"{where} names neither a shape nor a mesh",
            f"'shape' (one of: {', '.join(INDENTERS)}) or 'mesh' with 'unit'",
            "docs/indenters.md lists shapes and sizes.",
            path=where,
        )
    # errors of the table and of the solid become errors of the document, with the place in it
    try:
        solid = INDENTERS[shape]
    except UnknownName as error:
        raise SchemaError(f"{where}: {error.found}", error.expected, error.remedy, path=where) from error
    _check_keys(entry, shape, list(solid().sizes), where)
    try:
        return solid(**{name: value for name, value in entry.items() if name not in NOT_SIZES})
    except UsageError as error:
        raise SchemaError(f"{where}: {error.found}", error.expected, error.remedy, path=where) from error


def _check_keys(entry: Mapping[str, Any], shape: str, names: list[str], where: str) -> None:
    """Refuse an entry that states a unit other than metres, or a size that the shape does not have."""
    if entry.get("unit") not in (None, "m"):
        raise SchemaError(
            f"{where} states the unit {entry['unit']!r} beside shape {shape!r}",
            "sizes in metres; a unit belongs to a mesh",
            "Write the sizes in metres (4 mm is 0.004) and drop 'unit'.",
            path=where,
        )
    unknown = [name for name in entry if name not in NOT_SIZES and name not in names]
    if unknown:
        raise SchemaError(
            f"{where} gives {', '.join(map(repr, unknown))}, which {shape!r} does not have",
            f"sizes of {shape}: {', '.join(names)} (metres; angles in radians)",
            "Correct the name, or leave the size out for its default.",
            path=where,
        )
