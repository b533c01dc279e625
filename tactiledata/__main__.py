"""The command `tactiledata`, also run as `python -m tactiledata` where the script is not on the path."""

import sys


def main() -> None:
    """Run the command; Ctrl-C while it is still being imported ends it as quietly as later."""
    try:
        from tactiledata.cli.main import run
    except KeyboardInterrupt:
        sys.stderr.write("interrupted: nothing was begun\n")
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()
