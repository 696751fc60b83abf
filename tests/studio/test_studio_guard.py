"""The studio answers its own page on this machine, and nobody else."""

import socket
import subprocess
import sys

import pytest
from refusals import refusal
from studio_server import Studio

from granulab.errors import InputError
from granulab.studio.folder import Folder
from granulab.studio.forms import as_files


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio")
    (folder / "seen.csv").write_text("a,b\n1,2\n")
    (folder.parent / "secret.csv").write_text("not,this\n")
    (folder / "leads_out.csv").symlink_to(folder.parent / "secret.csv")
    (folder / "out").symlink_to(folder.parent)
    running = Studio(folder)
    yield running
    running.close()


def test_the_page_comes_with_its_parts_and_a_policy_that_loads_nothing_else(studio):
    page = studio.request("GET", "", origin="")
    assert page.status == 200
    policy = page.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy, "no scripts but files of the page"
    assert page.headers["referrer-policy"] == "no-referrer", "the token stays here"
    for part in ("page/main.js", "page/studio.css", "page/icon.svg"):
        assert part.encode() in page.body
        assert studio.request("GET", part, origin="").status == 200
    for other in ("page/../app.py", "page/none.js", "page/%2e%2e%2fapp.py"):
        assert studio.request("GET", other, origin="").status == 404


REFUSED = {
    "another host, as a name that leads here": ({"host": "evil.example"}, 403),
    "the right name at another port": ({"host": "127.0.0.1:1"}, 403),
    "a page of another origin": ({"origin": "http://evil.example"}, 403),
    "a page without an origin of its own": ({"origin": "null"}, 403),
    "another program on this machine": ({"origin": "http://127.0.0.1:1"}, 403),
    "a browser that says it is for another site": ({"sec_fetch_site": "cross-site"}, 403),
    "and for another port of this one": ({"sec_fetch_site": "same-site"}, 403),
}


@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.parametrize("method", ["GET", "POST", "PUT"])
def test_requests_of_others_are_refused(studio, kind, method):
    headers, status = REFUSED[kind]
    answer = studio.request(method, "api/start", b"{}" if method != "GET" else None, **headers)
    assert answer.status == status
    assert b"\n" not in answer.body
    assert b"silo2d" not in answer.body


def test_an_order_without_an_origin_is_refused(studio):
    """Browsers send one with every order; what they send without is a form of another page."""
    assert studio.request("POST", "api/check", b"{}", origin="").status == 403


def test_no_address_without_the_token_answers(studio):
    almost = f"{studio.path[:-2]}x/api/start"
    for path in ("/", "/api/start", "/x/api/start", almost, "//api/start"):
        answer = studio.request("GET", path, whole=True, origin="")
        assert answer.status == 404
        assert b"silo2d" not in answer.body


def test_it_listens_on_this_machine_alone(studio):
    """Its port is free on every other address of the machine."""
    with socket.socket() as other:
        other.bind(("127.0.0.2", studio.port))


OUTSIDE = ["../secret.csv", "/etc/passwd", "out/secret.csv", "leads_out.csv", "a/../../secret.csv",
           "./seen.csv", "..\\secret.csv", "C:/secret.csv", "seen.csv\0"]  # fmt: skip


@pytest.mark.parametrize("name", OUTSIDE)
def test_no_name_leads_out_of_the_folder(studio, name):
    line = refusal(Folder(studio.folder).path, name)
    assert "not within the folder" in line
    encoded = "".join(f"%{ord(letter):02x}" for letter in name)
    answer = studio.request("GET", f"files/{encoded}", origin="")
    assert answer.status == 404
    assert b"not,this" not in answer.body


@pytest.mark.parametrize(
    "case",
    [
        {"silo": {"preset": "A4"}, "particles": {"shapes": "../secret.csv"}},
        {"silo": {"preset": "A4"}, "particles": {"materials": "/etc/passwd"}},
        {"silo": {"preset": "A4"}, "particles": {"shapes": "leads_out.csv"}},
    ],
)
def test_no_case_names_a_file_outside(studio, case):
    found = studio.order("check", simulator="silo2d", case=case)
    assert "not within the folder of the studio" in found["refused"]


@pytest.mark.parametrize("name", ["../rock.toml", "{outside}/rock.toml", "out/rock.toml"])
def test_no_materials_outside_are_shown(studio, name):
    """By "..", an absolute path, or a folder that is a link to elsewhere."""
    outside = studio.folder.parent
    (outside / "rock.toml").write_text(
        'schema = 1\n[material.secret]\ndensity = { value = "2 g/cm3", source = "hidden" }\n'
    )
    found = studio.ask("materials", name=name.format(outside=outside))
    assert "not within the folder" in found["refusal"]
    assert "secret" not in str(found)


def test_no_measurement_reads_or_writes_outside(studio):
    outside = [{"into": "../other.toml"}, {"roi": "/etc/passwd"}, {"unit": "time=s\n/etc/passwd"}]
    for options in outside:
        found = studio.order("measure", task="calibrate drop", files=["seen.csv"], options=options)
        assert "not within the folder" in found["refusal"]
    found = studio.order("measure", task="calibrate drop", files=["../secret.csv"], options={})
    assert "not within the folder" in found["refusal"]
    found = studio.order("measure", task="calibrate drop", files=["seen.csv"], options={"out": "x"})
    assert "no option" in found["refusal"]
    found = studio.order(
        "measure", task="damper3d map", files=[], options={}, presets=["../secret"]
    )
    assert "not within the folder" in found["refusal"]


def test_a_file_is_no_option_of_a_command():
    assert as_files(["a.csv", "b.csv"]) == ["a.csv", "b.csv"]
    assert as_files(["a.csv", "--into=b.toml"]) == ["--", "a.csv", "--into=b.toml"]


KEPT = {
    "table.csv": b"h,e\n1,2\n",
    "drawing.svg": b'<?xml version="1.0"?><svg/>',
    "case.toml": b"schema = 1\n",
    "sound.wav": b"RIFF\0\0\0\0WAVEfmt ",
    "film.mp4": b"\0\0\0\x18ftypmp42",
}
NOT_KEPT = {
    "film.mp4": (b"<html>", "no MP4 file"),
    "picture.png": (b"\xff\xd8\xff\xe0", "no PNG file"),
    "table.csv": (b"\0\1\2", "no CSV file"),
    "book.xlsx": (b"h,e\n1,2\n", "no XLSX file"),
    "case.toml": (b"[silo\n", "not valid TOML"),
    "drawing.svg": (b"<html></html>", "no SVG file"),
    "program.exe": (b"MZ", "not taken"),
    "page.html": (b"<html>", "not taken"),
    "none": (b"x", "not taken"),
    "a:b.csv": (b"a\n", "no file can be called so"),
    "empty.csv": (b"", "no CSV file"),
}


@pytest.mark.parametrize("name", KEPT)
def test_a_file_that_is_what_it_says_is_kept(studio, name):
    assert studio.send(name, KEPT[name]) == {"name": name}
    assert (studio.folder / name).read_bytes() == KEPT[name]
    stem, _, ending = name.rpartition(".")
    assert studio.send(name, KEPT[name]) == {"name": name}, "the same again is the same file"
    assert studio.send(name, KEPT[name] + b"\n") == {"name": f"{stem}-2.{ending}"}
    assert (studio.folder / name).read_bytes() == KEPT[name]


@pytest.mark.parametrize("name", NOT_KEPT)
def test_a_file_that_is_something_else_is_refused(studio, name):
    content, words = NOT_KEPT[name]
    before = sorted(path.name for path in studio.folder.iterdir())
    assert words in studio.send(name, content)["refusal"]
    assert sorted(path.name for path in studio.folder.iterdir()) == before, "nothing is left of it"


def test_a_file_of_the_folder_runs_nothing(studio):
    """An SVG may hold a script, a table anything: what is shown is shown in a sandbox."""
    studio.send("shown.svg", b"<svg><script>1</script></svg>")
    answer = studio.request("GET", "files/shown.svg", origin="")
    assert answer.headers["content-security-policy"].startswith("sandbox;")
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_questions_that_are_none_get_one_line(studio):
    assert studio.request("GET", "api/none", origin="").status == 404
    assert "no simulator" not in studio.order("check", simulator="x", case={})
    assert "no such simulator" in studio.order("check", simulator="x", case={})["refusal"]
    assert "another page version" in studio.order("check", other=1)["refusal"]
    answer = studio.request("POST", "api/check", b"[" * 100_000)
    assert answer.json == {"refusal": "the request is no JSON object"}
    assert (
        "larger than 4 MB" in studio.request("POST", "api/check", b" " * 5_000_000).json["refusal"]
    )


def command(*arguments: str) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-m", "granulab", *arguments], capture_output=True, text=True, timeout=60
    )
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--port", "{port}"], "cannot be used"),
        (["--folder", "none"], "no such folder"),
        (["--port", "70000"], "--port"),
    ],
)
def test_what_it_cannot_start_with_is_refused_in_one_line(studio, tmp_path, arguments, words):
    given = [one.format(port=studio.port) for one in arguments]
    code, out, err = command("studio", "--no-browser", *given)
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert err.startswith("granulab: ")


def test_a_browser_that_is_not_there_is_one_line(tmp_path, monkeypatch):
    """The page is served all the same, and ends with Ctrl-C, code 0."""
    monkeypatch.setenv("BROWSER", "/nowhere/browser")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("DISPLAY", raising=False)
    running = Studio(tmp_path, "--port", "0")
    assert running.request("GET", "", origin="").status == 200
    code, err = running.close()
    assert (code, err.count("\n")) == (0, 1), err


def test_the_line_on_a_browser_says_what_to_do(capsys, monkeypatch):
    import webbrowser

    from granulab.studio.launch import _show

    monkeypatch.setattr(webbrowser, "open_new_tab", lambda address: False)
    _show("http://127.0.0.1:1/x/")
    assert capsys.readouterr().err == "no browser was found; open the address above in one\n"


def test_granulab_alone_lists_what_there_is(tmp_path):
    code, out, err = command("-o", str(tmp_path))
    assert (code, err) == (0, "")
    commands = ("silo2d ", "damper3d ", "calibrate ", "granulab studio ")
    for word in (*commands, "A4", "thesis", "acrylic"):
        assert word in out, word


@pytest.mark.parametrize("name", ["CON", "../up.toml", "a/b.toml", "", "..", "a:b", "x" * 300])
def test_no_file_is_written_under_a_name_that_is_none(tmp_path, name):
    with pytest.raises(InputError, match="no file can be called so"):
        Folder(tmp_path).write(name, "x")
    assert list(tmp_path.iterdir()) == []
