"""Generators: who computes the contact of a world's touches. None of them shares a formula with the gel engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactiledata.contract.extras import missing_package
from tactiledata.registry import Registry
from tactiledata.rig.bank.bank import ContactBank
from tactiledata.rig.contact.analytic import touch_analytic
from tactiledata.rig.contact.contact import RigContact, TouchSetup
from tactiledata.rig.play import SolveContact

_HERE = "tactiledata.prove.worlds.generators"
GENERATORS = Registry(
    "generator",
    {
        "layer": f"{_HERE}:layer_contact",
        "analytic": f"{_HERE}:analytic_contact",
        "element": f"{_HERE}:element_contact",
    },
    "tactiledata.generators",
)
"""Functions that take a bank of kept solutions and return the contact of touches, by name."""
SOLVED_ANEW = ("thickness", "dome", "indenter_mount")
"""Hidden effects for which a solver must solve every touch anew, which takes hours; closed forms need not."""


def make_generator(name: str, bank: ContactBank) -> SolveContact:
    """Return the contact of touches by a generator.

    Parameters
    ----------
    name : str
        Name in ``GENERATORS``.
    bank : ContactBank
        Indenters, grid, and the folder in which solutions are kept.

    Raises
    ------
    UnknownName
        No generator has this name.
    """
    made: Callable[[ContactBank], SolveContact] = GENERATORS[name]
    return made(bank)


def layer_contact(bank: ContactBank) -> SolveContact:
    """Return the contact by the rig's layer solver, kept in the bank."""
    return bank.contact


def analytic_contact(bank: ContactBank) -> SolveContact:
    """Return the contact by the rig's closed forms; nothing is kept."""
    return closed_form


def element_contact(bank: ContactBank) -> SolveContact:
    """Return the contact by finite elements of scikit-fem, kept in the bank's folder.

    Raises
    ------
    UsageError
        scikit-fem is not installed.
    """
    try:
        from tactiledata.prove.element_world.bank import ElementBank
    except ImportError as error:
        raise missing_package("skfem", "the generator 'element'") from error
    return ElementBank(bank.folder).contact


def closed_form(_: Any, setup: TouchSetup, path: Any = None, deviation: Any = None) -> RigContact:
    """Return the contact of a touch by the rig's closed forms; a `SolveContact`.

    Parameters
    ----------
    _ : Gel
        Not used.
    setup : TouchSetup
        The touch as it really is.
    path, deviation
        See `SolveContact`.
    """
    return touch_analytic(setup, path, deviation)
