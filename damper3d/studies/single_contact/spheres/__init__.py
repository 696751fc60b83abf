"""One sphere that hits a wall or another sphere."""
