"""The HTML of a page: a template of parts/ with its style, scripts and data, in one file.

Scripts are modules of parts/, joined into one: a page that is opened as a file may import none. A
policy in the page lets nothing run but this script and nothing be fetched; what the data say is set
as text, never as markup.
"""

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

_PARTS = files(__name__.rpartition(".")[0]) / "parts"
_IMPORT = re.compile(r'(?m)^import (\{[^}]*\}) from "\./(\w+)\.js";$')
_EXPORT = re.compile(r"(?m)^export ((?:async )?(?:function|class|const) (\w+))")


def document(
    template: str, scripts: Sequence[str], title: str, data: Mapping[str, Any], arrays: str = ""
) -> str:
    """A page from a template: its scripts in the order in which they need each other.

    data     of JSON types, without NaN
    arrays   base64, as packing.packed gives it
    """
    script, style = _joined(scripts), _part("page.css")
    policy = (
        f"default-src 'none'; script-src {_known(script)}; style-src {_known(style)}; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    pieces = {
        "policy": policy,
        "title": escape(title),
        "style": style,
        "script": script,
        # No tag can end or begin in it: a name may hold "</script>" or "<!--".
        "data": json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
        "arrays": arrays,
    }
    return re.sub(r"<!--(\w+)-->", lambda found: pieces[found[1]], _part(template))


def picture(png: bytes) -> str:
    """A PNG as an address in itself."""
    return f"data:image/png;base64,{base64.b64encode(png).decode()}"


def _part(name: str) -> str:
    return (_PARTS / name).read_text(encoding="utf-8")


def _joined(scripts: Sequence[str]) -> str:
    """One script of several modules, each a function that gives what the module exports."""
    return "".join(map(_as_function, scripts))


def _as_function(script: str) -> str:
    text, module = _part(script), script.removesuffix(".js")
    exports = ", ".join(found[1] for found in _EXPORT.findall(text))
    body = _EXPORT.sub(r"\1", _IMPORT.sub(r"const \1 = \2_js;", text))
    return f"const {module}_js = (() => {{\n{body}return {{ {exports} }};\n}})();\n"


def _known(text: str) -> str:
    """The digest by which a policy knows an element's text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
