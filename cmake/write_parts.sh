#!/usr/bin/env bash
# write_parts.sh SOURCE_DIR VERSION OUTPUT PROGRAM...: the third-party parts of built programs and modules as an SPDX 2.3
# document (tag:value): every library that the dynamic linker loads with the package and version that it is of,
# and what lies bundled or is compiled in from headers. Debian's dpkg tells; elsewhere versions are NOASSERTION.
set -euo pipefail
source=$1 version=$2 output=$3
programs=("${@:4}")
export LC_ALL=C

declare -A installed
while IFS=$'\t' read -r name number; do
  installed[$name]=$number
done < <(dpkg-query -W -f '${Package}\t${Version}\n' 2>/dev/null || true)
version_of() { printf '%s' "${installed[$1]:-NOASSERTION}"; }

# "package<TAB>file" of the shared libraries. dpkg knows a library by the one of its names that /usr has merged;
# of what it does not know, as CUDA's, the file is the part.
find_linked() {
  local files owners
  mapfile -t files < <(ldd "${programs[@]}" | awk '/=> \// { print $3 }' | xargs -r realpath | sort -u)
  owners=$(dpkg-query -S "${files[@]}" "${files[@]#/usr}" 2>/dev/null | sed -E 's|^([^:,]+)[^/]*/(.*/)?|\1\t|' || true)
  awk -F'\t' 'NR == FNR { if (!($2 in owner)) owner[$2] = $1; next }
               { f = $0; sub(".*/", "", f); print (f in owner ? owner[f] : f) "\t" f }' \
    <(printf '%s\n' "$owners") <(printf '%s\n' "${files[@]}") | sort -u
}

part() {  # NAME VERSION COMMENT [LICENCE]
  local id=${1//[^A-Za-z0-9.]/-}
  printf '\nPackageName: %s\nSPDXID: SPDXRef-%s\nPackageVersion: %s\nPackageDownloadLocation: NOASSERTION\n' "$1" "$id" "$2"
  printf 'FilesAnalyzed: false\nPackageLicenseConcluded: NOASSERTION\nPackageLicenseDeclared: %s\n' "${4:-NOASSERTION}"
  printf 'PackageCopyrightText: NOASSERTION\nPackageComment: <text>%s</text>\n' "$3"
  printf 'Relationship: SPDXRef-angio DEPENDS_ON SPDXRef-%s\n' "$id"
}

parts=$(find_linked)
linked() { printf '%s\n' "$parts"; }

write() {
  local name files package
  # The document's name space is its content's: the same build gives the same bytes.
  local hash
  hash=$(linked | sha256sum | cut -c1-32)
  printf 'SPDXVersion: SPDX-2.3\nDataLicense: CC0-1.0\nSPDXID: SPDXRef-DOCUMENT\nDocumentName: angio-%s\n' "$version"
  printf 'DocumentNamespace: urn:angio:parts:%s\nCreator: Tool: write_parts.sh\nCreated: %s\n' "$hash" \
    "$(date -u -d "@${SOURCE_DATE_EPOCH:-$(git -C "$source" log -1 --format=%ct 2>/dev/null || echo 0)}" +%Y-%m-%dT%H:%M:%SZ)"
  printf '\nPackageName: angio\nSPDXID: SPDXRef-angio\nPackageVersion: %s\nPackageDownloadLocation: NOASSERTION\n' "$version"
  printf 'FilesAnalyzed: false\nPackageLicenseConcluded: NOASSERTION\nPackageLicenseDeclared: GPL-3.0-or-later\n'
  printf 'PackageCopyrightText: NOASSERTION\nRelationship: SPDXRef-DOCUMENT DESCRIBES SPDXRef-angio\n'
  linked | awk -F'\t' '{ files[$1] = files[$1] " " $2 } END { for (name in files) print name "\t" files[name] }' | sort |
    while IFS=$'\t' read -r name files; do
      part "$name" "$(version_of "$name")" "shared library:$files"
    done
  # Headers alone, or static: nothing is left of them that could be asked for.
  for package in libcgal-dev libeigen3-dev libtomlplusplus-dev nlohmann-json3-dev libcli11-dev; do
    part "$package" "$(version_of "$package")" "compiled in from headers"
  done
  part vtk.js 37.4 "bundled in viewer/page, inside the report" BSD-3-Clause
}

write > "$output.tmp"
mv "$output.tmp" "$output"
