#!/usr/bin/env bash
# bare_debian.sh FOLDER [TESTS]: from nothing to a dilated vessel, and to all tests, on a bare Debian 12.
#
# Makes one in FOLDER (debootstrap; root only; a folder that exists is refused), clones this repository
# into it and takes the time of `./quickstart run` there and, with TESTS = yes, of `./quickstart test`
# afterwards; compilers start without a cache. Prints a table for docs/results/build.md.
set -euo pipefail

usage() {
  echo "usage: benchmarks/bare_debian.sh FOLDER [yes|no]" >&2
  exit 64
}
[[ $# -ge 1 && $# -le 2 && ${2:-no} =~ ^(yes|no)$ ]] || usage
readonly root=$1 tests=${2:-no}
[[ $(id -u) -eq 0 ]] || { echo "bare_debian.sh: only root can make a system of its own" >&2; exit 77; }
[[ ! -e $root ]] || { echo "bare_debian.sh: $root is there already. Name a new folder" >&2; exit 73; }
source_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
readonly source_folder

debootstrap --variant=minbase bookworm "$root" >&2
git clone --quiet "$source_folder" "$root/root/angio"
leave() { umount "$root/proc" "$root/dev" "$root/sys" 2>/dev/null || true; }
trap leave EXIT
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
mount --bind /sys "$root/sys"
cp /etc/resolv.conf "$root/etc/"

# seconds_of COMMAND: in the repository there; its output goes to standard error.
seconds_of() {
  local begin=$SECONDS
  chroot "$root" bash -c "export CCACHE_DISABLE=1; cd /root/angio && $1" >&2
  echo $((SECONDS - begin))
}

to_report=$(seconds_of './quickstart run')
printf '| what | s |\n|---|---|\n'
printf '| `./quickstart run` on a bare Debian 12: packages, build, a vessel dilated from DICOM to report | %d |\n' "$to_report"
[[ $tests == no ]] || printf '| then `./quickstart test`: everything built again with checks, all tests | %d |\n' "$(seconds_of './quickstart test')"
