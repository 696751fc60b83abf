"""Many runs: studies, sweeps, and the processes or cluster that work on them."""
