"""Attraction: how often contacts of a law that may pull did so, and how strongly."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Attraction:
    """Contacts looked at so far, those of them that pulled, and the strongest pull."""

    contacts: float = 0
    pulling: float = 0
    strongest: float = 0.0  # [N]

    def look(self, contacts: dict[str, np.ndarray]) -> None:
        """Add the contacts of a moment: normal (c, d) towards, and force (c, d) on, the second [N].

        They pull where the force has a part against the normal.
        """
        pressing = (contacts["force"] * contacts["normal"]).sum(axis=1)
        self.contacts += len(pressing)
        self.pulling += int((pressing < 0.0).sum())
        self.strongest = max(self.strongest, float(-pressing.min(initial=0.0)))

    def numbers(self, particle_weight: float) -> dict[str, float]:
        """Share of the contacts that pulled, and the strongest over a particle's weight [N]."""
        share = self.pulling / self.contacts if self.contacts else 0.0
        return {"share": share, "particle_weights": self.strongest / particle_weight}
