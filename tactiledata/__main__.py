"""The command `tactiledata`, run as `python -m tactiledata` where the script is not on the path."""

from tactiledata.cli.main import run

if __name__ == "__main__":
    run()
