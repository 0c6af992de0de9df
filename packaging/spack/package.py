"""Spack recipe of nsdae: packages/nsdae/package.py of a repository of recipes."""

from spack_repo.builtin.build_systems.cmake import CMakePackage, generator

from spack.package import *


class Nsdae(CMakePackage):
    """Non-smooth multibody dynamics in C, C++ and Fortran: mechanisms whose parts hit, slide and
    stick, as differential-algebraic equations with contacts, impacts and Coulomb friction."""

    homepage = "https://nsdae.example"
    git = "https://nsdae.example/nsdae.git"

    license("BSD-3-Clause")

    # a released version joins with the sha256 of its archive
    version("main", branch="main")

    variant("hdf5", default=True, description="Write trajectories to HDF5 files")
    variant("sundials", default=True, description="Stiff phases of penalty and event")
    variant("fortran", default=True, description="Fortran module")
    variant("drivers", default=True, description="Example programs and tools")

    generator("ninja")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("fortran", type="build", when="+fortran")
    depends_on("cmake@3.21:", type="build")

    # brings CBLAS and LAPACKE; one thread serves the small matrices of a step best
    depends_on("openblas")
    depends_on("suite-sparse")  # AMD
    depends_on("qhull")
    depends_on("hdf5+hl~mpi", when="+hdf5")
    depends_on("sundials@6.4:7+IDA~mpi precision=double", when="+sundials")

    # what nsdae-plot and nsdae-animate are written in
    with when("+drivers"):
        depends_on("python@3.9:", type=("build", "run"))
        depends_on("py-h5py", type="run")
        depends_on("py-matplotlib", type="run")
        depends_on("py-pillow", type="run")

    depends_on("gsl", type="test")
    depends_on("cmocka", type="test")

    def cmake_args(self):
        return [
            self.define_from_variant("NSDAE_HDF5", "hdf5"),
            self.define_from_variant("NSDAE_SUNDIALS", "sundials"),
            self.define_from_variant("NSDAE_FORTRAN", "fortran"),
            self.define_from_variant("NSDAE_DRIVERS", "drivers"),
            self.define("BUILD_TESTING", self.run_tests),
        ]

    def setup_build_environment(self, env):
        env.set("OPENBLAS_NUM_THREADS", "1")
