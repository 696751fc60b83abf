"""Sources that made what a sweep finds: these, or those of another version."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.provenance import to_stderr
from granulab.errors import FolderError

if TYPE_CHECKING:
    from granulab.campaign.sweeps.sweep import Simulator


class Origins:
    """Origins of the runs, packings and results of a sweep: whether others made them.

    of_these: folders of runs that these sources made, or will make, with packing and results
    """

    def __init__(self, simulator: "Simulator", out: Path) -> None:
        self._simulator, self._out = simulator, out
        self._made_by = simulator.made_by or (lambda case: (simulator.sources, simulator.sources))
        self.of_these: set[Path] = set()
        # Whether others made it, by where it is.
        self._runs: dict[Path, bool] = {}
        self._packings: dict[Path, bool] = {}
        self._results: dict[Path, bool] = {}

    def digests(self, case: Any) -> list[str]:
        """Digests of the sources that make the run of a case now, its packing, and its results."""
        measures = self._simulator.measures
        own = [sources.digest for sources in self._made_by(case)]
        return [*own, measures.digest] if measures else own

    def know(self, folder: RunFolder) -> None:
        """Note a run of these sources, and its results."""
        self._runs[folder.path] = self._results[folder.path] = False

    def look(self, folder: RunFolder, case: Any, *, begun: bool) -> None:
        """Note who made the run of a case and its packing, where that is there.

        begun: whether the folder was there before; its provenance says who made it.
        """
        of_run, of_packing, *of_results = self.digests(case)
        origin = _origin(folder) if begun else {}
        made, measured = origin.get("source_digest"), origin.get("measures_digest")
        self._runs[folder.path] = made not in (None, of_run)
        self._results[folder.path] = bool(of_results) and measured not in (None, *of_results)
        packing = self._simulator.packing_file(case, self._out)
        if packing not in self._packings:
            filled = self._simulator.packing_from(packing) if packing.exists() else None
            self._packings[packing] = filled not in (None, of_packing)
        by_others = self._runs[folder.path], self._results[folder.path], self._packings[packing]
        if not any(by_others):
            self.of_these.add(folder.path)

    def warn(self) -> None:
        """One line on stderr where runs, packings or results were made by another version."""
        of_others = [
            f"{sum(made.values())} of {len(made)} {what}"
            for what, made in (
                ("runs", self._runs), ("packings", self._packings), ("results", self._results)
            )
            if what != "results" or any(made.values())
        ]  # fmt: skip
        if any(not words.startswith("0 ") for words in of_others):
            to_stderr(
                f"{' and '.join(of_others)} were made by another version of the sources; delete "
                "their folders and the same command makes them again"
            )


def _origin(folder: RunFolder) -> dict[str, Any]:
    try:
        return folder.read_provenance()
    except FolderError:  # not begun; what is damaged is reported in its row
        return {}
