#!/usr/bin/env python3
"""mutation_trial.py --build DIR --results FILE.csv [--count N] [--seed S] [--folder NAME]... [--markdown FILE]

Which part of small faults the tests find. Draws random places of simulation, segmentation, centerline and pipeline,
changes one operator or constant in each, builds, and runs the tests of that folder until one fails. A change that does
not compile is drawn again. FILE.csv has a line a change; a second run with the same seed goes on where the first one
stopped.

It changes sources where it stands: use a checkout of its own (its files are restored, also after Ctrl-C). Exit codes:
0 done, 64 usage, 65 the tests do not pass as they are, or the checkout has changes.
"""
import argparse
import csv
import datetime
import os
import pathlib
import platform
import random
import re
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# The tests of each folder, the quickest first.
TESTS = {
    "simulation": ("test_simulation_parts", "test_simulation", "test_inflate", "test_solid"),
    "segmentation": ("test_segmentation_reading", "test_segmentation_phantoms", "test_segmentation"),
    "centerline": ("test_centerline",),
    "pipeline": ("test_pipeline", "test_command_line", "test_verify", "test_inputs", "test_one_number", "test_cohort"),
}
NO_GPU_HERE = re.compile(r"cuda|gpu", re.IGNORECASE)
TIMEOUT_S = 900
OPERATORS = {"+": "-", "-": "+", "*": "/", "/": "*", "<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=",
             "!=": "==", "&&": "||", "||": "&&", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
OPERATOR = re.compile(r"(?<=[\w)\]] )(" + "|".join(re.escape(o) for o in sorted(OPERATORS, key=len, reverse=True)) +
                      r")(?= [\w(\-!~*])")
NUMBER = re.compile(r"(?<![\w.\"])(\d+\.\d+(?:e-?\d+)?|\d+)(?=f?[;,) }\]]|f? [-+*/<>=?:])")
WORD = re.compile(r"\b(true|false|std::min|std::max)\b(?=[(;,) }])")
WORDS = {"true": "false", "false": "true", "std::min": "std::max", "std::max": "std::min"}
# Nothing that a program does.
SKIPPED = re.compile(r"^\s*(//|\*|#|static_assert|template|using|namespace|requires|concept|include)|ANGIO_ASSERT|operator")

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--build", type=pathlib.Path, required=True, help="a configured build folder of this checkout")
parser.add_argument("--results", type=pathlib.Path, required=True)
parser.add_argument("--count", type=int, default=200)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--folder", choices=TESTS, action="append", help="of these alone; may be given again")
parser.add_argument("--markdown", type=pathlib.Path)


def changed_number(text):
    if "." in text or "e" in text:
        value = float(text)
        return repr(1.5 * value) if value else "1.0"
    return str(int(text) + 1)


def changes_of(line):
    """All changes of a line: (column, before, after)."""
    code = line.split("//")[0]
    if SKIPPED.search(code):
        return []
    quoted = [match.span() for match in re.finditer(r'"(?:[^"\\]|\\.)*"', code)]
    found = [(m.start(), m.group(), OPERATORS[m.group()]) for m in OPERATOR.finditer(code)]
    found += [(m.start(), m.group(), changed_number(m.group())) for m in NUMBER.finditer(code)]
    found += [(m.start(), m.group(), WORDS[m.group()]) for m in WORD.finditer(code)]
    return [change for change in found if not any(a <= change[0] < b for a, b in quoted)]


def all_places():
    listed = subprocess.run(["git", "ls-files", *TESTS], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    places = []
    for name in sorted(listed.split()):
        if not name.endswith((".cpp", ".hpp")) or NO_GPU_HERE.search(name):
            continue
        for number, line in enumerate((ROOT / name).read_text(encoding="utf-8").splitlines()):
            places += [(name, number, *change) for change in changes_of(line)]
    return places


def builds(build, test):
    return subprocess.run(["cmake", "--build", build, "--target", test], capture_output=True).returncode == 0


def passes(build, test):
    environment = dict(os.environ, GTEST_FAIL_FAST="1", GTEST_BRIEF="1")
    run = subprocess.run(["ctest", "--test-dir", build, "-R", f"^{test}$", "--timeout", str(TIMEOUT_S)],
                         capture_output=True, env=environment)
    return run.returncode == 0


def outcome_of(build, folder):
    """The test that fails, "" where none does, None where it does not compile."""
    for test in TESTS[folder]:
        if not builds(build, test):
            return None
        if not passes(build, test):
            return test
    return ""


def try_change(build, place):
    name, number, column, before, after = place
    file = ROOT / name
    original = file.read_text(encoding="utf-8")
    lines = original.splitlines(keepends=True)
    line = lines[number]
    lines[number] = line[:column] + after + line[column + len(before):]
    try:
        file.write_text("".join(lines), encoding="utf-8")
        return outcome_of(build, name.split("/")[0])
    finally:
        file.write_text(original, encoding="utf-8")


def write_markdown(path, rows, seed, folders):
    killed = [row for row in rows if row["killed_by"]]
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True,
                            text=True).stdout.strip()
    only = "".join(f" --folder {folder}" for folder in folders or ())
    lines = ["# Faults that the tests find", "",
             f"- Command: `benchmarks/mutation_trial.py --build build/dev --results mutations.csv --count {len(rows)} "
             f"--seed {seed}{only} --markdown docs/results/{path.name}`",
             f"- Commit: {commit}, {datetime.date.today()}",
             f"- Machine: {platform.machine()}, {os.cpu_count()} cores", "",
             "One operator or constant changed at a random place of a folder; the tests of that folder, no others.",
             "", "| folder | changes | found | share |", "| --- | --- | --- | --- |"]
    for folder in (*TESTS, ""):
        own = [row for row in rows if row["file"].startswith(folder)]
        found = [row for row in own if row["killed_by"]]
        if own:
            lines.append(f"| {folder or '**all**'} | {len(own)} | {len(found)} | {100 * len(found) / len(own):.0f} % |")
    lines += ["", f"## Not found ({len(rows) - len(killed)})", "", "| place | before | after |", "| --- | --- | --- |"]
    for row in rows:
        if not row["killed_by"]:
            before, after = (row[key].replace("|", "\\|") for key in ("before", "after"))
            lines.append(f"| {row['file']}:{row['line']} | `{before}` | `{after}` |")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    options = parser.parse_args()
    if subprocess.run(["git", "diff", "--quiet", "--", *TESTS], cwd=ROOT).returncode != 0:
        print("mutation_trial.py: the checkout has changes in what is to be changed. Commit or stash them",
              file=sys.stderr)
        return 65
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(75))
    places = all_places()
    draw = random.Random(options.seed)
    rows = []
    if options.results.exists():
        with options.results.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    fields = ("draw", "file", "line", "before", "after", "killed_by", "seconds")
    folders = sorted(options.folder or TESTS)
    by_folder = {folder: [place for place in places if place[0].startswith(folder + "/")] for folder in folders}
    drawn = int(rows[-1]["draw"]) if rows else 0
    for n in range(10**6):
        place = draw.choice(by_folder[folders[n % len(folders)]])  # as many of each folder
        if n < drawn:
            continue
        if len(rows) >= options.count:
            break
        start = time.monotonic()
        killed_by = try_change(options.build, place)
        if killed_by is None:
            continue
        row = dict(zip(fields, (n + 1, place[0], place[1] + 1, place[3], place[4], killed_by,
                                f"{time.monotonic() - start:.0f}")))
        rows.append({key: str(value) for key, value in row.items()})
        with options.results.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, fields)
            writer.writeheader()
            writer.writerows(rows)
        print(f"{len(rows)} of {options.count}: {place[0]}:{place[1] + 1} {place[3]} -> {place[4]}: "
              f"{killed_by or 'not found'}", flush=True)
    if options.markdown:
        write_markdown(options.markdown, rows, options.seed, options.folder)
    found = sum(bool(row["killed_by"]) for row in rows)
    print(f"{found} of {len(rows)} found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
