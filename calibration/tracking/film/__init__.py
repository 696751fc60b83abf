"""Films as files: frames, time stamps, regions and drawings on frames."""
