"""Packages that only some commands need: which extra of the installation brings each, and what to say without it."""

from __future__ import annotations

from importlib.util import find_spec

from tactiledata.errors import UsageError

EXTRAS = {
    "dask": ("dask", "dask"),
    "distributed": ("distributed", "dask"),
    "jinja2": ("jinja2", "report"),
    "matplotlib": ("matplotlib", "report"),
    "meshio": ("meshio", "sim"),
    "mujoco": ("mujoco", "sim"),
    "nlopt": ("nlopt", "sim"),
    "numba": ("numba", "sim"),
    "onnx": ("onnx", "models"),
    "onnxruntime": ("onnxruntime", "models"),
    "onnxscript": ("onnxscript", "models"),
    "rerun": ("rerun-sdk", "view"),
    "s3fs": ("s3fs", "s3"),
    "skfem": ("scikit-fem", "prove"),
    "skimage": ("scikit-image", "models"),
    "sklearn": ("scikit-learn", "sim"),
    "torch": ("torch", "models"),
}
"""Name of a module -> name of its package, and the extra of ``pyproject.toml`` that brings it."""

GEL = ("meshio", "nlopt", "numba")
"""What the simulated gel and its calibration need."""
PAGE = ("jinja2", "matplotlib")
"""What a page needs."""


def missing_package(module: str, what: str) -> UsageError:
    """Return the error for a package that is not installed; the message says how to install it.

    Parameters
    ----------
    module : str
        Name of the module, a key of `EXTRAS`.
    what : str
        What needs it: the subject of the message's sentence, such as ``"a calibration"``.
    """
    package, extra = EXTRAS[module]
    return UsageError(
        f"{what} needs {package}, which is not installed",
        "",
        f"Install it with: pip install 'tactiledata[{extra}]' (-c constraints.txt adds the tested versions).",
        module=module,
    )


def need_packages(what: str, *modules: str) -> None:
    """Refuse to go on where a package is not installed, before any work is done.

    Parameters
    ----------
    what : str
        What needs them: the subject of the message's sentence.
    *modules : str
        Names of modules, keys of `EXTRAS`.

    Raises
    ------
    UsageError
        One of them is not installed; the first is named.
    """
    for module in modules:
        if find_spec(module) is None:
            raise missing_package(module, what)


def package_behind(error: Exception) -> UsageError | None:
    """Return the error that says how to install what an import missed; None for any other error."""
    if not isinstance(error, ModuleNotFoundError) or error.name is None:
        return None
    module = error.name.partition(".")[0]
    return missing_package(module, "this command") if module in EXTRAS else None
