"""Studies other than the shaken run: single contacts, slow tests, packing, maps, closed forms."""
