"""The pictures of layers and rooms in docs/architecture.md, drawn from the imports.

``python tests/import_picture.py`` draws them anew.
"""

import ast
import textwrap
from collections import defaultdict
from pathlib import Path

from parsed_sources import tree_of
from test_layers import LAYERS, imported, place

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
PACKAGES = ("tactiledata", "split_models")
ROOMS = (
    "tactiledata.diagnose", "tactiledata.effects", "tactiledata.gel", "tactiledata.ingest", "tactiledata.store",
    "tactiledata.rig", "split_models",
)  # fmt: skip
"""Packages whose rooms are drawn, too."""
WIDTH = 118


def module_of(path):
    """Dotted name of a module."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def sources(package):
    """Modules below a package, with their paths."""
    return {module_of(path): path for path in sorted((ROOT / package.replace(".", "/")).rglob("*.py"))}


def question(path):
    """First sentence of the docstring of a package or module."""
    text = ast.get_docstring(tree_of(path)) or ""
    return " ".join(text.partition("\n\n")[0].split()).partition(". ")[0].rstrip(".")


def floors(arrows):
    """Rooms by floor, the lowest first; rooms that import one another share a floor."""
    reached = {room: set(targets) & set(arrows) for room, targets in arrows.items()}
    for _ in arrows:
        for targets in reached.values():
            for target in list(targets):
                targets |= reached[target]
    left, listed = set(arrows), []
    while left:
        # below a room is what it reaches and what does not reach it
        free = {room for room in left if all(room in reached[other] for other in reached[room] & left)}
        listed.append(sorted(free))
        left -= free
    return listed


def lines_of(name, targets, said):
    """Lines of the picture for one package or room: its name, what it answers, and what it imports."""
    head = f"  {name:<16} {said}"
    arrow = f"imports {', '.join(sorted(targets))}" if targets else "imports nothing of them"
    indent = " " * 19
    return [
        *textwrap.wrap(head, WIDTH, subsequent_indent=indent),
        *textwrap.wrap(arrow, WIDTH, initial_indent=indent, subsequent_indent=indent + "  "),
    ]


def layers_picture():
    """Packages, the highest layer first, each with the packages that it imports."""
    arrows = defaultdict(set)
    for package in PACKAGES:
        for module, path in sources(package).items():
            here = place(module)
            if here is None:
                continue
            for target in imported(path):
                there = place(target)
                if there is not None and there[1] != here[1]:
                    arrows[here[1]].add(there[1].removeprefix("tactiledata."))
    drawn = []
    for row in reversed(LAYERS):
        for package in row:
            folder = ROOT / package.replace(".", "/")
            path = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
            drawn += lines_of(package.removeprefix("tactiledata."), arrows[package], question(path))
        drawn.append("  " + "-" * 40)
    return drawn[:-1]


def rooms_picture(package):
    """Rooms of a package, the highest floor first, each with the rooms that it imports."""
    arrows, modules = defaultdict(set), sources(package)
    for module, path in modules.items():
        room = module.removeprefix(package).strip(".").split(".")[0]
        if not room:
            continue
        arrows[room] |= set()
        for target in imported(path):
            if target.startswith(f"{package}."):
                arrows[room].add(target.removeprefix(f"{package}.").split(".")[0])
    arrows = {room: targets & set(arrows) - {room} for room, targets in arrows.items()}
    drawn = []
    for floor in reversed(floors(arrows)):
        for room in floor:
            path = modules.get(f"{package}.{room}")
            drawn += lines_of(room + ("/" if path.name == "__init__.py" else ".py"), arrows[room], question(path))
        drawn.append("  " + "-" * 40)
    return drawn[:-1]


def pictures():
    """The text between the marks of the page, by the name in the mark."""
    drawn = {"layers": layers_picture()} | {package: rooms_picture(package) for package in ROOMS}
    return {name: "\n".join(["```text", *lines, "```"]) for name, lines in drawn.items()}


def drawn_page(text):
    """The page with every picture drawn anew."""
    for name, picture in pictures().items():
        begin, end = f"<!-- picture: {name} -->\n", "<!-- end of picture -->"
        before, mark, rest = text.partition(begin)
        _, closing, after = rest.partition(end)
        if not (mark and closing):
            raise ValueError(f"{PAGE.name} has no place for the picture of {name}: write {begin!r} and {end!r}")
        text = f"{before}{begin}{picture}\n{end}{after}"
    return text


if __name__ == "__main__":
    PAGE.write_text(drawn_page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
