"""Pictures, films, tables and words of runs, read from their folders."""
