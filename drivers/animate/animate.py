"""The bodies of an nsdae trajectory in motion: a GIF, a film (MP4, with ffmpeg), and an offline page of HTML."""

import base64
import contextlib
import hashlib
import html
import io
import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np

from bodies import WHOLE, columns_of, count_of, read_motion, times_of
from contacts import force_lines
from scene import scene
from trajectory import Parser, Problem, has_forces, has_list, heading, open_trajectory, replace, tell

FORMATS = (".gif", ".mp4", ".html")
LONGEST = 8.0  # of a GIF by default [s]
PAGE_FRAMES = 1500
PAGE_POSES, PICTURE_POSES = 300000, 400000  # bodies by frames: what a page holds, and is drawn in a minute or two
HOLD = 1.0  # on the last frame of a GIF, before it begins again [s]
LADDER = (1, 2, 5)


def chosen_speed(span):
    """1 where that lasts 2 to 8 s, else the slowest of ..., 1/5, 1/2, 1, 2, 5, 10, ... that is over in time."""
    if 2 <= span <= LONGEST or span <= 0:
        return 1.0
    steps = [m * 10.0**e for e in range(-12, 13) for m in LADDER] if span > 1 else \
        sorted(1 / (m * 10.0**e) for e in range(-12, 13) for m in LADDER)
    return next((s for s in steps if span / s <= LONGEST), steps[-1])


def shown(time, start, end, path):
    """First and last record between two times."""
    first = int(np.searchsorted(time, time[0] if start is None else start))
    last = int(np.searchsorted(time, time[-1] if end is None else end, side="right")) - 1
    if first > last:
        raise Problem(f"'{path}' has no records between --from and --to: its times are {time[0]:g} to {time[-1]:g} s")
    return first, last


def frames_of_page(first, last, bodies):
    most = int(np.clip(PAGE_POSES // max(bodies, 1), 2, PAGE_FRAMES))
    return np.unique(np.linspace(first, last, most).round().astype(int))


def step_of(span, step, bodies):
    """A longer step if there are too many bodies to draw."""
    most = max(PICTURE_POSES // max(bodies, 1), 20)
    return max(step, span / most)


def read_frames(file, arguments, frames):
    """The bodies, and which of the records they were read at the frames are: all, or of a long motion of
    many the frames alone."""
    records = np.arange(frames[-1] + 1) if file["q"].size <= WHOLE else frames
    bodies = read_motion(file, arguments.file, arguments.point, records)
    return bodies, np.searchsorted(records, frames)


def records_at(time, first, last, step):
    """The last record at or before each of the times that are a step apart, and the last of all."""
    count = int(np.floor((time[last] - time[first]) / step * (1 + 1e-12))) + 1
    due = time[first] + step * np.arange(count)
    at = np.clip(np.searchsorted(time, due + 1e-9 * step, side="right") - 1, first, last)
    return at if at[-1] == last else np.append(at, last)


def palette_of(drawing, count):
    """One for all frames: of three of them side by side."""
    from PIL import Image
    width, height = drawing.size
    some = Image.new("RGB", (3 * width, height))
    for i, number in enumerate((0, count // 2, count - 1)):
        some.paste(drawing.frame(number), (i * width, 0))
    return some.quantize(128)


def gif(drawing, count, delay):
    """The file's bytes; delay: of a frame, in hundredths of a second."""
    palette = palette_of(drawing, count)
    flat = (drawing.frame(i).quantize(palette=palette, dither=0) for i in range(count))
    whole = io.BytesIO()
    next(flat).save(whole, format="GIF", save_all=True, append_images=flat, loop=0, disposal=1,
                    duration=[10 * delay] * (count - 1) + [10 * delay + int(1000 * HOLD)])
    return whole.getbuffer()


def feed(program, drawing, count):
    """All frames; it may end before it has them."""
    with contextlib.suppress(BrokenPipeError):
        for i in range(count):
            program.stdin.write(drawing.frame(i).tobytes())
        program.stdin.close()
    return program.stderr.read().decode(errors="replace")


def mp4(drawing, count, fps, path):
    """The file's bytes, as ffmpeg makes them beside it."""
    if not shutil.which("ffmpeg"):
        raise Problem(f"cannot write '{path}': it needs ffmpeg, which was not found")
    part = f"{path}.part"
    command = ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-r", str(fps),
               "-s", "{}x{}".format(*drawing.size), "-i", "-", "-pix_fmt", "yuv420p", "-movflags", "+faststart",
               "-f", "mp4", part]
    try:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as program:
            said = feed(program, drawing, count).strip().split("\n")[0]
        if program.returncode:
            raise Problem(f"cannot write '{path}': ffmpeg: {said or 'it failed'}")
        with open(part, "rb") as file:
            return file.read()
    finally:
        with contextlib.suppress(OSError):
            os.remove(part)


# JSON within <script>: characters that end a script, begin a comment, or end a line of JavaScript
ESCAPED = {ord(c): f"\\u{ord(c):04x}" for c in "<>&\u2028\u2029"}


def hash_of(template, element):
    """Of an element's content, as a content security policy names it."""
    content = re.search(f"<{element}>(.*?)</{element}>", template, re.DOTALL)[1]
    return f"'sha256-{base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()}'"


def page(shown_scene, title, speed):
    """All in one file: nothing is fetched. One pass: what is put in is not searched for placeholders. The policy
    names the template's own script, before anything of the trajectory is in it."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "page.html"), encoding="utf-8") as file:
        template = file.read()
    data = json.dumps({**shown_scene, "title": title, "speed": speed}, separators=(",", ":")).translate(ESCAPED)
    put = {"NSDAE_TITLE": html.escape(title), "NSDAE_SCENE": data, "NSDAE_SCRIPT": hash_of(template, "script"),
           "NSDAE_STYLE": hash_of(template, "style")}
    return re.sub("|".join(put), lambda found: put[found[0]], template).encode(errors="replace")


def number(low, high, whole=False):
    def read(word):
        value = int(word) if whole else float(word)
        if not low <= value <= high:
            raise ValueError
        return value

    read.__name__ = f"number ({low:g} to {high:g})"  # argparse quotes it
    return read


def parse(argv):
    parser = Parser(prog="nsdae-animate", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="file", help="trajectory, e.g. pendulum.h5")
    parser.add_argument("-o", "--output", action="append", metavar="OUT",
                        help=".gif, .mp4 or .html, of one file; repeatable; default FILE.gif, FILE.html and, with ffmpeg, FILE.mp4")
    parser.add_argument("--speed", type=number(1e-9, 1e9), metavar="X",
                        help="speed of the motion: 0.1 is a tenth of real time (default: a duration of a few seconds)")
    parser.add_argument("--fps", type=number(1, 50), default=25, metavar="N", help="frames per second, 1 to 50 (default 25)")
    parser.add_argument("--from", type=float, dest="start", metavar="S", help="first time shown [s]")
    parser.add_argument("--to", type=float, dest="end", metavar="S", help="last time shown [s]")
    parser.add_argument("--width", type=number(160, 3840, whole=True), default=480, metavar="N",
                        help="width of the picture, 160 to 3840 pixels (default 480)")
    parser.add_argument("--title", help="title, by default model and method")
    parser.add_argument("--forces", action="store_true",
                        help="draw contact forces at their points, or those of a contact list as lines from body to body")
    parser.add_argument("--point", metavar="X,Y,Z", action="append", type=columns_of,
                        help="a point at these coordinates of q, numbered from 0, in place of the bodies, "
                        "- for none; repeatable")
    parser.add_argument("--version", action="version", version="nsdae-animate @PROJECT_VERSION@")
    arguments = parser.parse_args(argv)
    if arguments.output and len(arguments.files) > 1:
        parser.error(f"--output is for one file, not {len(arguments.files)}")
    for output in arguments.output or ():
        if not output.lower().endswith(FORMATS):
            parser.error(f"--output '{output}' must end with {', '.join(FORMATS)}")
    arguments.file = arguments.files[0]
    return arguments


def outputs_of(arguments):
    """Of the file: those named, or all formats."""
    stem = os.path.splitext(arguments.file)[0]
    return arguments.output or [stem + end for end in FORMATS if end != ".mp4" or shutil.which("ffmpeg")]


def write(output, file, time, first, last, arguments):
    """One animation; how many frames and bodies it has."""
    speed = arguments.speed or chosen_speed(time[last] - time[first])
    title = arguments.title if arguments.title is not None else heading(file, arguments.file)
    count, on_page = count_of(file, arguments.point), output.lower().endswith(".html")
    delay = max(round(100 / arguments.fps), 2)  # what a GIF counts in
    if on_page:
        frames = frames_of_page(first, last, count)
    else:
        step = step_of(time[last] - time[first], speed * delay / 100, count)
        delay = max(round(100 * step / speed), delay)
        frames = records_at(time, first, last, step)
    bodies, at = read_frames(file, arguments, frames)
    forces = force_lines(file, bodies, at, frames) if arguments.forces else []
    shown_scene = scene(file, time, bodies, frames, at, forces)
    if on_page:
        replace(output, page(shown_scene, title, speed))
        return len(frames), len(bodies)
    from raster import Drawing  # with Pillow and Matplotlib, which a page does not need
    drawing = Drawing(shown_scene, arguments.width, title, speed)
    whole = gif(drawing, len(frames), delay) if output.lower().endswith(".gif") else \
        mp4(drawing, len(frames), 100 / delay, output)
    replace(output, whole)
    return len(frames), len(bodies)


def animate(arguments):
    """All animations of a file."""
    with open_trajectory(arguments.file) as file:
        if arguments.forces and not (has_forces(file) or has_list(file)):
            raise Problem(f"'{arguments.file}' has no contact forces and no contact list for --forces")
        time = times_of(file)
        first, last = shown(time, arguments.start, arguments.end, arguments.file)
        for output in outputs_of(arguments):
            frames, bodies = write(output, file, time, first, last, arguments)
            tell(f"{frames} frames of {bodies} bodies in {output}")


def main(argv):
    arguments = parse(argv)
    try:
        for arguments.file in arguments.files:
            animate(arguments)
    except Problem as problem:
        print(f"nsdae-animate: error: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
