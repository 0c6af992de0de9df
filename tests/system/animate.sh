#!/bin/sh
# nsdae-animate: every example's GIF, page (and MP4, where ffmpeg is) against its trajectory, the page
# run by a browser where one is, one-line errors, and a full disk.
# usage: animate.sh BIN_DIR DATA_DIR CHECK.py
set -u
bin=$1
data=$2
check=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export HOME="$work" # of the browser
failures=0

python=""
for candidate in ${NSDAE_PYTHON:+"$NSDAE_PYTHON"} python3 /usr/bin/python3; do
  [ -z "$python" ] && "$candidate" -c "import h5py, matplotlib, PIL" 2>/dev/null && python=$candidate
done
if [ -z "$python" ]; then
  "$bin/nsdae-animate" --version 2>err && exit 1
  grep -q python3-pil err || exit 1
  echo "no Python with h5py, matplotlib and PIL: not tested"
  exit 77
fi

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect EXIT WORDS ARGUMENT...: the exit code, and one line on stderr that has the words
expect() {
  code=$1
  words=$2
  shift 2
  "$bin/nsdae-animate" "$@" >out 2>err
  got=$?
  if [ "$got" != "$code" ] || [ "$(wc -l <err)" != 1 ] || ! grep -qF -- "$words" err; then
    fail "nsdae-animate $*: exit $got (wanted $code), stderr: $(cat err) (wanted one line with: $words)"
  fi
}

browser=$(command -v chromium || command -v google-chrome || true)
# shown FILE T FRAME BODIES: a browser that opens the page at the time T stands at that frame
shown() {
  [ -n "$browser" ] || return
  timeout 60 "$browser" --headless --no-sandbox --disable-gpu --user-data-dir="$work/browser" --dump-dom \
    "file://$work/$1#t=$2" >dom 2>browser.err || { echo "$browser does not run here" && browser="" && return; }
  grep -q "data-frame=\"$3\"" dom || fail "$1 at $2 s: $(grep -o 'data-frame="[0-9]*"' dom), not $3"
  grep -q ">Play</button>" dom || fail "$1 plays though a time was asked for"
  grep -q "<option value=" dom || fail "$1 offers no speeds"
}

# ten frames a second, and earlier ends or fewer bodies where the test would last
for program in "$bin"/nsdae-*; do
  example=${program##*/nsdae-}
  "$program" --help 2>/dev/null | grep -q 'FILE.h5 *trajectory' || continue # not an example
  params=$data/$example.ini
  shorter=""
  case $example in
  bouncing-ball | pendulum* | crank-slider) shorter="--t-end 3" ;;
  woodpecker | newtons-cradle) shorter="--t-end 1" ;;
  dominoes | heap | shaken-ball) shorter="--t-end 0.3" ;;
  column) shorter="--set balls=3" ;; # each is a mesh
  esac
  "$program" --quiet $([ ! -e "$params" ] || echo --params "$params") $shorter --output "$example.h5" ||
    fail "$example"
  if "$bin/nsdae-animate" --fps 10 "$example.h5" >out 2>err; then
    "$python" -B "$check" "$example" || fail "$example"
  else
    fail "nsdae-animate $example.h5: $(cat err)"
  fi
done

shown pendulum.html 0.5 100
shown rolling-ball.html 0.25 50
if command -v node >/dev/null; then # the script is one
  for page in *.html; do
    sed -n '/^<script>$/,/^<\/script>$/p' "$page" | sed '1d;$d' >page.js
    node --check page.js 2>err || fail "$page: $(cat err)"
  done
fi

# a part of the time, slower, of another size, and what was asked for only
"$bin/nsdae-animate" -o part.gif --from 0.4 --to 0.6 --speed 0.1 --fps 20 --width 320 pendulum.h5 >out || fail "--from"
grep -q '^41 frames of 3 bodies in part.gif$' out || fail "--from: $(cat out)" # 2 s, 20 a second, both ends
# points of a model that names no bodies
"$python" - <<'END' || fail "a file without bodies"
import h5py
with h5py.File("pendulum.h5") as old, h5py.File("other.h5", "w") as g:
    for name in ("time", "q"):
        old.copy(name, g)
    g.attrs.update(old.attrs)
END
"$bin/nsdae-animate" --point 0,1,- --point 2,-,- -o points.html other.h5 >out || fail "--point"
grep -q '^601 frames of 2 bodies in points.html$' out || fail "--point: $(cat out)"

expect 1 "'other.h5' names no bodies" other.h5
expect 1 "the coordinates 0 to 2, not 3" other.h5 --point 3,-,-
expect 1 "cannot read 'none.h5': No such file or directory" none.h5
printf 'text' >text.h5
expect 1 "cannot read 'text.h5'" text.h5
expect 1 "no records between --from and --to" pendulum.h5 --from 5
expect 1 "cannot write 'no/x.gif': No such file or directory" pendulum.h5 --to 0.1 -o no/x.gif
expect 2 "must end with .gif, .mp4, .html" pendulum.h5 -o x.png
expect 2 "--fps" pendulum.h5 --fps 0
expect 2 "--speed" pendulum.h5 --speed -1
expect 2 "--width" pendulum.h5 --width 10
expect 2 "X,Y,Z" pendulum.h5 --point 1
expect 2 "required: file"
if ! command -v ffmpeg >/dev/null; then
  expect 1 "cannot write 'x.mp4': it needs ffmpeg" pendulum.h5 -o x.mp4
fi

# a formula that has no value at some time
"$python" - <<'END' || fail "a formula without a value"
import h5py
with h5py.File("pendulum.h5", "r+") as f:
    f["bodies/x"][0] = "sqrt(q0-100)"
END
expect 1 "the formula 'sqrt(q0-100)' is not finite" pendulum.h5

# a disk that fills: said, and the file that was there stays whole
cp incline.gif kept
(ulimit -f 40 && "$bin/nsdae-animate" incline.h5 -o incline.gif >out 2>err)
[ $? = 1 ] && grep -q "cannot write 'incline.gif': File too large" err || fail "full disk: $(cat err)"
cmp incline.gif kept || fail "the old file is lost"
[ ! -e incline.gif.part ] || fail "a part is left"

[ $failures = 0 ] && echo "all as expected"
exit $failures
