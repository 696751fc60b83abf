"""The subcommands of calibrate, one file each."""
