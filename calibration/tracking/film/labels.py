"""Words in figures and films: a scale bar of round length, a value with its sigma."""

import math

_UNITS = ((1.0, "m"), (1e-2, "cm"), (1e-3, "mm"), (1e-6, "µm"))


def scale_bar(longest: float) -> tuple[float, str]:
    """The longest of 1, 2, 5 x 10^n [m] that is not above `longest` [m], and its words."""
    power = 10.0 ** math.floor(math.log10(longest))
    length = power * max(k for k in (1, 2, 5) if k * power <= longest)
    size, unit = next((one for one in _UNITS if length >= 0.999 * one[0]), _UNITS[-1])
    return length, f"{length / size:.3g} {unit}"


def with_sigma(value: float, sigma: float | None) -> str:
    """Both to the first place of sigma, two to four of them; "0.80" where it is not known."""
    if sigma is None or not sigma > 0:
        return f"{value:.2f}"
    places = min(max(-math.floor(math.log10(sigma)), 2), 4)
    return f"{value:.{places}f} \N{PLUS-MINUS SIGN} {max(sigma, 10.0**-places):.{places}f}"
