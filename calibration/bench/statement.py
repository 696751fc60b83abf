"""A printed number beside what its own parts give, as text and for JSON."""

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Statement:
    """A printed number and what its own ingredients give; units in `what`."""

    what: str
    printed: float
    printed_sd: float | None
    found: float
    sigma: float | None = None
    scatter: float | None = None
    groups_p: float | None = None  # of the hypothesis that the samples are alike
    remark: str = ""


def as_json(found: dict[str, list[Statement]]) -> dict[str, list[dict[str, object]]]:
    """The statements' fields, by table."""
    return {name: [asdict(one) for one in ones] for name, ones in found.items()}


def as_text(found: dict[str, list[Statement]]) -> str:
    """Printed and found side by side, with what is to be said about them below."""
    width = max(len(one.what) for ones in found.values() for one in ones)
    lines = [f"{'':{width}}  {'printed':>16}  {'from its parts':>16}  scatter  p(samples alike)"]
    for name, ones in found.items():
        lines.append(name)
        for one, remark_below in zip(ones, [*(o.remark for o in ones[1:]), None], strict=True):
            sd = "" if one.printed_sd is None else f" +- {one.printed_sd:g}"
            sigma = "" if one.sigma is None else f" +- {one.sigma:.2g}"
            scatter = "-" if one.scatter is None else f"{one.scatter:.2g}"
            p = "" if one.groups_p is None else f"{one.groups_p:.2g}"
            printed, own = f"{one.printed:g}{sd}", f"{one.found:.4g}{sigma}"
            lines.append(
                f"{one.what:{width}}  {printed:>16}  {own:>16}  {scatter:>7}  {p}".rstrip()
            )
            if one.remark and one.remark != remark_below:  # once, below the last it is about
                lines.append(f"  {one.remark}")
    return "\n".join(lines)
