"""Pages of the docs, as tests read them: the commands they show, the files they say to write."""

import os
import re
import shlex
import sys
from pathlib import Path

PROGRAMS = ("silo2d", "damper3d", "calibrate", "granulab")
# Indented or behind a prompt, and gone on with behind a backslash.
_SHOWN = re.compile(rf"^(?: {{4,}}|\$ )((?:{'|'.join(PROGRAMS)}) (?:.*\\\n)*.*)$", re.MULTILINE)
_FILE = re.compile(r"`([^`/]+)`:\n+```\w*\n(.*?)```", re.DOTALL)


def commands_of(text: str) -> list[list[str]]:
    """The words of each command of a page, without what follows two spaces, a pipe or the like."""
    found = []
    for shown in _SHOWN.findall(text):
        one_line = re.sub(r"\s*\\\n\s*", " ", shown)
        words = shlex.split(re.split(r" {2,}", one_line)[0], comments=True)
        ends = [k for k, word in enumerate(words) if word in ("|", ">", "&&", ";", "||")]
        found.append(words[: ends[0]] if ends else words)
    return found


def files_of(text: str) -> dict[str, str]:
    """The files that a page shows behind their names, such as `beech.toml`, by name."""
    return dict(_FILE.findall(text))


def plain_environment() -> dict[str, str]:
    """PATH with this Python's programs first, and HOME.

    Nothing else: settings of BLAS change roundings, and so a packing and the numbers of its run.
    """
    binaries = Path(sys.executable).parent
    return {"PATH": f"{binaries}{os.pathsep}{os.environ['PATH']}", "HOME": str(Path.home())}
