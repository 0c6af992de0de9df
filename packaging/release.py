#!/usr/bin/env python3
"""What a release must have.

usage: release.py versions        the version of CMakeLists.txt is that of all other files
       release.py check           that, a dated entry in the changelog, and no placeholder of author or address
       release.py sbom PART...    software bill of materials, CycloneDX 1.5 as JSON; on Debian. PART: a shared library, of
                                  which those count that it needs; a static one; a package URL, as pkg:pypi/nanobind@2.9.2
"""
import json
import pathlib
import re
import subprocess
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parent.parent
# file: where its version is. pyproject.toml may read that of CMakeLists.txt.
VERSIONS = {
    "CITATION.cff": r"^version: (.+)",
    "include/nsdae/version.h": r'NSDAE_VERSION +"(.+)"',
    "packaging/conda/meta.yaml": r'set version = "(.+)"',
    "packaging/debian/changelog": r"\Ansdae \((.+)-",
    "pyproject.toml": r'^version = "(.+)"',
}
ADDRESSED = ("CITATION.cff", "pyproject.toml", "packaging/conda/meta.yaml", "packaging/debian/changelog",
             "packaging/debian/control", "packaging/spack/package.py")
# Licences of what is linked, by the beginning of the name of the package. Debian's file "copyright" is about all parts of a
# source, most of which are not linked.
BSD = {"license": {"id": "BSD-3-Clause"}}
LICENSES = {
    "libamd": BSD,
    "libc6": {"license": {"id": "LGPL-2.1-or-later"}},
    "libgfortran": {"expression": "GPL-3.0-or-later WITH GCC-exception-3.1"},
    "libhdf5": {"license": {"name": "HDF5"}},
    "liblapacke": BSD,
    "libopenblas": BSD,
    "libqhull": {"license": {"id": "Qhull"}},
    "libsundials": BSD,
    "nanobind": BSD,
    "qhull": {"license": {"id": "Qhull"}},
    "robin-map": {"license": {"id": "MIT"}},
    "sundials": BSD,
    "suitesparse": BSD,  # AMD of it
    "ziglang": {"expression": "Apache-2.0 WITH LLVM-exception"},  # libc++ of it
}


def text(name):
    return (ROOT / name).read_text()


def version():
    return re.search(r"^project\(nsdae VERSION ([0-9.]+)", text("CMakeLists.txt"), re.M)[1]


def other_versions():
    """Faults: files with another version."""
    for name, pattern in VERSIONS.items():
        found = re.search(pattern, text(name), re.M)
        if found is None and name == "pyproject.toml" and 'input = "CMakeLists.txt"' in text(name):
            continue
        if found is None or found[1] != version():
            yield f"{name}: version {found and found[1]}, CMakeLists.txt has {version()}"


def not_ready():
    """Faults: what keeps this tree from being a release."""
    log = text("CHANGELOG.md")
    dated = re.search(rf"^## {re.escape(version())} - (\d{{4}}-\d\d-\d\d)$", log, re.M)
    if not dated:
        yield f"CHANGELOG.md: no heading '## {version()} - YYYY-MM-DD'"
    elif f"date-released: {dated[1]}\n" not in text("CITATION.cff"):
        yield f"CITATION.cff: date-released is not {dated[1]}, as CHANGELOG.md has"
    if re.search(r"^## Unreleased\s+[^#\s]|^## Unreleased\s+###", log, re.M):
        yield "CHANGELOG.md: entries under Unreleased: move them to the version, or raise the version"
    for name in ADDRESSED:
        found = re.search(r"[\w.@/:-]*\bnsdae\.example\b[\w./-]*", text(name))
        if found:
            yield f"{name}: the placeholder {found[0]}: give the real address"


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def package_of(path):
    """URL of the Debian package that has the file."""
    real = str(pathlib.Path(path).resolve())
    for place in (real, real.removeprefix("/usr")):
        found = subprocess.run(["dpkg", "-S", place], capture_output=True, text=True).stdout
        if found:
            package = found.split(": ")[0]
            break
    else:
        sys.exit(f"{path}: no Debian package has this library: link one that does, or write its entry by hand")
    name, number = output("dpkg-query", "-W", "-f", "${Package} ${Version}", package).split()
    return f"pkg:deb/debian/{name}@{urllib.parse.quote(number)}"


def license_of(package):
    for start, found in LICENSES.items():
        if package.startswith(start):
            return found
    sys.exit(f"{package}: its licence is not known: add it to LICENSES of packaging/release.py")


def packages_of(part):
    """URLs of the packages that a part brings."""
    if part.startswith("pkg:"):
        return [part]
    if not re.search(r"\.so(\.|$)", part):
        return [package_of(part)]
    needed = re.findall(r"\(NEEDED\).*\[(.+)\]", output("readelf", "-d", part))
    places = dict(re.findall(r"(\S+) => (\S+)", output("ldd", part)))
    return [package_of(places[name]) for name in needed if name in places]


def component(url):
    name, _, number = url.partition("?")[0].rpartition("/")[2].partition("@")
    return {"type": "library", "bom-ref": url, "name": name, **({"version": urllib.parse.unquote(number)} if number else {}),
            "purl": url, "licenses": [license_of(name)]}


def sbom(parts):
    components = [component(url) for url in sorted({url for part in parts for url in packages_of(part)})]
    own = {"type": "library", "bom-ref": "nsdae", "name": "nsdae", "version": version(), "licenses": [BSD]}
    return {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "metadata": {"component": own},
            "components": components, "dependencies": [{"ref": "nsdae", "dependsOn": [one["bom-ref"] for one in components]}]}


def main():
    verb = sys.argv[1] if len(sys.argv) > 1 else ""
    if verb == "sbom" and len(sys.argv) > 2:
        print(json.dumps(sbom(sys.argv[2:]), indent=2))
        return
    if verb not in ("versions", "check"):
        sys.exit(__doc__)
    faults = list(other_versions()) + (list(not_ready()) if verb == "check" else [])
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
