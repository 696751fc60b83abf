"""Size of pages and what a frame of them costs in headless Chromium, without a graphics card.

`python benchmarks/player.py` runs three cases where they are not there yet (in --out, default
runs/player), writes their pages and plays them: 650 polygons in 500 frames with contacts in each,
358 spheres and 90 prolates of 51 sub-spheres in 301 frames each. For each page, as it opens and
with contact network and wall forces:

    median, 90 %   [ms] of wall time from one frame drawn to the next, which includes that the
                   browser has composed the page; frames of the whole run in turn
    CPU            [ms] of all processes of the browser a frame; as wall time counts what others do
                   on the machine too, this is what to compare
"""

import argparse
import shutil
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

import psutil

ARGUMENTS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-frame-rate-limit", "--disable-gpu-vsync",  # else a frame takes 16.7 ms at least
]  # fmt: skip
SIZE = {"width": 1280, "height": 800}
FRAMES = 100  # that are timed

# D4 for half a second: at its end 440 of the particles are left.
SILO = {"frame_interval": "1 ms", "contact_interval": "1 ms", "max_time": "500 ms"}
DAMPER = ["--frequency", "40", "--gamma", "20", "--frames", "20", "--cycles", "15"]
CASES = {
    "650 polygons x 500": ("silo2d", ["run", "{case}"]),
    "358 spheres x 301": ("damper3d", ["run", *DAMPER]),
    "90 prolates x 301": ("damper3d", ["run", "--particles", "prolate:1.5", *DAMPER]),
}
# Draws frames in turn and waits for each to be composed; reading a pixel waits for the card.
PLAY = """async (count) => {
  const { gl } = player.view, pixel = new Uint8Array(4), times = [];
  const composed = () => new Promise((done) => requestAnimationFrame(done));
  await composed();
  for (let k = 0; k < count; k++) {
    const start = performance.now();
    player.state.frame = Math.floor(k * player.frames / count);
    player.render();
    if (gl) gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    await composed();
    times.push(performance.now() - start);
  }
  return times;
}"""


def main() -> None:
    """Run the cases, write their pages, play them and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("runs/player"))
    out = parser.parse_args().out
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("no chromium on this machine; on Debian: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    print(f"{'page':20} {'MB':>5}  {'shown':12} {'median':>7} {'90 %':>7} {'CPU':>6}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        for name in CASES:
            page = made(name, out)
            for shown, keys in (("particles", []), ("with forces", ["n", "b"])):
                times, cpu = played(browser, page, keys)
                median, most = statistics.median(times), statistics.quantiles(times, n=10)[-1]
                size = page.stat().st_size / 1e6
                print(f"{name:20} {size:5.2f}  {shown:12} {median:7.1f} {most:7.1f} {cpu:6.1f}")
        browser.close()


def made(name: str, out: Path) -> Path:
    """The page of a case, whose run is made where it is not there."""
    package, words = CASES[name]
    out.mkdir(parents=True, exist_ok=True)
    case = out / "silo.toml"
    case.unlink(missing_ok=True)
    command = [sys.executable, "-m", package]
    subprocess.run([*command, "init", str(case), "--from", "D4"] if package == "silo2d" else
                   [*command, "--version"], check=True, capture_output=True)  # fmt: skip
    if package == "silo2d":
        case.write_text(changed(case.read_text("utf-8"), SILO), "utf-8")
    words = [word.format(case=case) for word in words]
    done = subprocess.run(
        [*command, *words, "--page", "--no-figures", "--quiet", "--json", "--out", str(out)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return Path(" ".join(done.stderr.split("page ", 1)[1].split(":")[0].split()))


def changed(text: str, keys: dict[str, str]) -> str:
    """A case file with other values of some keys, commented or not."""
    lines = []
    for line in text.splitlines():
        key = line.removeprefix("# ").partition(" =")[0]
        lines.append(f'{key} = "{keys[key]}"' if key in keys else line)
    return "\n".join(lines) + "\n"


def played(browser: Any, page: Path, keys: list[str]) -> tuple[list[float], float]:
    """Times [ms] from frame to frame of a page, and the CPU time of the browser a frame [ms]."""
    window = browser.new_page(viewport=SIZE)
    window.goto(page.resolve().as_uri())
    while not window.evaluate("typeof player !== 'undefined'"):
        window.wait_for_timeout(50)
    for key in keys:
        window.keyboard.press(key)
    window.evaluate(PLAY, 10)
    before = cpu_seconds()
    times = window.evaluate(PLAY, FRAMES)
    cpu = cpu_seconds() - before
    window.close()
    return times, 1e3 * cpu / FRAMES


def cpu_seconds() -> float:
    """CPU time of the processes that this one started, so far."""
    total = 0.0
    for process in psutil.Process().children(recursive=True):
        try:
            total += sum(process.cpu_times()[:2])
        except psutil.NoSuchProcess:
            continue
    return total


if __name__ == "__main__":
    main()
