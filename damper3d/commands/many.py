"""What the commands that compute many runs share: lists of numbers, and how they end."""

from collections.abc import Sequence
from typing import Any

from granulab.campaign.cli.commandline import Ended


def numbers(option: str, text: str | None, default: Sequence[float]) -> tuple[float, ...]:
    """The numbers of a list such as "20,40,80"; InputError where one is none."""
    if text is None:
        return tuple(default)
    from granulab.errors import InputError

    try:
        return tuple(float(word) for word in text.split(",") if word.strip())
    except ValueError:
        cure = "write numbers with commas, such as 20,40,80"
        raise InputError(f"{option} {text!r}: {cure}") from None


def stop_unless_whole(rows: Sequence[dict[str, Any]]) -> None:
    """End the command where runs were interrupted (code 130) or failed (3)."""
    lost = [row["reason"] for row in rows if row["state"] == "interrupted"]
    if lost:
        why = next((reason for reason in lost if reason.endswith("went away")), "stopped")
        raise Ended(f"{why}; the same command goes on from there", 130)
    failed = [row["reason"] for row in rows if row["state"] == "failed"]
    if failed:
        raise Ended(f"{len(failed)} of {len(rows)} runs failed, the first: {failed[0]}", 3)
