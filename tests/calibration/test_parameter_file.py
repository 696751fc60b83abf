"""Values into the parameter file: all else in it stays, whatever it looks like and what happens."""

import copy
import datetime
import re
import stat
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from fuzzing import examples
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from small_silo import DRY, silo2d

from calibration.files.parameter_file import check_section, digest_of, into
from calibration.statistics.uncertainty import Estimate
from granulab.contact.files.datafile import data_root
from granulab.contact.files.table import load_table, write_table
from granulab.contact.material import PROPERTIES
from granulab.errors import InputError

DAY = datetime.date(2026, 3, 14)
FOUND = Estimate(0.512345, 0.0123456, 5, 0.0276)


def put(path, where="pair.wood-wood", key="restitution", estimate=FOUND, **changes):
    given = {"method": "drop", "source": "clip.mp4", "digest": "ab" * 32, "date": DAY} | changes
    return into(path, where, key, estimate, **given)


@pytest.fixture
def wood(tmp_path) -> Path:
    path = tmp_path / "wood.toml"
    path.write_bytes((data_root() / "materials" / "wood.toml").read_bytes())
    return path


def test_a_replaced_value_stands_in_the_history(wood):
    """What the simulators read is the new value; the old one is kept with all that was known."""
    old = load_table(wood).pair("wood", "wood").restitution
    written = put(wood)
    new = load_table(wood).pair("wood", "wood").restitution
    assert (written.changed, written.replaces, written.lacking) == (True, old.value, [])
    # To a hundredth of sigma, that is to 1e-4, and the widths to three digits.
    assert (new.value, new.sigma, new.scatter) == (0.5123, 0.0123, 0.0276)
    assert (new.trials, new.method, new.source) == (5, "drop", "clip.mp4")
    assert (new.digest, new.date, new.history) == ("ab" * 32, DAY, (old,))


def test_the_history_grows_with_the_oldest_first(wood):
    values = [0.45]
    for value in (0.5, 0.51, 0.52):
        put(wood, estimate=Estimate(value, 0.01, 3))
        values.append(value)
    new = load_table(wood).pair("wood", "wood").restitution
    assert [old.value for old in new.history] + [new.value] == values
    assert all(old.history == () for old in new.history)


def test_the_same_measurement_twice_is_one(wood):
    put(wood)
    before = wood.read_bytes()
    again = put(wood, date=datetime.date(2026, 3, 15))
    assert not again.changed
    assert wood.read_bytes() == before


def test_what_is_read_written_and_read_is_equal(wood, tmp_path):
    """With history, digest and scatter."""
    put(wood)
    put(wood, "material.wood", "youngs_modulus", Estimate(2.5e8, 1e7, 5, 2e7))
    table = load_table(wood)
    write_table(table, tmp_path / "copy.toml")
    assert load_table(tmp_path / "copy.toml") == table


def test_the_silo_reads_what_was_written(wood):
    """The new friction and the new damping are those of the run; the history is not in its way."""
    before = silo2d("run", "A4", "--materials", wood, *DRY, "--json").json["restitution"]
    put(wood, key="gamma_n", estimate=Estimate(21200.0, 900.0, 5))
    after = silo2d("run", "A4", "--materials", wood, *DRY, "--json").json["restitution"]
    assert before["particle_particle"]["one_contact"] == pytest.approx(0.80, abs=0.01)  # errata
    assert after["particle_particle"]["one_contact"] == pytest.approx(0.45, abs=0.01)
    assert after["particle_wall"] == before["particle_wall"]


def test_a_value_keeps_the_unit_of_the_file(wood):
    """The shipped table has MPa, where a new entry would be in GPa."""
    put(wood, "material.wood", "youngs_modulus", Estimate(2.5e8, 1.2e7, 5))
    assert 'youngs_modulus = { value = "250 MPa", sigma = "12 MPa", trials' in wood.read_text()


def test_a_pair_is_found_in_either_order(wood):
    assert put(wood, "pair.methacrylate-wood").section == "pair.wood-methacrylate"
    assert put(wood, "pair.methacrylate-wood", "kn", Estimate(1e7, None, 1)).replaces == 1e7


def test_a_new_key_comes_before_the_comment_of_the_next_section(wood):
    put(wood, "material.wood", "yield_strength", Estimate(5e6, None, 1))
    text = wood.read_text()
    assert re.search(r"poisson = .*\nyield_strength = .*\n\n\[material.methacrylate\]", text)


def test_a_file_is_begun_and_says_what_it_lacks(tmp_path):
    """Measurements come one by one: each is kept, and the simulators' needs are named."""
    path = tmp_path / "new.toml"
    put(path, "pair.wood-steel")
    put(path, "pair.wood-steel", "kn", Estimate(1e7, None, 1))
    assert put(path, "material.wood", "density", Estimate(450.0, 5.0, 3)).lacking == [
        "[material.steel] density",
        "[material.wood] length",
        "[pair.wood-steel] friction",
        "[pair.wood-steel.linear] kt",  # its gammas may follow from the restitution
        "[pair.wood-wood] friction",
        *[f"[pair.wood-wood.linear] {key}" for key in ("kn", "kt", "gamma_n", "gamma_t")],
    ]
    with pytest.raises(InputError, match="friction is missing"):
        load_table(path)
    put(path, "material.steel", "density", Estimate(7850.0, 5.0, 3))
    for key in ("kt", "gamma_n", "gamma_t"):
        put(path, "pair.wood-steel", key, Estimate(3.0, None, 1))
    put(path, "material.wood", "length", Estimate(0.02, None, 1))
    put(path, "pair.wood-wood", "friction")
    for key in ("kn", "kt", "gamma_n", "gamma_t"):
        assert put(path, "pair.wood-steel", "friction").lacking != []
        put(path, "pair.wood-wood", key, Estimate(3.0, None, 1))
    assert put(path, "pair.wood-steel", "friction").lacking == []
    assert load_table(path).pair("steel", "wood").linear.kn.value == 1e7


# Whatever the file looks like

_COMMENT = st.sampled_from(["", " # said", ' # "quoted" = [x]'])
_GAP = st.sampled_from(["", "\n", "# above\n", "\n# one\n# two\n", "# [pair.x-y]\n\n"])
_KEYS = {
    "material.a": ["density", "length", "poisson", "youngs_modulus"],
    "material.b": ["density", "length"],
    "pair.a-b": ["friction", "restitution"],
    "pair.b-b": ["friction", "restitution"],
    "pair.a-b.linear": ["kn", "kt", "gamma_n", "gamma_t"],
}
_REQUIRED = {"density", "friction", "kn", "kt", "gamma_n", "gamma_t"}


@st.composite
def entries(draw, section: str, key: str) -> str:
    """One entry: bare, inline, dotted; or, at another place, a table (see files)."""
    unit = PROPERTIES[key].unit_in_files
    number = draw(st.sampled_from(["0.25", "0.5", "0.125"]))
    value = number if unit == "1" else f'"{number} {unit}"'
    more = draw(
        st.sampled_from(
            [
                "",
                ', sigma = "6 %"',
                ', date = 2013-09-17, source = "a } # b"',
                ", trials = 3",
                ", date = 2013-09-17",
            ]
        )
    )
    indent = draw(st.sampled_from(["", "  "]))
    kind = draw(st.sampled_from(["bare", "inline", "dotted", "old"]))
    text = {
        "bare": f"{key} = {value}",
        "inline": f"{key} = {{ value = {value}{more} }}",
        "dotted": f"{key}.value = {value}",
        "old": f"{key} = {{ value = {value}{more}, history = [\n {{ value = {value} }},\n] }}",
    }[kind]
    return f"{indent}{text}{draw(_COMMENT)}\n"


@st.composite
def files(draw) -> str:
    """A valid file: sections in any order, with comments, blank lines and either line end."""
    sections = ["material.a", "material.b"]
    sections += draw(st.lists(st.sampled_from(list(_KEYS)[2:4]), unique=True))
    sections += ["pair.a-b.linear"] if "pair.a-b" in sections and draw(st.booleans()) else []
    lines = ["# head\n" * draw(st.integers(0, 2)), "schema = 1\n"]
    for section in draw(st.permutations(sections)):
        lines += [draw(_GAP), f"[{section}]{draw(_COMMENT)}\n"]
        for key in draw(st.permutations(_KEYS[section])):
            if key in _REQUIRED or draw(st.booleans()):
                lines += [draw(_GAP), draw(entries(section, key))]
    lines.append(draw(_GAP))
    text = "".join(lines)
    text = text.rstrip("\n") if draw(st.booleans()) else text
    return text.replace("\n", "\r\n") if draw(st.booleans()) else text


_TARGETS = [
    ("material.a", "density"), ("material.a", "poisson"), ("material.b", "yield_strength"),
    ("pair.b-a", "restitution"), ("pair.b-b", "friction"), ("pair.a-b", "kt"),
    ("pair.c-a", "gamma_n"), ("material.c", "density"),
]  # fmt: skip


_DOTTED_APART = """schema = 1
[pair.a-b]
friction.value = 0.25
[material.a]
density = "0.25 g/cm3"
[material.b]
density = "0.25 g/cm3"
[pair.a-b.linear]
kn = "0.25 N/mm"
kt = "0.25 N/mm"
gamma_n = "0.25 1/s"
gamma_t = "0.25 1/s"
"""


_DATE_AT_THE_END = """schema = 1
[material.a]
[material.b]
density = { value = "0.25 g/cm3", date = 2013-09-17 }"""


@example(text=_DATE_AT_THE_END, target=("material.b", "yield_strength"))
@example(text=_DOTTED_APART, target=("pair.b-a", "restitution"))
@given(text=files(), target=st.sampled_from(_TARGETS))
@settings(
    deadline=None,
    max_examples=examples(60),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_any_valid_file_keeps_its_comments_its_order_and_all_other_entries(text, target, tmp_path):
    """The lines of the old file stand in the new one in their order, but for those of the entry."""
    path, key = tmp_path / "t.toml", target[1]
    path.write_bytes(text.encode())
    section = put(path, *target, Estimate(0.25, 0.01, 4)).section
    new = path.read_bytes().decode()
    assert_only_the_entry_changed(tomllib.loads(text), tomllib.loads(new), section.split("."), key)
    ends = "\r\n" if "\r\n" in text else "\n"
    assert new.count(ends) == new.count("\n")
    for comment in ("# said", '# "quoted" = [x]', "# one", "# two", "# above", "# [pair", "# head"):
        assert new.count(comment) == text.count(comment)
    # tomlkit takes the space between a date and the end of its table for a part of the date.
    remaining = (line.replace(" }", "}") for line in new.splitlines())
    kept = (line.replace(" }", "}") for line in other_lines(text, key))
    assert all(line in remaining for line in kept), "lines in another order"


def assert_only_the_entry_changed(before, after, section, key):
    """Tables as tomllib reads them: all else is equal, and the old entry ends the history."""
    expected = holder = copy.deepcopy(before)
    found = after
    for name in section:
        holder, found = holder.setdefault(name, {}), found[name]
    old, entry = holder.get(key), found[key]
    holder[key] = entry
    assert after == expected
    assert (entry["trials"], entry["date"]) == (4, DAY)
    if old is None:
        assert "history" not in entry
    else:
        old = old if isinstance(old, dict) else {"value": old}
        assert entry["history"] == [*old.pop("history", []), old]


def other_lines(text, key):
    """Lines that do not belong to an entry of that name, in any section."""
    inside = False
    for line in text.splitlines():
        if line.lstrip().startswith((f"{key} =", f"{key}.")):
            inside = line.endswith("history = [")
        elif inside:
            inside = not line.startswith("] }")
        else:
            yield line


def test_an_entry_that_is_a_table_of_its_own_stays_one(tmp_path):
    path = tmp_path / "t.toml"
    path.write_text(
        "schema = 1\n[material.a]\n[material.a.density] # head\n# why\n"
        'value = "2 g/cm3" # from there\nsigma = "5 %"\n\n[material.b]\ndensity = "1 g/cm3"\n'
    )
    put(path, "material.a", "density", Estimate(1900.0, None, 2))
    text = path.read_text()
    assert '[material.a.density] # head\n# why\nvalue = "1.9 g/cm3" # from there\n' in text
    density = load_table(path).material("a").density
    assert (density.value, density.sigma, density.trials) == (1900.0, None, 2)
    assert (density.history[0].value, density.history[0].sigma) == (2000.0, 100.0)


def test_a_section_written_on_one_line_takes_a_key(tmp_path):
    path = tmp_path / "t.toml"
    path.write_text('schema = 1\nmaterial = { a = { density = "2 g/cm3" } } # all\n')
    put(path, "material.a", "poisson", Estimate(0.3, None, 1))
    assert load_table(path).material("a").poisson.value == 0.3
    assert path.read_text().endswith("} # all\n")


# Whatever comes between


_WRITER = """
import datetime, os, pathlib, sys
from calibration.files.parameter_file import into
from calibration.statistics.uncertainty import Estimate
def put(value):
    into(sys.argv[1], "pair.wood-wood", "restitution", Estimate(value, None, 1), method="m",
         source="s", date=datetime.date(2026, 3, 14))
"""


def writer(path: Path, program: str, *arguments: object) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-c", _WRITER + program, str(path), *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE)


@pytest.mark.parametrize(
    ("dies", "value"),
    [
        ("os.fsync = lambda number: os._exit(9)", 0.45),
        ("pathlib.Path.replace = lambda *names: os._exit(9)", 0.45),
        ("replace = os.replace\nos.replace = lambda *a, **k: (replace(*a, **k), os._exit(9))", 0.5),
    ],
    ids=["before all is on the disk", "before the new name", "right after it"],
)
def test_a_writer_that_dies_leaves_the_old_file_or_the_new(wood, dies, value):
    """And the next one is not in the way of what it left."""
    old = wood.read_bytes()
    process = writer(wood, f"{dies}\nput(0.5)")
    process.communicate(timeout=100)
    assert process.returncode == 9
    assert load_table(wood).pair("wood", "wood").restitution.value == value
    assert (wood.read_bytes() == old) == (value == 0.45)
    put(wood)
    assert load_table(wood).pair("wood", "wood").restitution.value == 0.5123
    assert {path.name for path in wood.parent.iterdir()} <= {"wood.toml", ".wood.toml.lock"}


def test_a_writer_killed_at_any_moment_leaves_a_whole_file(wood):
    """SIGKILL while it writes one value after the other."""
    process = writer(wood, "for k in range(1, 1000): put(k / 1000); print(k, flush=True)")
    assert process.stdout is not None
    seen = [int(process.stdout.readline()) for _ in range(5)]
    process.kill()
    seen += [int(line) for line in process.communicate(timeout=100)[0].split()]
    restitution = load_table(wood).pair("wood", "wood").restitution
    written = [round(1000 * old.value) for old in (*restitution.history[1:], restitution)]
    # Each value that was reported is there; one more may be written and not yet reported.
    assert written[: len(seen)] == seen
    assert len(written) <= len(seen) + 1
    assert wood.read_text().count("# ") == (data_root() / "materials/wood.toml").read_text().count(
        "# "
    )


def test_two_writers_at_once_lose_nothing(wood):
    program = "for k in range(8): put(float(sys.argv[2]) + k / 1000)"
    both = [writer(wood, program, start) for start in (0.3, 0.6)]
    for process in both:
        process.communicate(timeout=100)
        assert process.returncode == 0
    restitution = load_table(wood).pair("wood", "wood").restitution
    values = [old.value for old in (*restitution.history, restitution)][1:]
    for start in (0.3, 0.6):
        own = [value for value in values if start <= value < start + 0.1]
        assert own == [start + k / 1000 for k in range(8)]
    assert len(values) == 16


def test_a_file_that_is_protected_stays_as_it_is(wood):
    """Replacing it by another of its name would not ask for its own rights."""
    wood.chmod(0o444)
    before = wood.read_bytes()
    with pytest.raises(InputError, match=r"write-protected; chmod u\+w"):
        put(wood)
    assert wood.read_bytes() == before


def test_a_link_stays_a_link_and_the_rights_stay(wood):
    wood.chmod(0o640)
    link = wood.with_name("link.toml")
    link.symlink_to(wood)
    put(link)
    assert link.is_symlink()
    assert stat.S_IMODE(wood.stat().st_mode) == 0o640
    assert load_table(wood).pair("wood", "wood").restitution.value == 0.5123


# What is refused


@pytest.mark.parametrize(
    ("where", "key", "estimate", "line"),
    [
        (
            "pair.wood-wood",
            "restitution",
            Estimate(1.2, 0.1, 3),
            "restitution = 1.2: must be above",
        ),
        (
            "pair.wood-wood",
            "restitution",
            Estimate(float("nan"), None, 1),
            "restitution = nan: must",
        ),
        (
            "pair.wood-wood",
            "friction",
            Estimate(0.3, float("inf"), 1),
            "friction.sigma = inf: must",
        ),
        ("pair.wood-wood", "kn", Estimate(-1.0, None, 1), "kn = -1 N/m: must be above 0"),
        ("pair.wood-wood", "density", FOUND, r"holds no density; it holds friction, restitution"),
        ("material.wood", "kn", FOUND, "holds no kn; it holds density, length"),
        ("material.wood", "hardness", FOUND, "holds no hardness; it holds density"),
        ("pair.wood", "friction", FOUND, "'pair.wood': no section of a parameter file; give"),
        ("pair.wood-cast-iron", "friction", FOUND, "no section of a parameter file"),
        ("wood", "density", FOUND, "no section of a parameter file"),
    ],
)
def test_an_impossible_value_or_section_is_refused_and_nothing_is_written(
    wood, where, key, estimate, line
):
    before = wood.read_bytes()
    with pytest.raises(InputError, match=line) as refused:
        put(wood, where, key, estimate)
    assert "\n" not in str(refused.value)
    assert wood.read_bytes() == before


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"schema = 1\n[material.a\n", "not valid TOML"),
        (b"\xff\x00", "not valid TOML"),
        (b"[material.a]\n", "schema is missing"),
        (b"schema = 7\n", "schema = 7: unknown"),
        (b"schema = 1\n[materials.a]\n", "unknown key 'materials'"),
        (b"schema = 1\n[pair.wood-wood]\nrestitution = {}\n", "restitution.value is missing"),
        (b"schema = 1\n[pair.wood-wood]\nrestitution = '1 mm'\n", "the unit is wrong here"),
        (b"schema = 1\npair = 3\n", "pair"),
    ],
)
def test_a_wrong_file_is_refused_and_left(tmp_path, content, line):
    path = tmp_path / "t.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=line) as refused:
        put(path)
    assert str(path) in str(refused.value)
    assert path.read_bytes() == content


def test_a_file_that_cannot_be_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        put(tmp_path / "none" / "t.toml")
    with pytest.raises(InputError, match=r"clip.mp4: no parameter file; give the name of a .toml"):
        put(tmp_path / "clip.mp4")
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(InputError, match="not a file"):
        put(tmp_path / "folder.toml")


def test_the_digest_is_that_of_sha256sum(tmp_path):
    """FIPS 180-4: SHA-256 of "abc"; of several files, that of the list of theirs."""
    (tmp_path / "a").write_bytes(b"abc")
    digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert digest_of([tmp_path / "a"]) == digest
    assert digest_of([tmp_path / "a"] * 2) != digest
    with pytest.raises(InputError, match="cannot be read"):
        digest_of([tmp_path / "b"])


def test_stiffness_and_damping_stand_in_the_linear_section():
    assert check_section("pair.a-b", "kn") == ["pair", "a-b", "linear"]
    assert check_section("pair.a-b", "friction") == ["pair", "a-b"]
