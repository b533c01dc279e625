"""Which sections of docs/results.md are older than the program that prints their figures.

    python benchmarks/results_age.py                          say which
    python benchmarks/results_age.py --mark                   write it into the page, below the headings
    python benchmarks/results_age.py --stamp HEADING [--commit COMMIT]

docs/results.yaml lists the sections: command, commit, the paths on which the figures depend, and a digest of each of
these paths at that commit. A digest is of statements: comments and docstrings of Python files are no part of it. Where
one of a path differs from today's, the section is older than the code, and the page must say so; a test holds that.

Run a section's command again, put its output into the page, and stamp the section: commit, date and digests are then
those of the named commit, by default the last one, at which nothing on which the section depends may be uncommitted.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import io
import re
import subprocess
import tarfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from tactiledata.contract.atomic import write_atomic

ROOT = Path(__file__).resolve().parents[1]
PAGE, LIST = ROOT / "docs" / "results.md", ROOT / "docs" / "results.yaml"
MARK = re.compile(r"^\*Older than the code: .*\*$")
DIGITS = 12
HEAD = """# Sections of results.md: the command that prints them, the commit at which it did, and digests of what their
# figures depend on. `python benchmarks/results_age.py --stamp HEADING` writes it; `command` and `depends` are by hand.
"""

Section = dict[str, Any]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mark", action="store_true", help="write the marks into the page")
    parser.add_argument("--stamp", metavar="HEADING", help="the section was printed at a commit")
    parser.add_argument("--commit", help="that commit [default: the last one]")
    given = parser.parse_args()
    sections = listed()
    if given.stamp:
        sections = [stamped(one, given.commit) if one["heading"] == given.stamp else one for one in sections]
        if given.stamp not in [one["heading"] for one in sections]:
            raise SystemExit(
                f"no section {given.stamp!r} in {LIST.relative_to(ROOT)}: add it with `depends` and `command`"
            )
        write_atomic(LIST, (HEAD + yaml.safe_dump({"sections": sections}, sort_keys=False, width=120)).encode())
    if given.mark or given.stamp:
        write_atomic(PAGE, marked(PAGE.read_text(encoding="utf-8"), marks(sections)).encode())
    for one in sections:
        changed = changed_paths(one)
        print(
            f"{'older' if changed else 'as the code'}: {one['heading']} ({one['commit']}) {', '.join(changed)}".rstrip()
        )


def listed() -> list[Section]:
    """The sections of the list."""
    sections: list[Section] = yaml.safe_load(LIST.read_text(encoding="utf-8"))["sections"]
    return sections


def headings(page: str) -> list[str]:
    """Headings of the second level of a page, without those in printed output."""
    return [
        line.removeprefix("## ") for line, is_output in page_lines(page) if line.startswith("## ") and not is_output
    ]


def marked(page: str, marks: dict[str, str]) -> str:
    """The page with a mark below each heading that has one, and no other marks."""
    kept: list[str] = []
    lines = list(page_lines(page))
    for number, (line, is_output) in enumerate(lines):
        if MARK.match(line) and not is_output:
            continue
        # the blank line before a mark goes with it
        if not line and number + 1 < len(lines) and MARK.match(lines[number + 1][0]) and not lines[number + 1][1]:
            continue
        kept.append(line)
        if line.startswith("## ") and not is_output and (mark := marks.get(line.removeprefix("## "))):
            kept += ["", mark]
    return "\n".join(kept) + "\n"


def marks(sections: Iterable[Section]) -> dict[str, str]:
    """The mark of each section that is older than the code, by heading."""
    found = {}
    for one in sections:
        if changed := changed_paths(one):
            paths = ", ".join(f"`{path}`" for path in changed)
            found[one["heading"]] = (
                f"*Older than the code: printed at {one['commit']} or before, and changed since: {paths}.*"
            )
    return found


def changed_paths(section: Section) -> list[str]:
    """Paths on which a section depends and whose digest differs from today's."""
    return [path for path in section["depends"] if section["digests"].get(path) != digest_now(path)]


def stamped(section: Section, commit: str | None) -> Section:
    """The section with the commit, its date, and the digests of what it depends on there."""
    if commit is None and (open_changes := _git("status", "--porcelain", "--", *section["depends"])):
        raise SystemExit(f"not committed, so no commit has it:\n{open_changes}")
    name = _git("rev-parse", "--short=8", commit or "HEAD").strip()
    date = _git("show", "-s", "--format=%cs", name).strip()
    digests = {path: digest_at(name, path) for path in section["depends"]}
    return {**section, "commit": name, "date": date, "digests": digests}


@cache
def digest_now(path: str) -> str:
    """Digest of a file or of all files of a folder, as they are."""
    place = ROOT / path
    files = [place] if place.is_file() else sorted(file for file in place.rglob("*") if file.is_file())
    names = [file.relative_to(ROOT).as_posix() for file in files if "__pycache__" not in file.parts]
    return _digest(names, lambda name: (ROOT / name).read_bytes())


def digest_at(commit: str, path: str) -> str:
    """Digest of a file or of all files of a folder, as they were at a commit."""
    if not _git("ls-tree", "--name-only", commit, "--", path):
        return _digest([], str.encode)  # there was no such path yet
    with tarfile.open(fileobj=io.BytesIO(_git_bytes("archive", "--format=tar", commit, "--", path))) as archive:
        contents = {one.name: archive.extractfile(one) for one in archive.getmembers() if one.isfile()}
        held = {name: file.read() for name, file in contents.items() if file is not None}
    return _digest(sorted(held), held.__getitem__)


def _digest(names: Iterable[str], read: Callable[[str], bytes]) -> str:
    """Digest of named files: of the statements of Python files, of the bytes of others."""
    total = hashlib.sha256()
    for name in names:
        content = read(name)
        if name.endswith(".py"):
            content = repr(_program(ast.parse(content))).encode()
        total.update(name.encode() + b"\0" + hashlib.sha256(content).digest())
    return total.hexdigest()[:DIGITS]


def _program(node: Any) -> Any:
    """A syntax tree as nested tuples without positions, texts that stand alone, and whatever is empty.

    `ast.dump` lists empty fields, and newer versions of Python have more of them.
    """
    if isinstance(node, list):
        return tuple(_program(part) for part in node if not _is_text(part))
    if not isinstance(node, ast.AST):
        return node
    fields = [(name, value) for name, value in ast.iter_fields(node) if value is not None and value != []]
    return (type(node).__name__, *((name, _program(value)) for name, value in fields))


def _is_text(node: Any) -> bool:
    """Whether a statement is nothing but a text: a docstring, or a text below a constant."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def page_lines(page: str) -> Iterable[tuple[str, bool]]:
    """Lines of a page, each with whether it is printed output between fences."""
    is_output = False
    for line in page.rstrip("\n").split("\n"):
        is_fence = line.startswith("```")
        yield line, is_output or is_fence
        is_output ^= is_fence


def _git(*words: str) -> str:
    """What a git command prints."""
    return _git_bytes(*words).decode()


def _git_bytes(*words: str) -> bytes:
    """What a git command prints, as bytes."""
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, check=True).stdout


if __name__ == "__main__":
    main()
