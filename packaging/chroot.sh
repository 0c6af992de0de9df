#!/bin/sh
# README's two commands as a newcomer calls them: as root, without sudo, on a fresh clone of HEAD in a chroot of Debian's or
# Ubuntu's minimal system. Prints for each command its time, and the packages and the disk space that it added.
# usage: chroot.sh RELEASE [COMMAND...]
# RELEASE: bookworm, trixie or noble. COMMAND: one argument each, by default './run demo' './run test'.
# Needs root, debootstrap and the network; noble also Ubuntu's keys (package ubuntu-keyring, or $UBUNTU_KEYRING names the file).
# The minimal system is made once, in $NSDAE_CHROOTS or build/chroots; beside it stay RELEASE-run, where the commands ran, and logs.
set -eu
release=${1:?bookworm, trixie or noble}
shift
[ $# -gt 0 ] || set -- './run demo' './run test'
source=$(cd "$(dirname "$0")/.." && pwd)
folder=${NSDAE_CHROOTS:-$source/build/chroots}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
base=$folder/$release root=$folder/$release-run

case $release in
noble)
  mirror=http://archive.ubuntu.com/ubuntu components=main,universe
  keys=${UBUNTU_KEYRING:-/usr/share/keyrings/ubuntu-archive-keyring.gpg}
  script=gutsy # that of all Ubuntu's releases
  ;;
*)
  mirror=http://deb.debian.org/debian components=main
  keys=/usr/share/keyrings/debian-archive-keyring.gpg
  script=sid
  ;;
esac
if [ ! -e "$base/etc/os-release" ] || [ -e "$base.part" ]; then
  [ -e "$keys" ] || { echo "no keys of $release at $keys: nothing that it fetches could be checked" >&2 && exit 1; }
  echo "making $base"
  rm -rf "$base"
  touch "$base.part" # until it is whole
  debootstrap --variant=minbase --components="$components" --keyring="$keys" "$release" "$base" "$mirror" "$script" \
    >"$folder/$release-debootstrap.log" 2>&1 || { tail -3 "$folder/$release-debootstrap.log" >&2 && exit 1; }
  rm "$base.part"
fi

umount "$root/proc" 2>/dev/null || true # left by a run that was killed
rm -rf "$root"
cp -a "$base" "$root"
git clone -q --no-hardlinks "$source" "$root/root/nsdae"
mount -t proc proc "$root/proc"
trap 'umount "$root/proc"' EXIT
trap 'exit 1' INT TERM

# of the system, without the clone and without the archives that apt keeps
disk() {
  du -sxm --exclude="$root/root/nsdae" --exclude="$root/var/cache/apt" --exclude="$root/var/lib/apt/lists" "$root" | cut -f1
}
packages() {
  grep -c '^Status: install ok installed' "$root/var/lib/dpkg/status"
}

. "$root/etc/os-release"
echo "$PRETTY_NAME, $(getconf _NPROCESSORS_ONLN) cores, nsdae $(git -C "$source" describe --always --dirty)"
count=0 bad=0
for command in "$@"; do
  count=$((count + 1))
  log=$folder/$release-$count.log
  disk_before=$(disk) packages_before=$(packages) start=$(date +%s)
  echo "\$ $command"
  {
    code=0
    env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
      chroot "$root" sh -c "cd /root/nsdae && $command" 2>&1 || code=$?
    echo "exit $code"
  } | tee "$log"
  end=$(date +%s)
  tail -1 "$log" | grep -qx 'exit 0' || bad=1
  installing=$(sed -n 's/^packages: there after \([0-9]*\) s$/\1/p' "$log")
  echo "$command: $((end - start)) s, of them ${installing:-0} s for packages: $(($(packages) - packages_before))," \
    "$(($(disk) - disk_before)) MB on disk"
done
exit $bad
