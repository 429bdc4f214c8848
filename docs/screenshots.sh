#!/usr/bin/env bash
# Makes docs/images/screenshots: report, viewer, live window and film as a user sees them.
#
#     docs/screenshots.sh ANGIO CASE_SCAN CASE_PHANTOM [CASE_LIVE]
#
# ANGIO: the program. CASE_SCAN, CASE_PHANTOM: finished cases, of a scan and of a phantom. CASE_LIVE: a
# meshed case for the live window; without one CASE_PHANTOM is taken.
# Needs chromium, xvfb, ffmpeg and, for smaller files, pngquant where it is there.
set -euo pipefail
if [[ $# -lt 3 || $# -gt 4 ]]; then
  sed -n '2,8s/^# \{0,1\}//p' "$0" >&2
  exit 64
fi
angio=$(realpath "$1")
scan=$(realpath "$2")
phantom=$(realpath "$3")
live=$(realpath "${4:-$3}")
out=$(realpath "$(dirname "${BASH_SOURCE[0]}")")/images/screenshots
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"

# picture NAME FILE.png: into the documents, in 256 colours where that can be done.
picture() {
  if command -v pngquant > /dev/null; then
    pngquant --force --speed 1 --output "$out/$1.png" "$2"
  else
    cp "$2" "$out/$1.png"
  fi
}

# page NAME REPORT WIDTH HEIGHT: the report's top in a browser of that size. A frame stands in for a phone:
# Chromium's own window is not as narrow.
page() {
  cat > "$work/page.html" << HTML
<!DOCTYPE html><style>*{margin:0;border:0}</style><iframe src="file://$2" width="$3" height="$4"></iframe>
HTML
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$work/profile" \
    --window-size="$(($3 > 500 ? $3 : 500)),$4" --allow-file-access-from-files \
    --virtual-time-budget=3000 --screenshot="$work/$1.png" "file://$work/page.html" > "$work/log" 2>&1
  picture "$1" "$work/$1.png"
}

# view NAME CASE KEYS...: the desktop viewer with these keys pressed.
view() {
  "$angio" view "$2" --screenshot "$work/$1.png" ${3:+--keys "$3"} > "$work/log" 2>&1
  picture "$1" "$work/$1.png"
}

for case in scan phantom; do
  page "report_${case}_desktop" "${!case}/report/index.html" 1280 1600
  page "report_${case}_phone" "${!case}/report/index.html" 390 1400
done

view view_1_lesion "$scan" ""
view view_2_tree "$scan" t
view view_3_projection "$scan" t,m
view view_4_pressure "$scan" b,period
view view_5_clipped "$phantom" k

xvfb-run -a -s '-screen 0 1280x900x24' "$angio" live "$live" --wall shape_matching --seconds 12 \
  --pressure 40 --screenshot "$work/live.png" | tee "$work/live.txt"
picture live "$work/live.png"

"$angio" film "$phantom" -o "$work/film.avi" > "$work/log" 2>&1
middle=$(ffprobe -v error -show_entries format=duration -of csv=p=0 "$work/film.avi" |
  awk '{print $1 / 2}')
ffmpeg -v error -y -ss "$middle" -i "$work/film.avi" -frames:v 1 "$work/film.png"
picture film "$work/film.png"
ls -l "$out"
