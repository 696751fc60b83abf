"""Questions on the page: how they end."""

import signal

from studio_server import Studio

from granulab.studio.forms import texts_of


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
