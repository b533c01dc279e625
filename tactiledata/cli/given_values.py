"""Texts that were typed after an option, held to one rule in every command.

Blank ones are wrong usage, lists name something, and no page or picture is written into a store.
"""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand

from tactiledata.contract.atomic import refusal
from tactiledata.contract.near_path import dead_link, near_path
from tactiledata.contract.own_files import refuse_foreign
from tactiledata.errors import TactileDataError, UsageError

OUTPUT = "out"
"""Name of the parameter that says where a command writes what is no store; one that writes a store has another name."""

STORES = ("store", "stores", "parents")
"""Names of parameters that take the path or the address of a store."""
INDENTERS = "the folder of the mesh files that recordings name"
SEEDS = 2**32
"""Number of seeds, from 0, that NumPy, scikit-learn and our own draws all accept."""
NAMED = re.compile(r"(?:the gel's )?(?P<name>\w+)(?P<is> is)? (?P<value>.+)", re.DOTALL)
"""What errors say of a value: a parameter's name, and the value."""

WRITTEN = (OUTPUT, "into", "out_store", "picture")
"""Names of all parameters that say where a command writes: on this machine."""


class CheckedCommand(TyperCommand):
    """A command that refuses blank texts, and output into a store, before it does anything."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read what was typed.

        Raises
        ------
        UsageError
            An option or an argument was given as a blank text (where blank is the default it says "none", typed or
            not); or output would be written into a store; or one that must be given was not.
        """
        # as it was typed: of a path, "" would be the working folder
        typed, _, _ = self.make_parser(ctx).parse_args(args=list(args))
        for parameter in self.params:
            value = typed.get(parameter.name)
            texts = value if isinstance(value, list | tuple) else [value]
            if parameter.default != "" and any(_is_blank(text) for text in texts):
                self._refuse_blank(parameter, ctx.command_path)
        for parameter in self.params:
            if parameter.name == OUTPUT and typed.get(OUTPUT) is not None:
                _refuse_store(str(typed[OUTPUT]), max(parameter.opts, key=len))
            if parameter.name in WRITTEN and typed.get(parameter.name) is not None:
                need_local_place(str(typed[parameter.name]), max(parameter.opts, key=len))
        if not (ctx.resilient_parsing or typed.get("help")):
            for parameter in self.params:
                if parameter.required and typed.get(parameter.name) in (None, ()):
                    _refuse_missing(parameter, ctx.command_path)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; where a value that was typed is refused, the error names its option as it was typed."""
        try:
            return super().invoke(ctx)
        except UsageError as error:
            error.found = _with_option(error.found, self.params, ctx.params)
            raise

    def _refuse_blank(self, parameter: Any, command: str) -> None:
        name = max(parameter.opts, key=len)
        if parameter.nargs == -1 and not name.startswith("-"):
            raise UsageError(
                f"a word after `{command}` is empty",
                "a text, or a path",
                "Write one in its place, or leave the quotes out.",
            )
        kind = str(signature(self.callback).parameters[parameter.name].annotation) if self.callback else ""
        is_path = "Path" in kind or parameter.name in STORES
        place = f"after {name}" if name.startswith("-") else f"in the place of {name}"
        raise UsageError(f"{name} is empty", "a path" if is_path else "a text", f"Write one {place}.")


class CheckedApp(typer.Typer):
    """An application whose commands, also those that other packages add, are `CheckedCommand`."""

    def command(self, *words: Any, **options: Any) -> Any:
        """A decorator that adds a command; as in typer, with another class by default."""
        return super().command(*words, **{"cls": CheckedCommand, **options})


def _with_option(found: str, parameters: Sequence[Any], given: Mapping[str, Any]) -> str:
    """Return what was found with an option in the place of the parameter's name, where its value stands behind that."""
    said = NAMED.match(found)
    parameter = next((one for one in parameters if said and one.name == said["name"] and one.opts[0][0] == "-"), None)
    if said is None or parameter is None or (value := given.get(parameter.name)) is None:
        return found
    typed = {str(value), *([f"{value:g}"] if isinstance(value, float) else ())}
    is_that = said["value"].strip("'").startswith(tuple(typed))
    return f"{max(parameter.opts, key=len)}{said['is'] or ''} {said['value']}" if is_that else found


def is_given(context: typer.Context, name: str) -> bool:
    """Whether an option was typed.

    Parameters
    ----------
    context : typer.Context
        Of the command.
    name : str
        The parameter's name, with underscores.
    """
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def refuse_given(context: typer.Context, names: Iterable[str], found: str, expected: str) -> None:
    """Refuse options that were typed and would change nothing; one that was typed with its default passes.

    Parameters
    ----------
    context : typer.Context
        Of the command.
    names : iterable of str
        The parameters' names, with underscores.
    found : str
        What is against them, such as ``"without --web"``.
    expected : str
        What they need, such as ``"with --web"``.

    Raises
    ------
    UsageError
        One of them was typed, with another value than its default.
    """
    options = {parameter.name: parameter for parameter in context.command.params}
    for name in names:
        option = options[name].opts[0]
        if is_given(context, name) and context.params.get(name) != options[name].get_default(context):
            raise UsageError(
                f"{option} {found}",
                f"{option} {expected}",
                "Leave the option out: it would change nothing.",
            )


def need_seed(seed: int, below: int = SEEDS) -> None:
    """Refuse a seed that a generator of random numbers does not take.

    Parameters
    ----------
    seed : int
        Value of ``--seed``.
    below : int
        Number of seeds, from 0.

    Raises
    ------
    UsageError
        It is none of them.
    """
    if not 0 <= seed < below:
        raise UsageError(f"--seed {seed}", f"0 or more, below {below}", "Any of these numbers serves.")


def need_folder(path: Path | None, option: str, what: str) -> Path | None:
    """The folder that an option names; ``None`` where it was not typed.

    Parameters
    ----------
    path : Path, optional
    option : str
        As it is typed.
    what : str
        What the folder is, for the message.

    Raises
    ------
    UsageError
        There is no folder.
    """
    if path is not None and not path.is_dir():
        raise UsageError(f"{option} {path} is no folder", what, near_path(path))
    return path


def _refuse_missing(parameter: Any, command: str) -> None:
    name = max(parameter.opts, key=len) if parameter.opts[0].startswith("-") else str(parameter.name).upper()
    said = (parameter.help or "").rstrip(".")
    raise UsageError(f"{name} is not given", said[:1].lower() + said[1:], f"Run `{command} --help` for what it takes.")


def _refuse_store(path: str, option: str) -> None:
    from tactiledata.store.layout.places import store_around

    if (store := store_around(path)) is not None:
        raise UsageError(
            f"{option} {path!r} lies in the store {store}",
            "a place outside any store",
            "Name a place outside: a file that is no part of a store counts as damage.",
        )


def need_local_place(place: str, option: str) -> None:
    """Refuse an address where something will be written, a link that leads nowhere, and a name that is no text.

    A folder with the name of the address would come to be on this machine; stores, pages and documents hold names of
    files as UTF-8.

    Parameters
    ----------
    place : str
        What was typed.
    option : str
        After which option, for the message.

    Raises
    ------
    UsageError
        It is an address, such as ``s3://bucket/x``, and no path; or it, or a folder around it, is a link to nothing; or
        it holds bytes that are no UTF-8.
    """
    try:
        place.encode()
    except UnicodeEncodeError as error:
        raise UsageError(
            f"{option} {place!r} holds bytes that are no UTF-8 text", "a name that is UTF-8 text", "Name another place."
        ) from error
    if "://" in place or "::" in place:
        raise UsageError(
            f"{option} {place!r} is an address",
            "a path on this machine",
            "Write it here, then copy it there; a store is read from an address (docs/store.md).",
        )
    _refuse_dangling(Path(place), f"{option} {place}")


def _refuse_dangling(path: Path, named: str) -> None:
    """Refuse a path that is a link to nothing, or that leads through one."""
    for link in (path, *path.parents):
        if dead_link(link):
            behind = "" if link == path else f"behind {link}, "
            raise UsageError(
                f"{named} is {behind}a link that leads to {link.readlink()}, which is not there",
                "a place that can be written to",
                "Make what the link leads to, remove the link, or name another place.",
            )


def need_writable_folder(folder: Path, *files: str, option: str = "--out") -> None:
    """Refuse a folder for results that cannot be written to, before any work is done.

    Parameters
    ----------
    folder : Path
        The folder; it need not exist.
    *files : str
        Names of files that will be written there.
    option : str
        The option that names the folder, for the message.

    Raises
    ------
    UsageError
        A file stands in the place of the folder or of its parents, a folder in the place of a file, or a file of others
        where one of ours will be.
    TactileDataError
        The folder, or the nearest that exists around it, may not be written to.
    """
    nearest = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    for name in files:
        _refuse_dangling(folder / name, str(folder / name))
    in_the_way = [name for name in files if (folder / name).is_dir()]
    if not nearest.is_dir() or in_the_way:
        why = f"{in_the_way[0]} in it is a folder" if in_the_way else f"{nearest} is a file"
        raise UsageError(
            f"the folder {folder} cannot be written to: {why}",
            "a folder, or a place for one",
            f"Name another with {option}.",
        )
    if not os.access(nearest, os.W_OK | os.X_OK):
        number = errno.EROFS if os.statvfs(nearest).f_flag & os.ST_RDONLY else errno.EACCES
        raise TactileDataError(*refusal(OSError(number, os.strerror(number)), nearest))
    for name in files:
        refuse_foreign(folder / name)


def _is_blank(text: Any) -> bool:
    return isinstance(text, str) and not text.strip()


def listed_names(text: str, option: str) -> list[str]:
    """The names in a text with commas between; gaps are left out.

    Parameters
    ----------
    text : str
    option : str
        As errors call it.

    Raises
    ------
    UsageError
        It names nothing.

    Examples
    --------
    >>> listed_names("D1, D2,", "--from")
    ['D1', 'D2']
    """
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise UsageError(
            f"{option} {text!r} names nothing",
            "names, with commas between",
            f"Name some after {option}, or leave it out where it may be.",
        )
    return names
