"""The motional phases of a run, from its folder: motion, measures, criteria, phase map."""

from damper3d.measures.phases.criteria import classify, phase_of_run

__all__ = ["classify", "phase_of_run"]
