"""A command run in this process as the installed script runs it."""

import sys

from tactiledata.cli.main import run


def run_command(capsys, *arguments):
    """Exit code, standard output and standard error of one command."""
    before = sys.argv
    sys.argv = ["tactiledata", *map(str, arguments)]
    code = 0
    try:
        run()
    except SystemExit as stop:
        code = stop.code or 0
    finally:
        sys.argv = before
    printed = capsys.readouterr()
    return code, printed.out, printed.err
