#!/usr/bin/env bash
# benchmarks/phantoms.sh BUILD FOLDER: four phantoms of 60 % stenosis, written as DICOM and taken to the report by
# default. FOLDER gets them and their cases. Writes docs/results/phantoms.md.
set -euo pipefail
build=$(realpath "${1:?benchmarks/phantoms.sh BUILD FOLDER}")
folder=$(realpath -m "${2:?benchmarks/phantoms.sh BUILD FOLDER}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."

for name in unilateral bilateral ytype coronary; do
  [[ -e $folder/$name ]] || "$build/bin/angio" phantom "$name" --stenosis 60 --noise 0.1 --seed 3 -o "$folder/$name"
  "$build/bin/angio" run "$folder/$name/dicom" -o "$folder/$name/case" >&2
done

python3 - "$folder" << 'END' | "$build/benchmarks/result_file" "Phantoms, from DICOM to numbers" \
  --command "benchmarks/phantoms.sh BUILD FOLDER" --markdown docs/results/phantoms.md
import json
import pathlib
import sys

print("""0.3 mm voxels, noise 10 % of the contrast, 60 % stenosis, seed 3; all else by default. How near lines and radii come is in
[accuracy](../accuracy.md).

| phantom | MLD found (true) mm | stenosis found (true) % | status | MLD at peak mm | MLD after mm | recoil % | frames without air | penetration mm |
|---|---|---|---|---|---|---|---|---|""")
for name in ("unilateral", "bilateral", "ytype", "coronary"):
    case = pathlib.Path(sys.argv[1]) / name
    truth = json.loads((case / "truth.json").read_text())
    metrics = json.loads((case / "case/metrics.json").read_text())
    lesion, result, solver = metrics["lesion"], metrics["result"], metrics["simulation"]
    peak = metrics["peak"]["mld_mm"]
    print(f"| {name} "
          f"| {lesion['image_mld_mm']:.3f} ({truth['mld_mm']:.3f}) "
          f"| {100 - 100 * lesion['image_mld_mm'] / lesion['reference_diameter_mm']:.0f} ({truth['diameter_stenosis_percent']:.0f}) "
          f"| {metrics['status']} | {peak:.2f} | {result['mld_mm']:.2f} | {result['recoil_percent']:.0f} "
          f"| {solver['frames_without_air']} | {solver['max_penetration_mm']:g} |")
END
