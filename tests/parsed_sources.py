"""Modules of the code base as syntax trees, parsed once for all tests that read the code itself."""

import ast
import gc
from functools import cache


@cache
def tree_of(path):
    """The syntax tree of a module; nobody may change it."""
    # a tree is thousands of objects that stay: the collector would look at all of them again and again
    was_on = gc.isenabled()
    gc.disable()
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    finally:
        if was_on:
            gc.enable()
