"""Every recording of others, the command that measures it, its answer and the reference.

    python benchmarks/recordings.py FOLDER docs/results/calibration/recordings.txt

FOLDER holds the recordings, which their licences keep out of this repository. References were
measured apart from this project: a parabola through each flight, contacts where neighbouring
parabolas meet, restitution as the ratio of flight times.
"""

import argparse
import shlex
import subprocess
import sys
from pathlib import Path

SOURCES = """Recordings, by the repository that publishes them:
bounceAmeen.avi            arzafiruddin/BouncingBall
andwel11_*                 andwel11/Particle-Tracking-Velocimetry-for-a-Bouncing-Ball
pingpongvid2.mov           zakilyawatsonjarrett/PTV-restitution-coefficient-home-experiment
necrosskull_*              necrosskull/opencv_pendulum (MIT)
keremsirtikizil_*          keremsirtikizil/Executable-Environment-Models
Audio_1.wav                Fr4nci/relazione_rimbalzi
A4_*.csv, V_*.csv          XS06/2025-Projects
stopwatch_*, golf_*, heights_*   giiulia/LabI-Dynamics-Thermodynamics
openpiv_*                  OpenPIV/openpiv-python-examples (MIT)
webb_*                     willowebb/Axisymmetric-saturated-granular-column-collapses (CC BY 4.0)"""
RECORDINGS = (
    ("drop bounceAmeen.avi",
     "flights 0.508, 0.359, 0.258, 0.189 s; e 0.706, 0.719, 0.730 (0.012)"),
    ("drop bounceAmeen.avi --scale '0.808 mm/px'",
     "g of the free fall 9.6 to 9.8 m/s2; the ball comes nearer as it bounces"),
    ("drop andwel11_ping_pong_ball_at_height_2-1.mp4", "e 0.761, 0.804, 0.816 (0.015)"),
    ("drop andwel11_tennis_ball-1.mp4",
     "frames were dropped in recording: to be said, and no small sigma"),
    ("drop pingpongvid2.mov",
     "every picture stands twice, 30.016 a second; e 0.853, 0.851, 0.872, 0.871 (0.006)"),
    ("pendulum necrosskull_ball_on_string_wall.mp4", "e 0.79 (0.03); the swing is not plane"),
    ("pendulum keremsirtikizil_newtons_cradle.mp4", "five balls: to be refused"),
    ("drop keremsirtikizil_droplet.mp4", "a drop of water, header wrong 400-fold: to be refused"),
    ("drop keremsirtikizil_newtons_cradle.mp4", "no drop: to be refused"),
    ("impacts Audio_1.wav",
     "impacts at 0.5474, 1.1002, 1.5456, 1.9076, 2.1994 s; e 0.806, 0.813, 0.806 (0.005)"),
    ("drop A4_1-60-M.csv", "contacts at frames 80.72, 147.36, 182.63; e 0.529 (0.01)"),
    ("drop V_18-7_Results_100_1018.csv",
     "contacts at frames 231.31, 282.46, 317.50, 342.77; e 0.685, 0.721 (0.01)"),
    ("drop A4_1-1-M.csv", "none: too noisy"),
    ("impacts stopwatch_blue_1_55cm.xls",
     "ratios 0.873 0.874 0.891 0.902 0.890 0.902 0.886; 1.69 and 0.43 are no bounces"),
    ("impacts stopwatch_blue_2_55cm.xls", "ratios 0.880 0.876 0.882 0.879 0.886 0.873"),
    ("impacts stopwatch_pingpong_1_18cm.xlsx",
     "ratios 0.931 0.940 0.940 0.943 0.943 0.945 0.945 0.941: rise slowly, air"),
    ("impacts golf_intervals.xlsx", "first ratios 0.889, 0.896, 0.895, 0.897 at 80 cm"),
    ("heights heights_blue_ball.csv",
     "65 cm 0.874, 55 0.874, 45 0.913, 35 0.893, 25 0.861 (each 0.008); not one number"),
    ("piv openpiv_test14_disp_096a.bmp openpiv_test14_disp_096b.bmp",
     "(3.00, 3.00) px everywhere"),
    ("piv openpiv_test1_exp1_001_a.bmp openpiv_test1_exp1_001_b.bmp", "none: a real flow"),
    ("flow webb_04g_010w_cam1.mp4 --collapse --fps 240",
     "the front of webb_04g_010w.txt; 240 frames/s where the file says 120"),
)  # fmt: skip


def answer(command: str, folder: Path) -> str:
    """What a calibrate command prints in the folder, with its exit code where it refuses."""
    done = subprocess.run(
        [sys.executable, "-m", "calibration", *shlex.split(command), "--quiet"],
        capture_output=True, text=True, check=False, cwd=folder, timeout=600,
    )  # fmt: skip
    said = (done.stdout + done.stderr).strip()
    return said if not done.returncode else f"{said}\n(refused, exit code {done.returncode})"


def main() -> None:
    """Measure each recording, and write what was said."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("file", type=Path)
    options = parser.parse_args()
    said = ["python benchmarks/recordings.py FOLDER docs/results/calibration/recordings.txt",
            "", SOURCES]  # fmt: skip
    for command, reference in RECORDINGS:
        shown = f"$ calibrate {command}\n{answer(command, options.folder)}\nreference: {reference}"
        print(f"\n{shown}", flush=True)
        said += ["", shown]
    options.file.write_text("\n".join(said) + "\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
