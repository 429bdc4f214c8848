#!/usr/bin/env python3
"""kills.py ANGIO FOLDER [--moments N] [--until STAGE] [--seed N] [--markdown FILE]

kill -9 at random moments over a run and over a batch. A sequence is one to three kills, each at a moment drawn
evenly from the time that the work takes, then the same command to its end. It has passed if that ends with 0, if
every file is as of a run that nobody killed (but for times), and if the kill left no process and no temporary file.
"""
import argparse
import datetime
import os
import pathlib
import platform
import random
import shutil
import signal
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
parser = argparse.ArgumentParser()
parser.add_argument("program", type=pathlib.Path)
parser.add_argument("folder", type=pathlib.Path)
parser.add_argument("--moments", type=int, default=200)
parser.add_argument("--until", default="report")
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--markdown", type=pathlib.Path)
options = parser.parse_args()
PROGRAM = str(options.program.resolve())
FOLDER = options.folder.resolve()
COMPARE = str(HERE.parent / "tests" / "workflow" / "compare_batches.py")
PHANTOM = "phantom:concentric,length=16,spacing=0.5,stenosis=60,seed=%d"


def processes():
    """Those of the program: every process whose executable it is."""
    found = set()
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if os.readlink(entry / "exe") == PROGRAM and f"{FOLDER}/" in (entry / "cmdline").read_text():
                    found.add(int(entry.name))
            except OSError:
                pass
    return found


def start(command, log):
    return subprocess.Popen(command, stdout=log, stderr=log, env={**os.environ, "TMPDIR": str(FOLDER / "tmp")})


def run_through(command):
    began = time.monotonic()
    with open(FOLDER / "log", "w", encoding="utf-8") as log:
        code = start(command, log).wait()
    return code, time.monotonic() - began


def kill_at(command, seconds):
    """@return whether it was still at work, and whether anything of it lives two seconds later"""
    with open(FOLDER / "log", "w", encoding="utf-8") as log:
        work = start(command, log)
        try:
            work.wait(seconds)
            return False, False
        except subprocess.TimeoutExpired:
            os.kill(work.pid, signal.SIGKILL)
            work.wait()
    deadline = time.monotonic() + 2.0  # a case hears of its parent's death, and ends in a second
    while processes() and time.monotonic() < deadline:
        time.sleep(0.05)
    return True, bool(processes())


def same(first, second):
    return subprocess.run([sys.executable, COMPARE, str(first), str(second)], capture_output=True, text=True, check=False)


class Trial:
    """One kind of work: a run or a batch, in OUTPUT."""

    def __init__(self, name, command):
        self.name, self.command = name, command
        self.reference = FOLDER / (name + "-reference")
        code, self.seconds = run_through(command(self.reference))
        assert code == 0, f"{name}: the reference ended with {code}, see {FOLDER / 'log'}"
        self.kills = self.sequences = self.failed = self.orphans = self.leftovers = 0

    def sequence(self, dice, most):
        output = FOLDER / (self.name + "-killed")
        shutil.rmtree(output, ignore_errors=True)
        moments = [dice.uniform(0.0, self.seconds) for _ in range(min(most, dice.randint(1, 3)))]
        for moment in moments:
            at_work, lives_on = kill_at(self.command(output), moment)
            self.kills += at_work
            self.orphans += lives_on
        code, _ = run_through(self.command(output))
        for folder in (self.reference, output):  # a run has none
            (folder / "summary.csv").touch()
        compared = same(self.reference, output)
        if code != 0 or compared.returncode != 0:
            self.failed += 1
            print(f"{self.name}, killed after {moments}: exit code {code}\n{compared.stdout}", flush=True)
            shutil.copytree(output, FOLDER / f"failed-{self.name}-{self.sequences}", dirs_exist_ok=True)
        self.leftovers += len(list((FOLDER / "tmp").iterdir())) + len(list(output.rglob(".*.tmp-*")))
        self.sequences += 1
        return len(moments)


def main():
    shutil.rmtree(FOLDER, ignore_errors=True)
    (FOLDER / "tmp").mkdir(parents=True)
    manifest = FOLDER / "cohort.csv"
    manifest.write_text("case,input\n" + "".join(f'c{n},"{PHANTOM % n}"\n' for n in range(3)), encoding="utf-8")
    shared = ["--preset", "draft", "--until", options.until, "--backend", "cpu", "--quiet"]
    # A run's case lies in a folder of its own, so that both are compared alike.
    trials = [Trial("run", lambda out: [PROGRAM, "run", PHANTOM % 0, "-o", str(out / "c0"), *shared]),
              Trial("batch", lambda out: [PROGRAM, "batch", str(manifest), "-o", str(out), "-j", "2", "--resume", *shared])]
    dice = random.Random(options.seed)
    done = 0
    while done < options.moments:
        trial = trials[0] if dice.random() < 0.7 else trials[1]
        done += trial.sequence(dice, options.moments - done)
    rows = [f"| {t.name} | {t.seconds:.1f} | {t.sequences} | {t.kills} | {t.failed} | {t.orphans} | {t.leftovers} |"
            for t in trials]
    commit = subprocess.run(["git", "-C", str(HERE), "describe", "--always", "--dirty", "--abbrev=12", "--exclude", "*"],
                            capture_output=True, text=True, check=False).stdout.strip()
    text = "\n".join([
        "# kill -9 at random moments", "",
        f"- Command: `benchmarks/kills.py ANGIO FOLDER --moments {options.moments} --until {options.until} "
        f"--seed {options.seed}`",
        f"- Commit: {commit}, measured on {datetime.date.today()}",
        f"- Program: {subprocess.run([PROGRAM, '--version'], capture_output=True, text=True, check=True).stdout.strip()}",
        f"- Machine: {os.cpu_count()} cores, {platform.machine()}; beside other work", "",
        f"{done} moments were drawn; a moment after the work's end kills nothing. After the last of a sequence the same "
        "command must end with 0, every file being that of a run that nobody killed.", "",
        "| what | seconds alone | sequences | kills at work | failed or other bytes | processes that lived on | "
        "temporary files left |", "|---|---|---|---|---|---|---|", *rows]) + "\n"
    print(text)
    if options.markdown:
        options.markdown.write_text(text, encoding="utf-8")
    return 1 if any(t.failed or t.orphans or t.leftovers for t in trials) else 0


sys.exit(main())
