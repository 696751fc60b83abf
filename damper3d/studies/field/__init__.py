"""The effective field: a bed's complex effective mass, and a structure's response with it."""

from damper3d.studies.field.balance import respond
from damper3d.studies.field.runs import field_of_runs
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Field, read_field

__all__ = ["Field", "Structure", "field_of_runs", "read_field", "respond"]
