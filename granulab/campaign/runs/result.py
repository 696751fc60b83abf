"""The results of a finished run, read back from its folder and checked against their type."""

from functools import cache
from typing import Self

from pydantic import TypeAdapter, ValidationError

from granulab.errors import FolderError
from granulab.campaign.runs.folder import RunFolder


class Results:
    """Base of a dataclass of results, which has the fields `reused` and `run_folder`."""

    @classmethod
    def read(cls, folder: RunFolder, *, reused: bool) -> Self:
        """Return the results kept in a finished run folder; FolderError where they are damaged."""
        kept = {**folder.read_summary(), "reused": reused, "run_folder": str(folder.path)}
        try:
            return cls._adapter().validate_python(kept)
        except ValidationError as error:
            problem = error.errors()[0]
            raise FolderError(
                f"{folder.path / 'summary.json'}: damaged ({problem['loc'][0]}: "
                f"{problem['msg'].lower()}); use --again to compute the run again"
            ) from None

    @classmethod
    @cache
    def _adapter(cls) -> TypeAdapter[Self]:
        """Return what checks a summary; a sweep reads many."""
        return TypeAdapter(cls)
