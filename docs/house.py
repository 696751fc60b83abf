"""The house as one picture: packages and their floors, from the import contracts that are checked.

Who stands higher may import who stands lower, in a package as between packages; side by side knows
nothing of each other.
"""

import tomllib
from html import escape
from pathlib import Path

WIDTH, MARGIN, GAP = 960, 12, 12  # [px]
STRIP, TITLE = 20, 46  # [px] height of a floor, and of what stands above the floors
LINES = {"room": "#8a8f98", "floor": "#c9cdd3"}


def picture(root: Path, purposes: dict[str, str]) -> str:
    """The SVG of the packages of `purposes` (folder: a sentence), lowest at the bottom."""
    contracts = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "importlinter"
    ]["contracts"]
    house, *others = (one for one in contracts if one["type"] == "layers")
    floors = {one["containers"][0]: one["layers"] for one in others}
    drawn, top = [], MARGIN
    for storey in house["layers"]:
        rooms = [name.strip() for name in storey.split("|")]
        rooms = [name for name in rooms if name.replace(".", "/") in purposes]
        if not rooms:
            continue
        inside = {
            name: floors.get(name) or _folders(root / name.replace(".", "/")) for name in rooms
        }
        height = TITLE + STRIP * max(map(len, inside.values()))
        wide = (WIDTH - 2 * MARGIN - GAP * (len(rooms) - 1)) / len(rooms)
        for k, name in enumerate(rooms):
            folder = name.replace(".", "/")
            drawn += _room(MARGIN + k * (wide + GAP), top, wide, height, f"{folder}/",
                           purposes[folder], inside[name])  # fmt: skip
        top += height + GAP
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {top}" role="img" '
        'font-family="sans-serif" font-size="12">\n<title>Packages and their floors: each imports '
        f'what stands lower</title>\n<rect width="{WIDTH}" height="{top}" fill="#ffffff"/>'
    )
    return "\n".join([head, *drawn, "</svg>", ""])


def _room(
    x: float, y: float, wide: float, high: float, name: str, purpose: str, floors: list[str]
) -> list[str]:
    """A package: name, purpose and its floors, the lowest at the bottom."""
    short = purpose if len(purpose) * 5.6 < wide else purpose[: int(wide / 5.6) - 3] + "..."
    drawn = [
        _box(x, y, wide, high, "room", "#f6f7f9"),
        f'<text x="{x + 8:g}" y="{y + 17:g}" font-weight="bold" font-size="14">{name}</text>',
        f'<text x="{x + 8:g}" y="{y + 34:g}" font-size="11" fill="#454b54">{escape(short)}</text>',
    ]
    for k, floor in enumerate(floors):
        at = y + high - STRIP * (len(floors) - k)
        words = floor.replace("|", " | ").replace(" : ", " | ").replace("  ", " ")
        drawn += [
            _box(x + 6, at, wide - 12, STRIP - 3, "floor", "#ffffff"),
            f'<text x="{x + 14:g}" y="{at + 12.5:g}">{escape(" ".join(words.split()))}</text>',
        ]
    return drawn


def _box(x: float, y: float, wide: float, high: float, line: str, fill: str) -> str:
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{wide:g}" height="{high:g}" rx="4" '
        f'fill="{fill}" stroke="{LINES[line]}"/>'
    )


def _folders(folder: Path) -> list[str]:
    """Folders of a package without floors, some to a line."""
    names = sorted(path.parent.name for path in folder.glob("*/__init__.py"))
    return [" | ".join(names[k : k + 8]) for k in range(0, len(names), 8)]
