"""Certificates of the motions of a folder: how many motions are certified, how long that and both checkers take, and
whether both refuse wrong certificates.

    benches/certificates.py PROGRAM CHECKER FOLDER [WRONG]

Every folder in FOLDER has the summary.json of a solve. WRONG certificates are made of those of FOLDER; the Python
checker sees every twentieth of them, and every one of the motions.
"""

import json
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python" / "aghf"))
import check_certificate  # noqa: E402


def robot_of(summary):
    robot = summary["provenance"]["scenario"]["robot"]
    return Path(robot) if robot.endswith(".urdf") else ROOT / "robots" / robot / f"{robot}.urdf"


def python_code(texts):
    """The exit code of the Python checker, and the reason of a refusal."""
    try:
        return (0 if check_certificate.check(*texts).is_complete else 4), ""
    except check_certificate.Refused as fault:
        return 1, str(fault)


def spoil(certificate, rng):
    """Changes one thing of a certificate to something wrong; the kind of it, or `None` where it is not possible."""
    intervals = certificate["intervals"]
    i = rng.randrange(len(intervals))
    count = len(certificate["promises"])
    kinds = ["hash", "key", "bound", "left out", "overlap", "NaN", "cut", "end", "place", "direction"]
    kind = rng.choice(kinds)
    if kind == "hash":
        of = rng.choice(["robot_sha256", "run_sha256"])
        certificate[of] = certificate[of][:-1] + ("0" if certificate[of][-1] != "0" else "1")
    elif kind == "key":
        key = rng.choice(list(certificate["keys"]))
        certificate["keys"][key] = rng.choice(["left out", "left out: a reason", f"{certificate['keys'][key]} "])
        certificate["complete"] = True
    elif kind == "bound" and count:
        k = rng.randrange(count)
        # Claims of rows are within a fiftieth of what is true, those of small clearances of balls closer, unless they
        # are cut off; no claim is above one.
        promise, claim = certificate["promises"][k], intervals[i][3][k]
        is_clear = promise in ("obstacles", "self_collision")
        intervals[i][3][k] += (0.002 if claim < 0.04 else 10.0) if is_clear else 0.06 if claim < 0.9 else 10.0
    elif kind == "left out":
        del intervals[i]
    elif kind == "overlap":
        intervals.insert(i, intervals[i])
    elif kind == "end":
        intervals[i][rng.randrange(1, 3)] += rng.choice([-1e-12, 1e-12])
    elif kind == "place" and ("goal" in certificate or certificate["waypoints"]):
        if "goal" in certificate:
            certificate["goal"] += 2e-6
        else:
            place = rng.choice(certificate["waypoints"])
            place[rng.choice([1, 2])] += 1e-3
    elif kind == "direction" and intervals[i][4]:
        rng.choice(intervals[i][4])[2] = rng.choice([[0.0, 0.0, 0.0], [1.0, 0.0], None])
    elif kind == "NaN" and count:
        intervals[i][3][rng.randrange(count)] = float("nan")
    elif kind != "cut":
        return None
    return kind


def measure(program, checker, folders):
    """Certifies and checks every motion; the ones that are certified."""
    found, times = [], {"certify": [], "rust": [], "python": [], "kB": []}
    for folder in folders:
        summary = json.loads((folder / "summary.json").read_text())
        out = folder / "certificate.json"
        begin = time.perf_counter()
        command = [program, "certify", folder / "summary.json", folder / "summary.json", "-o", out, "--force"]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode not in (0, 4):
            print(f"{folder.name}: {run.stdout.strip()}{run.stderr.strip()}")
            continue
        seconds = run.stdout.rsplit(" s)", 1)[0].rsplit("(", 1)[1]
        times["certify"].append(float(seconds))
        files = [robot_of(summary), folder / "summary.json", folder / "summary.json", out]
        begin = time.perf_counter()
        run = subprocess.run([checker, *files], capture_output=True, text=True, check=False)
        times["rust"].append(time.perf_counter() - begin)
        texts = [file.read_bytes().decode() for file in files]
        begin = time.perf_counter()
        code, fault = python_code(texts)
        times["python"].append(time.perf_counter() - begin)
        times["kB"].append(len(texts[3]) / 1000)
        if run.returncode == 1 or run.returncode != code:
            print(f"{folder.name}: {run.stderr.strip()}; Python: {fault}")
            continue
        found.append((folder, texts))
    print(f"{len(found)} of {len(folders)} motions are certified and accepted by both checkers")
    complete = sum(json.loads(texts[3])["complete"] for _, texts in found)
    print(f"{complete} of them in all promises")
    for what, values in times.items():
        if values:
            print(f"{what}: median {statistics.median(values):.4f}, largest {max(values):.4f}")
    return found


def spoilt(checker, found, count):
    rng, refused, kinds = random.Random(38), 0, {}
    with tempfile.TemporaryDirectory() as folder:
        wrong = Path(folder) / "wrong.json"
        while refused < count:
            place, texts = rng.choice(found)
            certificate = json.loads(texts[3])
            kind = spoil(certificate, rng)
            if kind is None:
                continue
            text = json.dumps(certificate)
            wrong.write_text(text[: rng.randrange(len(text) - 2)] if kind == "cut" else text)
            files = [robot_of(json.loads(texts[1])), place / "summary.json", place / "summary.json", wrong]
            run = subprocess.run([checker, *files], capture_output=True, text=True, check=False)
            by_python = refused % 20 == 0 and python_code([*texts[:3], wrong.read_text()])[0] != 1
            if run.returncode != 1 or by_python:
                sys.exit(f"{place.name}: a wrong certificate ({kind}) is accepted")
            refused += 1
            kinds[kind] = kinds.get(kind, 0) + 1
    print(f"{refused} wrong certificates are refused: {kinds}")


def main(program, checker, folder, count="0"):
    folders = sorted(path.parent for path in Path(folder).glob("*/summary.json"))
    found = measure(program, checker, folders)
    spoilt(checker, found, int(count))


if __name__ == "__main__":
    main(*sys.argv[1:])
