"""The contact parameters of the sensitivity runs: two baselines, and one parameter varied.

The paper does not say what its Tables 7 to 11 start from. Their rows of 0.99 s show it: Table 7 has
gamma_n = 4000 1/s at kn = 1e4 N/mm; Table 9 gives 0.99 s at mu = 0.40, for all contacts; Table 10
at gamma_n of 2000 and 4000 1/s; Table 11 at gamma_t of 0 and 3 1/s; Table 8 at kt of 1000 and
2500 N/mm, the range of kt/kn that section 5 names, 0.1 to 0.25. The implied baseline takes of
these gamma_n = 4000 1/s, as Table 7 does, kt = 1000 N/mm, the nearer to Table 4's 650, and
gamma_t = 3 1/s, Table 4's. One gamma_n is printed, so both pairs have it.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Literal

Pairs = Literal["both", "particle", "wall"]


@dataclass(frozen=True)
class Parameters:
    """Of the linear contact law; stiffnesses are those of all contacts."""

    kn: float  # [N/mm]
    kt: float  # [N/mm]
    mu_particle: float  # [-]
    mu_wall: float  # [-]
    gamma_n: float  # between particles [1/s]
    gamma_n_wall: float  # [1/s]
    gamma_t: float  # [1/s]

    def changes(self) -> dict[str, Any]:
        """Return what a case needs to have them; nothing of what it has anyway, from Table 4."""
        written = {
            "law.kn": _written(self.kn, "N/mm"),
            "law.kt": _written(self.kt, "N/mm"),
            "law.mu_particle": self.mu_particle,
            "law.mu_wall": self.mu_wall,
            "law.gamma_n": _written(self.gamma_n, "1/s"),
            "law.gamma_n_wall": _written(self.gamma_n_wall, "1/s"),
            "law.gamma_t": _written(self.gamma_t, "1/s"),
        }
        if self == TABLE_4:
            return {}
        usual = {f"law.{f.name}": getattr(TABLE_4, f.name) for f in dataclasses.fields(self)}
        own = {f"law.{f.name}": getattr(self, f.name) for f in dataclasses.fields(self)}
        other = {key for key in own if own[key] != usual[key]}
        if other & {"law.gamma_n", "law.gamma_n_wall"}:  # alone, the first would scale the second
            other |= {"law.gamma_n", "law.gamma_n_wall"}
        return {key: value for key, value in written.items() if key in other}

    def varied(self, parameter: str, value: float, pairs: Pairs = "both") -> "Parameters":
        """With one parameter at another value [N/mm, 1 or 1/s].

        kn takes kt and the damping along: kt/kn and gamma_n/omega_0, hence gamma_n/sqrt(kn), stay
        (sec. 4.3.1). gamma_n keeps the ratio of its two pairs.
        """
        if parameter == "kn":
            stiffer = value / self.kn
            return dataclasses.replace(
                self,
                kn=value,
                kt=self.kt * stiffer,
                gamma_n=self.gamma_n * math.sqrt(stiffer),
                gamma_n_wall=self.gamma_n_wall * math.sqrt(stiffer),
            )
        if parameter == "mu":
            names = {"both": ("particle", "wall")}.get(pairs, (pairs,))
            return dataclasses.replace(self, **{f"mu_{name}": value for name in names})
        if parameter == "gamma_n":
            wall = value * self.gamma_n_wall / self.gamma_n
            return dataclasses.replace(self, gamma_n=value, gamma_n_wall=wall)
        return dataclasses.replace(self, **{parameter: value})


def _written(value: float, unit: str) -> str:
    """Ten digits: the same value has the same bits whichever way it was reckoned."""
    return f"{value:.10g} {unit}"


TABLE_4 = Parameters(1e4, 650, 0.38, 0.44, 6085, 4303, 3)
IMPLIED = Parameters(1e4, 1000, 0.40, 0.40, 4000, 4000, 3)
BASELINES = {"Table 4": TABLE_4, "implied": IMPLIED}
