"""Lazy tables of names: ``name -> "package.module:Object"``, looked up only when a name is used."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib.metadata import entry_points
from typing import Any

from tactiledata.errors import UnknownName


class Registry(Mapping[str, Any]):
    """The members of a family by name; looking up a member imports its module, listing the names imports nothing.

    Parameters
    ----------
    kind : str
        What a member is called in messages, for example ``"format"``.
    table : dict
        ``name -> "package.module:Object"``, in the order in which members are tried and listed.
    group : str, optional
        Entry-point group by which other installed packages add members. A member of ours wins over theirs.

    Examples
    --------
    >>> roots = Registry("function", {"sqrt": "math:sqrt"})
    >>> roots["sqrt"](9.0)
    3.0
    """

    def __init__(self, kind: str, table: Mapping[str, str], group: str | None = None) -> None:
        self.kind = kind
        self._table = dict(table)
        self._group = group

    def _targets(self) -> dict[str, str]:
        return {**self._table, **self._outside}

    @cached_property
    def _outside(self) -> dict[str, str]:
        """Targets of the members that other installed packages add; read once, as it takes milliseconds."""
        if self._group is None:
            return {}
        points = entry_points(group=self._group)
        return {point.name: point.value for point in points if point.name not in self._table}

    def __getitem__(self, name: str) -> Any:
        # our own first: reading the entry points of all installed packages takes milliseconds
        target = self._table.get(name) or self._targets().get(name)
        if target is None:
            raise UnknownName(self.kind, name, self._targets())
        module, _, attribute = target.partition(":")
        return getattr(importlib.import_module(module), attribute)

    def __iter__(self) -> Iterator[str]:
        return iter(self._targets())

    def __len__(self) -> int:
        return len(self._targets())

    def __contains__(self, name: object) -> bool:
        return name in self._table or name in self._targets()
