"""The studio as a process of its own, and requests to it by plain HTTP."""

import http.client
import json
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote, urlencode, urlsplit


class Answer(NamedTuple):
    """An answer of the studio."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        """Its JSON."""
        return json.loads(self.body)


class Studio:
    """`granulab studio` on a folder and any free port; close it."""

    def __init__(self, folder: Path, *options: str) -> None:
        self.folder = folder
        self._process = subprocess.Popen(
            [sys.executable, "-m", "granulab", "studio", "--folder", str(folder), "--no-browser",
             *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert self._process.stdout
        self.address = self._process.stdout.readline().strip()
        parts = urlsplit(self.address)
        assert parts.hostname == "127.0.0.1", (self.address, self._process.poll())
        assert parts.port
        self.host, self.path, self.port = parts.netloc, parts.path, parts.port

    def request(
        self, method: str, path: str, body: bytes | None = None, *, whole: bool = False,
        **headers: str,
    ) -> Answer:  # fmt: skip
        """Send a request to a path below the token, or to a whole one; headers as host, origin."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        sent = {"Host": self.host, "Origin": f"http://{self.host}"}
        sent |= {name.replace("_", "-").title(): value for name, value in headers.items()}
        connection.putrequest(
            method, path if whole else self.path + path, skip_host=True, skip_accept_encoding=True
        )
        for name, value in sent.items():
            if value:
                connection.putheader(name, value)
        if body is not None:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        got = connection.getresponse()
        answer = Answer(got.status, {k.lower(): v for k, v in got.getheaders()}, got.read())
        connection.close()
        return answer

    def ask(self, question: str, /, **parameters: str) -> Any:
        """The JSON that answers a question."""
        return self.request("GET", f"api/{question}?{urlencode(parameters)}", origin="").json

    def order(self, name: str, /, **body: Any) -> Any:
        """The JSON that answers an order."""
        return self.request("POST", f"api/{name}", json.dumps(body).encode()).json

    def send(self, name: str, content: bytes) -> Any:
        """The JSON that answers a file."""
        return self.request("PUT", f"files/{quote(name, safe='')}", content).json

    def close(self, number: signal.Signals = signal.SIGINT) -> tuple[int, str]:
        """End it as Ctrl-C does, or by another signal; its exit code and its stderr."""
        if self._process.poll() is None:
            self._process.send_signal(number)
        _, err = self._process.communicate(timeout=60)
        return self._process.returncode, err
