"""Make pictures of the pages again, each by the commands that docs/pictures/made.toml has for it.

python docs/picture.py [NAME ...] writes docs/pictures/NAME.png; without a name all that have a
command. Pictures that share their commands share one folder and one run of them.
"""

import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
PICTURES = DOCS / "pictures"
WIDEST = 1200  # [px] of a picture that is kept; a page shows 800


def recipes() -> dict[str, dict]:
    """The recipe of each picture by its name."""
    return tomllib.loads((PICTURES / "made.toml").read_text(encoding="utf-8"))


def make(names: list[str], folder: Path) -> None:
    """Run the commands of pictures in an empty folder, each once, and keep what they draw."""
    known, done = recipes(), set()
    for name in ("data", "docs"):
        (folder / name).symlink_to(DOCS.parent / name)
    binaries = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for name in names:
        for command in known[name]["run"]:
            if command not in done:
                print(f"{name}: {command}", flush=True)
                subprocess.run(
                    command, shell=True, cwd=folder, check=True, stdout=subprocess.DEVNULL,
                    env={**os.environ, "PATH": binaries},
                )  # fmt: skip
                done.add(command)
        made = max(folder.glob(known[name]["from"]), key=lambda path: path.stat().st_mtime)
        with Image.open(made) as picture:
            picture = picture.convert("RGB")
            picture.thumbnail((WIDEST, 2 * WIDEST))
            picture.quantize(256).save(PICTURES / f"{name}.png", optimize=True)


def main() -> None:
    """Make the pictures that are named, or all with a command."""
    known = recipes()
    names = sys.argv[1:] or [name for name, recipe in known.items() if "run" in recipe]
    wrong = [name for name in names if "run" not in known.get(name, {})]
    if wrong:
        sys.exit(f"{', '.join(wrong)}: no command in docs/pictures/made.toml")
    with tempfile.TemporaryDirectory() as folder:
        make(names, Path(folder))


if __name__ == "__main__":
    main()
