"""A store on S3, by a real server: read as from a folder, checked, described by the command, trained from."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store

pytestmark = pytest.mark.slow
BUCKET = "tactile"


@pytest.fixture(scope="module")
def bucket(tiny_store, tmp_path_factory):
    """The URL of the tiny store in a bucket; the environment has the server's address."""
    s3fs = pytest.importorskip("s3fs")
    server = pytest.importorskip("moto.server")
    served = server.ThreadedMotoServer(port=0)
    served.start()
    host, port = served.get_host_and_port()
    settings = {
        "AWS_ENDPOINT_URL": f"http://{host}:{port}",
        "AWS_ACCESS_KEY_ID": "key",
        "AWS_SECRET_ACCESS_KEY": "secret",
        "AWS_DEFAULT_REGION": "us-east-1",
        # the machine's own settings play no part
        "AWS_CONFIG_FILE": os.devnull,
        "AWS_SHARED_CREDENTIALS_FILE": os.devnull,
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, value in settings.items():
            patch.setenv(name, value)
        system = s3fs.S3FileSystem(skip_instance_cache=True)
        system.mkdir(BUCKET)
        system.put(str(tiny_store), f"{BUCKET}/lab/ds.zarr", recursive=True)
        yield f"s3://{BUCKET}/lab/ds.zarr"
    served.stop()


def test_it_reads_as_from_a_folder(bucket, tiny_store):
    """Digest, tables, signals, pictures and every checksum are those of the folder."""
    there, here = Store.open(bucket), Store.open(tiny_store)
    assert there.digest == here.digest
    assert there.trajectories().equals(here.trajectories())
    rows = range(here.n_frames)
    np.testing.assert_array_equal(there.images(rows), here.images(rows))
    forces = [store.signal("contact_wrench").values(0, 500) for store in (there, here)]
    np.testing.assert_array_equal(*forces)
    assert check(there) == check(here)


def test_a_network_learns_from_it(bucket, tiny_store):
    """Batches of a loader with two worker processes are those of the folder."""
    torch = pytest.importorskip("torch")
    from tactiledata.loaders.torch import TactileDataset, collate

    batches = [
        list(
            torch.utils.data.DataLoader(
                TactileDataset(place, "default/train", ["digit", "contact_wrench"]),
                batch_size=8,
                num_workers=workers,
                collate_fn=collate,
            )
        )
        for place, workers in ((bucket, 2), (tiny_store, 0))
    ]
    assert len(batches[0]) == len(batches[1]) > 1
    for there, here in zip(*batches, strict=True):
        assert torch.equal(there["digit"], here["digit"])
        assert torch.equal(there["contact_wrench"], here["contact_wrench"])


def command(words):
    """Return exit code and all output of a command in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", "from tactiledata.cli.main import run; run()", *words],
        capture_output=True, text=True, check=False, cwd=Path(__file__).parents[2], timeout=300,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


def test_the_command_describes_it(bucket):
    """`info` and `audit` take the URL; what only a local store can do is refused in a sentence."""
    for words, code, expected in (
        (["info", bucket], 0, "4 trajectories"),
        (["audit", bucket], 0, "no leak found"),
        (["info", f"s3://{BUCKET}/elsewhere.zarr"], 2, "elsewhere.zarr"),
        (["split", bucket, "--name", "other"], 2, "local"),
    ):
        found, said = command(words)
        assert found == code, (words, said)
        assert expected in said
        assert "Traceback" not in said


def test_a_server_that_is_gone_is_said(bucket, monkeypatch):
    """Where nobody answers, the error names the place, and the command does not hang."""
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    code, said = command(["info", bucket])
    assert code == 1
    assert bucket in said
    assert "Traceback" not in said
