"""Restitution from the heights of a drop or a swing before and after (paper sec. 3.3).

Particle on wall, dropped from rest at H0 and rising to H1: e = sqrt(H1/H0) (eq. 3.5). Two equal
blocks on strings, one released at H0, which rise to H1 (that one) and H2: e = (sqrt(H2) - sqrt(H1))
/ sqrt(H0) (eq. 3.6). Air is left out of both: it makes a fall of 1 m of a ping-pong ball slower by
some per cent, of a wooden block by less than one in a thousand.

A table has a row a trial; or a column a drop height, whose line of heights begins with H0; or means
and standard deviations, as the paper's Tables 2 and 3 print them.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibration.bench.measure import Quantity, measure, no_better_than
from calibration.bench.sections import (
    Columns,
    Input,
    Request,
    Section,
    chosen,
    head_of,
    need,
    rows,
)
from calibration.files.dialect import Row, is_missing, name_and_unit, number
from calibration.files.layout import is_made_of_others, slip_in
from calibration.files.sheets import is_spreadsheet
from calibration.files.tables import read_table, refuse_two_marks, rows_of
from calibration.statistics.mixed import mixed
from calibration.statistics.uncertainty import Estimate, pooled_summaries
from granulab.contact.files.units import to_si
from granulab.errors import InputError

INPUTS = (
    Input("h0", "m", "height of release, H0"),
    Input("h1", "m", "height of the rebound, H1; of a pendulum, of the block that was released"),
    Input("h2", "m", "of a pendulum, of the other block, H2"),
    Input("mean", "1", "or the mean of the restitution at H0,"),
    Input("sd", "1", "its standard deviation, in per cent that of the mean,"),
    Input("trials", "1", "and the number of trials"),
)
_OF_SD = INPUTS[4]
_CHOICES = (("h0", "h1", "h2"), ("h0", "h1"), ("h0", "mean", "sd", "trials"))
_PER_CENT = ("%", "percent", "per cent")
_MEAN = re.compile(r"\b(mean|mittelwert)\b", re.IGNORECASE)
_SD = re.compile(
    r"\b(s\.?d\.?|std(\.? ?dev)?|stdev|stdabw|standard deviation|standardabweichung)(?!\w)",
    re.IGNORECASE,
)
_OF_OTHERS = re.compile(r"\b(average|overall|all|total)\b", re.IGNORECASE)
_NUMBER = re.compile(r"\d+")
_NAMES = re.compile(r"H_?0|drop height.*|release height.*|Fallhöhe.*", re.IGNORECASE)


def restitution(files: Sequence[str | Path], what: Request) -> list[Quantity]:
    """The restitution, pooled by drop height (and group), each height once where they differ."""
    sections, remarks = _sections(files, what)
    kinds = {need(section, _CHOICES, INPUTS) for section in sections}
    if len(kinds) > 1:
        raise InputError("rows of a drop, of a pendulum or of means together; measure them apart")
    (kind,) = kinds
    by_height = [by_label(section, _height(section)) for section in sections]
    if kind < 2:
        said = "particles on a wall, e = sqrt(H1/H0)" if kind else (
            "a pendulum of two like blocks, e = (sqrt(H2) - sqrt(H1))/sqrt(H0)"
        )  # fmt: skip
        found = measure(
            by_height, _of_heights, what, key="restitution", name="restitution",
            remarks=[said, *remarks],
        )  # fmt: skip
    else:
        if what.shared or what.single:
            raise InputError(
                "--instrument, --reading and the +- of a constant do not go with means, whose sd "
                "is theirs: leave them out"
            )
        found = _of_means(by_height, remarks)
    particles = {one.group: section.group for one, section in zip(by_height, sections, strict=True)}
    found = nested(found, particles, read=bool(what.single))
    return [replace(found, details=found.details | _details(found, by_height))]


def by_label(section: Section, height: str) -> Section:
    """A trial in the group of its drop height, and of its own group where it has one."""
    own = "" if section.group == "all" else f"{section.group}, "
    return section._replace(group=f"{own}{height}")


def _height(section: Section) -> str:
    return f"{1e3 * float(section.columns['h0'][0]):.4g} mm"


def nested(found: Quantity, particle_of: Mapping[str, str], *, read: bool = False) -> Quantity:
    """Restitution over particles of several heights each, with the scatter of each level.

    particle_of   the particle of each group of the trials
    read          the trials have the sigma of their readings: no mean is better known than by it

    Unchanged where there are fewer than two particles, or no particle has two heights.
    """
    groups = found.pooled.groups
    particles = list(dict.fromkeys(particle_of.values()))
    if len(particles) < 2 or len(groups) == len(particles):
        return found
    levels = mixed(groups, particle_of)
    names = {"trial": levels.trial, "height": levels.height, "particle": levels.particle}
    shown = ", ".join(f"{name} {one:.2g}" for name, one in names.items() if one is not None)
    said = [
        *_grid(groups, particle_of, particles),
        f"scatter by origin (mixed model): {shown}; sigma of the mean with {levels.freedom:.1f} "
        "degrees of freedom",
    ]
    details = {"levels": names | {"degrees_of_freedom": levels.freedom}}
    whole = levels.mean
    if read:
        cells = [
            no_better_than(
                [v for _, own, v in found.trials if own == name], replace(one, sigma=None)
            )
            for name, one in groups.items()
        ]
        whole = no_better_than(cells, whole)
    sigma = math.hypot(whole.sigma or 0.0, *found.shared.values())
    whole = replace(whole, sigma=sigma or None)
    return replace(
        found, pooled=replace(found.pooled, all=whole), details=details,
        remarks=(*found.remarks, *said),
    )  # fmt: skip


def _grid(
    groups: Mapping[str, Estimate], particle_of: Mapping[str, str], particles: Sequence[str]
) -> Iterator[str]:
    """Lines of a table as the paper's Table 2: a line a particle, mean and scatter by height."""
    for particle in particles:
        cells = [
            f"{name.removeprefix(f'{particle}, ')}: {one.value:.2f}"
            + ("" if one.scatter is None else f", SD {100 * one.scatter / one.value:.0f} %")
            for name, one in groups.items()
            if particle_of[name] == particle
        ]
        yield f"{particle}  " + "   ".join(cells)


def _sections(files: Sequence[str | Path], what: Request) -> tuple[list[Section], list[str]]:
    """A section for each row, or for each cell where the drop heights stand in a line."""
    sections: list[Section] = []
    remarks: list[str] = []
    plain = []
    for file in files:
        lines, said = rows_of(Path(file))
        if (first := _line_of_heights(lines)) is None:
            plain.append(file)
            continue
        remarks += said
        several = f" of {Path(file).name}" if len(files) > 1 else ""
        _refuse_columns(what, str(file))
        if not is_spreadsheet(Path(file)):
            by_line = {f"line {line}": fields for line, fields in lines[first:]}
            refuse_two_marks(by_line, str(file))
        cells, left_out = _cells(lines[first:], what, str(file))
        remarks += left_out
        sections += [one._replace(name=f"{one.name}{several}") for one in cells]
    for file in plain:
        more, said_of_rows = _rows(file, what)
        several = f" of {Path(file).name}" if len(files) > 1 else ""
        sections += [one._replace(name=f"{one.name}{several}") for one in more]
        remarks += said_of_rows
    if not sections:
        raise InputError(f"{', '.join(map(str, files))}: no height of a rebound below those of H0")
    return chosen(sections, what.only), remarks


def _refuse_columns(what: Request, where: str) -> None:
    """InputError for options that name columns, which a table with a line of heights has not."""
    given = {"--group": what.group, "--column": what.columns}
    for option, value in given.items():
        if value:
            raise InputError(
                f"{where}: has a line of drop heights and its particles in the first column: "
                f"{option} does not go with it; leave it out"
            )


def _rows(file: str | Path, what: Request) -> tuple[list[Section], list[str]]:
    """A section for each row, of the particle that its column names unless a group is given."""
    table = read_table(file).renamed(what.columns)
    if what.group is None and table.has("particle"):
        what = replace(what, group="particle")
    found, remarks = rows([file], INPUTS, replace(what, only=None), _CHOICES)
    head = "" if "sd" in what.constants else head_of(_OF_SD, table) or ""
    if head == "sd":  # or sd_percent
        head = next(name for name in table.texts if re.fullmatch("sd(_.*)?", name.lower()))
    unit = table.units.get(head, "")
    if unit.lower() in _PER_CENT or head.lower().endswith(_PER_CENT):
        # A unit, or a name such as sd_percent, has made a part of it already.
        part = 1.0 if unit or head.lower().endswith("_percent") else 0.01
        found = [_with_sd_of(one, part) for one in found]
    return found, remarks


def _with_sd_of(section: Section, part: float) -> Section:
    """A trial whose standard deviation was one of its mean, in parts of it."""
    known = section.columns
    if not known.keys() >= {"sd", "mean"}:
        return section
    sd = part * known["sd"] * known["mean"]
    return section._replace(columns=known | {"sd": sd})


def _line_of_heights(lines: Sequence[Row]) -> int | None:
    """Number of the line that begins with H0 and goes on with numbers; None without one."""
    for k, (_, fields) in enumerate(lines):
        name = name_and_unit(fields[0])[0] if fields else ""
        held = [field for field in fields[1:] if not is_missing(field)]
        if _NAMES.fullmatch(name) and held and all(number(field) is not None for field in held):
            return k
    return None


def _cells(lines: Sequence[Row], what: Request, where: str) -> tuple[list[Section], list[str]]:
    """Trials below a line of drop heights, or means with the standard deviations below them.

    What is made of the trials above it, and notes, are left out, which the remarks say. Raises
    InputError for a cell that holds no number.
    """
    line, head = lines[0]
    name, unit = name_and_unit(head[0])
    if not unit:
        raise InputError(f"{where}: line {line}: {name} has no unit; write '{name} [mm]'")
    scale = to_si(f"1 {unit}", "m", where)
    heights = {k: h for k, field in enumerate(head) if k and (h := number(field)) is not None}
    found, kept, remarks = _Below(scale, heights), list[Row](), list[str]()
    for line, fields in lines[1:]:
        label = fields[0]
        held = [fields[k] for k in heights if k < len(fields)]
        made = kept and (is_made_of_others(label) or _SD.search(label) or _MEAN.search(label))
        slip = slip_in(held)
        note = slip is None and not any(map(_is_value, held))
        if made or note or _OF_OTHERS.search(label):
            found.means = {}
            if any(fields):
                said = " ".join(filter(None, fields))[:60]
                remarks.append(
                    f"{where}: line {line} left out, a note or made from other lines: {said!r}"
                )
        elif slip is not None:
            raise InputError(
                f"{where}: line {line}: {slip!r} is no number; write the height, or leave the "
                "cell empty"
            )
        elif _MEAN.search(label) or _SD.search(label):
            found.add_mean(line, fields)
        else:
            kept.append((line, fields))
    particle_of, said_of_labels = _particles([fields[0] for _, fields in kept])
    for line, fields in kept:
        found.add_trial(line, fields, particle_of.get(fields[0], "all"))
    constants = {key: np.array([one]) for key, one in what.constants.items()}
    sections = [one._replace(columns=one.columns | constants) for one in found.sections]
    return sections, [*remarks, *said_of_labels]


def _is_value(field: str) -> bool:
    return not is_missing(field) and number(field) is not None


class _Below:
    """Sections of the lines below one of drop heights; scale: of a height [m]."""

    def __init__(self, scale: float, heights: Mapping[int, float]) -> None:
        self.scale, self.heights = scale, heights
        self.sections: list[Section] = []
        self.means: dict[int, float] = {}
        self.group = ""

    def _values(self, fields: Sequence[str]) -> dict[int, float]:
        """The numbers of a line by column."""
        return {
            k: value
            for k, field in enumerate(fields)
            if k in self.heights and (value := number(field)) is not None and not math.isnan(value)
        }

    def _add(self, line: int, group: str, k: int, known: Mapping[str, float]) -> None:
        columns = {"h0": self.scale * self.heights[k], **known}
        arrays = {key: np.array([one]) for key, one in columns.items()}
        self.sections.append(Section(group, f"line {line}", arrays))

    def add_mean(self, line: int, fields: Sequence[str]) -> None:
        """A line of means, or of the standard deviations of those above."""
        label, values = fields[0], self._values(fields)
        if _MEAN.search(label):
            self.group = _MEAN.sub("", name_and_unit(label)[0]).strip(" :") or "all"
            self.means = values
            return
        for k, sd in values.items():
            if k in self.means:  # else of an average, which is made of the others
                mean = self.means[k]
                sd *= mean / 100 if "%" in label else 1.0
                self._add(line, self.group, k, {"mean": mean, "sd": sd})

    def add_trial(self, line: int, fields: Sequence[str], group: str) -> None:
        """A line of rebound heights."""
        for k, value in self._values(fields).items():
            self._add(line, group, k, {"h1": self.scale * value})


def _particles(labels: Sequence[str]) -> tuple[dict[str, str], list[str]]:
    """The particle of each label in words, and a remark on what labels were taken for.

    Labels that stand once each and differ in a number alone are of trials, but "particle 1" is not.
    """
    words = [label for label in labels if label and number(label) is None]
    names = list(dict.fromkeys(words))
    if len(names) < 2:
        return {name: name for name in names}, []
    stems = {_NUMBER.sub("", name).strip().lower() for name in names}
    if len(stems) == 1 and len(names) == len(words) and "particle" not in stems:
        return {}, [
            f"{names[0]!r} to {names[-1]!r} are taken for trials of one particle; of particles "
            "write 'particle 1' and so on"
        ]
    return {name: name for name in names}, [f"each label is a particle: {', '.join(names)}"]


def _of_heights(columns: Columns) -> Estimate:
    h0, h1 = float(columns["h0"][0]), float(columns["h1"][0])
    heights = {"H0": h0, "H1": h1}
    if "h2" in columns:
        heights["H2"] = float(columns["h2"][0])
    for name, height in heights.items():
        if not (height > 0 or (name == "H1" and "H2" in heights and height == 0)):
            raise InputError(f"{name} = {1e3 * height:g} mm: heights are above 0")
        if height > h0:
            raise InputError(
                f"{name} = {1e3 * height:g} mm is above H0 = {1e3 * h0:g} mm: are the columns "
                "swapped, or is a unit wrong? name them by --column 'h0=HEAD [UNIT]'"
            )
    if "H2" not in heights:
        return Estimate(math.sqrt(h1 / h0), None, 1)
    if heights["H2"] < h1:
        raise InputError(
            f"H2 = {1e3 * heights['H2']:g} mm is below H1 = {1e3 * h1:g} mm: the block that was "
            "hit rises higher; swap the columns"
        )
    return Estimate((math.sqrt(heights["H2"]) - math.sqrt(h1)) / math.sqrt(h0), None, 1)


def _of_means(sections: Sequence[Section], remarks: Sequence[str]) -> Quantity:
    """Means pooled as if their trials were known: the analysis of variance needs no more."""
    groups: dict[str, Estimate] = {}
    for section in sections:
        known = {name: float(values[0]) for name, values in section.columns.items()}
        where, mean, n = section.name, known["mean"], known["trials"]
        sd = known["sd"]
        if not 0 < mean <= 1:
            raise InputError(f"{where}: mean = {mean:g}: a restitution is above 0 and at most 1")
        if not (sd >= 0 and n >= 1 and n.is_integer()):
            raise InputError(f"{where}: sd = {sd:g} of {n:g} trials: no standard deviation")
        if section.group in groups:
            raise InputError(f"{where}: {section.group} stands twice; name the --group")
        groups[section.group] = Estimate(mean, None, int(n), sd if n > 1 else None)
    said = [f"{len(groups)} means of {sum(one.trials for one in groups.values())} trials", *remarks]
    trials = tuple((s.name, s.group, groups[s.group]) for s in sections)
    whole = pooled_summaries(groups)
    return Quantity("restitution", "restitution", "1", "1", whole, trials, remarks=tuple(said))


def _details(found: Quantity, sections: Sequence[Section]) -> dict[str, object]:
    """Keys of the JSON besides those of every method of the bench."""
    heights = {section.group: float(section.columns["h0"][0]) for section in sections}
    whole = found.to_dict()[found.key] | {"constant_within_noise": found.pooled.alike}
    return {
        found.key: whole,
        "per_height": [
            {"height_m": heights[name], "group": name, "value": one.value, "sigma": one.sigma,
             "n": one.trials, "scatter": one.scatter}
            for name, one in found.pooled.groups.items()
        ],
    }  # fmt: skip
