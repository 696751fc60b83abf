"""Pages: one HTML file each, which holds all that it shows and needs no network."""
