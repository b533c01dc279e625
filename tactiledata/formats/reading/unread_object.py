"""Objects in pickles that are passed over, and the arrays that ``dill`` wraps in functions of its own.

Shared by the family, as `base` is: members may import it.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

COMPANIONS = {("typing", "Any"), ("collections", "defaultdict"), ("dill._dill", "_load_type")}
"""Names that stand inside such objects and are values of nothing that is read."""
CORE = "numpy.core.", "numpy._core."
"""Modules of numpy in which ``dill`` looks for the function that begins an array, whatever file of them it names."""


class UnreadObject:
    """An object that was passed over: it holds nothing, and whatever a pickle does to it changes nothing."""

    def __call__(self, *_: Any) -> UnreadObject:
        """Stand for what a call of it would have given."""
        return self


@dataclass(frozen=True)
class _ModuleName:
    """The name of a module, which is not imported."""

    name: str


def _module_name(name: Any, *_: Any) -> _ModuleName:
    if not isinstance(name, str):
        raise pickle.UnpicklingError(f"a module named by a {type(name).__name__}")
    return _ModuleName(name)


def dill_names(
    allowed: Mapping[tuple[str, str], Callable[..., Any]],
    begin_array: Callable[..., Any],
    end_array: Callable[..., Any],
) -> dict[tuple[str, str], Callable[..., Any]]:
    """Return what ``dill`` calls for the arrays of a pickle, by module and name.

    Its releases before 0.3.6 ask for numpy's functions by module and attribute, later ones hand an array's parts to a
    function. Here the first gives a function of ``allowed``, the second an array of the checked parts.

    Parameters
    ----------
    allowed : dict, (module, name) -> function
        What stands for the names that a pickle may ask for.
    begin_array, end_array : callable
        What stands for the function that begins an array, and what makes an array of its state.

    Raises
    ------
    pickle.UnpicklingError
        By the functions, where they are called with anything else.
    """

    def attribute(module: Any, name: Any) -> Any:
        home = module.name if isinstance(module, _ModuleName) else ""
        for core in CORE:
            if home.startswith(core) and (found := allowed.get((f"{core}multiarray", str(name)))):
                return found
        raise pickle.UnpicklingError(f"{name} of {home or 'no module'} is asked for, which is not data")

    def array(begin: Any, _: Any, state: Any, attributes: Any = None) -> Any:
        if begin is not begin_array or attributes:
            raise pickle.UnpicklingError("an array of another class")
        return end_array(state)

    functions: dict[str, Callable[..., Any]] = {
        "_import_module": _module_name,
        "_get_attr": attribute,
        "_create_array": array,
    }
    return {(module, name): function for module in ("dill._dill", "dill.dill") for name, function in functions.items()}
