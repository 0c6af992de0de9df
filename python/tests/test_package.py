"""What the installed package has beside its code: metadata, licences, stubs."""

import importlib.metadata
import os
import re

import nsdae

FOLDER = os.path.dirname(nsdae.__file__)
META = importlib.metadata.distribution("nsdae")
# what is linked into the module, by the names of the licence texts
LINKED = ("LAPACK", "OpenBLAS", "Qhull", "SUNDIALS", "SuiteSparse-AMD", "libgfortran", "nanobind", "robin-map", "LLVM")


def test_numpy_alone_is_required():
    needed = META.requires or []
    assert [one for one in needed if "extra ==" not in one] == ["numpy>=1.22"]
    assert set(META.metadata.get_all("Provides-Extra")) >= {"hdf5", "plot"}
    assert META.version == nsdae.__version__


def test_licences():
    texts = {os.path.basename(str(file)): file for file in META.files or () if "/licenses/" in str(file)}
    assert set(texts) == {"LICENSE", *(f"{name}.txt" for name in LINKED)}
    assert all(len(file.read_text()) > 1000 for file in texts.values())


def test_the_description_has_addresses_alone():
    """Links and images of README.md are paths, which an index of packages does not have."""
    targets = re.findall(r"\]\(([^)]+)\)", META.metadata.get_payload())
    assert len(targets) > 20 and all(target.startswith(("https://", "#")) for target in targets)


def test_no_address_of_a_process_in_the_stub():
    with open(os.path.join(FOLDER, "_core.pyi"), encoding="utf-8") as file:
        assert max(map(int, re.findall(r"\b\d+\b", file.read()))) < 2**32


def test_no_folder_of_the_build_in_the_module():
    """Its bytes would differ from build to build."""
    module = next(name for name in os.listdir(FOLDER) if name.startswith("_core.") and name.endswith(".so"))
    with open(os.path.join(FOLDER, module), "rb") as file:
        assert not re.search(rb"/(tmp|home|work)/[ -~]*\.(c|cpp|h|o)\b", file.read())
