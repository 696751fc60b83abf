"""Two blocks in contact by plane finite elements: their normal and tangential stiffness."""
