"""The viewer in a browser: what is served, to whom, and that it opens and draws in a real one."""

import asyncio
import http.client
import re
import subprocess
import sys
import time
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
from browser import BROWSER, open_browser
from copied_trees import copy_tree

pytest.importorskip("rerun")

from viewed_store import attach_planted

from tactiledata.errors import UsageError
from tactiledata.store.read.reader import Store
from tactiledata.view.options import ViewOptions
from tactiledata.view.recording import write_view
from tactiledata.view.serve import served

CONTENT = bytes(range(256)) * 5000


def ask(address, path, **headers):
    """Status, headers and content of an answer."""
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=60)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer.status, answer.headers, content


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """The address of a served file called "a view.rrd"."""
    path = tmp_path_factory.mktemp("served") / "a view.rrd"
    path.write_bytes(CONTENT)
    (path.parent / "other.rrd").write_bytes(b"secret")
    with served(path, 0) as place:
        yield place


def test_the_file_is_served_whole_at_the_address_that_the_page_is_given(address):
    """The page's address names the file; there it is, byte for byte."""
    place = urlsplit(parse_qs(urlsplit(address).query)["url"][0])
    assert place.netloc == urlsplit(address).netloc
    status, _, content = ask(address, place.path)
    assert (status, content) == (200, CONTENT)


def test_the_page_may_reach_no_other_address(address):
    """Rerun's page comes with a policy that lets it connect to its own address only."""
    status, headers, content = ask(address, "/")
    assert status == 200
    assert b"re_viewer" in content
    connect = next(part for part in headers["Content-Security-Policy"].split(";") if "connect-src" in part)
    assert set(connect.split()[1:]) == {"'self'", "data:", "blob:"}


@pytest.mark.parametrize(
    "path",
    [
        "/recording/other.rrd",
        "/recording/../other.rrd",
        "/recording/..%2fother.rrd",
        "/recording/",
        "/recording//etc/passwd",
    ],
)
def test_nothing_else_is_served(address, path):
    """No other file beside the one that was named is given, however the path is written."""
    status, _, content = ask(address, path)
    assert status == 404
    assert b"secret" not in content


def test_a_name_that_leads_here_from_elsewhere_is_refused(address):
    """A page of another site whose name resolves to this address is answered nothing (DNS rebinding)."""
    path = urlsplit(parse_qs(urlsplit(address).query)["url"][0]).path
    port = urlsplit(address).port
    assert ask(address, path, Host=f"evil.example:{port}")[0] == 403
    assert ask(address, path, Host=f"localhost:{port}")[0] == 200


def test_it_listens_on_the_loopback_address_alone(address):
    """The file is not offered to the network: the server's socket is bound to 127.0.0.1."""
    psutil = pytest.importorskip("psutil")
    port = urlsplit(address).port
    bound = {c.laddr.ip for c in psutil.Process().net_connections() if c.laddr and c.laddr.port == port}
    assert bound == {"127.0.0.1"}


def test_a_taken_port_is_wrong_usage(address, tmp_path):
    """A port that another server has is named, and what to do."""
    (tmp_path / "b.rrd").write_bytes(b"")
    with pytest.raises(UsageError, match="--port"), served(tmp_path / "b.rrd", urlsplit(address).port):
        pass


OPTIONS = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
           "--window-size=1600,1000")  # fmt: skip
PATIENCE = 240.0
"""Seconds in which the page must have drawn: without a graphics card it is slow."""
MEASURED_BLUE = (44, 90, 160)
"""Colour of z among measured dots and simulated lines."""
HELD_BACK = re.compile(r"Content Security Policy")
"""Errors of the page's own attempts to reach its makers, which the policy holds back, and what follows from them."""


async def drawn_in_browser(address, folder, is_drawn):
    """A picture (H, W, 3) of a page once it is drawn, and the errors of its console."""
    pytest.importorskip("aiohttp")
    async with open_browser(folder, *OPTIONS) as tab:
        await tab.send("Page.navigate", url=address)
        began = time.monotonic()
        while time.monotonic() < began + PATIENCE:
            await asyncio.sleep(4)
            picture = await tab.picture()
            if is_drawn(picture):
                return picture, tab.errors
        pytest.fail(f"the page was not drawn in {PATIENCE} s; errors: {tab.errors}")


def share_near(picture, colour, reach=12):
    return float((np.abs(picture.astype(int) - colour).max(axis=2) <= reach).mean())


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no browser")
def test_a_real_browser_draws_it_without_an_error(tiny_store, tmp_path):
    """A headless browser loads page and file, draws picture, grey difference and dots of measured force, and reports no
    error but those of connections to the page's makers that the policy holds back.
    """
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    attach_planted(tmp_path / "ds.zarr")
    store = Store.open(tmp_path / "ds.zarr")
    write_view(store, tmp_path / "view.rrd", ViewOptions(names=("t00000",)))
    background = store.reference("D20001").image.reshape(-1, 3)
    middle = tuple(np.median(background, axis=0).astype(int))

    def is_drawn(picture):
        grey = share_near(picture, (128, 128, 128), 6)
        return grey > 0.03 and share_near(picture, MEASURED_BLUE) > 2e-4 and share_near(picture, middle, 25) > 0.02

    with served(tmp_path / "view.rrd", 0) as address:
        picture, errors = asyncio.run(drawn_in_browser(address, tmp_path / "profile", is_drawn))
    held_back = [error for error in errors if HELD_BACK.search(error)]
    failed = [error for error in errors if error.startswith("TypeError: Failed to fetch")]
    assert len(failed) <= len(held_back)
    assert not set(errors) - set(held_back) - set(failed)
    # a control: what the page shows while it loads is not taken for drawn
    assert not is_drawn(np.full_like(picture, 255))


@pytest.mark.slow
def test_the_command_serves_until_it_is_interrupted(tiny_store, tmp_path):
    """`view --web` says the address, serves there, and ends with 0 at Ctrl-C."""
    import signal

    command = [sys.executable, "-c", "from tactiledata.cli.main import run; run()", "view", str(tiny_store)]
    arguments = ["t00000", "--web", "--port", "0", "--out", str(tmp_path / "view.rrd"), "--pictures", "2"]
    # a shell may start what it runs in the background with this signal ignored
    running = subprocess.Popen(
        [*command, *arguments], stdout=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    try:
        for line in running.stdout:
            if line.startswith("look: "):
                break
        address = line.split()[1]
        path = urlsplit(parse_qs(urlsplit(address).query)["url"][0]).path
        assert ask(address, path)[2] == (tmp_path / "view.rrd").read_bytes()
        port = urlsplit(address).port
        assert f"`ssh -L {port}:127.0.0.1:{port} " in running.stdout.readline()
        running.send_signal(signal.SIGINT)
        assert running.wait(30) == 0
    finally:
        running.kill()
        running.communicate()


def test_ctrl_c_while_the_address_is_said_ends_it_too(tmp_path, monkeypatch):
    """Ctrl-C that comes before the command waits for it ends the page as well, without an error."""
    from tactiledata.cli import view

    said = []

    def say(line):
        said.append(line)
        if line.startswith("look: "):
            raise KeyboardInterrupt

    monkeypatch.setattr(view, "say", say)
    view._serve(tmp_path / "view.rrd", 0)
    assert len(said) == 2
    assert said[-1] == "ended"
