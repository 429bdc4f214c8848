#!/bin/sh
# Fetches the public data sets of datasets/public_data.csv from their own addresses and checks them.
#
#   datasets/fetch_public_data.sh [--split dev|heldout|all] [--large] [FOLDER]      by default: dev, ./data
#
# Rows of over 10 MB (series of DICOM slices) come with --large only.
# Files that are there and right are kept, so a run that was cut off goes on where it was.
# Afterwards: export ANGIO_DATA=FOLDER
# $ANGIO_PUBLIC_DATA_URL: another place that has REPOSITORY/COMMIT/PATH (a mirror, file://...).
# Needs curl (or wget) and sha256sum. Exit codes: 0 done, 1 something could not be had, 64 usage, 69 no tool.
set -u

table=$(dirname "$0")/public_data.csv
address=${ANGIO_PUBLIC_DATA_URL:-https://raw.githubusercontent.com}
folder=
split=dev
large=no
most_bytes=10000000 # of a row, without --large
failed=0

stop() {
  echo "fetch_public_data.sh: $2" >&2
  exit "$1"
}

while [ $# -gt 0 ]; do
  case $1 in
    --split)
      [ $# -gt 1 ] || stop 64 "--split needs dev, heldout or all"
      split=$2
      shift
      ;;
    --split=*) split=${1#--split=} ;;
    --large) large=yes ;;
    -*) stop 64 "unknown option $1. Usage: fetch_public_data.sh [--split dev|heldout|all] [--large] [FOLDER]" ;;
    *)
      [ -z "$folder" ] || stop 64 "one folder only, but '$folder' and '$1' were given"
      folder=$1
      ;;
  esac
  shift
done
folder=${folder:-data}
case $split in
  dev | heldout | all) ;;
  *) stop 64 "no split '$split': dev, heldout or all" ;;
esac
[ -r "$table" ] || stop 64 "$table cannot be read. It lies beside this script in the repository"

if command -v curl >/dev/null; then
  download() { curl --fail --silent --show-error --location --retry 3 --output "$2" "$1"; }
elif command -v wget >/dev/null; then
  download() { wget --quiet --tries 3 --output-document "$2" "$1"; }
else
  stop 69 "neither curl nor wget is installed. Try: apt-get install curl"
fi

sha256_of_stdin() { sha256sum | cut -d ' ' -f 1; }

# numbers_of NAME: of a series' name, '...[000001-000275]...', the numbers; of any other name, one line '-'
numbers_of() {
  range=$(printf '%s\n' "$1" | sed -n 's/.*\[\([0-9]*-[0-9]*\)\].*/\1/p')
  if [ -z "$range" ]; then echo -; else seq -w "${range%-*}" "${range#*-}"; fi
}

# with_number NAME NUMBER: the name of that member of the series
with_number() { printf '%s\n' "$1" | sed "s/\[[0-9]*-[0-9]*\]/$2/"; }

# is_there NAME: with all its members
is_there() {
  for number in $(numbers_of "$1"); do
    [ -f "$folder/$(with_number "$1" "$number")" ] || return 1
  done
}

# is_right NAME SHA256: a series is right as a whole, its members one after the other
is_right() {
  is_there "$1" || return 1
  [ "$(for number in $(numbers_of "$1"); do cat "$folder/$(with_number "$1" "$number")"; done | sha256_of_stdin)" = "$2" ]
}

forget() {
  for number in $(numbers_of "$1"); do rm -f "$folder/$(with_number "$1" "$number")"; done
}

# fetch_members NAME REPOSITORY COMMIT PATH: those that are not there
fetch_members() {
  for number in $(numbers_of "$1"); do
    target=$folder/$(with_number "$1" "$number")
    [ ! -f "$target" ] || continue
    mkdir -p "$(dirname "$target")" || exit 1
    path=$(with_number "$4" "$number" | sed 's/ /%20/g')
    if ! download "$address/$2/$3/$path" "$target.part"; then
      rm -f "$target.part"
      return 1
    fi
    mv "$target.part" "$target"
  done
}

# fetch NAME SHA256 REPOSITORY COMMIT PATH
fetch() {
  if is_right "$1" "$2"; then
    echo "have     $1"
    return
  fi
  if is_there "$1"; then forget "$1"; fi
  if ! fetch_members "$1" "$3" "$4" "$5"; then
    echo "missing  $1 (no answer for $3 from $address). Try again later: what came is kept" >&2
    failed=1
  elif ! is_right "$1" "$2"; then
    forget "$1"
    echo "wrong    $1 (its SHA-256 is not the one listed in public_data.csv). It was not kept" >&2
    failed=1
  else
    echo "fetched  $1"
  fi
}

listed=0
left_out=0
while IFS=, read -r row_case row_split _ _ _ repository commit path file sha256 bytes _; do
  [ "$row_case" != case ] || continue
  [ "$split" = all ] || [ "$split" = "$row_split" ] || continue
  listed=$((listed + 1))
  if [ $large = no ] && [ "$bytes" -gt $most_bytes ]; then
    left_out=$((left_out + 1))
    continue
  fi
  fetch "$file" "$sha256" "$repository" "$commit" "$path"
done <"$table"
[ $listed -gt 0 ] || stop 64 "$table lists nothing for --split $split"
[ $left_out -eq 0 ] || echo "left out $left_out of over 10 MB: --large fetches them, too"

exit $failed
