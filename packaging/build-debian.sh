#!/bin/sh
# Builds the Debian packages of this source tree (as committed) into FOLDER; runs lintian where it is installed, whose
# errors and warnings fail. Needs git, dpkg-dev and the Build-Depends of packaging/debian/control. Debian 12 has no nanobind:
# there the package for Python is left out.
# usage: packaging/build-debian.sh FOLDER
set -eu
folder=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$(dirname "$0")/.."
version=$(sed -n 's/^project(nsdae VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
rm -rf "$folder/nsdae-$version"
git archive --prefix="nsdae-$version/" -o "$folder/nsdae_$version.orig.tar.gz" HEAD
cd "$folder"
tar -xzf "nsdae_$version.orig.tar.gz"
cd "nsdae-$version"
cp -r packaging/debian debian
profiles=
dpkg-query -W nanobind-dev >/dev/null 2>&1 || profiles=-Ppkg.nsdae.nopython
dpkg-buildpackage -us -uc $profiles
if command -v lintian >/dev/null; then
  lintian --fail-on error,warning ../nsdae_*.changes
fi
ls -l "$folder"/*.deb
