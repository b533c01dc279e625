"""Gel engines by the names that a user gives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from tactiledata.errors import UsageError
from tactiledata.gel.mesh.pad import PadMesh

if TYPE_CHECKING:
    from tactiledata.gel.engines.fem import FemEngine
    from tactiledata.gel.flex.engine import FlexEngine

EngineName = Literal["fem", "mujoco-flex"]
Mechanics = Literal["finite-strain", "linear", "mujoco-flex"]
"""Engine and fidelity in one word: the two fidelities of ``fem``, and the other engine."""
ENGINES = ("fem", "mujoco-flex")


def mechanics_of(engine: str, fidelity: str) -> Mechanics:
    """Return the mechanics that the options ``engine`` and ``fidelity`` name together.

    Raises
    ------
    UsageError
        An unknown engine or fidelity, or ``linear`` for an engine that does not have it.
    """
    for option, name, known in (("engine", engine, ENGINES), ("fidelity", fidelity, ("finite-strain", "linear"))):
        if name not in known:
            raise UsageError(f"{option} {name!r}", " or ".join(known), "Name one of them.")
    if engine == "fem":
        return fidelity  # type: ignore[return-value]
    if fidelity == "linear":
        raise UsageError("engine mujoco-flex with fidelity 'linear'", "finite-strain", "Only fem has a linear preview.")
    return "mujoco-flex"


def make_engine(mesh: PadMesh, poisson_ratio: float, mechanics: Mechanics) -> FemEngine | FlexEngine:
    """Return the engine that simulates touches of a pad; it is assembled for this mesh and Poisson's ratio.

    Young's modulus and friction are given later, with the touches.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of the pad.
    poisson_ratio : float
        0 to below 0.5.
    mechanics : "finite-strain", "linear" or "mujoco-flex"
        The finite-element engine at finite strain or linear, or MuJoCo's soft body; `mechanics_of` makes it of the
        options of a command.

    Raises
    ------
    UsageError
        An unknown name, or a Poisson's ratio out of range; for ``mujoco-flex``, MuJoCo is not installed, or the pad is
        not made of hexahedra.
    """
    if mechanics == "mujoco-flex":
        from tactiledata.gel.flex.engine import FlexEngine

        return FlexEngine(mesh, poisson_ratio)
    from tactiledata.gel.engines.fem import FemEngine

    return FemEngine(mesh, poisson_ratio, mechanics)
