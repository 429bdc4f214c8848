#!/bin/sh
# Laws of datasets/fetch_public_data.sh and of its table, without a network: it fetches from a folder.
#
#   test_fetch_public_data.sh DATASETS_FOLDER
set -eu

if ! command -v curl >/dev/null; then
  echo "skipped: without curl there is no fetching from a folder"
  exit 77
fi
datasets=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# run_script EXPECTED_EXIT_CODE ARGUMENTS...
run_script() {
  expected=$1
  shift
  code=0
  ANGIO_PUBLIC_DATA_URL=file://$work/mirror "$work/datasets/fetch_public_data.sh" "$@" \
    >"$work/out" 2>"$work/err" || code=$?
  [ "$code" -eq "$expected" ] || fail "exit code $code, not $expected, of: $*: $(cat "$work/out" "$work/err")"
}

says() { grep -q -- "$1" "$work/out" "$work/err" || fail "'$1' is not said: $(cat "$work/out" "$work/err")"; }

sha256_of() { cat "$@" | sha256sum | cut -d ' ' -f 1; }

# --- the table itself
table=$datasets/public_data.csv
readings=$datasets/public_readings.csv
ends=$datasets/public_ends.csv
awk -F, 'NF != 13 { print "row " NR " has " NF " fields"; bad = 1 }
  NR == 1 { next }
  $2 != "dev" && $2 != "heldout" { print "split of row " NR; bad = 1 }
  $3 !~ /^(volume|surface|labels|lines|contours|codec)$/ { print "kind of row " NR; bad = 1 }
  $5 !~ /^(mm|cm|m|unknown)$/ { print "unit of row " NR; bad = 1 }
  $7 !~ /^[0-9a-f]+$/ || length($7) != 40 { print "commit of row " NR; bad = 1 }
  $10 !~ /^[0-9a-f]+$/ || length($10) != 64 { print "sha256 of row " NR; bad = 1 }
  $11 !~ /^[0-9]+$/ { print "bytes of row " NR; bad = 1 }
  $12 == "" || $13 == "" { print "licence or remark of row " NR; bad = 1 }
  file[$9]++ { print "file of row " NR " is there twice"; bad = 1 }
  ($2 == "heldout") != ($9 ~ /^heldout\//) { print "file of row " NR " lies in the other split"; bad = 1 }
  END { exit bad }' "$table" >"$work/out" || fail "$(cat "$work/out")"
awk -F, 'NR == FNR { split_of[$1] = $2; next }
  FNR == 1 { count = NF; next }
  NF != count { print "reading of row " FNR " has " NF " fields, not " count; bad = 1 }
  !($1 in split_of) { print "reading of an unknown case: " $1; bad = 1 }
  END { exit bad }' "$table" "$readings" >"$work/out" || fail "$(cat "$work/out")"

awk -F, 'NR == FNR { ends_of[$1 "/" $2] = $4; next }
  FNR == 1 { next }
  NF != 8 { print "end " FNR " has " NF " fields"; bad = 1 }
  { listed[$1 "/" $2]++ }
  END {
    for (file in listed)
      if (listed[file] != ends_of[file]) {
        print file " has " listed[file] " ends listed, but a person reads " ends_of[file]
        bad = 1
      }
    exit bad
  }' "$readings" "$ends" >"$work/out" || fail "$(cat "$work/out")"

# --- a mirror with one file of each split and a series
mkdir -p "$work/datasets" "$work/mirror/some/where/c0ffee/a folder"
cp "$datasets/fetch_public_data.sh" "$work/datasets/"
source=$work/mirror/some/where/c0ffee
echo lumen >"$source/a folder/lumen.stl"
echo other >"$source/other.stl"
for number in 08 09 10 11; do echo "slice $number" >"$source/$number.dcm"; done
write_table() {
  {
    echo 'case,split,kind,region,unit,repository,commit,path,file,sha256,bytes,licence,remark'
    echo "one,dev,surface,x,mm,some/where,c0ffee,a folder/lumen.stl,one/lumen.stl,$(sha256_of "$source/a folder/lumen.stl"),6,MIT,x"
    echo "two,heldout,surface,x,mm,some/where,c0ffee,other.stl,heldout/two/other.stl,$(sha256_of "$source/other.stl"),6,MIT,x"
    echo "series,dev,volume,x,mm,some/where,c0ffee,[08-11].dcm,dev/series/[08-11].dcm,$(sha256_of "$source"/08.dcm "$source"/09.dcm "$source"/10.dcm "$source"/11.dcm),36,MIT,x"
  } >"$work/datasets/public_data.csv"
}
write_table

run_script 0 "$work/data"
says 'fetched  one/lumen.stl'
[ "$(cat "$work/data/one/lumen.stl")" = lumen ] || fail 'not the file that the table lists'
[ "$(cat "$work/data"/dev/series/*.dcm | sha256_of)" = "$(sha256_of "$source"/08.dcm "$source"/09.dcm "$source"/10.dcm "$source"/11.dcm)" ] || fail 'not the series'
[ ! -e "$work/data/heldout" ] || fail 'held-out data came unasked'

run_script 0 "$work/data"
says 'have     one/lumen.stl'
says 'have     dev/series/'

run_script 0 --split heldout "$work/held"
[ -f "$work/held/heldout/two/other.stl" ] || fail 'the held-out file did not come'
[ ! -e "$work/held/one" ] || fail 'the split is not kept'
run_script 0 --split=all "$work/all"
[ -f "$work/all/heldout/two/other.stl" ] || fail 'all is not all'
[ -f "$work/all/one/lumen.stl" ] || fail 'all is not all'

# what the table calls large comes only when asked for
cp "$work/datasets/public_data.csv" "$work/table"
sed 's/,36,MIT/,10000001,MIT/' "$work/table" >"$work/datasets/public_data.csv"
run_script 0 "$work/small"
says 'left out 1 of over 10 MB'
[ ! -e "$work/small/dev/series" ] || fail 'a large row came unasked'
[ -f "$work/small/one/lumen.stl" ] || fail 'a small row did not come'
run_script 0 --large "$work/small"
says 'fetched  dev/series/'
cp "$work/table" "$work/datasets/public_data.csv"

# a run that was cut off goes on: what is there is not fetched again
rm "$work/data/dev/series/09.dcm"
mv "$source/08.dcm" "$work/08.dcm"
run_script 0 "$work/data"
says 'fetched  dev/series/'
mv "$work/08.dcm" "$source/08.dcm"

# a spoilt file is fetched again
echo spoilt >"$work/data/one/lumen.stl"
echo spoilt >"$work/data/dev/series/10.dcm"
run_script 0 "$work/data"
[ "$(cat "$work/data/one/lumen.stl")" = lumen ] || fail 'a spoilt file was kept'

# what is not as listed is not kept; what does not answer is named; the others come all the same
echo changed >"$source/a folder/lumen.stl"
rm -rf "$work/data"
run_script 1 "$work/data"
says 'wrong    one/lumen.stl'
says 'fetched  dev/series/'
[ ! -e "$work/data/one/lumen.stl" ] || fail 'a wrong file was kept'
rm "$source/a folder/lumen.stl"
run_script 1 "$work/data"
says 'missing  one/lumen.stl'
[ -z "$(find "$work/data" -name '*.part')" ] || fail 'a part was left behind'

run_script 64 --split tomorrow
says "no split 'tomorrow'"
run_script 64 --faster
run_script 64 one two
run_script 64 --split
rm "$work/datasets/public_data.csv"
run_script 64 "$work/data"
echo passed
