"""The guard before the page: the token, Host and Origin of each request, headers of each answer.

A page of another site that the same browser shows may send requests to 127.0.0.1, also by a name
of its own that leads there (DNS rebinding): what it sends has another Host, Origin or
Sec-Fetch-Site than ours, and no token.
"""

import hmac
from collections.abc import Iterable

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

# Nothing but what this server sends is loaded, and nothing else runs.
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
    "media-src 'self'; connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'"
)
_HEADERS = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_READING = ("GET", "HEAD")


class Guard:
    """Answers requests of our own page alone; paths then begin after the token."""

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self._app, self._token = app, token
        after = "" if port == 80 else f":{port}"  # which browsers leave out
        self._hosts = {f"127.0.0.1{after}", f"localhost{after}"}
        self._origins = {f"http://{host}" for host in self._hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it in one line."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return  # no other kind of connection is offered

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        _, _, rest = scope["path"].partition("/")
        token, slash, inner = rest.partition("/")
        refusal = self._refusal(scope, token)
        if refusal is not None:
            await refusal(scope, receive, with_headers)
            return
        if not slash:  # addresses in the page are relative to its folder
            moved = PlainTextResponse("", 307, {"Location": f"/{token}/"})
            await moved(scope, receive, with_headers)
            return
        path = f"/{inner}"
        await self._app({**scope, "path": path, "raw_path": path.encode()}, receive, with_headers)

    def _refusal(self, scope: Scope, token: str) -> PlainTextResponse | None:
        headers = Headers(scope=scope)
        if headers.get("host", "") not in self._hosts or not _single(headers, ("host", "origin")):
            return PlainTextResponse("This is answered at 127.0.0.1 only.", 403)
        origin = headers.get("origin")
        ours = origin in self._origins or (origin is None and scope["method"] in _READING)
        if not ours or headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            return PlainTextResponse("Requests of other pages are refused.", 403)
        if not hmac.compare_digest(token.encode(), self._token.encode()):
            return PlainTextResponse("Nothing here; `granulab studio` prints its address.", 404)
        return None


def _single(headers: Headers, names: Iterable[str]) -> bool:
    """True where none of the headers is given twice."""
    return all(len(headers.getlist(name)) <= 1 for name in names)
