"""Ctrl-C ends a command, whatever it met on its way, with one line and exit code 130."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMAND = """
import os, signal, sys, time
from tactiledata.cli import failure, main

failure.AGAIN_S = 0.2
# what runs in the background ignores Ctrl-C, and so does what it starts
signal.signal(signal.SIGINT, signal.default_int_handler)

@main.app.command("stand-in")
def stand_in() -> None:
{body}

sys.argv = ["tactiledata", "stand-in"]
main.run()
"""
CAUGHT = ("try:", "    os.kill(os.getpid(), signal.SIGINT)", "    time.sleep(50)", "except KeyboardInterrupt:")
"""Lines that interrupt themselves; the next one says what then happens."""
pytestmark = pytest.mark.slow


def ended(*lines):
    """The ended process of a command with these lines."""
    program = COMMAND.format(body="\n".join(f"    {line}" for line in lines))
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)


def test_an_interruption_that_was_swallowed_is_repeated():
    """Code of others may catch it while it calls back: the command would run to its end and exit with 0."""
    began = time.monotonic()
    done = ended(*CAUGHT, "    pass", "time.sleep(50)")
    # what waits in the system is woken
    assert time.monotonic() - began < 30.0
    assert done.returncode == 130
    assert done.stderr.startswith("interrupted: ")
    assert "Traceback" not in done.stderr


def test_an_interruption_that_a_callback_drops_is_repeated_without_a_word():
    """Python prints an error of a callback from C, which nobody can catch; that of Ctrl-C is no news."""
    calls = "import ctypes; ctypes.CFUNCTYPE(None)(lambda: {})()"
    done = ended(calls.format("os.kill(os.getpid(), signal.SIGINT)"), "time.sleep(50)")
    assert (done.returncode, done.stderr.count("\n")) == (130, 1)
    assert "ZeroDivisionError" in ended(calls.format("1 / 0")).stderr


def test_an_error_that_follows_an_interruption_is_no_fault():
    """What was interrupted half-way may fail in any way; without Ctrl-C the same error is a fault of the program."""
    fails = "raise RuntimeError('dictionary changed size during iteration')"
    done = ended(*CAUGHT, f"    {fails} from None")
    assert (done.returncode, done.stderr.count("\n")) == (130, 1)
    assert ended(fails).returncode == 3


def test_a_command_that_ends_well_is_not_interrupted():
    """A server that Ctrl-C ends has done its work."""
    done = ended(*CAUGHT, "    pass")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("raised", ["KeyboardInterrupt", "ImportError"])
def test_an_interruption_while_the_command_is_imported_is_quiet(raised):
    """The first tenths of a second are imports; an error there is still shown in full."""
    program = (
        "import sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == 'tactiledata.cli.main': raise {raised}\n"
        "sys.meta_path.insert(0, Finder())\n"
        "from tactiledata.__main__ import main\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    if raised == "KeyboardInterrupt":
        assert (done.returncode, done.stderr) == (130, "interrupted: nothing was begun\n")
    else:
        assert done.returncode == 1
        assert "Traceback" in done.stderr


def test_the_package_loads_no_other_module_before_an_interruption_is_quiet():
    """Until `main` runs, Ctrl-C is loud: the package itself imports nothing that takes time."""
    program = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r}); before = set(sys.modules); import tactiledata.__main__; "
        "print(sorted(set(sys.modules) - before - {'__future__', 'tactiledata', 'tactiledata.__main__'}))"
    )
    done = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("as_module", [True, False])
def test_an_interruption_inside_a_text_that_runs_ends_with_the_code(as_module, tmp_path):
    """Python would end by the signal, under -m, where Ctrl-C was caught inside `exec` of a text."""
    (tmp_path / "interrupted.py").write_text(
        "import sys\n"
        "from tactiledata.__main__ import main\n"
        "from tactiledata.cli import main as command\n"
        "def stop():\n"
        "    exec('raise KeyboardInterrupt')\n"
        "command.app.command('stand-in')(stop)\n"
        "sys.argv = ['tactiledata', 'stand-in']\n"
        "main()\n"
    )
    program = ["-m", "interrupted"] if as_module else ["interrupted.py"]
    done = subprocess.run([sys.executable, *program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (130, 1), done.stderr
