"""Places in the code where Cosmic Ray can make a change, and a sample of them."""

from __future__ import annotations

import ast
import hashlib
import random
import re
import subprocess
from collections import defaultdict
from collections.abc import Mapping, Set
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cosmic_ray.plugins
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code

OPERATORS = re.compile(
    # each arithmetic or bitwise operator by the one that is hardest to notice: others often only raise an error
    r"core/(ReplaceBinaryOperator_(Add_Sub|Sub_Add|Mul_Div|Div_Mul|Pow_Mul|FloorDiv_Mul|Mod_Mul"
    r"|BitAnd_BitOr|BitOr_BitAnd|BitXor_BitOr|LShift_RShift|RShift_LShift)"
    # `is` of numbers and words depends on what the interpreter shares
    r"|ReplaceComparisonOperator_(?!Is_|IsNot_)\w+_(Eq|NotEq|Lt|LtE|Gt|GtE)"
    r"|ReplaceComparisonOperator_(Is_IsNot|IsNot_Is)"
    r"|ReplaceUnaryOperator_(USub_UAdd|Delete_USub|Delete_Not|Delete_Invert)"
    r"|AddNot|ReplaceTrueWithFalse|ReplaceFalseWithTrue|ReplaceAndWithOr|ReplaceOrWithAnd"
    r"|ReplaceBreakWithContinue|ReplaceContinueWithBreak|NumberReplacer|RemoveDecorator"
    r"|ZeroIterationForLoop)"
)
"""Names of Cosmic Ray's operators that are used."""


@dataclass(frozen=True)
class Mutant:
    """A changed module.

    Parameters
    ----------
    file : str
        Path of the module, relative to the repository.
    row : int
        Line of the change, from 1.
    name : str
        Operator and its number in the file.
    line, changed : str
        The line before and after, without indentation.
    text : str
        The module with the change.
    first, last : int
        Lines of the statement that holds the change, without the statements within it.
    """

    file: str
    row: int
    name: str
    line: str
    changed: str
    text: str
    first: int
    last: int

    @property
    def key(self) -> str:
        """A name that stays as long as the changed module does."""
        return f"{self.file} {hashlib.sha256(self.text.encode()).hexdigest()[:16]}"


def sample(
    root: Path, files: list[str], count: int, seed: str, only: Mapping[str, Set[int]] | None = None
) -> tuple[list[Mutant], int]:
    """So many mutants at places drawn at random, and the number of all places; ``count`` 0 takes every place.

    Parameters
    ----------
    root : Path
        The repository.
    files : list of str
    count : int
    seed : str
    only : dict, file -> rows, optional
        Lines, from 1, that are changed; all of them where not given.
    """
    places: dict[tuple[str, int, int], list[tuple[str, int]]] = defaultdict(list)
    for file in files:
        for position, name, number in _changes((root / file).read_text()):
            if only is None or position[0] in only.get(file, ()):
                places[file, *position].append((name, number))
    draws = random.Random(seed)
    order = sorted(places)
    draws.shuffle(order)
    chosen = order[:count] if count else order
    return [_mutant(root, place, draws.choice(places[place])) for place in chosen], len(places)


def changed_lines(root: Path, commit: str) -> dict[str, set[int]]:
    """Return the lines, from 1, of each module that are new or other than at a commit, by its path."""
    command = ["git", "diff", "--unified=0", "--no-color", "--no-ext-diff", commit, "--", "*.py"]
    printed = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True).stdout
    found: dict[str, set[int]] = {}
    file = ""
    for line in printed.splitlines():
        if line.startswith("+++ "):
            file = line.removeprefix("+++ ").removeprefix("b/")
        elif hunk := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line):
            first, count = int(hunk[1]), int(hunk[2] or 1)
            found.setdefault(file, set()).update(range(first, first + count))
    return found


@cache
def _operators() -> dict[str, object]:
    names = [name for name in cosmic_ray.plugins.operator_names() if OPERATORS.fullmatch(name)]
    return {name: cosmic_ray.plugins.get_operator(name)() for name in names}


def _changes(text: str) -> list[tuple[tuple[int, int], str, int]]:
    """Position, operator and its occurrence for each change that can be made."""
    tree = get_ast(text)
    nodes = list(ast_nodes(tree))
    spans = _passed_over(text)
    found = []
    for name, operator in _operators().items():
        positions = [start for node in nodes for start, _ in operator.mutation_positions(node)]
        for number, start in enumerate(positions):
            if not any(low <= start < high for low, high in spans):
                found.append((start, name, number))
    return found


def _passed_over(text: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Spans of what only type checkers read, and of ``strict=True``: that guards against faults of our own."""
    spans = []
    for node in ast.walk(ast.parse(text)):
        for part in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            if part is not None:
                spans.append(((part.lineno, part.col_offset), (part.end_lineno, part.end_col_offset)))
        if isinstance(node, ast.keyword) and node.arg == "strict":
            spans.append(((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset)))
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            spans.append(((node.lineno, 0), (node.end_lineno + 1, 0)))
    return spans


def _mutant(root: Path, place: tuple[str, int, int], change: tuple[str, int]) -> Mutant:
    file, row, _ = place
    name, number = change
    before = (root / file).read_text()
    after = mutate_code(before, _operators()[name], number)
    old, new = before.splitlines(), after.splitlines()
    at = next((k for k, two in enumerate(zip(old, new, strict=False)) if two[0] != two[1]), row - 1)
    first, last = _statement(before, row)
    changed = new[at].strip() if len(old) == len(new) else "(line removed)"
    return Mutant(file, at + 1, f"{name} {number}", old[at].strip(), changed, after, first, last)


def _statement(text: str, row: int) -> tuple[int, int]:
    """First and last line of the innermost statement at a line; of one with a body, those of its head."""
    best = (1, len(text.splitlines()))
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.stmt, ast.ExceptHandler)):
            continue
        first = min([node.lineno, *(part.lineno for part in getattr(node, "decorator_list", []))])
        body = getattr(node, "body", None)
        last = max(first, body[0].lineno - 1) if body else node.end_lineno
        if body and body[0].lineno == node.lineno:
            last = node.lineno
        if first <= row <= last and last - first <= best[1] - best[0]:
            best = (first, last)
    return best
