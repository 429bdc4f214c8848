#!/usr/bin/env python3
"""submit.py JOBSCRIPT: hands a job of Snakemake's to Slurm, and prints its number.

ANGIO_SBATCH holds further options of sbatch: an account, a partition.
"""
import json
import os
import shlex
import sys

MARK = "# properties = "  # Snakemake's own, in every job's script
script = sys.argv[-1]
with open(script, encoding="utf-8") as file:
    job = next(json.loads(line[len(MARK):]) for line in file if line.startswith(MARK))
asked = job["resources"]
name = "angio-" + job["rule"] + "-" + job["wildcards"].get("job", "")
command = ["sbatch", "--parsable", "--requeue"]  # a node that dies sends its jobs to another
command += ["--job-name=" + name, "--output=/dev/null", f"--cpus-per-task={job['threads']}"]
command += [f"--mem={asked['mem_mb']}", f"--time={asked['runtime']}"]
if asked.get("gpus", 0) > 0:
    command.append(f"--gres=gpu:{asked['gpus']}")
command += shlex.split(os.environ.get("ANGIO_SBATCH", "")) + [script]
os.execvp(command[0], command)
