# Sourced by the comparisons: `build`, `options`, and an empty folder as the working directory, which
# is removed at the end. usage of each: SCRIPT BUILD_FOLDER [--markdown FILE]
build=$(realpath "$1")
options=("${@:2}")
[[ ${options[0]:-} != --markdown ]] || options[1]=$(realpath -m "${options[1]}")
if ! command -v ccx >/dev/null; then
  echo "no ccx here: apt-get install calculix-ccx" >&2
  exit 69
fi
export OMP_NUM_THREADS=${OMP_NUM_THREADS:-2}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
