"""Output: tables, figures, films, statistics and files for ParaView."""
