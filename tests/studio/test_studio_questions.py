"""Questions on the page: their files, what they will take, and answers that are seen again."""

import signal
from pathlib import Path

import pytest
from studio_server import Studio
from waiting import wait_until

from damper3d.studies.design.spec import example, read_spec
from granulab.studio.forms import texts_of
from granulab.studio.rooms.measuring import TASKS
from silo2d.loads.design import load_design
from silo2d.loads.spec import commented_spec

# Example, reader, and another value of a key.
OWN = {
    "damper3d design": (example, read_spec, ("structure", "mass", "7 kg")),
    "silo2d loads": (commented_spec, load_design, ("silo", "height", "7 m")),
}


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    running = Studio(tmp_path_factory.mktemp("questions"))
    (running.folder / "silo_case.toml").write_text('schema = 1\n[silo]\npreset = "A4"\n')
    (running.folder / "seen.html").write_text("<p>of the folder, and of no answer</p>")
    yield running
    running.close()


@pytest.mark.parametrize("task", OWN)
def test_a_question_s_form_holds_the_shipped_example_and_is_kept_as_its_file(
    studio, tmp_path, task
):
    """The file that the form writes is the example that `init` writes, read by the command."""
    text, read, another = OWN[task]
    own = studio.ask("task", task=task)["own"]
    assert all(key["meaning"] for section in own["form"] for key in section["keys"])
    kept = studio.order("keep", task=task, texts=own["texts"])
    assert kept == {"file": f"{own['texts']['name']}.toml", "exists": False}
    (tmp_path / "example.toml").write_text(text())
    assert vars(read(studio.folder / kept["file"])) == vars(read(tmp_path / "example.toml"))
    assert studio.ask("open_own", task=task, name=kept["file"]) == own["texts"]
    section, key, value = another
    other = own["texts"] | {section: own["texts"][section] | {key: value}}
    assert studio.order("keep", task=task, texts=other) == {**kept, "exists": True}
    assert studio.order("keep", task=task, texts=other, replace=True) == kept


def answer(studio: Studio, place: str) -> dict:
    """What a task says once it has ended."""
    wait_until(lambda: studio.ask("measured", place=place)["state"] != "running", 120.0)
    return studio.ask("measured", place=place)


def test_an_answer_with_its_page_is_seen_again_by_a_page_that_was_reloaded(studio):
    """What was started is listed with what it was asked, and whether it goes on."""
    texts = studio.ask("task", task="silo2d loads")["own"]["texts"] | {"name": "wheat"}
    file = studio.order("keep", task="silo2d loads", texts=texts)["file"]
    asked = {"task": "silo2d loads", "files": [file], "options": {}, "presets": []}
    place = studio.order("measure", **asked)["place"]
    found = answer(studio, place)
    assert "Janssen" in found["said"], found
    assert (found["figures"], found["pages"]) == (
        ["runs/loads/wheat/loads.png"], ["runs/loads/wheat/loads.html"]
    )  # fmt: skip
    page = studio.request("GET", f"answer/{found['pages'][0]}", origin="")
    assert page.body.lower().startswith(b"<!doctype html>")
    assert page.headers["content-security-policy"].startswith("sandbox allow-scripts;")
    (again,) = (one for one in studio.ask("started") if one["place"] == place)
    assert {name: again[name] for name in asked} == asked
    assert (again["state"], again["command"]) == ("done", found["command"])


def test_what_a_question_will_take_is_said_before_it_starts(studio):
    """The dry run stands under a name of its own, and runs nothing."""
    options = {"outlets": "45 mm,50 mm", "seeds": "2"}
    place = studio.order(
        "measure", task="silo2d clog", files=[], presets=["A3"], options=options, dry=True
    )["place"]
    found = answer(studio, place)
    assert "4 runs of 4 packings" in found["said"], found
    assert found["dry"]
    assert not list((studio.folder / "runs").glob("A3*"))
    assert studio.ask("started")[0]["place"] == place, "the last is the first"
    dry = {name for name in TASKS if studio.ask("task", task=name)["dry"]}
    assert dry == {
        "damper3d map", "damper3d design", "damper3d response", "silo2d clog", "silo2d loads CASE"
    }  # fmt: skip


STRUCTURE = {"mass": "2 kg", "frequency": "60", "damping_ratio": "0.005"}
REFUSED = {
    "a measurement without a file": (
        "measure", {"task": "calibrate drop", "files": [], "options": {}}, "drop one on the page",
    ),
    "a question without a case": (
        "measure", {"task": "damper3d response", "files": [], "options": {}}, "save one in its",
    ),
    "a file with a value that it cannot have": (
        "keep", {"task": "damper3d design", "texts": {"structure": STRUCTURE | {"mass": "2 m"}}},
        "[structure] mass",
    ),
    "a file without what it needs": (
        "keep", {"task": "silo2d loads", "texts": {"name": "x"}}, "[silo]",
    ),
    "a file that leads out": (
        "keep", {"task": "damper3d design", "texts": {"budget": {"catalogue": "/etc/passwd"}}},
        "not within the folder",
    ),
    "a file of a task that takes none": (
        "keep", {"task": "damper3d map", "texts": {}}, "takes no file of its own kind",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_what_a_question_cannot_be_asked_is_refused_in_one_line(studio, kind):
    order, body, words = REFUSED[kind]
    before = sorted(studio.folder.iterdir())
    line = studio.order(order, **body)["refusal"]
    assert words in line
    assert "\n" not in line
    assert sorted(studio.folder.iterdir()) == before


def test_a_file_of_another_kind_is_no_file_of_a_question(studio):
    found = studio.ask("open_own", task="damper3d design", name="silo_case.toml")
    assert found["refusal"].startswith("silo_case.toml: ")


@pytest.mark.parametrize("name", ["seen.html", "silo_case.toml", "runs/../seen.html", "../x.html"])
def test_no_page_but_that_of_an_answer_is_shown(studio, name):
    answer = studio.request("GET", f"answer/{name}", origin="")
    assert b"<p>" not in answer.body


def test_a_studio_whose_damper_was_shown_ends_by_a_signal_without_a_warning(tmp_path):
    """The semaphores of the process beside it go before the signal ends the server."""
    one = Studio(tmp_path)
    tables = {"enclosure": {"diameter": "40 mm", "height": "40 mm"}, "particles": {"count": 20}}
    found = one.order("fill", simulator="damper3d", case={"name": "d"} | {
        section: texts_of({section: table})[section] for section, table in tables.items()
    })  # fmt: skip
    assert len(found["spheres"]) == 20
    code, err = one.close(signal.SIGTERM)
    assert (code, err.count("\n")) == (-signal.SIGTERM, 1), err


def test_the_page_has_a_question_for_each_command_that_takes_long():
    """Each task that is no measurement stands in the table of the page."""
    script = Path(__file__).parents[2] / "granulab" / "studio" / "page" / "questions.js"
    text = script.read_text()
    for task in TASKS:
        assert (f'task: "{task}"' in text) == (not task.startswith("calibrate ")), task
