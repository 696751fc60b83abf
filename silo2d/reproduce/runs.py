"""From a table's cases to rows: what they will cost, and the sweep."""

from functools import partial

from granulab.campaign.cli import reproduce
from silo2d.run import sweep

run_all = partial(reproduce.run_all, sweep, sweep.SILO)
run_of_cases = partial(reproduce.run_of_cases, run_all)
