"""The answers of a finished run, read back from its folder and checked against their type."""

from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from campaign.folder import FolderError, RunFolder

Answers = TypeVar("Answers")


def read_answers(adapter: TypeAdapter[Answers], folder: RunFolder, *, reused: bool) -> Answers:
    """The summary of a run folder, with `reused` and `run_folder`; FolderError where damaged."""
    kept = {**folder.read_summary(), "reused": reused, "run_folder": str(folder.path)}
    try:
        return adapter.validate_python(kept)
    except ValidationError as error:
        problem = error.errors()[0]
        raise FolderError(
            f"{folder.path / 'summary.json'}: damaged ({problem['loc'][0]}: "
            f"{problem['msg'].lower()}); use --again to compute the run anew"
        ) from None
