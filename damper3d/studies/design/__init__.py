"""Design of a damper for a structure: candidates, fields, a surrogate, verification, a page."""
