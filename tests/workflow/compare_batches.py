#!/usr/bin/env python3
"""compare_batches.py A B: are two folders of `angio batch` the same, but for how they came about?

Every file of every case is compared byte by byte. run.json, metrics.json and the report may differ where
docs/contract.md says that they do (times and memory, and what hashes these); summary.csv in how often a case was
tried, and by which of several commands it was done. Prints what differs; exit code 1 if something does.
"""
import csv
import json
import pathlib
import sys

TIMES = {"seconds", "peak_memory_mib", "solver_seconds", "time_split_s", "record_sha256", "files", "wall_s",
         "frames_per_second", "real_time_factor"}
HOLD_TIMES = ("report/", "simulation/summary.json")


def without_times(node):
    if isinstance(node, dict):
        return {key: without_times(value) for key, value in node.items()
                if key not in TIMES and not key.startswith(HOLD_TIMES)}
    return [without_times(value) for value in node] if isinstance(node, list) else node


def content(folder, name):
    data = (folder / name).read_bytes()
    if name in ("run.json", "metrics.json") or name.endswith("/summary.json"):
        return without_times(json.loads(data))
    return data


def files_of(folder):
    names = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    return {name for name in names if not name.startswith("report/")}


def summary(folder):
    with open(folder / "summary.csv", newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    for row in rows:
        del row["tries"]
        if row["status"] == "done":
            del row["reason"]
    return rows


def compare(first, second):
    differences = []
    cases = {path.parent.name for root in (first, second) for path in root.glob("*/run.json")}
    for case in sorted(cases):
        a, b = first / case, second / case
        for name in sorted(files_of(a) | files_of(b)):
            if not (a / name).is_file() or not (b / name).is_file():
                differences.append(f"{case}/{name}: in one of them alone")
            elif content(a, name) != content(b, name):
                differences.append(f"{case}/{name}: differs")
    if summary(first) != summary(second):
        differences.append("summary.csv: differs")
    return len(cases), differences


case_count, found = compare(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
print(f"{case_count} cases compared, {len(found)} differences")
for line in found:
    print("  " + line)
sys.exit(1 if found or case_count == 0 else 0)
