"""The job script of the page on sweeps, run by stand-ins of SLURM's sbatch and srun."""

import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages import files_of, plain_environment
from small_silo import write_case

PAGE = Path(__file__).parents[2] / "docs" / "runs" / "sweeps.md"
# As SLURM does: options on the command line before those of the script, the script copied, its
# output in a file, its environment; at its end all that is left of the job is killed.
SBATCH = r"""#!/bin/bash
[ "$1" = --wait ] && shift
ntasks=$(sed -n 's/^#SBATCH --ntasks=//p' "${!#}")
case $1 in --ntasks=*) ntasks=${1#*=}; shift ;; esac
export SLURM_JOB_ID=7 SLURM_NTASKS=$ntasks SLURM_JOB_NODELIST=$(hostname)
cp "$1" spooled
setsid bash spooled > slurm-7.out 2>&1 &
job=$!
wait $job
code=$?
kill -9 -- -$job 2> /dev/null
exit $code
"""
# The command once for each task, which it tells apart; a signal is passed on to them.
SRUN = r"""#!/bin/bash
ntasks=$SLURM_NTASKS
case $1 in --ntasks=*) ntasks=${1#*=}; shift ;; esac
trap 'kill $(jobs -p)' TERM
for ((k = 0; k < ntasks; k++)); do
    echo "task $k of $ntasks" >> tasks.log
    SLURM_PROCID=$k SLURM_LOCALID=$k SLURM_NODEID=0 "$@" &
done
wait
"""


@pytest.mark.skipif(
    sys.platform != "linux" or not shutil.which("openssl"), reason="a script for Linux"
)
def test_job_of_the_page_makes_the_table_to_the_same_bits(tmp_path):
    """Two workers, as the third task is left for the sweep; its certificate does not stay."""
    small = write_case(tmp_path)
    (tmp_path / "friction.toml").write_text(
        'schema = 1\nname = "friction"\ncase = "small.toml"\nseeds = 2\n', encoding="utf-8"
    )
    script = files_of(PAGE.read_text(encoding="utf-8"))["sweep.sbatch"]
    (tmp_path / "sweep.sbatch").write_text(script)
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, text in (("sbatch", SBATCH), ("srun", SRUN)):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)
    environment = plain_environment()
    environment["PATH"] = f"{programs}:{environment['PATH']}"
    words = ["sbatch", "--wait", "--ntasks=3", "sweep.sbatch"]
    job = subprocess.run(words, cwd=tmp_path, env=environment, timeout=600, check=False)
    output = (tmp_path / "slurm-7.out").read_text()
    assert job.returncode == 0, output
    assert (tmp_path / "tasks.log").read_text().split("\n")[:-1] == ["task 0 of 2", "task 1 of 2"]
    (table,) = tmp_path.glob("runs/studies/friction-*/table.csv")
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["seed"], row["state"]) for row in rows] == [("1", "done"), ("2", "done")]
    words = ["silo2d", "run", small, "--seed", "2", "--json", "--no-figures", "--out", "alone"]
    alone = subprocess.run(words, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, check=True)
    assert rows[1]["state_digest"] == json.loads(alone.stdout)["state_digest"]
    assert not list(tmp_path.glob("job-*"))
