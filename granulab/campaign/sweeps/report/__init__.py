"""Report of many runs: means with intervals over seeds, ranking, pictures, page."""
