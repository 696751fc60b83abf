"""Pictures of a drop test: the diagnostic figure, the annotated film."""
