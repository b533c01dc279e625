"""Texts that were typed after an option: blank ones are wrong usage in every command, and lists name something."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperCommand

from tactiledata.errors import UsageError


class CheckedCommand(TyperCommand):
    """A command that refuses blank texts before it does anything."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read what was typed.

        Raises
        ------
        UsageError
            An option or an argument was given as a blank text. Where blank is the default it says "none", typed or not.
        """
        # as it was typed: of a path, "" would be the working folder
        typed, _, _ = self.make_parser(ctx).parse_args(args=list(args))
        for parameter in self.params:
            value = typed.get(parameter.name)
            texts = value if isinstance(value, list | tuple) else [value]
            if parameter.default != "" and any(_is_blank(text) for text in texts):
                name = max(parameter.opts, key=len)
                raise UsageError(
                    f"{name} is given a blank text", "a text that says something", f"Leave {name} out, or name a value."
                )
        return super().parse_args(ctx, args)


class CheckedApp(typer.Typer):
    """An application whose commands, also those that other packages add, are `CheckedCommand`."""

    def command(self, *words: Any, **options: Any) -> Any:
        """A decorator that adds a command; as in typer, with another class by default."""
        return super().command(*words, **{"cls": CheckedCommand, **options})


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
