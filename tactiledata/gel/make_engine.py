"""The gel engines by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from tactiledata.errors import UsageError
from tactiledata.gel.mesh.pad import PadMesh

if TYPE_CHECKING:
    from tactiledata.gel.engines.fem import FemEngine
    from tactiledata.gel.flex.engine import FlexEngine

EngineName = Literal["fem", "mujoco-flex"]
Mechanics = Literal["finite-strain", "linear", "mujoco-flex"]
"""What an engine's ``fidelity`` says: the two of ``fem``, and the other engine."""
ENGINES = ("fem", "mujoco-flex")


def mechanics_of(engine: str, fidelity: str) -> Mechanics:
    """What two options name together.

    Raises
    ------
    UsageError
        No such engine or fidelity; ``linear`` of an engine that does not have it.
    """
    for what, name, known in (("engine", engine, ENGINES), ("fidelity", fidelity, ("finite-strain", "linear"))):
        if name not in known:
            raise UsageError(f"{what} {name!r}", " or ".join(known), "Name one of them.")
    if engine == "fem":
        return fidelity  # type: ignore[return-value]
    if fidelity == "linear":
        raise UsageError("engine mujoco-flex with fidelity 'linear'", "finite-strain", "Only fem has a linear preview.")
    return "mujoco-flex"


def make_engine(mesh: PadMesh, poisson_ratio: float, mechanics: Mechanics) -> FemEngine | FlexEngine:
    """The engine for a pad and a Poisson's ratio."""
    if mechanics == "mujoco-flex":
        from tactiledata.gel.flex.engine import FlexEngine

        return FlexEngine(mesh, poisson_ratio)
    from tactiledata.gel.engines.fem import FemEngine

    return FemEngine(mesh, poisson_ratio, mechanics)
