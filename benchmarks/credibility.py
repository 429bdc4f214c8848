#!/usr/bin/env python3
"""credibility.py [OUTPUT]: docs/credibility.md, from the rows that docs/results holds.

The shape is ASME V&V 40-2018's and FDA's "Assessing the Credibility of Computational Modeling and Simulation
in Medical Device Submissions" (2023): question, context of use, risk, then each credibility factor with what
was measured and what is missing. A figure is read from its table; where its row is gone the program fails.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "docs" / "results"


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def value(file, row, column=None):
    """The cell of a table: of the first row that begins with `row`, under `column` (else its last but one)."""
    header = []
    for line in (RESULTS / f"{file}.md").read_text(encoding="utf-8").splitlines():
        if not line.startswith("|"):
            header = []
            continue
        found = cells(line)
        if not header:
            header = found
        elif found[0].startswith(row) and (column is None or column in header):
            return found[header.index(column)] if column else found[-2]
    raise SystemExit(f"credibility.py: docs/results/{file}.md has no row '{row}' (column {column})")


def all_pass(file):
    rows = [cells(line) for line in (RESULTS / f"{file}.md").read_text(encoding="utf-8").splitlines()
            if line.startswith("|") and ("pass" in line or "FAIL" in line)]
    passed = sum(row[-1] == "pass" for row in rows)
    return f"{passed} of {len(rows)} laws within their bars"


def commit(file):
    text = (RESULTS / f"{file}.md").read_text(encoding="utf-8")
    found = re.search(r"^- Commit: ([0-9a-f]{7,12})", text, re.M)
    return found.group(1) if found else "see there"


def source(file):
    return f"[{file}](results/{file}.md), {commit(file)}"


FACTORS = [
    ("Verification: code", [
        ("Software quality", "tests state laws, every backend and thread count gives the same bytes; sanitizers, "
         "clang-tidy, fuzz targets; results name commit, build, machine", "[security](security.md)",
         "no quality system, no independent team"),
        ("Numerical code: closed forms", all_pass("validation"), source("validation"), ""),
        ("Numerical code: sphere, error ratio of two meshes against 4",
         value("validation", "sphere: error ratio", "value"), source("validation"), ""),
        ("Another program, the membrane: FEniCSx", value("fenicsx", "sphere", "at most")
         + " of the largest displacement", source("fenicsx"), ""),
        ("Another program, the wall: CalculiX, lumen after a growing cylinder",
         value("growing-cylinder", "mean lumen diameter after", "difference %") + " %", source("growing-cylinder"),
         "one stenosis, no contact with friction"),
        ("A thousand inflations in one process: runs with other bytes", value("soak", "runs with other bytes", "value"),
         source("soak"), ""),
    ]),
    ("Verification: calculation", [
        ("Discretisation: lumen after, default mesh to three times finer, coronary lumen",
         value("layered-default", "coronary lumen (X-ray", "default to 48 (bar 4 %)"), source("layered-default"),
         "time step and mesh together are not varied"),
        ("The solver: vertex block descent against Newton, semi-compliant balloon",
         value("validation", "vbd against newton, semi_compliant", "value"), source("validation"), ""),
        ("Friction: angle of repose", value("contact-laws", "friction 2 + 2: angle of repose", "value"),
         source("contact-laws"), ""),
        ("Whether a result is determined", "a second run with a start moved by 1e-6 mm, in every default case",
         "[contract](contract.md)", "two runs tell no distribution"),
        ("Use error", "units and ranges are checked, unknown keys refused, doubts printed", "[contract](contract.md)",
         "no study of users"),
    ]),
    ("Validation: model", [
        ("Form", "layered hyperelastic wall that yields and recoils, hyperelastic folded balloon, Coulomb friction",
         "[method](method/simulation.md)", "no rate, no dissection, no blood flow in the wall"),
        ("Inputs: the vessel's shape, 60 % stenosis, least diameter found (true)",
         value("phantoms", "coronary", "MLD found (true) mm") + " mm", source("phantoms"), "phantoms"),
        ("Inputs: stenoses of 50 to 90 % found on random trees", value("random-trees", "**50 to 90 %**", "found %") + " %",
         source("random-trees"), "generated trees"),
        ("Inputs: balloon, diameter at its chart's points", value("validation", "chart, semi_compliant", "value"),
         source("validation"), "charts are makers' nominal ones"),
        ("Inputs: materials", "published means", "[method](method/simulation.md)", "none is the patient's"),
    ]),
    ("Validation: comparator", [
        ("Samples", "published series of patients, 200 random lesions beside them", source("random-lesions"),
         "no case with its own before and after"),
        ("Conditions", "nominal pressure, one dilation", source("random-lesions"), "what was done in each patient is not published"),
    ]),
    ("Validation: assessment", [
        ("Recoil in % of the balloon, here", value("random-lesions", "recoil, % of the full", "here") + "; published "
         + value("random-lesions", "recoil, % of the full", "published"), source("random-lesions"), ""),
        ("Residual stenosis %, here", value("random-lesions", "residual stenosis, %", "here") + "; published "
         + value("random-lesions", "residual stenosis, %", "published"), source("random-lesions"),
         "the spread of patients is not met"),
        ("Recoil in % of the gain, here", value("random-lesions", "recoil, % of the gain", "here") + "; published "
         + value("random-lesions", "recoil, % of the gain", "published"), source("random-lesions"), "not met"),
        ("Balloon below its chart mm, here", value("random-lesions", "balloon below its chart", "here")
         + "; published " + value("random-lesions", "balloon below its chart", "published"), source("random-lesions"),
         "not met"),
    ]),
    ("Applicability", [
        ("Quantities", "diameters, areas, recoil: those compared", "", "stresses are compared with nothing measured"),
        ("Activities to the context of use", "coronary-sized vessels", source("random-lesions"),
         "carotids and cerebral vessels: runs only, no outcome"),
    ]),
]

HEAD = """# Credibility

Made by `benchmarks/credibility.py` from the rows in [results](results/README.md): do not edit. The shape is that of
ASME V&V 40-2018 and of FDA's guidance of 17 November 2023.

**Question of interest.** How do balloon, length and pressure change the lumen that a dilation leaves in this vessel?

**Context of use.** Research: comparing balloons and pressures on one vessel, and groups of vessels. Not a medical
device; nothing that it prints may guide a treatment.

**Model risk.** Influence: low, for no treatment follows from it. Consequence of a wrong answer: a wrong conclusion
in a study. Risk: low. **In a clinical context both would be high, and what stands below would not do**: no patient's
own result was compared with its prediction, and no quality system stood behind the work.
"""


def main():
    text = [HEAD]
    for title, rows in FACTORS:
        text += [f"\n## {title}\n", "| factor | measured | from | missing |", "|---|---|---|---|"]
        text += [f"| {name} | {measured} | {origin} | {missing} |" for name, measured, origin, missing in rows]
    output = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "credibility.md"
    output.write_text("\n".join(text) + "\n", encoding="utf-8")


main()
