"""--into, --pair and --material: what a measuring command writes, and what it refuses at once."""

import click
import pytest
from click.testing import CliRunner

from calibration.commands.options import Into, into_options
from calibration.statistics.uncertainty import Estimate
from granulab.contact.files.table import load_table
from granulab.errors import InputError

E = Estimate(0.5, 0.02, 7, 0.05)
MODULUS = Estimate(2.4e8, 1e7, 5)


@click.command()
@click.argument("file", required=False)
@into_options("restitution", "youngs_modulus")
def measure(file: str | None, into: Into | None) -> None:
    """A command that measures one property of a pair and one of a material."""
    click.echo("measured")
    for key, found in (("restitution", E), ("youngs_modulus", MODULUS)):
        if into and into.takes(key):
            into.put(key, found, method="drop", files=[file] if file else [])


def run(*arguments: object):
    return CliRunner().invoke(measure, [str(argument) for argument in arguments])


def test_without_into_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run().output == "measured\n"
    assert list(tmp_path.iterdir()) == []


def test_the_named_pair_and_material_get_their_values(tmp_path):
    clip, path = tmp_path / "clip.csv", tmp_path / "new.toml"
    clip.write_bytes(b"abc")
    done = run(clip, "--into", path, "--pair", "wood-wood", "--material", "wood")
    assert done.exit_code == 0
    assert "[pair.wood-wood] restitution added; a simulator still needs" in done.stderr
    text = path.read_text()
    assert text.count('source = "clip.csv", digest = "ba7816bf8f01cfea') == 2


def test_only_what_is_named_is_written(tmp_path):
    path = tmp_path / "new.toml"
    run("--into", path, "--material", "wood")
    assert "restitution" not in path.read_text()
    assert 'youngs_modulus = { value = "0.24 GPa", sigma = "0.01 GPa"' in path.read_text()


def test_a_second_measurement_goes_to_the_same_pair_in_either_order(tmp_path):
    path = tmp_path / "t.toml"
    path.write_text(
        'schema = 1\n[material.a]\ndensity = "1 g/cm3"\n[material.b]\ndensity = "1 g/cm3"\n'
        "[pair.a-b]\nfriction = 0.3\nrestitution = 0.4\n"
    )
    done = run("--into", path, "--pair", "b-a")
    assert "restitution replaced; the old value is kept as history" in done.stderr
    assert load_table(path).pair("a", "b").restitution.value == 0.5
    again = run("--into", path, "--pair", "b-a")
    assert "stands there already, from this measurement; nothing changed" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--into", "t.toml"], "--into t.toml: say of which pair: --pair wood-steel"),
        (["--pair", "a-b"], "a-b: names what is written; give the file, too: --into wood.toml"),
        (["--into", "t.csv", "--pair", "a-b"], "t.csv: no parameter file"),
        (["--into", "none/t.toml", "--pair", "a-b"], "no such folder"),
        (["--into", "t.toml", "--pair", "a"], "'pair.a': no section of a parameter file"),
    ],
)
def test_bad_options_are_refused_before_the_work(arguments, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run(*arguments)
    assert isinstance(done.exception, InputError)
    assert line in str(done.exception)
    assert "measured" not in done.output
    assert list(tmp_path.iterdir()) == []
