"""An indenter whose lengths are all multiplied by a factor."""

from __future__ import annotations

from tactiledata.indenters.base import Indenter, ParametricIndenter
from tactiledata.indenters.mesh_indenter import MeshIndenter


def scaled(indenter: Indenter, factor: float) -> Indenter:
    """Return the indenter with all its lengths multiplied by a factor; tip and angles stay.

    Raises
    ------
    TypeError
        An indenter of one's own that has neither sizes nor a mesh file.
    UsageError
        A result that is larger or smaller than any indenter.
    """
    if isinstance(indenter, ParametricIndenter):
        sizes = {name: value if name.endswith("angle") else factor * value for name, value in indenter.sizes.items()}
        return type(indenter)(**sizes)
    if isinstance(indenter, MeshIndenter):
        surface = indenter.mesh()
        surface.apply_scale(factor)
        return MeshIndenter(surface, indenter.document["mesh"], indenter.document["unit"])
    raise TypeError(f"{type(indenter).__name__} cannot be scaled: it has neither sizes nor a mesh file")
