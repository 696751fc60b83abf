"""The studio on its port: socket, token, server, and the browser that is opened."""

import contextlib
import logging
import secrets
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import click

from granulab.errors import InputError

HOST = "127.0.0.1"


def serve(folder: Path, port: int, *, open_browser: bool) -> None:
    """Serve the page of a folder until Ctrl-C, SIGTERM or the end of the terminal (SIGHUP).

    The runs that it started then keep their state and end with it. Raises InputError, one line,
    where the folder is none or the port is taken.
    """
    from granulab.campaign.output.files import refuse_unless_writable

    if not folder.is_dir():
        raise InputError(f"--folder {folder}: no such folder; make it, or give another")
    refuse_unless_writable(folder, "--folder")
    import uvicorn  # slow, as what it serves: --help needs none of it

    from granulab.studio.app import studio
    from granulab.studio.desk import Desk
    from granulab.studio.guard import Guard

    with _listening(port) as listening:
        port = listening.getsockname()[1]
        token = secrets.token_urlsafe(24)
        address = f"http://{HOST}:{port}/{token}/"
        desk = Desk(folder)
        application = Guard(studio(desk), token, port)

        class Server(uvicorn.Server):
            def handle_exit(self, sig: int, frame: FrameType | None) -> None:
                desk.beside.ending = True  # an answer that takes long holds up the end
                super().handle_exit(sig, frame)

            @contextlib.contextmanager
            def capture_signals(self) -> Iterator[None]:
                # at its end the signals that came do what they did before: most end the process
                with super().capture_signals(), _on_hangup(self.handle_exit):
                    try:
                        yield
                    finally:
                        desk.close()

        config = uvicorn.Config(
            application, log_level=logging.WARNING, access_log=False, server_header=False,
            timeout_graceful_shutdown=3, ws="none",
        )  # fmt: skip
        click.echo(address)
        click.echo(f"serves {folder.resolve()} on this machine alone; Ctrl-C ends it", err=True)
        if open_browser:
            threading.Thread(target=_show, args=(address,), daemon=True).start()
        with contextlib.suppress(KeyboardInterrupt):  # the way to end it
            Server(config).run(sockets=[listening])


@contextlib.contextmanager
def _on_hangup(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Take the end of the terminal within; not where it means nothing (nohup, Windows)."""
    number = getattr(signal, "SIGHUP", None)
    if number is None or signal.getsignal(number) is not signal.SIG_DFL:
        yield
        return
    signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, signal.SIG_DFL)


def _listening(port: int) -> socket.socket:
    """A socket at a port of this machine alone; InputError where it is taken."""
    listening = socket.socket()
    if sys.platform != "win32":  # there it would share the port with another program
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        listening.listen(128)
    except OSError as error:
        listening.close()
        reason = error.strerror or type(error).__name__
        raise InputError(
            f"--port {port}: cannot be used ({reason}); give another, or leave it out"
        ) from None
    return listening


def _show(address: str) -> None:
    """Open the address in the person's browser; a line where there is none."""
    import webbrowser

    try:
        opened = webbrowser.open_new_tab(address)
    except (webbrowser.Error, OSError):
        opened = False
    if not opened:
        click.echo("no browser was found; open the address above in one", err=True)
