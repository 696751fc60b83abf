"""Loads on a silo in words, pictures and one page: runs compared with the closed forms."""
