"""A simulator without physics for sweeps; workers import it by name."""

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from granulab.campaign.runs.folder import RunFolder, digest, open_run
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.runs.provenance import Sources
from granulab.campaign.sweeps.sweep import Simulator, Task, as_outcome
from granulab.errors import FolderError, Stopped

SOURCES = Sources(Path(__file__).parent / "published")  # of no .py file: a digest that stays


class FakeRun(BaseModel):
    seed: int = 1


class FakeSettings(BaseModel):
    run: FakeRun = FakeRun()
    number: int = 2
    packing: str = "loose"


@dataclass(frozen=True)
class FakeCase:
    """Squares a number, and adds what stands in its packing."""

    settings: FakeSettings
    name: str = "square"


def fake(number: int, **settings: Any) -> FakeCase:
    return FakeCase(FakeSettings(number=number, **settings))


@dataclass(frozen=True)
class FakeResult:
    square: int
    parts: dict[str, float]
    per_cycle: list[float]
    reused: bool


def fake_digest(case: FakeCase) -> str:
    return digest(case.settings.model_dump())


def packing_folder(case: FakeCase, out: Path) -> Path:
    return out / "packings" / case.settings.packing


def packing_from(file: Path) -> str | None:
    return json.loads(file.read_text())["sources"] if file.exists() else None


def work(task: Task, stop: Stop) -> FakeResult | None:
    """Fails for 13, stops for 99, and asks nobody before it makes a packing."""
    with as_outcome(FolderError):
        file = packing_folder(task.case, task.out) / "packing.h5"
        if not file.exists():
            file.parent.mkdir(parents=True)  # fails where two make it at once
            time.sleep(0.2)
            file.write_text(json.dumps({"sources": SOURCES.digest}))
        if task.packing_only:
            return None
        number = task.case.settings.number
        if number == 13:
            raise FolderError("13: unlucky; use --again to compute the run again")
        if number == 99:
            raise Stopped("the same command goes on")
        name = f"{task.case.name}-seed{task.case.settings.run.seed}"
        folder = open_run(task.out, name, fake_digest(task.case))
        folder.write_case("schema = 1\n")
        folder.write_provenance({"source_digest": SOURCES.digest})
        folder.write_summary({"square": number**2})
        return _result(folder, reused=False)


def _result(folder: RunFolder, reused: bool) -> FakeResult:
    square = folder.read_summary()["square"]
    return FakeResult(square, {"half": square / 2}, [square, 0.5], reused)


def read(folder: RunFolder) -> FakeResult:
    return _result(folder, reused=True)


FAKE = Simulator(
    name="fake",
    digest=fake_digest,
    packing_folder=packing_folder,
    packing_from=packing_from,
    work=work,
    read=read,
    expected_cpu_s=lambda case: (60.0, 30.0),
    sources=SOURCES,
    packages=["numpy"],
)
