#!/bin/sh
# Runs a program in an empty folder of its own: two runs of one test at a time do not share files. usage: own_folder.sh PROGRAM ARGUMENT...
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
trap 'exit 1' INT TERM
cd "$folder" && "$@"
