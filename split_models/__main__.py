"""`torchrun -m split_models train RECIPE`: the command `tactiledata`, in several processes."""

from tactiledata.cli.main import run

if __name__ == "__main__":
    run()
