#!/bin/sh
# The pendulum in Fortran beside the one in C: the same text, the same bytes in the trajectory, the
# same errors and exit codes. usage: twin.sh BIN_DIR DATA_DIR HDF5(ON|OFF)
set -u
bin=$1
data=$2
hdf5=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# both ARGUMENT...: the two programs with these; exit codes, outputs (without the clock) and errors
# (without the name) agree
both() {
  "$bin/nsdae-pendulum" "$@" >c.out 2>c.err
  c=$?
  "$bin/nsdae-pendulum-fortran" "$@" >f.out 2>f.err
  f=$?
  [ $c = $f ] || fail "$*: exit $f, not $c: $(cat f.err)"
  for side in c f; do
    sed -i '/^time /d' $side.out
    sed -i 's/^nsdae-pendulum\(-fortran\)*: //' $side.err
  done
  cmp c.out f.out || fail "$*: other output"
  cmp c.err f.err || fail "$*: '$(cat f.err)', not '$(cat c.err)'"
}

# same DATASET: byte for byte
same() {
  h5dump -d "$1" -b LE -o c.bin c.h5 >/dev/null || fail "h5dump $1 of C"
  h5dump -d "$1" -b LE -o f.bin f.h5 >/dev/null || fail "h5dump $1 of Fortran"
  [ -s c.bin ] || fail "$1 is empty"
  cmp c.bin f.bin || fail "$1 differs"
}

for method in implicit implicit-printed moreau penalty event; do
  both --no-output --method $method --t-end 3
done
both --no-output --params "$data/pendulum.ini"
[ "$(wc -l <f.out)" -gt 18 ] || fail "no table of impacts"
both --no-output --set e_N=0 --set L=0.7 --set theta_0=3 --dt=0.002 --t-end=2
both --no-output --set dt=0.01 --set e_N=1 --t-end 40
both --no-output --quiet
[ -s f.out ] && fail "--quiet prints"

both --metod moreau
both --method moraeu
both --set theta0=1
both --set lenght=2
both --set zzzzzz=1
both --dt -0.1
both --dt 0
both --set m=nan
both --set e_N=1.5
both --dt fast
both --dt
both --quiet=1
both --set mass
both --output=
printf 'L = 1\n\nlenght = 2 # m\n' >bad.ini
both --params bad.ini
both --no-output --dt 10 --t-end 1e4 --set iteration_max=3
"$bin/nsdae-pendulum-fortran" --params none.ini 2>err
[ $? = 2 ] && grep -q "cannot read 'none.ini'" err || fail "--params none.ini: $(cat err)"
"$bin/nsdae-pendulum-fortran" --help >help && grep -q theta_0 help || fail "--help"
# the options of the library, with their defaults
"$bin/nsdae-pendulum" --help | sed -n '/^options$/,$p' >c.help
sed -n '/^options$/,$p' help | cmp - c.help || fail "--help has other options"
"$bin/nsdae-pendulum-fortran" --version | grep -q '^nsdae-pendulum-fortran nsdae 0' || fail "--version"

if [ "$hdf5" = ON ]; then
  both --quiet --output no/such/folder/x.h5
  "$bin/nsdae-pendulum" --quiet --output c.h5 || fail "C with a trajectory"
  "$bin/nsdae-pendulum-fortran" --quiet --output f.h5 || fail "Fortran with a trajectory"
  for set in /time /q /v /multiplier /contacts/gap /contacts/normal_impulse /contacts/mode \
    /energy/kinetic /energy/potential /energy/dissipated /certificate/lcp_residual /certificate/contact_tol \
    /impact/time /impact/normal_impulse /impact/velocity_after /parameters/L /parameters/theta_0 \
    /bodies/size /bodies/points /bodies/point \
    /options/dt; do
    same $set
  done
  # both go on in a file of the other, and refuse the same
  "$bin/nsdae-pendulum" --quiet --t-end 2 --output twin.h5 && cp twin.h5 kept.h5
  for arguments in "--t-end 3" "--t-end 1" "--dt 0.001 --t-end 4" "--live" "--output other.h5" \
    "--every 3" "--t-end 4 --quiet"; do
    cp kept.h5 twin.h5
    "$bin/nsdae-pendulum" --restart twin.h5 $arguments 2>&1 | sed '/^time /d; s/^nsdae-[a-z-]*: //' >c.out
    cp kept.h5 twin.h5
    "$bin/nsdae-pendulum-fortran" --restart twin.h5 $arguments 2>&1 |
      sed '/^time /d; s/^nsdae-[a-z-]*: //' >f.out
    cmp c.out f.out || fail "--restart $arguments: '$(tail -1 f.out)', not '$(tail -1 c.out)'"
  done
  # but for the time of day all attributes are the same; h5dump 1.14 shows references with an address
  # in its own memory
  for side in c f; do
    h5dump -A $side.h5 |
      sed '/"[0-9-]*T[0-9:]*Z\?"/d; /^HDF5/d; s/DATASET [0-9]* /DATASET /' >$side.txt
  done
  [ -s c.txt ] || fail "no attributes"
  cmp c.txt f.txt || fail "other attributes"
fi
[ $failures = 0 ] && echo "the same text, bytes, errors and exit codes"
