"""The viewer that opens a written file: rerun's own program, or rerun's page in a browser of this machine.

The page and the file come from one address on the loopback interface. It answers no other page, and the page may reach
no other address: rerun's page would report its use to its makers.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.client import HTTPConnection, HTTPException
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import BinaryIO
from urllib.parse import quote

from tactiledata.errors import TactileDataError, UsageError
from tactiledata.view.rerun_package import load_rerun

HOST, NAMES = "127.0.0.1", ("127.0.0.1", "localhost")
PORT = 9090
"""Port of the page where no other is asked for."""
RECORDING = "/recording/"
"""Where the file is, beside the files of rerun's page."""
BLOCK = 2**20
"""Bytes in memory at once."""
STARTING = 3.0
"""Seconds in which the viewer's program may fail to start."""
TRIES = 5
"""Free ports that are tried for rerun's own server."""
POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; worker-src 'self' blob:; connect-src 'self' data: blob:"
)
"""Content security policy of the page: it works alone, and reaches this address only."""


def has_display() -> bool:
    """Whether a window can be opened: always so on macOS and Windows, elsewhere where X11 or Wayland is named."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def need_display(path: Path) -> None:
    """Refuse to open a file in a window where there can be none.

    Raises
    ------
    UsageError
        There is no display.
    """
    if not has_display():
        raise UsageError(
            "there is no display for the viewer",
            "a window system (DISPLAY or WAYLAND_DISPLAY)",
            f"Use --web, or copy {path} to a machine with a display and run `rerun {path.name}` there.",
        )


def open_viewer(path: Path) -> None:
    """Open a file in rerun's viewer, a program of its own that goes on when this one ends.

    Raises
    ------
    UsageError
        There is no display.
    TactileDataError
        The viewer ended at once.
    """
    load_rerun()
    need_display(path)
    command = [sys.executable, "-m", "rerun", str(path)]
    quiet = subprocess.DEVNULL
    viewer = subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True)
    deadline = time.monotonic() + STARTING
    while time.monotonic() < deadline and viewer.poll() is None:
        time.sleep(0.05)
    if viewer.poll():
        raise TactileDataError(
            f"the viewer ended at once, with code {viewer.returncode}",
            "a window",
            f"`{sys.executable} -m rerun {path}` says why; --web needs no window.",
        )


@contextmanager
def served(path: Path, port: int = PORT) -> Iterator[str]:
    """Serve a file and rerun's page to browsers of this machine inside the block; give the address of the page.

    Parameters
    ----------
    path : Path
        A file that `write_view` wrote.
    port : int
        Port of the page; 0 for any that is free.

    Raises
    ------
    UsageError
        The port is taken.
    """
    page_port = _serve_page()
    try:
        server = ThreadingHTTPServer((HOST, port), partial(_Answer, path, page_port))
    except (OSError, OverflowError) as error:
        raise _port_refused(port, error) from error
    thread = Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        here = f"http://{HOST}:{server.server_port}"
        recording = quote(f"{here}{RECORDING}{quote(path.name)}", safe="")
        yield f"{here}/?url={recording}&hide_welcome_screen&persist=0&notebook=0"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def need_port(port: int) -> None:
    """Refuse a port that cannot be used, before a file is written that it would serve.

    Raises
    ------
    UsageError
        The port is taken, or is no port.
    """
    try:
        # as the server will: an address that was served a moment ago may be taken again
        with socket.socket() as tried:
            tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            tried.bind((HOST, port))
    except (OSError, OverflowError) as error:
        raise _port_refused(port, error) from error


def _port_refused(port: int, error: Exception) -> UsageError:
    """Return the error of a port that cannot be used."""
    return UsageError(f"port {port} cannot be used: {error}", "a free port", "Name another --port, or 0 for any.")


def _serve_page() -> int:
    """Start rerun's server of its own page, which has no recordings; return its port. It ends with this process."""
    rr = load_rerun()
    for attempt in range(TRIES):
        with socket.socket() as free:
            free.bind((HOST, 0))
            port = int(free.getsockname()[1])
        try:
            rr.serve_web_viewer(web_port=port, open_browser=False)
        except RuntimeError as error:  # another program took it meanwhile
            if attempt + 1 == TRIES:
                raise TactileDataError(
                    f"rerun's page cannot be served: {error}", "a free port", "Try again."
                ) from error
        else:
            break
    return port


class _Answer(BaseHTTPRequestHandler):
    """Answers with the file, or with a file of rerun's page."""

    protocol_version = "HTTP/1.1"

    def __init__(self, path: Path, page_port: int, *request: object) -> None:
        self._path, self._page_port = path, page_port
        super().__init__(*request)  # type: ignore[arg-type]

    def do_GET(self) -> None:
        """Send the file, or a part of the page."""
        self._answer()

    def do_HEAD(self) -> None:
        """Send what is known of the file, or of a part of the page."""
        self._answer()

    def _answer(self) -> None:
        # a page elsewhere whose name leads to this address has that name in its requests
        if (self.headers.get("Host") or "").rpartition(":")[0] not in NAMES:
            self.send_error(403)
        elif self.path.startswith(RECORDING):
            self._send_recording()
        else:
            self._send_page()

    def _send_recording(self) -> None:
        if self.path != f"{RECORDING}{quote(self._path.name)}":
            self.send_error(404)
            return
        try:
            stream = self._path.open("rb")
        except OSError:
            self.send_error(404)
            return
        with stream:
            self._send(stream, "application/octet-stream", os.fstat(stream.fileno()).st_size)

    def _send_page(self) -> None:
        """Send a part of rerun's page, as its own server has it, with the policy that keeps it here."""
        connection = HTTPConnection(HOST, self._page_port, timeout=60)
        try:
            connection.request("GET", self.path.partition("?")[0])
            answer = connection.getresponse()
            if answer.status != 200:
                self.send_error(404)
                return
            content = answer.read()
        except (OSError, HTTPException):
            self.send_error(502)
            return
        finally:
            connection.close()
        self._send(content, answer.getheader("Content-Type") or "application/octet-stream", len(content))

    def _send(self, content: bytes | BinaryIO, kind: str, size: int) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(size))
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.end_headers()
        if self.command == "HEAD":
            return
        try:
            if isinstance(content, bytes):
                self.wfile.write(content)
            else:
                while size and (block := content.read(min(BLOCK, size))):
                    self.wfile.write(block)
                    size -= len(block)
        except (BrokenPipeError, ConnectionResetError):  # the browser has left
            return

    def log_message(self, *_: object) -> None:
        """Say nothing of requests."""
