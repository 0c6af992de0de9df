#!/bin/sh
# Builds the Debian packages of this source tree (as committed) into FOLDER; runs lintian where it
# is installed. Needs debhelper and the Build-Depends of packaging/debian/control.
# usage: packaging/build-debian.sh FOLDER
set -eu
folder=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$(dirname "$0")/.."
version=$(sed -n 's/^project(nsdae VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
rm -rf "$folder/nsdae-$version"
git archive --prefix="nsdae-$version/" HEAD | tar -x -C "$folder"
cd "$folder/nsdae-$version"
tar -czf "../nsdae_$version.orig.tar.gz" --exclude=debian -C .. "nsdae-$version"
cp -r packaging/debian debian
dpkg-buildpackage -us -uc -b
if command -v lintian >/dev/null; then
  lintian --no-tag-display-limit ../nsdae_*.changes || :
fi
ls -l "$folder"/*.deb
