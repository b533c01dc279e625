"""What of a program is its digest."""

import hashlib
import shutil
import subprocess
from pathlib import Path

from tactiledata.contract import program
from tactiledata.contract.program import statements

SAMPLE = '''
"""A program with what versions of Python write differently."""
from __future__ import annotations
import os.path as place, sys
LIMITS: dict[str, float] = {"far": 1e-300, **{}, "é\\U0001fae8\\u0378": -1.5j}
def share(a, /, b=1, *rest, c, d=None, **more) -> float:
    """Return a share."""
    global TOTAL
    return a / b if a else (yield from rest)
async def late(): await share(*[1, *()], c=u"u" "v", **{}); return ...
@staticmethod
class Empty(Exception, metaclass=type): """Nothing."""
def texts(x, width): return (
    f"", f"{{}}", "a" f"b{x}" "c" f"{{{x!r:>{width}}}}" f"", f"{x=}", f"{x:{width}{width}}", f"{x:%H:%M}",
    rb"\\d", b"\\xff", "\\ud800", f"{x:}" f"{'a'}")
match LIMITS:
    case {"far": [1, *_, None] | Empty(args=True), **others} if others: pass
    case _: ...
try: [i async for i in late() if i for (j, k) in i]; del TOTAL, LIMITS["far"][1:, ::2]
except* (ValueError, OSError) as error: raise error from None
else: "no docstring"
finally: (lambda *, n=0x10: n) if False else (last := {*()}) < 2 < 3 is not (not None)
with open(__file__) as one, (yield): TOTAL @= ~1 if sys else 1_000
'''
DIGEST = "46f92b115248f5f9606dffdfef444c7f957f9f8208746b4352dcacaff22863e8"
"""SHA-256 of the statements of the sample, as Python 3.11.7, 3.12.1 and 3.13.0 give it."""


def digest(source):
    return hashlib.sha256(statements(source)).hexdigest()


def test_words_about_a_program_leave_its_plays_valid():
    """Docstrings, comments and blank lines are no part of the digest; numbers, defaults and texts in use are."""
    inside = '    """Return a share."""\n    return a / b if a else "none"\n'
    text = 'LIMIT = 2\n"""A limit."""\n\n\ndef share(a, b=1):\n' + inside
    words = 'LIMIT = 2\n# a comment\ndef share(a, b=1):\n    return a / b if a else "none"\n'
    assert statements(text) == statements(words)
    changed = [("LIMIT = 2", "LIMIT = 3"), ("b=1", "b=2"), ('"none"', '"nothing"'), ("a / b", "a * b")]
    assert len({statements(text), *(statements(text.replace(*pair)) for pair in changed)}) == 5


def test_an_f_strings_texts_are_part_of_it():
    """Texts, values, formats and conversions of an f-string count; how its text is cut into pieces does not."""
    same = {
        statements(text) for text in ('f"ab{x}"', '"a" f"b{x}"', "f'a' 'b' f'{x}' ''", '(f"ab" # a comment\n f"{x}")')
    }
    assert len(same) == 1
    others = ('f"ab{x}b"', 'f"b{x}"', 'f"ab{y}"', 'f"ab{x!r}"', 'f"ab{x:3}"', 'f"ab{x:{3}}"', 'f"{x}ab"', '"ab{x}"')
    assert len(same | {statements(text) for text in others}) == 1 + len(others)


def test_what_is_left_out_when_empty_is_not_confused():
    """Programs that differ only by `None`, an empty list or a missing part have different bytes."""
    texts = ("x = None", "x = []", "x = ''", "x = ()", "x: None", "x", "{**x}", "{None: x}", "return", "return None")
    assert len({statements(text) for text in texts}) == len(texts)


def interpreters():
    """Other versions of Python on this machine that can read the sample."""
    kept = sorted((Path.home() / ".pyenv" / "versions").glob("3.1[1-9].*/bin/python"))
    named = [shutil.which(f"python3.{minor}") for minor in range(11, 20)]
    # a shim stands for a version that may not be there
    return [*map(str, kept), *(place for place in named if place and "shims" not in place)]


def test_every_version_of_python_gives_the_same_bytes():
    """The digest of the sample is the one recorded, here and by each other interpreter from 3.11 on that is found."""
    assert digest(SAMPLE) == DIGEST
    words = (
        "import hashlib, runpy, sys; "
        "statements = runpy.run_path(sys.argv[1])['statements']; "
        "print(hashlib.sha256(statements(sys.stdin.read())).hexdigest())"
    )
    for python in interpreters():
        command = [python, "-I", "-X", "utf8", "-W", "ignore", "-c", words, program.__file__]
        done = subprocess.run(command, input=SAMPLE.encode(), capture_output=True, check=True)
        assert done.stdout.decode().strip() == DIGEST, python
