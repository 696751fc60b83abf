"""Files with units: quantities, parameter tables, cases and shipped data."""
