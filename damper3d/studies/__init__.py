"""Studies beside the shaken run: single contacts, slow tests, packing, maps, closed forms."""
