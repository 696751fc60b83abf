"""The addresses of the studio: what the page fetches, and what it sends."""

import inspect
import json
import logging
from collections.abc import Callable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    PlainTextResponse,
    Response,
)
from starlette.routing import Route

from granulab.errors import FolderError, InputError, SimulationError, Stopped
from granulab.studio.contents import KIND
from granulab.studio.desk import Desk

_PAGE = files("granulab.studio") / "page"
_TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css",
          ".svg": "image/svg+xml"}  # fmt: skip
_MOST_JSON = 2**22  # bytes of a request
# A page of its own origin: it can read nothing of the studio, and fetch nothing.
_SANDBOX = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:; frame-ancestors 'self'"
)
_log = logging.getLogger(__name__)

Answer = Callable[..., Any]


def studio(desk: Desk) -> Starlette:
    """The application, without its guard."""
    return Starlette(
        routes=[
            Route("/", _page),
            Route("/page/{name}", _page),
            Route("/files/{name:path}", _file(desk), methods=["GET"]),
            Route("/files/{name}", _receive(desk), methods=["PUT"]),
            Route("/player/{run}", _shown(lambda run: desk.runs.player(run), desk)),
            Route("/answer/{name:path}", _shown(lambda name: desk.measuring.page(name), desk)),
            Route("/frames/{name:path}", _frame(desk)),
            Route("/api/{question}", _answers(desk), methods=["GET", "POST"]),
        ]
    )


async def _page(request: Request) -> Response:
    """The page itself, or one of its scripts and styles."""
    name = request.path_params.get("name", "index.html")
    known = {one.name: one for one in _PAGE.iterdir()}
    ending = Path(name).suffix
    if name not in known or ending not in _TYPES:
        return _refused("no such part of the page", 404)
    return Response(known[name].read_bytes(), media_type=_TYPES[ending])


def _answers(desk: Desk) -> Any:
    """Questions of the page: JSON in, JSON out; a refusal is a line."""

    async def answer(request: Request) -> Response:
        asks = desk.asks if request.method == "GET" else desk.orders
        function = asks.get(request.path_params["question"])
        if function is None:
            return _refused("no such question", 404)
        try:
            given = dict(request.query_params) if request.method == "GET" else await _json(request)
            return JSONResponse(await run_in_threadpool(_called, function, given))
        except (InputError, FolderError, SimulationError, Stopped) as error:
            return _refused(desk.without_root(str(error)))

    return _guarded(answer)


def _called(function: Answer, given: Mapping[str, Any]) -> Any:
    """The answer to a question with its parameters; InputError where they are others."""
    try:
        bound = inspect.signature(function).bind(**given)
    except TypeError as error:
        raise InputError(f"a request of another page version: {error}") from None
    return function(*bound.args, **bound.kwargs)


async def _json(request: Request) -> dict[str, Any]:
    content = bytearray()
    async for piece in request.stream():
        content += piece
        if len(content) > _MOST_JSON:
            raise InputError("the request is larger than 4 MB")
    try:
        found = json.loads(bytes(content) or b"{}")
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError("the request is no JSON object")
    return found


def _file(desk: Desk) -> Any:
    """A picture, film or table of the folder."""

    async def file(request: Request) -> Response:
        try:
            path = desk.folder.file(request.path_params["name"])
        except InputError as error:
            return _refused(desk.without_root(str(error)), 404)
        if KIND.get(path.suffix.lower()) is None and path.suffix.lower() != ".gif":
            return _refused(f"{path.name}: files of this kind are not shown", 404)
        # Nothing in it runs, whatever it is: an SVG may hold scripts.
        return FileResponse(
            path, headers={"Content-Security-Policy": "sandbox; default-src 'none'"}
        )

    return _guarded(file)


def _receive(desk: Desk) -> Any:
    """A file that is dropped on the page."""

    async def receive(request: Request) -> Response:
        try:
            name = await desk.folder.receive(request.path_params["name"], request.stream())
        except (InputError, FolderError) as error:
            return _refused(desk.without_root(str(error)))
        return JSONResponse({"name": name})

    return _guarded(receive)


def _shown(page_of: Callable[..., str], desk: Desk) -> Any:
    """A page for a frame of its own: that plays a run, or that a question was answered by."""

    async def shown(request: Request) -> Response:
        try:
            page = await run_in_threadpool(page_of, **request.path_params)
        except (InputError, FolderError) as error:
            return PlainTextResponse(desk.without_root(str(error)))
        return HTMLResponse(page, headers={"Content-Security-Policy": _SANDBOX})

    return _guarded(shown)


def _frame(desk: Desk) -> Any:
    """A frame of a film of the folder, for marking what to look at."""
    from granulab.studio.rooms.measuring import film_frame

    async def frame(request: Request) -> Response:
        number = request.query_params.get("number", "0")
        try:
            if not number.isdecimal() or len(number) > 9:
                raise InputError(f"frame {number!r}: must be a whole number")
            name = request.path_params["name"]
            png = await run_in_threadpool(film_frame, desk.folder, name, int(number))
        except InputError as error:
            return _refused(desk.without_root(str(error)), 404)
        return Response(png, media_type="image/png")

    return _guarded(frame)


def _guarded(answer: Any) -> Any:
    """An answer in one line where something fails that nobody foresaw; the terminal has more."""

    async def guarded(request: Request) -> Response:
        try:
            return await answer(request)
        except Exception as error:
            _log.exception("unforeseen")
            reason = " ".join(str(error).split())
            return _refused(
                f"{type(error).__name__}: {reason} (a fault; the terminal has more)", 500
            )

    return guarded


def _refused(line: str, status: int = 200) -> Response:
    """A line in place of an answer. Browsers count an error status as a fault of the page."""
    return JSONResponse({"refusal": line}, status)
