"""The command `tactiledata`, also run as `python -m tactiledata` where the script is not on the path."""

import sys


def main() -> None:
    """Run the command; Ctrl-C while it is still being imported ends it as quietly as later; while it exits, not."""
    try:
        import signal

        from tactiledata.cli.main import run
    except KeyboardInterrupt:
        sys.stderr.write("interrupted: nothing was begun\n")
        sys.exit(130)
    try:
        run()
    finally:
        # a process that is exiting would die of a second Ctrl-C, and its exit code would be lost
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        # Python notes an interruption inside `exec` of a text, as dataclasses do it, and under `-m` ends by the signal
        # although it was caught; the next text takes the note away
        exec("")


if __name__ == "__main__":
    main()
