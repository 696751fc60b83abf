"""Commands that take a bed from prescribed motion to the structure that it damps."""
