"""The report of loads in 80 columns, and the design sheet: one page of HTML with its picture."""

import base64
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from granulab.campaign.output.layout import columns, wrapped
from silo2d.view.loads.tables import Fact, Part, closed_parts, facts_of, run_parts

_STYLE = """
@page { size: A4; margin: 9mm; }
body { font: 8pt/1.25 "DejaVu Sans", Arial, sans-serif; color: #2b2b2b; background: #fff;
       max-width: 192mm; margin: 4mm auto; }
h1 { font-size: 12pt; margin: 0 0 1mm; } h2 { font-size: 8pt; margin: 1.5mm 0 .5mm; }
.two { columns: 2; column-gap: 6mm; } .keep { break-inside: avoid; }
table { border-collapse: collapse; width: 100%; font-size: 6.8pt; }
th, td { text-align: right; padding: .1mm 1mm; border-bottom: .1mm solid #ddd; }
th:first-child, td:first-child { text-align: left; } th { font-weight: 600; }
p { margin: .6mm 0; } b { font-weight: 600; } img { width: 100%; }
.small { font-size: 6.3pt; color: #55504a; margin: .3mm 0; }
"""


def parts_of(found: Mapping[str, Any]) -> list[Part]:
    """Facts and tables of a study of runs, or of a silo in closed form."""
    forms = found["closed_forms"]
    runs = run_parts(found) if "dem" in found else []
    return [*facts_of(forms), *runs, *closed_parts(forms)]


def title(found: Mapping[str, Any]) -> str:
    """Title of a report or sheet."""
    if "dem" not in found:
        return f"Loads on silo {found['closed_forms']['name']}"
    seeds = found["seeds"]
    runs = f"seed {seeds[0]}" if len(seeds) == 1 else f"{len(seeds)} seeds"
    return f"Loads on silo {found['silo']}, {runs}"


def in_words(found: Mapping[str, Any], width: int | None = None) -> str:
    """The report."""
    lines = [title(found)]
    for part in parts_of(found):
        if isinstance(part, Fact):
            lines.append(f"  {part.name:<16}  {part.words}")
        else:
            table = columns(part.head, _right(part.head, part.rows)).split("\n")
            lines += [f"  {part.title}", *(f"    {line}" for line in table)]
    assumed = found["closed_forms"]["assumptions"]
    lines += [f"  {'' if k else 'assumes':<16}  - {line}" for k, line in enumerate(assumed)]
    return "\n".join(
        line if line.startswith("    ") and " - " not in line else wrapped(line, 22, width)
        for line in lines
    )


def _right(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Cells but the first of each row, set to the right below their heads."""
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    return [[cell.rjust(widths[k]) if k else cell for k, cell in enumerate(row)] for row in rows]


def as_page(found: Mapping[str, Any], picture: bytes, made_by: str) -> str:
    """The design sheet; picture: a PNG."""
    image = base64.b64encode(picture).decode()
    words = "\n".join(_html(part) for part in parts_of(found))
    assumed = "; ".join(found["closed_forms"]["assumptions"])
    name = escape(title(found))
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{name}</title>'
        f"<style>{_STYLE}</style></head><body><h1>{name}</h1>"
        f'<img alt="pressures by height, flow chart" src="data:image/png;base64,{image}">'
        f'<div class="two">{words}</div><p class="small"><b>Assumes</b> {escape(assumed)}.</p>'
        f'<p class="small">{escape(made_by)}</p></body></html>\n'
    )


def _html(part: Part) -> str:
    if isinstance(part, Fact):
        return f'<p class="keep"><b>{escape(part.name)}</b> {escape(part.words)}</p>'
    head = "".join(f"<th>{escape(cell)}</th>" for cell in part.head)
    rows = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in part.rows
    )
    return (
        f'<div class="keep"><h2>{escape(part.title)}</h2><table><tr>{head}</tr>{rows}</table></div>'
    )
