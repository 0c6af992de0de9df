// The compiled half of the package: what nsdae/*.py stand on.
#include <nanobind/nanobind.h>
#include <nsdae/nsdae.h>

#include "bodies.hpp"
#include "failure.hpp"
#include "lists.hpp"
#include "problems.hpp"
#include "sim.hpp"
#include "system.hpp"

NB_MODULE(_core, m)
{
  using namespace nsdae_python;
  // what a program keeps until the interpreter is gone (a daemon thread, an extension) is no fault
  nanobind::set_leak_warnings(false);
  m.attr("VERSION") = nsdae_version();
  m.attr("BUILD_INFO") = nsdae_build_info();
  bind_failure(m);
  bind_lists(m);
  bind_system(m);
  bind_sim(m);
  bind_bodies(m);
  bind_problems(m);
}
