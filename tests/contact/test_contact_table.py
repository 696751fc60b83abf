"""The contact-parameter file: published values, round trip, and one line for whatever is wrong."""

import csv
import dataclasses
import datetime
import math
import re
from pathlib import Path

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from granulab.contact.files.datafile import data_file, data_names
from granulab.contact.files.table import ContactTable, load_pairs, load_table, write_table
from granulab.contact.files.units import to_si
from granulab.contact.material import PROPERTIES, LinearParameters, Material, Measured, Pair
from granulab.errors import InputError


def published(name: str) -> list[dict[str, str]]:
    """Rows of a published table."""
    path = data_file("published", name)
    lines = path.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


# The shipped tables


@pytest.mark.parametrize("name", data_names("materials"))
def test_every_shipped_value_has_a_source(name):
    table = load_table(name)
    records = [*table.materials.values(), *table.pairs.values()]
    records += [pair.linear for pair in table.pairs.values() if pair.linear]
    for record in records:
        for field in dataclasses.fields(record):
            measured = getattr(record, field.name)
            assert not isinstance(measured, Measured) or measured.source, (record, field.name)


def test_the_materials_of_the_benchmarks_are_shipped():
    """Those of the impact tests of Chung and Ooi (2011) and of the damper thesis."""
    spheres = ["acrylic", "steel", "aluminium", "magnesium", "glass", "limestone", "alumina"]
    for name in ["wood", *spheres, "cast_iron"]:
        assert load_table(name).material(name).density.value > 0


def wood_value(symbol: str) -> list[Measured]:
    """Where wood.toml keeps a row of the published table."""
    table = load_table("wood")
    wood = table.material("wood")
    particle, wall = table.pair("wood", "wood"), table.pair("wood", "methacrylate")
    return {
        "kn": [particle.linear.kn, wall.linear.kn],
        "kt": [particle.linear.kt, wall.linear.kt],
        "mu_wall": [wall.friction],
        "mu_particle": [particle.friction],
        "gamma_n_pw": [wall.linear.gamma_n],
        "gamma_n_pp": [particle.linear.gamma_n],
        "gamma_t": [particle.linear.gamma_t, wall.linear.gamma_t],
        "eps_w": [wall.restitution],
        "eps_p": [particle.restitution],
        "rho": [wood.density],
        "length": [wood.length],
        "E_transverse": [wood.youngs_modulus],
    }[symbol]


@pytest.mark.parametrize(
    "row",
    [
        row
        for row in published("wood_contact_parameters")
        # Products of others, and the direction in which the prisms do not touch.
        if row["symbol"] not in ("rho_area", "E_longitudinal")
    ],
    ids=lambda row: row["symbol"],
)
def test_wood_is_the_published_table(row):
    """Alonso-Marroquin et al. 2013, Table 4: the same decimals, so equal to rounding."""
    unit = {"N/mm": "N/m", "1/s": "1/s", "1": "1", "g/mm3": "kg/m3", "mm": "m", "MPa": "Pa"}
    in_si = unit[row["unit"]]
    value = to_si(f"{row['value']} {row['unit']}".removesuffix(" 1"), in_si, row["symbol"])
    for measured in wood_value(row["symbol"]):
        assert measured.value == value
        if row["std"].endswith("%"):
            share = to_si(row["std"], "1", "std")
            assert measured.sigma == pytest.approx(share * value, rel=1e-15)
        elif row["std"]:
            sigma = to_si(f"{row['std']} {row['unit']}", in_si, "std")
            assert measured.sigma == pytest.approx(sigma, rel=1e-15)


def spread_of_all(means, deviations) -> float:
    """Standard deviation of samples of equal size taken together, over their mean."""
    means, deviations = np.asarray(means), np.asarray(deviations)
    return math.sqrt(np.mean(deviations**2) + np.var(means)) / np.mean(means)


@pytest.mark.parametrize(
    ("table", "symbol"), [("pendulum_restitution", "eps_p"), ("drop_test_restitution", "eps_w")]
)
def test_sigma_of_restitution_is_the_spread_of_all_trials(table, symbol):
    """Law of total variance over the samples of Tables 2 and 3; the file gives a whole percent."""
    rows = published(table)
    means = [float(row["mean"]) for row in rows]
    deviations = [float(row["mean"]) * float(row["sd_percent"]) / 100 for row in rows]
    (measured,) = wood_value(symbol)
    assert measured.sigma / measured.value == pytest.approx(
        spread_of_all(means, deviations), abs=0.005
    )
    assert measured.value == pytest.approx(np.mean(means), abs=0.005)


@pytest.mark.parametrize("symbol", ["mu_particle", "mu_wall"])
def test_sigma_of_friction_is_the_spread_of_all_pairings(symbol):
    """Law of total variance over the three pairings that the published row lists."""
    (row,) = (r for r in published("wood_contact_parameters") if r["symbol"] == symbol)
    samples = re.findall(r"(0\.\d+) \((\d+) %\)", row["source"])
    assert len(samples) == 3
    means = [float(mean) for mean, _ in samples]
    deviations = [float(mean) * float(percent) / 100 for mean, percent in samples]
    (measured,) = wood_value(symbol)
    assert measured.sigma / measured.value == pytest.approx(
        spread_of_all(means, deviations), abs=0.005
    )


def test_the_pairs_alone():
    assert load_pairs("wood") == load_table("wood").pairs
    assert load_pairs("glass") == {}


# Writing and reading back

_numbers = {
    "poisson": st.floats(-0.99, 0.49),
    "restitution": st.floats(1e-6, 1.0),
    "friction": st.floats(0.0, 10.0),
}
_text = st.none() | st.text(max_size=20)


def measured(name: str, depth: int = 1) -> st.SearchStrategy[Measured]:
    older = st.lists(measured(name, depth - 1), max_size=2).map(tuple) if depth else st.just(())
    return st.builds(
        Measured,
        value=_numbers.get(name, st.floats(1e-12, 1e15)),
        sigma=st.none() | st.floats(0.0, 1e15),
        source=_text,
        method=_text,
        trials=st.none() | st.integers(1, 10**6),
        date=st.none() | st.dates(),
        scatter=st.none() | st.floats(0.0, 1e15),
        digest=_text,
        history=older,
    )


def optional(name: str) -> st.SearchStrategy[Measured | None]:
    return st.none() | measured(name)


_linear = st.builds(LinearParameters, *[measured(k) for k in ("kn", "kt", "gamma_n", "gamma_t")])


@st.composite
def tables(draw) -> ContactTable:
    names = draw(st.lists(st.text("aZ09_", min_size=1), min_size=1, max_size=3, unique=True))
    keys = ("length", "youngs_modulus", "poisson", "yield_strength")
    materials = {
        name: Material(name, draw(measured("density")), *[draw(optional(key)) for key in keys])
        for name in names
    }
    every = [(a, b) for k, a in enumerate(names) for b in names[k:]]
    chosen = draw(st.lists(st.sampled_from(every), unique=True, max_size=2))
    pairs = {
        key: Pair(
            *key,
            draw(measured("friction")),
            draw(optional("restitution")),
            draw(st.none() | _linear),
        )
        for key in chosen
    }
    return ContactTable(materials, pairs)


@given(table=tables())
@settings(deadline=None, max_examples=examples(15))
def test_a_written_table_reads_back_equal(table, tmp_path_factory):
    """To the bit: numbers are written with the digits that hold them."""
    path = tmp_path_factory.mktemp("table") / "table.toml"
    write_table(table, path)
    assert load_table(path) == table


def test_a_table_is_written_in_the_units_of_the_field(tmp_path):
    table = ContactTable(
        {
            "wood": Material(
                "wood",
                Measured(450.0, sigma=27.0, trials=5, date=datetime.date(2013, 9, 17)),
                length=Measured(0.12),
                youngs_modulus=Measured(3.3e9),
            )
        },
        {
            ("wood", "wood"): Pair(
                "wood",
                "wood",
                Measured(0.38, source='a "block"\n'),
                linear=LinearParameters(*map(Measured, (1e7, 6.5e5, 6085.0, 3.0))),
            )
        },
    )
    write_table(table, tmp_path / "wood.toml")
    assert (tmp_path / "wood.toml").read_text(encoding="utf-8") == (
        "schema = 1\n\n"
        "[material.wood]\n"
        'density = { value = "0.45 g/cm3", sigma = "0.027 g/cm3", trials = 5, date = 2013-09-17 }\n'
        'length = "120 mm"\n'
        'youngs_modulus = "3.3 GPa"\n\n'
        "[pair.wood-wood]\n"
        'friction = { value = 0.38, source = "a \\"block\\"\\n" }\n\n'
        "[pair.wood-wood.linear]\n"
        'kn = "10000 N/mm"\n'
        'kt = "650 N/mm"\n'
        'gamma_n = "6085 1/s"\n'
        'gamma_t = "3 1/s"\n'
    )


def test_a_failed_write_leaves_the_old_table_and_nothing_else(tmp_path, monkeypatch):
    table = load_table("wood")
    path = tmp_path / "wood.toml"
    path.write_text("the old one")

    def disk_full(unfinished, text, **_):
        with unfinished.open("w") as file:
            file.write(text[:100])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", disk_full)
    with pytest.raises(InputError, match="cannot be written \\(No space left on device\\)"):
        write_table(table, path)
    assert [p.name for p in tmp_path.iterdir()] == ["wood.toml"]
    assert path.read_text() == "the old one"


@pytest.mark.parametrize("where", ["missing/wood.toml", "file/wood.toml"])
def test_a_table_cannot_be_written_where_there_is_no_folder(where, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be written"):
        write_table(load_table("wood"), tmp_path / where)


def test_a_sigma_in_percent_is_of_the_value(tmp_path):
    path = tmp_path / "t.toml"
    path.write_text(
        'schema = 1\n[material.a]\ndensity = { value = "2 g/cm3", sigma = "5 %" }\n'
        'poisson = { value = -0.2, sigma = "5 percent" }\n'
        "[pair.a-a]\nfriction = { value = 0.4, sigma = 0.05 }\n"
    )
    table = load_table(path)
    assert table.material("a").density.sigma == pytest.approx(100.0, rel=1e-15)
    assert table.material("a").poisson.sigma == pytest.approx(0.01, rel=1e-15)
    assert table.pair("a", "a").friction.sigma == 0.05


# What is refused

GOOD = """schema = 1
[material.wood]
density = "0.45 g/cm3"
poisson = 0.2
[material.steel]
density = "7.86 g/cm3"
[pair.wood-wood]
friction = 0.38
restitution = 0.45
[pair.wood-wood.linear]
kn = "1.0e4 N/mm"
kt = "650 N/mm"
gamma_n = "6085 1/s"
gamma_t = "3 1/s"
"""


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("schema = 1", "", "schema is missing; write schema = 1 on the first line"),
        ("schema = 1", "schema = 2", "schema = 2: unknown; this version reads 1"),
        ("schema = 1", "schema = true", "schema = True: unknown; this version reads 1"),
        ("poisson = 0.2", "poisson 0.2", "not valid TOML: Expected '=' after a key*at line 4*"),
        ("poisson = 0.2", "poisson = 0.2\npoisson = 0.2", "not valid TOML: *at line 5*"),
        ("[pair.", "[pairs.", "unknown key 'pairs'; did you mean 'pair'? known: material, pair"),
        (
            "poisson =",
            "poison =",
            "[material.wood]: unknown key 'poison'; did you mean 'poisson'? known: density, *",
        ),
        (
            "kt =",
            "k_t =",
            "[pair.wood-wood.linear]: unknown key 'k_t'; did you mean 'kt'? known: kn, kt, *",
        ),
        (
            "friction = 0.38",
            "friction = { val = 0.38 }",
            "[pair.wood-wood] friction: unknown key 'val'; did you mean 'value'? known: value, *",
        ),
        ("friction = 0.38", "", "[pair.wood-wood] friction is missing"),
        ("friction = 0.38", "friction = {}", "[pair.wood-wood] friction.value is missing"),
        (
            'density = "0.45 g/cm3"',
            "",
            "[material.wood] density is missing; give it in g/cm3",
        ),
        (
            "[material.wood]",
            "[material]\nwood = 3\n[material.brass]",
            "[material.wood]: expected *",
        ),
        (
            '"0.45 g/cm3"',
            "450",
            "[material.wood] density = 450: the unit is missing; *'0.45 g/cm3'",
        ),
        (
            '"0.45 g/cm3"',
            '"0.45 g/cm2"',
            "[material.wood] density = '0.45 g/cm2': the unit is wrong here; *'0.45 g/cm3'",
        ),
        ('"650 N/mm"', '"650"', "[pair.wood-wood.linear] kt = '650': the unit is missing; *"),
        (
            "friction = 0.38",
            'friction = "21 deg"',
            "[pair.wood-wood] friction = '21 deg': the unit is wrong here; *",
        ),
        (
            "friction = 0.38",
            'friction = { value = 0.38, sigma = "1 mm" }',
            "[pair.wood-wood] friction.sigma = '1 mm': the unit is wrong here; *",
        ),
        (
            "friction = 0.38",
            "friction = { value = 0.38, sigma = -0.02 }",
            "[pair.wood-wood] friction.sigma = -0.02: must be at least 0",
        ),
        (
            "friction = 0.38",
            "friction = { value = 0.38, trials = 0 }",
            "[pair.wood-wood] friction.trials = 0: must be at least 1",
        ),
        (
            "friction = 0.38",
            'friction = { value = 0.38, trials = "ten" }',
            "[pair.wood-wood] friction.trials = 'ten': input should be a valid integer",
        ),
        (
            "friction = 0.38",
            'friction = { value = 0.38, date = "yesterday" }',
            "[pair.wood-wood] friction.date = 'yesterday': input should be a valid date",
        ),
        (
            "friction = 0.38",
            "friction = [0.38]",
            "[pair.wood-wood] friction = [0.38]: expected a quantity such as '0.38'",
        ),
        ("= 0.38", "= nan", "[pair.wood-wood] friction = nan: not a finite number; *"),
        ("= 0.38", "= -0.1", "[pair.wood-wood] friction = -0.1: must be at least 0"),
        ("= 0.45", "= 0", "[pair.wood-wood] restitution = 0: must be above 0 and at most 1"),
        ("= 0.45", "= 1.01", "[pair.wood-wood] restitution = 1.01: must be above 0 and at most 1"),
        ("= 0.2", "= 0.5", "[material.wood] poisson = 0.5: must be between -1 and 0.5"),
        ("= 0.2", "= -1", "[material.wood] poisson = -1: must be between -1 and 0.5"),
        ('"0.45 g', '"-0.45 g', "[material.wood] density = -450 kg/m3: must be above 0"),
        ('"1.0e4', '"0', "[pair.wood-wood.linear] kn = 0 N/m: must be above 0"),
        ('"6085', '"-1', "[pair.wood-wood.linear] gamma_n = -1 1/s: must be at least 0"),
        (
            "[pair.wood-wood",
            "[pair.wood-stell",
            "[pair.wood-stell] material 'stell' is not in the table; did you mean 'steel'? *",
        ),
        (
            '"3 1/s"',
            '"3 1/s"\n[pair.wood-steel]\nfriction = 0.3\n[pair.steel-wood]\nfriction = 0.3',
            "[pair.wood-steel] is given again as steel-wood; leave one out",
        ),
        (
            "[pair.wood-wood",
            "[pair.wood",
            "[pair.wood] a pair is named by two materials and a hyphen, such as wood-steel",
        ),
        (
            "[material.steel]",
            "[material.cast-iron]",
            "[material.cast-iron] material name 'cast-iron': takes letters, digits and _ only *",
        ),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(old, new, line, tmp_path):
    """File, section, key and value as they stand in the file, and what would do (* any text)."""
    path = tmp_path / "table.toml"
    path.write_text(GOOD)
    load_table(path)
    assert old in GOOD
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError) as refused:
        load_table(path)
    pattern = re.escape(f"{path}: {line}").replace(r"\*", ".*")
    assert re.fullmatch(pattern, str(refused.value)), str(refused.value)


def test_a_file_without_materials_is_refused(tmp_path):
    path = tmp_path / "empty.toml"
    path.write_text("schema = 1\n")
    with pytest.raises(InputError) as refused:
        load_table(path)
    assert str(refused.value) == f"{path}: [material] is missing"


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "photo.toml"
    path.write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(InputError, match="not valid TOML"):
        load_table(path)
    with pytest.raises(InputError, match="not a file; give a TOML file"):
        load_table(tmp_path)


def test_an_unknown_table_is_reported_with_the_nearest():
    with pytest.raises(InputError) as refused:
        load_table("wod")
    assert str(refused.value) == (
        "wod: no such materials file, nor a shipped one; did you mean 'wood'? known: "
        + ", ".join(data_names("materials"))
    )


def test_a_pair_is_found_in_either_order_and_a_missing_one_is_listed():
    table = load_table("wood")
    assert table.pair("wood", "methacrylate") is table.pair("methacrylate", "wood")
    with pytest.raises(InputError) as refused:
        table.pair("wood", "steel")
    assert str(refused.value) == (
        f"{table.path}: no pair wood-steel; did you mean 'wood-wood'? "
        "known: wood-wood, wood-methacrylate"
    )
    with pytest.raises(InputError) as refused:
        table.material("wod")
    assert str(refused.value) == (
        f"{table.path}: no material 'wod'; did you mean 'wood'? known: wood, methacrylate"
    )


@pytest.mark.parametrize("name", PROPERTIES)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_no_property(name, value):
    """Whoever builds a record in Python, calibration included, meets the same ranges."""
    quantities = {key: Measured(0.3) for key in PROPERTIES} | {name: Measured(value)}

    def build():
        of = quantities.__getitem__
        Material("a", *map(of, list(PROPERTIES)[:6]))
        linear = LinearParameters(*map(of, ("kn", "kt", "gamma_n", "gamma_t")))
        Pair("a", "a", of("friction"), of("restitution"), linear)

    with pytest.raises(InputError, match=f"^{name} = {value}"):
        build()
