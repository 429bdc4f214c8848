#!/usr/bin/env python3
"""cost.py --cores N CASE... [--markdown FILE]

What a cohort takes: from case folders that were run on N cores with nothing beside them, the core hours, memory and
storage of a case, then of a thousand and of a million, with the arithmetic. Exit codes: 0 done, 64 usage, 65 a folder
is no finished case.
"""
import argparse
import datetime
import json
import os
import pathlib
import platform
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
# What `--keep minimal` leaves (docs/contract.md).
KEPT = ("case.toml", "run.json", "metrics.json", "report/", "centerline/", "meshing/placement.json",
        "simulation/timeseries.csv", "simulation/lumen_profile.csv", "simulation/summary.json")
NODE_CORES, NIGHT_HOURS = 64, 12
COHORTS = (1_000, 1_000_000)
STAGES = ("reconstruction", "segmentation", "centerline", "meshing", "simulation", "report")

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("cases", nargs="+", type=pathlib.Path)
parser.add_argument("--cores", type=int, required=True)
parser.add_argument("--markdown", type=pathlib.Path)


def read(case):
    try:
        run = json.loads((case / "run.json").read_text(encoding="utf-8"))
        seconds = {name: stage["seconds"] for name, stage in run["stages"].items() if stage["status"] == "done"}
        memory = max(stage["peak_memory_mib"] for stage in run["stages"].values() if stage["status"] == "done")
    except (OSError, KeyError, ValueError) as error:
        print(f"cost.py: {case.name} is no finished case ({error}). Run angio run INPUT -o CASE", file=sys.stderr)
        sys.exit(65)
    sizes = {str(path.relative_to(case)): path.stat().st_size for path in case.rglob("*") if path.is_file()}
    kept = sum(size for name, size in sizes.items() if name.startswith(KEPT) and "narrowed_lumen" not in name)
    on_gpu = run["stages"]["simulation"]["solver_seconds"] if run.get("backend") == "cuda" else 0.0
    return {"name": case.name, "seconds": seconds, "memory": memory, "all": sum(sizes.values()), "kept": kept,
            "gpu": on_gpu}


def table(header, rows):
    return ["| " + " | ".join(header) + " |", "|" + "---|" * len(header),
            *("| " + " | ".join(str(cell) for cell in row) + " |" for row in rows)]


def count(number):
    return f"{number:,.0f}" if number >= 10 else f"{number:.2g}"


def storage(byte_count):
    for unit, size in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if byte_count >= size:
            return f"{byte_count / size:.3g} {unit}"
    return f"{byte_count / 1e3:.3g} kB"


def main():
    options = parser.parse_args()
    cases = [read(case) for case in options.cases]
    stages = [name for name in STAGES if any(name in case["seconds"] for case in cases)]
    commit = subprocess.run(["git", "-C", str(HERE), "describe", "--always", "--dirty", "--abbrev=12", "--exclude", "*"],
                            capture_output=True, text=True, check=False).stdout.strip()
    lines = ["# What a cohort takes", "",
             "- Command: `angio run INPUT -o CASE --backend cpu`, then "
             f"`benchmarks/cost.py --cores {options.cores} CASE...`",
             f"- Commit: {commit}, measured on {datetime.date.today()}",
             f"- Machine: {os.cpu_count()} cores, {platform.machine()}", "",
             "## A case", "",
             *table(["case", *(f"{stage} s" for stage in stages), "whole s", "GPU s", "memory MiB", "all files",
                     "`--keep minimal`"],
                    [[case["name"], *(f"{case['seconds'].get(stage, 0.0):.1f}" for stage in stages),
                      f"{sum(case['seconds'].values()):.0f}", f"{case['gpu']:.0f}", f"{case['memory']:.0f}",
                      storage(case["all"]), storage(case["kept"])] for case in cases]),
             "", "## Cohorts", "",
             f"Core hours = whole s x {options.cores} cores / 3600 x cases; GPU hours likewise of GPU s. Nights = core "
             f"hours / ({NODE_CORES} cores of a node x {NIGHT_HOURS} h), for one node. Storage = bytes x cases. Memory "
             f"that a node of {NODE_CORES} cores needs = MiB x {NODE_CORES} / {options.cores}. Extrapolated, not run: "
             "cases are processes of their own, so that nothing but the file system is shared.", ""]
    rows = []
    for case in cases:
        hours = sum(case["seconds"].values()) * options.cores / 3600.0
        for size in COHORTS:
            rows.append([case["name"], f"{size:,}", count(hours * size), count(case["gpu"] / 3600.0 * size),
                         count(hours * size / (NODE_CORES * NIGHT_HOURS)),
                         storage(case["memory"] * 2**20 * NODE_CORES / options.cores), storage(case["all"] * size),
                         storage(case["kept"] * size)])
    lines += table(["cases like", "number", "core hours", "GPU hours", "nights of a node", "node's memory", "all files",
                    "`--keep minimal`"], rows)
    text = "\n".join(lines) + "\n"
    print(text)
    if options.markdown:
        options.markdown.write_text(text, encoding="utf-8")


main()
