"""Files of measurements: tables, tracks and signals in, contact parameters out."""
