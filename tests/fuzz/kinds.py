"""The kinds of input: how each is drawn from the schemas and the tables of mutations.

A kind writes its files into the working folder and gives the command that reads them.
"""

import importlib
import shutil
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import click
from mutations import (
    NAMES,
    NUMBERS,
    WRONG,
    damage_bytes,
    damaged_table,
    respelled,
    toml,
    value,
)
from odd import odd_film, odd_table
from resealed import resealed
from stock import SHAPES, TABLES, runs_of

from damper3d.case import settings as damper_settings
from damper3d.studies.design.spec import Spec
from granulab.campaign.sweeps.study_keys import StudyKeys
from granulab.contact.files.datafile import data_file, data_names
from granulab.contact.files.reference import Key, keys_of, plain_keys
from granulab.contact.files.schema import Entry, File, LinearTable, MaterialTable, PairTable
from silo2d.case import settings as silo_settings

PROGRAMS = {
    "silo2d": "silo2d.commands.main",
    "damper3d": "damper3d.commands.main",
    "calibrate": "calibration.commands.main",
}
_HOST = {"mass": "0.5 kg", "frequency": 40, "damping_ratio": 0.01}
EXCITED: list[dict[str, Any]] = [
    {"kind": "sines", "frequencies": [40, 60], "amplitudes": ["2 g", "1 g"]},
    {"kind": "rotation", "frequencies": [40], "amplitudes": ["5 deg"]},
    {"kind": "sweep", "from_frequency": 20, "to_frequency": 40, "amplitude": "2 g",
     "length": "2 s"},
    {"kind": "random", "psd": [[20, 0.1], [80, 0.1]], "length": "1 s"},
    {"kind": "shock", "amplitude": "20 g", "length": "5 ms"},
]  # fmt: skip
SPEC: dict[str, Any] = {
    "structure": {"mass": "2 kg", "frequency": 60, "damping_ratio": 0.005},
    "level": {"acceleration": "5 g"},
    "space": {"width": "60 mm", "height": "60 mm"},
}
SETTINGS = {"silo2d": silo_settings.Settings, "damper3d": damper_settings.Settings}
CASES: dict[str, list[dict[str, Any]]] = {
    "silo2d": [
        {"silo": {"preset": "A4"}},
        {"silo": {"angle": "60 deg", "outlet": "50 mm"}},
        {"silo": {"outline": [[-75, 0], [75, 0], [150, 130], [150, 500], [-150, 500]]}},
    ],
    "damper3d": [
        {}, {"enclosure": {"shape": "box", "width": "40 mm"}},
        {"particles": {"shape": "prolate:1.5"}}, {"host": {**_HOST, "force": "1 N"}},
        *({"excitation": excited} for excited in EXCITED),
        {"host": _HOST, "excitation": {**EXCITED[3], "on": "base"}},
    ],
}  # fmt: skip


@dataclass(frozen=True)
class Call:
    """A command, after how many seconds it is stopped if it computes, and its only right answer."""

    program: str
    arguments: tuple[str, ...]
    patience: float | None = None
    expected: tuple[str, tuple[str, ...]] | None = None  # the same call of undamaged folders


@dataclass(frozen=True)
class Kind:
    """How many inputs of it a full campaign has, and how one is made."""

    times: int
    make: Callable[[Random, Path], Call]
    of_runs: bool = False  # it needs run folders


@cache
def main_of(program: str) -> Callable[[], None]:
    """The entry of a program."""
    return importlib.import_module(PROGRAMS[program]).main


@cache
def _keys(program: str) -> list[Key]:
    return list(keys_of(SETTINGS[program]))


def _as_json(chance: Random) -> tuple[str, ...]:
    return ("--json",) if chance.random() < 0.5 else ()


def _written(name: str, table: dict[str, Any], chance: Random) -> str:
    """Write a document, now and then damaged as bytes; its name."""
    Path(name).write_text(toml({"schema": 1} | table), encoding="utf-8")
    if chance.random() < 0.05:
        damage_bytes(Path(name), chance)
    return name


def _of_key(key: Key, chance: Random, wild: float = 1.0) -> Any:
    return value(key.written, key.unit, key.choices, chance, wild)


def _as_named(key: str, one: Any) -> Any:
    """A value of a key; a name that reads as no number would be taken for a wrong answer."""
    return "so" if key == "name" and str(one).strip("-") in ("nan", "inf") else one


def case(program: str, chance: Random, _stock: Path) -> Call:
    """A case with one to three keys changed, and what a dry run says of it."""
    table = {k: dict(v) for k, v in chance.choice(CASES[program]).items()}
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        key = chance.choice(_keys(program))
        table.setdefault(key.section, {})
        if isinstance(table[key.section], dict):
            table[key.section][key.name] = _as_named(key.name, _of_key(key, chance))
        if chance.random() < 0.03:
            name = chance.choice([key.section, "name", "schema", "more"])
            table[name] = _as_named(name, chance.choice(WRONG))
    arguments = ("run", _written("c.toml", table, chance), "--dry-run", "--quiet")
    return Call(program, (*arguments, *_as_json(chance)))


def design(chance: Random, _stock: Path) -> Call:
    """A specification of a damper with one to three keys changed, and what a dry run says of it."""
    table = {name: dict(section) for name, section in SPEC.items()}
    for _ in range(chance.choice([1, 1, 2, 3])):
        key = chance.choice(list(keys_of(Spec)))
        table.setdefault(key.section, {})[key.name] = _of_key(key, chance)
    arguments = ("design", _written("d.toml", table, chance), "--dry-run", "--quiet")
    return Call("damper3d", (*arguments, *_as_json(chance)))


def _series(key: Key, chance: Random) -> Any:
    """Values of a key in a study: listed, in a range, drawn, one, or something else."""
    how = chance.choice([0, 0, 0, 1, 2, 3, 4])
    if how == 0:
        return [_of_key(key, chance, wild=0.6) for _ in range(chance.randrange(1, 4))]
    if how == 1:
        names = chance.sample(["start", "stop", "step", "number", "log"], chance.randint(2, 5))
    elif how == 2:
        names = ["distribution", *chance.sample(["mean", "sd", "min", "max", "number"], 3)]
    else:
        return _of_key(key, chance, wild=0.6) if how == 3 else chance.choice(WRONG)
    table = {name: _of_key(key, chance, wild=0.6) for name in names}
    if chance.random() < 0.8:
        right = {"distribution": chance.choice(["normal", "lognormal", "uniform", "no"]),
                 "number": chance.choice([1, 3, 8, 0, -1, 1e9, 10**7]), "log": True}  # fmt: skip
        table |= {name: one for name, one in right.items() if name in table}
    return table


def study(program: str, chance: Random, _stock: Path) -> Call:
    """A study with its own keys and one or two varied ones."""
    table: dict[str, Any] = {"case": "A4" if program == "silo2d" else "thesis"}
    for key in chance.sample(list(plain_keys(StudyKeys)), chance.choice([0, 0, 1, 2])):
        table[key.name] = _of_key(key, chance)
    varied = {}
    for key in chance.sample(_keys(program), chance.randint(1, 2)):
        varied[f"{key.section}.{key.name}"] = _series(key, chance)
    table["vary"] = varied if chance.random() < 0.95 else chance.choice(WRONG)
    arguments = ("sweep", _written("s.toml", table, chance), "--dry-run", "--quiet")
    return Call(program, (*arguments, *_as_json(chance)))


def materials(chance: Random, _stock: Path) -> Call:
    """A shipped materials file with one to three entries changed; read by any of its readers."""
    name = chance.choice(data_names("materials"))
    table = tomllib.loads(Path(str(data_file("materials", name))).read_text(encoding="utf-8"))
    for _ in range(chance.randint(1, 3)):
        section = chance.choice(list(File.model_fields))
        own = table.get(section)
        if not isinstance(own, dict) or not own:
            continue
        one = chance.choice(list(own))
        fields: dict[str, Any] = dict(
            (MaterialTable if section == "material" else PairTable).model_fields
        )
        where = own[one] if isinstance(own[one], dict) else {}
        if section == "pair" and chance.random() < 0.4 and isinstance(where.get("linear"), dict):
            where, fields = where["linear"], dict(LinearTable.model_fields)
        _change_entry(where, chance.choice(list(fields)), chance)
        if chance.random() < 0.1:
            own[chance.choice([*NAMES, "a-b", "a-b-c", "", "wood-"])] = own.pop(one)
    file = _written("m.toml", table, chance)
    first = next(iter(table.get("material") or {"a": 0}))
    return chance.choice([
        Call("calibrate", ("report", file, *_as_json(chance))),
        Call("silo2d", ("show", file)),
        Call("damper3d", ("show", file)),
        Call("silo2d", ("run", "A4", "--materials", file, "--dry-run", "--quiet")),
        Call("damper3d", ("run", "--material", file, "--dry-run", "--quiet", *_as_json(chance))),
        Call("calibrate", ("incline", _table_file("incline"), "--into", file, "--pair",
                           f"{first}-{chance.choice(['wall', first, 'x'])}", "--quiet")),
    ])  # fmt: skip


def _change_entry(where: dict[str, Any], name: str, chance: Random) -> None:
    entry = where.get(name, "1")
    if chance.random() < 0.15:
        where.pop(name, None)
    elif isinstance(entry, dict) and chance.random() < 0.7:
        field = chance.choice(list(Entry.model_fields))
        old = str(entry.get(field, entry.get("value", "1")))
        entry[field] = respelled(old, chance) if chance.random() < 0.7 else chance.choice(WRONG)
    else:
        old = str(entry["value"] if isinstance(entry, dict) and "value" in entry else entry)
        where[name] = respelled(old, chance) if chance.random() < 0.7 else chance.choice(WRONG)


def _table_file(command: str) -> str:
    Path(f"{command}.csv").write_text(TABLES[command][0], encoding="utf-8")
    return f"{command}.csv"


def shapes(chance: Random, _stock: Path) -> Call:
    """A shapes file of the silo with something changed."""
    table: dict[str, Any] = {k: v for k, v in SHAPES.items() if k != "schema"}
    table["shape"] = [dict(one) for one in SHAPES["shape"]]
    for _ in range(chance.randint(1, 2)):
        here = (
            chance.choice([table, *table["shape"]]) if isinstance(table["shape"], list) else table
        )
        name = chance.choice([*here, "more"]) if here else "more"
        old = here.get(name, 1)
        written = old if isinstance(old, str) else toml({"x": old}).partition("= ")[2].strip()
        here[name] = _as_named(name, value(written, "mm", (), chance))
    file = _written("sh.toml", table, chance)
    run = ("run", "A4", "--shapes", file, "--dry-run", "--quiet", *_as_json(chance))
    return Call("silo2d", chance.choice([("show", file), run]))


def meshes(chance: Random, stock: Path) -> Call:
    """A mesh with a number, a line or bytes changed, as a particle of twelve spheres."""
    source = chance.choice([stock / "mesh.stl", stock / "mesh.obj"])
    file = Path(source.name)
    lines = source.read_text(encoding="utf-8").split("\n")
    for _ in range(chance.randint(1, 3)):
        k = chance.randrange(len(lines))
        words = lines[k].split(" ")
        how = chance.randrange(4)
        if how == 0:
            words[chance.randrange(len(words))] = chance.choice([*map(repr, NUMBERS), "", "x"])
            lines[k] = " ".join(words)
        elif how == 1 and len(lines) > 3:
            lines.pop(k)
        elif how == 2:
            lines.insert(k, chance.choice(lines))
        else:
            lines[k] = " ".join(words[:-1])
    file.write_text("\n".join(lines), encoding="utf-8")
    if chance.random() < 0.2:
        damage_bytes(file, chance)
    unit = ("--mesh-unit", chance.choice(["mm", "m", "um", "nan", "", "kg"]))
    more = (*(unit if chance.random() < 0.3 else ()), *_as_json(chance))
    shape = ("shape", "--mesh", str(file), "--sub-spheres", "12", "--no-figures")
    return Call("damper3d", (*shape, *more))


# What comes with the commands that options are tried on: good arguments of each. Those of
# COMPUTE may begin to compute and are stopped; the others say what they would do, or are quick.
GOOD: dict[str, dict[str, tuple[str, ...]]] = {
    "silo2d": {
        "run": ("A4", "--dry-run"), "sweep": ("study.toml", "--dry-run"), "show": ("A4",),
        "list": (), "init": ("new.toml",), "packing": ("A4",), "compare": ("RUN", "RUN"),
        "observe": ("RUN", "curve"), "export": ("RUN", "--to", "csv"), "reproduce": (),
    },
    "damper3d": {
        "run": ("--dry-run",), "sweep": ("study.toml", "--dry-run"), "map": ("--dry-run",),
        "compress": ("--dry-run",), "shear": ("--dry-run",), "show": ("thesis",), "list": (),
        "init": ("new.toml",), "impact": (), "shape": ("--sphere", "5mm", "--no-figures"),
        "predict": ("--no-figures",), "pack": (), "contact": (), "compare": ("RUN", "RUN"),
        "observe": ("RUN", "efficiency"), "export": ("RUN", "--to", "csv"), "reproduce": (),
    },
    "calibrate": {
        **{command: ("TABLE", *options) for command, (_, options) in TABLES.items()},
        "damping": (), "published": (), "report": ("wood",), "piv": ("a.png", "b.png"),
        "flow": ("film.avi", "--no-velocity"),
        "stiffness-fe": ("--mesh", "32", "--random-profiles", "1"),
    },
}  # fmt: skip
COMPUTE = {"packing", "pack", "stiffness-fe", "impact", "predict", "flow"}
NEVER = {
    "--help",
    "--version",
    "--workers",
    "--engine",
    "--scheduler",
    "--resume",
    "--simulate",
    "--pack",
}


@cache
def _options(program: str, command: str) -> list[click.Option]:
    group = importlib.import_module(PROGRAMS[program]).app
    context = click.Context(group)
    found = group.get_command(context, command)
    return [p for p in found.params if isinstance(p, click.Option) and not NEVER & set(p.opts)]


def _option(option: click.Option, chance: Random) -> list[str]:
    """An option as it is written, with a value about its example or a wrong one."""
    flag = option.opts[-1]
    if option.is_flag:
        return [flag]
    if "--out" in option.opts or "--write" in option.opts or flag in ("--into", "--output"):
        return [flag, chance.choice(["out", "a/b", "film.avi/x", "", "/proc/none", "x" * 300, "."])]
    if isinstance(option.type, click.Choice):
        return [flag, str(chance.choice([*option.type.choices, "no", ""]))]
    example = (option.metavar or "3").strip('"').partition("|")[0]
    if chance.random() < 0.6:
        words = [
            part if chance.random() < 0.5 else respelled(part, chance)
            for part in example.split(",")
        ]
        text = ",".join(words)
    else:
        text = str(chance.choice([*WRONG, *NUMBERS, *NAMES]))
    return [flag, *([text] * option.nargs)]


def options(chance: Random, stock: Path) -> Call:
    """Any command with one to four of its options."""
    program = chance.choice(list(GOOD))
    command = chance.choice(list(GOOD[program]))
    for name in ("film.avi", "a.png", "b.png"):
        shutil.copy(stock / name, name)
    run = next(iter(runs_of(stock / "runs", program).values())) if program != "calibrate" else stock
    arguments = []
    for word in GOOD[program][command]:
        if word == "TABLE":
            arguments.append(_table_file(command))
        elif word == "study.toml":
            case = "A4" if program == "silo2d" else "thesis"
            Path(word).write_text(toml({"schema": 1, "case": case, "vary": {"run.seed": [1]}}))
            arguments.append(word)
        elif word == "RUN":
            if not Path("RUN").exists():
                shutil.copytree(run, "RUN")
            arguments.append(word)
        else:
            arguments.append(word)
    known = _options(program, command)
    for option in chance.sample(known, min(chance.randint(1, 4), len(known))):
        arguments += _option(option, chance)
    quiet = ("--quiet",) if any("--quiet" in one.opts for one in known) else ()
    patience = 0.3 if command in COMPUTE or "--engines" in arguments else None
    return Call(
        program, (command, *(word.replace("\x00", "") for word in arguments), *quiet), patience
    )


def table(chance: Random, _stock: Path) -> Call:
    """A table or signal with its cells, heads, units, marks or bytes changed."""
    command = chance.choice(list(TABLES))
    text, needed = TABLES[command]
    Path("t.csv").write_bytes(damaged_table(text, chance))
    if chance.random() < 0.05:
        damage_bytes(Path("t.csv"), chance)
    more = needed if chance.random() < 0.8 else []
    return Call("calibrate", (command, "t.csv", *more, "--quiet", *_as_json(chance)))


def sound(chance: Random, stock: Path) -> Call:
    """A WAV damaged as bytes, its header above all."""
    data = (stock / "sound.wav").read_bytes()
    file = Path("sound.wav")
    if chance.random() < 0.6:  # its header
        head = bytearray(data[:44])
        for _ in range(chance.randint(1, 3)):
            head[chance.randrange(44)] = chance.randrange(256)
        file.write_bytes(bytes(head) + data[44:])
    else:
        file.write_bytes(data)
        damage_bytes(file, chance)
    return Call("calibrate", ("impacts", "sound.wav", "--quiet", *_as_json(chance)))


OF_FILMS = [
    ("drop",), ("drop", "--one-bounce"), ("pendulum",), ("flow", "--no-velocity"),
    ("flow", "--collapse"), ("flow", "--collapse", "--scale", "1 mm/px"),
]  # fmt: skip


def odd_films(chance: Random, _stock: Path) -> Call:
    """A film that can be read and shows no experiment, read as any."""
    command, name = chance.choice(OF_FILMS), odd_film(chance)
    more = ("--fps", "100") if chance.random() < 0.4 else ()
    if Path(name).is_dir() and chance.random() < 0.3:
        return Call("calibrate", ("piv", f"{name}/im0.png", f"{name}/im1.png", "--quiet"))
    return Call("calibrate", (*command, name, *more, "--quiet", *_as_json(chance)))


def odd_tracks(chance: Random, _stock: Path) -> Call:
    """A track of numbers that nothing falls or swings by."""
    heads = [chance.choice(["time [s]", "frame", "time [ms]"]), "x", "y"]
    name = odd_table(heads, chance, [1, 2, 3, 7, 8, 9, 12, 30, 100, 300])
    asked = chance.choice([("drop",), ("drop", "--one-bounce"), ("pendulum",)])
    more = chance.choice([(), ("--fps", "240"), ("--scale", "1 mm/px")[: 2 * (asked[0] == "drop")]])
    return Call("calibrate", (*asked, name, *more, "--quiet", *_as_json(chance)))


SIGNALS = {
    "impacts": ["time [s]", "force [N]"],
    "shaker": ["time [s]", "force [N]", "acceleration [m/s2]"],
    "slide": ["time [s]", "velocity [m/s]"],
    "compression": ["displacement [mm]", "load [N]"],
    "roughness": ["x [mm]", "z [um]"],
    "heights": ["drop [cm]", "rebound [cm]"],
    "density": ["mass [g]", "volume [mm3]"],
    "incline": ["angle_deg"],
    "interface": ["dx_t [mm]", "dx_n [mm]", "sigma_t [MPa]", "sigma_n [MPa]"],
}


def odd_signals(chance: Random, _stock: Path) -> Call:
    """A signal, or a table of a bench test, of numbers that no instrument gives."""
    command = chance.choice(["impacts", "shaker", *SIGNALS])
    name = odd_table(SIGNALS[command], chance, [1, 2, 3, 5, 10, 40, 400, 3000])
    needed = TABLES[command][1] if command in TABLES else []
    return Call("calibrate", (command, name, *needed, "--quiet", *_as_json(chance)))


def film(chance: Random, stock: Path) -> Call:
    """A film damaged as bytes, read as any experiment."""
    file = Path(chance.choice(["film.avi", "film.mp4"]))
    shutil.copy(stock / file, file)
    damage_bytes(file, chance)
    command = chance.choice(OF_FILMS)
    return Call("calibrate", (*command, str(file), "--quiet", *_as_json(chance)))


def picture(chance: Random, stock: Path) -> Call:
    """Two pictures of which one is damaged."""
    for name in ("a.png", "b.png"):
        shutil.copy(stock / name, name)
    damage_bytes(Path(chance.choice(["a.png", "b.png"])), chance)
    return Call("calibrate", ("piv", "a.png", "b.png", "--quiet", *_as_json(chance)))


MEASURES = {"silo2d": ["curve", "network"], "damper3d": ["efficiency", "phases"]}


def reads(program: str, run: str) -> list[tuple[str, ...]]:
    """What is asked of a run folder."""
    asked: list[tuple[str, ...]] = [("show", f"runs/{run}"), ("list", "--verify", "-o", "runs")]
    if run.startswith("begun"):
        return [("run", "--resume", f"runs/{run}", "--no-figures", "--quiet", "--json")]
    observed = [
        ("observe", f"runs/{run}", what, "--no-figures", "--json") for what in MEASURES[program]
    ]
    return [*asked, *observed]


def folder(program: str, begun: bool, chance: Random, stock: Path) -> Call:
    """A run folder with a file damaged, removed, or exchanged for another of its kind."""
    source = stock / "runs" / program.removesuffix("2d").removesuffix("3d")
    shutil.copytree(source, "runs")
    names = [n for n in runs_of(stock / "runs", program) if (n == "begun") == begun]
    run = Path("runs") / runs_of(stock / "runs", program)[chance.choice(names)].name
    files = [path for path in sorted(run.rglob("*")) if path.is_file() and path.name != ".lock"]
    for file in chance.sample(files, chance.choice([1, 1, 1, 2])):
        how = chance.randrange(8)
        if how == 0:
            file.unlink()
        elif how == 1:
            others = [path for path in files if path.suffix == file.suffix and path.exists()]
            shutil.copy(chance.choice([file, *others]) if others else file, "other")
            if file.exists():
                shutil.move("other", file)
        elif file.exists() and file.stat().st_size:
            damage_bytes(file, chance)
    asked = chance.choice(reads(program, run.name))
    return Call(
        program, asked, expected=(program, asked) if asked[0] in ("observe", "run") else None
    )


def checkpoint(chance: Random, stock: Path) -> Call:
    """A part, checkpoint or trajectory whose seal is right and whose content is not."""
    import h5py
    import numpy as np

    program = chance.choice(["silo2d", "damper3d"])
    shutil.copytree(stock / "runs" / program[:-2], "runs")
    run = Path("runs") / chance.choice(list(runs_of(stock / "runs", program).values())).name
    file = chance.choice(sorted(run.rglob("*.h5")))
    kind = "checkpoint" if "checkpoint" in str(file.relative_to(run)) else "trajectory"
    with resealed(file, kind) as content:
        names: list[str] = []
        content.visititems(
            lambda name, one: names.append(name) if isinstance(one, h5py.Dataset) else None
        )
        name = chance.choice(names)
        array, how = content[name][()], chance.randrange(5)
        del content[name]
        if how == 0:
            content[name] = h5py.ExternalLink("/etc/passwd", "/")
        elif how == 1:
            content[name] = np.zeros((3, 3))
        elif how == 2 and np.asarray(array).ndim:
            content[name] = array[: len(array) // 2]
        elif how == 3 and np.asarray(array).dtype.kind == "f":
            content[name] = np.full_like(array, chance.choice([np.nan, -1.0, 0.0]))
        elif how == 4:
            content[name] = "text"
    return Call(program, chance.choice(reads(program, run.name)))


def _of(make: Callable[..., Call], *given: Any) -> Callable[[Random, Path], Call]:
    return lambda chance, stock: make(*given, chance, stock)


KINDS = {
    "silo case": Kind(3000, _of(case, "silo2d")),
    "damper case": Kind(3000, _of(case, "damper3d")),
    "design": Kind(600, design),
    "silo study": Kind(1200, _of(study, "silo2d")),
    "damper study": Kind(1200, _of(study, "damper3d")),
    "materials": Kind(2500, materials),
    "shapes": Kind(1200, shapes),
    "mesh": Kind(800, meshes),
    "options": Kind(3000, options, of_runs=True),
    "table": Kind(3000, table),
    "sound": Kind(500, sound),
    "film": Kind(300, film),
    "picture": Kind(200, picture),
    "odd film": Kind(500, odd_films),
    "odd track": Kind(500, odd_tracks),
    "odd signal": Kind(500, odd_signals),
    "silo folder": Kind(500, _of(folder, "silo2d", False), of_runs=True),
    "silo unfinished": Kind(300, _of(folder, "silo2d", True), of_runs=True),
    "damper folder": Kind(500, _of(folder, "damper3d", False), of_runs=True),
    "damper unfinished": Kind(300, _of(folder, "damper3d", True), of_runs=True),
    "checkpoint": Kind(500, checkpoint, of_runs=True),
}
