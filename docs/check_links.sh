#!/usr/bin/env bash
# Fails on dead relative links in the documents, and on documents that name a path of the repository
# that does not exist. Prints each, with its file.
#
#   docs/check_links.sh
#
# A path is what stands in backquotes, begins with a folder of the repository, and has a slash. Left out
# are CHANGELOG.md (it names what was), and names with placeholders: capitals (STAGE, NAME), *, <>, ...
# shellcheck disable=SC2016  # backquotes are what is searched for
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit

failed=0
dead() {
  echo "$1: $2" >&2
  failed=1
}

exists() { # PATH: a file, a folder, or a source without its ending
  [[ -e $1 ]] || compgen -G "$1.*" >/dev/null
}

folders=$(git ls-files | sed -n 's|/.*||p' | sort -u | paste -sd'|')
while read -r document; do
  folder=$(dirname "$document")
  while read -r link; do
    target=${link%%#*}
    [[ -n $target ]] || continue
    [[ -e $folder/$target ]] || dead "$document" "dead link to $link"
  done < <(sed 's/`[^`]*`//g' "$document" | grep -o '](\([^)]*\))' | sed 's/^](//; s/)$//' |
    grep -Ev '^([a-z]+:|#)')
  [[ $document != CHANGELOG.md ]] || continue
  while read -r path; do
    exists "$path" || exists "$folder/$path" || dead "$document" "no such path: $path"
  done < <(grep -o '`[^` ]*`' "$document" | tr -d '`' | grep -E "^($folders)/" |
    grep -Ev '[*<>{}$]|\.\.\.|[A-Z]{3,}|\.(vtp|vtu|pvd|csv|nrrd|json)$' | sort -u)
done < <(git ls-files '*.md')
exit $failed
