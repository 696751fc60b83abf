"""Claims of the sources as data: read from TOML, judged by a few rules over quantities."""
