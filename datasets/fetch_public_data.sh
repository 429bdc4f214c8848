#!/bin/sh
# Fetches the public data sets of datasets/README.md from their own addresses and checks them.
#
#   datasets/fetch_public_data.sh [FOLDER]      FOLDER: ./data by default
#
# Files that are there and right are kept. Afterwards: export ANGIO_DATA=FOLDER
# Needs curl (or wget) and sha256sum. Exit codes: 0 done, 1 something could not be had, 69 no tool.
set -u

folder=${1:-data}
failed=0

if command -v curl >/dev/null; then
  download() { curl --fail --silent --show-error --location --retry 3 --output "$2" "$1"; }
elif command -v wget >/dev/null; then
  download() { wget --quiet --tries 3 --output-document "$2" "$1"; }
else
  echo "fetch_public_data.sh: neither curl nor wget is installed. Try: apt-get install curl" >&2
  exit 69
fi

is_right() { [ "$(sha256sum "$1" 2>/dev/null | cut -d ' ' -f 1)" = "$2" ]; }

# fetch NAME SHA256 REPOSITORY COMMIT PATH, the path with its blanks as %20
fetch() {
  target=$folder/$1
  if is_right "$target" "$2"; then
    echo "have     $1"
    return
  fi
  mkdir -p "$(dirname "$target")" || exit 1
  if ! download "https://raw.githubusercontent.com/$3/$4/$5" "$target.part"; then
    echo "missing  $1 (no answer from github.com/$3). Try again later" >&2
    failed=1
  elif ! is_right "$target.part" "$2"; then
    echo "wrong    $1 (its SHA-256 is not the one listed here). It was not kept" >&2
    failed=1
  else
    mv "$target.part" "$target"
    echo "fetched  $1"
  fi
  rm -f "$target.part"
}

while read -r name sha256 repository commit path; do
  case $name in '' | '#'*) continue ;; esac
  fetch "$name" "$sha256" "$repository" "$commit" "$path"
done <<'LIST'
3dra-aneurism/aneurism.raw.gz c0cdcabb5ca0f46c7cd755128adad18ad3e8718d912581a9ec5609eaa72c4ef0 postspectacular/toxiclibs 6896bc17e85320e886bdf0819c66491ce484728e examples/volume/MRISurface/data/aneurism.raw.gz
mra-aorta-vmtk/aorta.mha 435c368b6ce04011b94bceb9f9a62110d49934417a96b73aafec57aba41cfca0 vmtk/vmtk-test-data 7f5abc07a33e1037a106fa4e0ac6c320adb1baa1 input/aorta.mha
mra-aorta-vmtk/aorta-surface.vtp 18f4d019c7cc553ef20452f27fb5c2713637607c5e2ca7745579753fc89335ab vmtk/vmtk-test-data 7f5abc07a33e1037a106fa4e0ac6c320adb1baa1 input/aorta-surface.vtp
mra-aorta-vmtk/aorta-centerline.vtp 6c540671dbef5575561fc5a9b4447ccff29e99261a8ec33d16aa213b6d24d2ca vmtk/vmtk-test-data 7f5abc07a33e1037a106fa4e0ac6c320adb1baa1 input/aorta-centerline.vtp
coronary-lumen-xra/lumen.stl 05f6f34b0277e939328a9f611081c902420517346438f3384434795dc98fa848 dmilashinovic/dfemtoolz 3801860f1bbc75e9e100a51550b3f6602113b695 case1-fluid-flow_program/input/initial_stl_model_files/m1_fluid.stl
coronary-ccta-centerlines/centerline_lca.csv d557281685477bb003136028f1bc56e0609414722c8dde963f242b73bcae6f49 yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/centerline_lca.csv
coronary-ccta-centerlines/centerline_rca.csv f0ac71bc4ab55cb079a8a310e682f6c670e8d4e1a3222c93feadb41708880f48 yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/centerline_rca.csv
coronary-ccta-centerlines/ao_cl.vtp 8702669c041e5f3998ca37e962d03d34af18094c2cd95cf299a678f8acfbce21 yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/ao_cl.vtp
coronary-ccta-centerlines/lca_cl.vtp 95bb9d7939abe07b8a868ba2340f338922ae4ab74c9659a0d42ad4fe12c52f35 yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/lca_cl.vtp
coronary-ccta-centerlines/rca_cl.vtp 9c3051f6f1ef341bc1a7a4d9f7f00416514088247515adfaaac54e710cf7246b yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/rca_cl.vtp
coronary-ivus-prestent/combined_sorted_manual.csv 4e0b9f73d3e0e5a3badb0d35ab739ef7cf519645dc75238057d3770cd375b9b4 yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/ivus_prestent/combined_sorted_manual.csv
coronary-ivus-prestent/diastolic_contours.csv 9dfa02b9b70b91751b1b79e94312c7411982501785d9a41fe07254d0528a6e28 yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/ivus_prestent/diastolic_contours.csv
coronary-ivus-prestent/diastolic_reference_points.csv abb77146ea2969b87c7e9bb814b9304a489a999610e86a6c09e4af57137ac83d yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/ivus_prestent/diastolic_reference_points.csv
coronary-ivus-prestent/systolic_contours.csv bb4d91a07e230ab1360537d9ad8c817e8265dc921889c28857e60855e9763d60 yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/ivus_prestent/systolic_contours.csv
coronary-ivus-prestent/systolic_reference_points.csv d80f4ebe7334aa75aa910d5d69934b44c805e9622537dc6d5be91cb75fbce42d yungselm/multimoda-rs 83248bf3709a633ddd9ad237335cc03ed2b5ad59 examples/data/ivus_prestent/systolic_reference_points.csv
xa-coronary-phantom/centerlines.vtk 9ce1eefc6e2454a5c3ea65929a3dea7953bd6bb36c52d61d4b7e41dc52c9b6df ArsoVukicevic/X-Ray-Angio-data e6ad56ea6c326c94ba5840eda49ec049a2d15c1b Dataset%20I%20%20%20%20-%20static%20phantom/X-Ray%20Angio/Centerlines.vtk
dicom-codecs/XA1_J2KI 24fa42e4a19ccb8f32115969fe413d5e440bcc239eb3c1da7b3b8900530890f9 wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_j2k/IMAGES/J2KI/XA1_J2KI
dicom-codecs/XA1_J2KR 5f0539e8963b842915e22f819ec738547c4835acf128e55b19a3dea2ffe08d8c wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_j2k/IMAGES/J2KR/XA1_J2KR
dicom-codecs/XA1_JLSL 2296005f4a4d57b757e164755f5baccf3ef6577d7fba6fdf06fcf5d193653c49 wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_jpegls/IMAGES/JLSL/XA1_JLSL
dicom-codecs/XA1_JLSN b78c433ca4445bbd47981d110114020b99b5c041301e3348b8af4a5123ebdc3f wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_jpegls/IMAGES/JLSN/XA1_JLSN
dicom-codecs/XA1_JPLL 94f21a860a274b9df68d2cfdafe5d5a2c93a123a369f1b7c352ba16c259af129 wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_jpeg/IMAGES/JPLL/XA1_JPLL
dicom-codecs/XA1_JPLY 816cdcb324a326cbe792e5fdfbe866977bb612089c6fbb589ecc5e36344fdfd3 wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_jpeg/IMAGES/JPLY/XA1_JPLY
dicom-codecs/XA1_RLE e9c89f2bb83c73f545d4962b2de9b0f0d01771255a9f93dccfd55746f7c4384d wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_rle_20040210/IMAGES/RLE/XA1_RLE
dicom-codecs/XA1_UNC 3b3b719e241f2365e9dfb585426f0e378db47aa5e0c42476aba43144b5656fb8 wearemothership/dicom-test-files 03a339a6f8ee3dc5d52af23aeb7a29b68948792b medical.nema.org/compsamples_refanddir/IMAGES/REF/XA1_UNC
LIST

exit $failed
